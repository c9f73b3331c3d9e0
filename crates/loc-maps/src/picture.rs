//! Pictures of maps, as SVG.
//!
//! A map is best judged by eye. A picture takes any number of maps of one frame, one over the
//! other (places over the grid they were extracted from), and becomes the text of an SVG file that
//! every browser shows, y upwards, to scale. Unknown is grey, free white, occupied black.
//!
//! ```
//! use loc_maps::{LineMap, MapPicture};
//! let map = LineMap::parse_csv("room.csv", "0,0,4,0\n4,0,4,2\n")?;
//! let svg = MapPicture::new().grid(&map.to_grid(0.1, 0.5)?).lines(&map).to_svg();
//! assert!(svg.starts_with("<svg") && svg.contains("M0 0L4 0"));
//! # Ok::<(), loc_maps::Error>(())
//! ```

use crate::grid::Occupancy;
use crate::topological::{Place, PlaceKind};
use crate::{Bounds, LandmarkMap, LineMap, OccupancyGrid, PointMap, TopologicalMap};
use std::fmt::Write as _;

/// Longer side of a picture \[px\].
const SIZE: f64 = 1200.0;

/// Layers of maps that become one picture.
#[derive(Debug, Clone, Default)]
pub struct MapPicture {
    bounds: Option<Bounds>,
    /// The SVG text of each layer; lengths in pixels are marked with [`PIXELS`].
    layers: Vec<String>,
}

/// Encloses a length in pixels in the text of a layer.
const PIXELS: char = '\u{1}';

impl MapPicture {
    /// An empty picture.
    pub fn new() -> Self {
        MapPicture::default()
    }

    /// Adds an occupancy grid; the picture shows the part of it that is known.
    #[must_use]
    pub fn grid(mut self, grid: &OccupancyGrid) -> Self {
        self.cover(known(grid).or_else(|| Bounds::around(grid.frame().corners())));
        self.layers.push(draw_grid(grid));
        self
    }

    /// Adds lines.
    #[must_use]
    pub fn lines(mut self, map: &LineMap) -> Self {
        self.cover(map.bounds());
        let mut path = String::new();
        for line in map.lines() {
            let (a, b) = (line.start, line.end);
            let _ = write!(path, "M{}L{}", xy(a.x, a.y), xy(b.x, b.y));
        }
        self.path("lines", "#0072b2", 2.0, &path);
        self
    }

    /// Adds obstacle points.
    #[must_use]
    pub fn points(mut self, map: &PointMap) -> Self {
        self.cover(map.bounds());
        self.dots("points", "#009e73", 2.0, map.points().iter().map(|p| (p.x, p.y)));
        self
    }

    /// Adds landmarks.
    #[must_use]
    pub fn landmarks(mut self, map: &LandmarkMap) -> Self {
        let positions = || map.iter().map(|landmark| landmark.position);
        self.cover(Bounds::around(positions().map(|p| p.xy())));
        self.dots("landmarks", "#d55e00", 8.0, positions().map(|p| (p.x, p.y)));
        self
    }

    /// Adds places: outlines, the edges between neighbours, names.
    #[must_use]
    pub fn places(mut self, map: &TopologicalMap) -> Self {
        self.cover(map.bounds());
        self.layers.push(draw_places(map));
        self
    }

    /// The text of an SVG file.
    pub fn to_svg(&self) -> String {
        let nothing = Bounds::around([[0.0, 0.0].into()]);
        let Some(bounds) = self.bounds.or(nothing) else { return String::new() };
        let margin = 0.02 * bounds.width().max(bounds.height()).max(0.1);
        let bounds = bounds.grown(margin);
        let pixel = bounds.width().max(bounds.height()) / SIZE;
        let (width, height) = (bounds.width(), bounds.height());
        let view = format!("{} {} {}", xy(bounds.min.x, bounds.max.y), n(width), n(height));
        let mut text = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" \
             viewBox=\"{view}\" font-family=\"sans-serif\">\n",
            n(width / pixel),
            n(height / pixel)
        );
        let (left, top) = (n(bounds.min.x), n(-bounds.max.y));
        let (width, height) = (n(width), n(height));
        let _ = writeln!(
            text,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{width}\" height=\"{height}\" fill=\"#fff\"/>"
        );
        for layer in &self.layers {
            scaled(layer, pixel, &mut text);
        }
        text + "</svg>\n"
    }

    fn cover(&mut self, bounds: Option<Bounds>) {
        self.bounds = self.bounds.into_iter().chain(bounds).reduce(Bounds::union);
    }

    fn path(&mut self, class: &str, colour: &str, width: f64, path: &str) {
        let width = pixels(width);
        self.layers.push(format!(
            "<path class=\"{class}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{width}\" \
             stroke-linecap=\"round\" d=\"{path}\"/>\n"
        ));
    }

    /// Dots, as lines without length with round ends: the shortest form in SVG.
    fn dots(
        &mut self,
        class: &str,
        colour: &str,
        width: f64,
        points: impl Iterator<Item = (f64, f64)>,
    ) {
        let mut path = String::new();
        for (x, y) in points {
            let _ = write!(path, "M{}h0", xy(x, y));
        }
        self.path(class, colour, width, &path);
    }
}

