//! Topological maps as TOML files.

use super::{Edge, Place, PlaceKind, TopologicalMap, path_length};
use crate::bounds::coordinate;
use crate::{Error, Result};
use loc_core::error::non_negative;
use nalgebra::Point2;
use serde::Deserialize;
use std::collections::{HashMap, HashSet};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use toml::Spanned;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    #[serde(default)]
    place: Vec<PlaceEntry>,
    #[serde(default)]
    edge: Vec<EdgeEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlaceEntry {
    name: Spanned<String>,
    kind: PlaceKind,
    position: Spanned<[f64; 2]>,
    width: Option<Spanned<f64>>,
    #[serde(default)]
    outline: Vec<Spanned<[f64; 2]>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct EdgeEntry {
    between: Spanned<[Spanned<String>; 2]>,
    length: Option<Spanned<f64>>,
    #[serde(default)]
    via: Vec<Spanned<[f64; 2]>>,
}

/// A text with the name of its file, for errors.
struct Source<'a> {
    file: PathBuf,
    text: &'a str,
}

impl TopologicalMap {
    /// Reads a TOML file of `[[place]]` (name, kind, position, and if wanted width and outline) and
    /// `[[edge]]` (between two names, and if wanted length and points it leads via); lengths in
    /// \[m\].
    ///
    /// # Errors
    /// [`Error::Toml`] with the line of whatever cannot be understood, of a second place of a
    /// name and of an edge to a place that is not there; [`loc_core::Error`] for files that cannot
    /// be read or hold no place.
    pub fn read_toml(file: impl AsRef<Path>) -> Result<Self> {
        let file = file.as_ref();
        let text = std::fs::read_to_string(file).map_err(loc_core::Error::io(file))?;
        TopologicalMap::parse_toml(file, &text)
    }

    /// The same from a text; `file` is only named in errors.
    ///
    /// # Errors
    /// As [`TopologicalMap::read_toml`].
    pub fn parse_toml(file: impl Into<PathBuf>, text: &str) -> Result<Self> {
        let source = Source { file: file.into(), text };
        let raw: File = toml::from_str(text).map_err(|error| source.broken(&error))?;
        if raw.place.is_empty() {
            return Err(loc_core::Error::Empty { file: source.file, what: "places" }.into());
        }
        let places = source.places(raw.place)?;
        let edges = source.edges(raw.edge, &places)?;
        TopologicalMap::new(places, edges)
    }

    /// The map as the text of a TOML file, every number to its last digit.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        for place in self.places() {
            let _ = write_place(&mut text, place);
        }
        for edge in self.edges() {
            let names = edge.between.map(|place| quoted(&self.places()[place].name));
            let _ = write_edge(&mut text, edge, &names);
        }
        text
    }
}

fn write_place(text: &mut String, place: &Place) -> std::fmt::Result {
    let (name, kind) = (quoted(&place.name), place.kind.name());
    let position = place.position;
    writeln!(text, "[[place]]\nname = {name}\nkind = \"{kind}\"")?;
    writeln!(text, "position = [{:?}, {:?}]", position.x, position.y)?;
    if let Some(width) = place.width {
        writeln!(text, "width = {width:?}")?;
    }
    if !place.outline.is_empty() {
        writeln!(text, "outline = {}", list(&place.outline))?;
    }
    writeln!(text)
}

fn write_edge(text: &mut String, edge: &Edge, [from, to]: &[String; 2]) -> std::fmt::Result {
    writeln!(text, "[[edge]]\nbetween = [{from}, {to}]\nlength = {:?}", edge.length)?;
    if !edge.via.is_empty() {
        writeln!(text, "via = {}", list(&edge.via))?;
    }
    writeln!(text)
}

fn list(points: &[Point2<f64>]) -> String {
    let points = points.iter().map(|p| format!("[{:?}, {:?}]", p.x, p.y));
    format!("[{}]", points.collect::<Vec<_>>().join(", "))
}

fn quoted(text: &str) -> String {
    toml::Value::from(text).to_string()
}

impl Source<'_> {
    fn error(&self, offset: usize, message: impl Into<String>) -> Error {
        let before = self.text.as_bytes().iter().take(offset);
        let line = before.filter(|&&byte| byte == b'\n').count() + 1;
        Error::Toml { file: self.file.clone(), line, message: message.into() }
    }

    fn broken(&self, error: &toml::de::Error) -> Error {
        let offset = error.span().map_or(0, |span| span.start);
        self.error(offset, error.message().replace('\n', ", "))
    }

    /// Turns what a check of a number found into an error with its line.
    fn checked<T>(&self, offset: usize, result: loc_core::Result<T>) -> Result<T> {
        result.map_err(|error| self.error(offset, error.to_string()))
    }

    fn point(&self, what: &'static str, point: &Spanned<[f64; 2]>) -> Result<Point2<f64>> {
        for &value in point.get_ref() {
            self.checked(point.span().start, coordinate(what, value))?;
        }
        Ok(Point2::from(*point.get_ref()))
    }

    fn non_negative(
        &self,
        what: &'static str,
        value: Option<&Spanned<f64>>,
    ) -> Result<Option<f64>> {
        let check = |value: &Spanned<f64>| {
            self.checked(value.span().start, non_negative(what, *value.get_ref()))
        };
        value.map(check).transpose()
    }

    fn places(&self, entries: Vec<PlaceEntry>) -> Result<Vec<Place>> {
        let mut names = HashSet::new();
        let mut places = Vec::new();
        for entry in entries {
            let name = entry.name.get_ref().clone();
            if !names.insert(name.clone()) {
                let message = format!("name: expected one place called `{name}`, got a second one");
                return Err(self.error(entry.name.span().start, message));
            }
            let position = self.point("position [m]", &entry.position)?;
            let width = self.non_negative("width [m]", entry.width.as_ref())?;
            let corners = entry.outline.iter().map(|corner| self.point("outline [m]", corner));
            let outline = corners.collect::<Result<_>>()?;
            places.push(Place { name, kind: entry.kind, position, width, outline });
        }
        Ok(places)
    }

    fn edges(&self, entries: Vec<EdgeEntry>, places: &[Place]) -> Result<Vec<Edge>> {
        let names = places.iter().enumerate().map(|(index, place)| (place.name.as_str(), index));
        let by_name: HashMap<&str, usize> = names.collect();
        let mut joined = HashSet::new();
        let mut edges = Vec::new();
        for entry in entries {
            let find = |name: &Spanned<String>| {
                let found = name.get_ref();
                by_name.get(found.as_str()).copied().ok_or_else(|| {
                    let message = format!("between: expected the name of a place, got `{found}`");
                    self.error(name.span().start, message)
                })
            };
            let [from, to] = entry.between.get_ref();
            let (a, b) = (find(from)?, find(to)?);
            if a == b || !joined.insert((a.min(b), a.max(b))) {
                let (from, to) = (from.get_ref(), to.get_ref());
                let expected = "between: expected two different places not joined yet";
                let message = format!("{expected}, got `{from}` and `{to}`");
                return Err(self.error(entry.between.span().start, message));
            }
            let via = entry.via.iter().map(|point| self.point("via [m]", point));
            let via: Vec<Point2<f64>> = via.collect::<Result<_>>()?;
            let ends = [a, b].map(|place| places[place].position);
            let way = [ends[0]].into_iter().chain(via.iter().copied()).chain([ends[1]]);
            let length = self.non_negative("length [m]", entry.length.as_ref())?;
            let length = length.unwrap_or_else(|| path_length(way));
            edges.push(Edge { between: [a, b], length, via });
        }
        Ok(edges)
    }
}
