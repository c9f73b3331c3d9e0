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

mod cells;
mod places;

use crate::{Bounds, LandmarkMap, LineMap, OccupancyGrid, PointMap, TopologicalMap};
use std::fmt::Write as _;

/// Longer side of a picture \[px\].
const SIZE: f64 = 1200.0;

/// Layers of maps that become one picture.
#[derive(Debug, Clone, Default)]
pub struct MapPicture {
    bounds: Option<Bounds>,
    /// Each layer's drawing, which is told the width of a pixel \[m\] where it stands.
    layers: Vec<String>,
}

/// Stands in a drawing for a length of so many pixels.
const PIXELS: char = '\u{1}';

impl MapPicture {
    /// An empty picture.
    pub fn new() -> Self {
        MapPicture::default()
    }

    /// Adds an occupancy grid; the picture shows the part of it that is known.
    #[must_use]
    pub fn grid(mut self, grid: &OccupancyGrid) -> Self {
        self.cover(cells::known(grid).or_else(|| Bounds::around(grid.frame().corners())));
        self.layers.push(cells::draw(grid));
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
        self.layers.push(places::draw(map));
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

    /// Dots, as lines without length with round ends: the shortest way to say them.
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

/// A length of so many pixels, which [`scaled`] turns into metres.
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

/// A number to a tenth of a millimetre, as short as it gets.
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