/// A length in pixels, which [`scaled`] turns into metres.
fn pixels(count: f64) -> String {
    format!("{PIXELS}{count}{PIXELS}")
}

/// Writes a layer with its lengths in pixels turned into metres.
fn scaled(layer: &str, pixel: f64, text: &mut String) {
    for (index, part) in layer.split(PIXELS).enumerate() {
        match part.parse::<f64>() {
            Ok(count) if index % 2 == 1 => *text += &n(count * pixel),
            _ => *text += part,
        }
    }
}

/// A point of the map, in the picture's coordinates: y downwards.
fn xy(x: f64, y: f64) -> String {
    format!("{} {}", n(x), n(-y))
}

/// A number rounded to a tenth of a millimetre, without trailing zeros.
fn n(value: f64) -> String {
    let rounded = (value * 1e4).round() / 1e4;
    // Adding 0 turns -0 into 0.
    format!("{}", rounded + 0.0)
}

impl OccupancyGrid {
    /// A picture of the grid, as the text of an SVG file.
    pub fn to_svg(&self) -> String {
        MapPicture::new().grid(self).to_svg()
    }
}

impl LineMap {
    /// A picture of the lines, as the text of an SVG file.
    pub fn to_svg(&self) -> String {
        MapPicture::new().lines(self).to_svg()
    }
}

impl PointMap {
    /// A picture of the points, as the text of an SVG file.
    pub fn to_svg(&self) -> String {
        MapPicture::new().points(self).to_svg()
    }
}

impl LandmarkMap {
    /// A picture of the landmarks seen from above, as the text of an SVG file.
    pub fn to_svg(&self) -> String {
        MapPicture::new().landmarks(self).to_svg()
    }
}

impl TopologicalMap {
    /// A picture of the places, as the text of an SVG file.
    pub fn to_svg(&self) -> String {
        MapPicture::new().places(self).to_svg()
    }
}

/// Equal cells side by side: first column, and the one behind the last.
type Run = (usize, usize);

/// A grid as SVG, in units of cells under a transform of its frame. Cells of one class become few
/// rectangles.
fn draw_grid(grid: &OccupancyGrid) -> String {
    let (origin, size) = (grid.origin(), grid.resolution());
    let place = format!(
        "translate({} {}) rotate({}) scale({size} {})",
        n(origin.x),
        n(-origin.y),
        n(-origin.theta.to_degrees()),
        -size
    );
    let (width, height) = (grid.width(), grid.height());
    let free = outlines(grid, Occupancy::Free);
    let occupied = outlines(grid, Occupancy::Occupied);
    format!(
        "<g class=\"grid\" transform=\"{place}\" shape-rendering=\"crispEdges\">\n\
         <path fill=\"#cdcdcd\" d=\"M0 0h{width}v{height}h-{width}z\"/>\n\
         <path fill=\"#fff\" d=\"{free}\"/>\n<path fill=\"#000\" d=\"{occupied}\"/>\n</g>\n"
    )
}

/// The box around all cells that are not unknown.
fn known(grid: &OccupancyGrid) -> Option<Bounds> {
    let known = |value: &i8| Occupancy::of(*value) != Occupancy::Unknown;
    let corners = (0..grid.height()).filter_map(|row| {
        let values = grid.row(row);
        let (first, last) = (values.iter().position(known)?, values.iter().rposition(known)?);
        let corner = |column: usize, row: usize| grid.frame().to_map(column as f64, row as f64);
        let ends = [corner(first, row), corner(last + 1, row)];
        Some(ends.into_iter().chain([corner(first, row + 1), corner(last + 1, row + 1)]))
    });
    Bounds::around(corners.flatten())
}

/// Rectangles that together are the cells of a class: runs of a row that repeat in the rows above
/// grow upwards.
fn outlines(grid: &OccupancyGrid, class: Occupancy) -> String {
    let mut path = String::new();
    let mut open: Vec<(Run, usize)> = Vec::new();
    for row in 0..=grid.height() {
        let runs = runs(grid.row(row), class);
        let mut still = Vec::with_capacity(runs.len());
        // Both are in order of their columns.
        let mut old = open.into_iter().peekable();
        for run in runs {
            while let Some(ended) = old.next_if(|(other, _)| *other < run) {
                close(&mut path, ended, row);
            }
            let since = old.next_if(|(other, _)| *other == run).map_or(row, |(_, since)| since);
            still.push((run, since));
        }
        old.for_each(|ended| close(&mut path, ended, row));
        open = still;
    }
    path
}

fn close(path: &mut String, ((from, to), since): (Run, usize), row: usize) {
    let (width, height) = (to - from, row - since);
    // Writing to a string cannot fail.
    let _ = write!(path, "M{from} {since}h{width}v{height}h-{width}z");
}

fn runs(row: &[i8], class: Occupancy) -> Vec<Run> {
    let mut runs: Vec<Run> = Vec::new();
    for (column, _) in row.iter().enumerate().filter(|(_, v)| Occupancy::of(**v) == class) {
        match runs.last_mut() {
            Some(last) if last.1 == column => last.1 += 1,
            _ => runs.push((column, column + 1)),
        }
    }
    runs
}

/// Places as SVG: outlines below, then edges, then dots and names.
fn draw_places(map: &TopologicalMap) -> String {
    // Writing to a string cannot fail.
    let mut text = String::from("<g class=\"places\">\n");
    let mut outlined: Vec<&Place> =
        map.places().iter().filter(|place| !place.outline.is_empty()).collect();
    // What lies inside a ring of corridors is drawn over it.
    outlined.sort_by(|a, b| b.area().total_cmp(&a.area()));
    for place in outlined {
        let corners: Vec<String> = place.outline.iter().map(|p| xy(p.x, p.y)).collect();
        let (fill, line) = (colour(place.kind), pixels(1.5));
        let path = corners.join("L");
        let _ = writeln!(
            text,
            "<path fill=\"{fill}\" fill-opacity=\"0.25\" stroke=\"{fill}\" stroke-width=\"{line}\" \
             d=\"M{path}z\"/>"
        );
    }
    let mut edges = String::new();
    for edge in map.edges() {
        let [a, b] = edge.between.map(|place| map.places()[place].position);
        let points = [a].into_iter().chain(edge.via.iter().copied()).chain([b]);
        let points: Vec<String> = points.map(|point| xy(point.x, point.y)).collect();
        let _ = write!(edges, "M{}", points.join("L"));
    }
    let line = pixels(2.0);
    let _ = writeln!(
        text,
        "<path fill=\"none\" stroke=\"#333\" stroke-linejoin=\"round\" stroke-width=\"{line}\" d=\"{edges}\"/>"
    );
    for place in map.places() {
        draw_place(&mut text, place);
    }
    text + "</g>\n"
}

fn draw_place(text: &mut String, place: &Place) {
    let (x, y) = (n(place.position.x), n(-place.position.y));
    let (fill, radius) =
        (colour(place.kind), if place.kind == PlaceKind::Door { 4.0 } else { 7.0 });
    let (r, line, size) = (pixels(radius), pixels(1.5), pixels(13.0));
    let name = escaped(&place.name);
    let _ = writeln!(
        text,
        "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\" fill=\"{fill}\" stroke=\"#fff\" \
         stroke-width=\"{line}\"><title>{name}</title></circle>"
    );
    // The name of a door would cover it.
    if place.kind != PlaceKind::Door {
        let (shift, halo) = (pixels(-11.0), pixels(3.0));
        let _ = writeln!(
            text,
            "<text x=\"{x}\" y=\"{y}\" dy=\"{shift}\" font-size=\"{size}\" text-anchor=\"middle\" \
             paint-order=\"stroke\" stroke=\"#fff\" stroke-width=\"{halo}\">{name}</text>"
        );
    }
}

fn colour(kind: PlaceKind) -> &'static str {
    match kind {
        PlaceKind::Room => "#0072b2",
        PlaceKind::Corridor => "#009e73",
        PlaceKind::Door => "#d55e00",
    }
}

/// A name as it may stand in XML: characters that XML has no room for are left out.
fn escaped(text: &str) -> String {
    let mut safe = String::new();
    for character in text.chars().filter(|c| !c.is_control()) {
        match character {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            other => safe.push(other),
        }
    }
    safe
}
