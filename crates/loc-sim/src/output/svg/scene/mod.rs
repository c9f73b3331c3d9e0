//! The map view: paths, ellipses, poses and landmarks in the plane.

mod bounds;
mod draw;
mod frames;
mod labels;
mod robot;
mod view;

pub use frames::Frames;

use super::drawable;
use super::style::Style;
use loc_core::{Ellipse, Pose2};

/// A map seen from above, in metres, x to the right and y up, with the same scale along both.
///
/// Things are drawn in the order in which they come, on top of the [`Backdrop`]. A label names a
/// thing in the legend; things of the same colour and label share one entry, and those with an
/// empty label have none. The view is fitted to the content, with a margin. Positions that are
/// not finite are left out; a path is broken there.
#[derive(Debug, Clone, Default)]
pub struct Scene {
    title: String,
    subtitle: String,
    backdrop: Option<Backdrop>,
    items: Vec<Item>,
}

/// An image under a [`Scene`], such as an occupancy grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Backdrop {
    /// Lower left corner of the image (x, y) \[m\].
    pub min: (f64, f64),
    /// Upper right corner of the image (x, y) \[m\].
    pub max: (f64, f64),
    /// The image as a data URI: `data:image/png;base64,...`. Figures load nothing from
    /// elsewhere, so that any other address leaves the backdrop empty.
    pub data_uri: String,
}

#[derive(Debug, Clone)]
struct Item {
    style: Style,
    label: String,
    shape: Shape,
}

#[derive(Debug, Clone)]
enum Shape {
    Path(Vec<(f64, f64)>),
    Segments(Vec<((f64, f64), (f64, f64))>),
    Dots(Vec<(f64, f64)>),
    Ellipses(Vec<Ellipse>),
    Poses(Vec<Pose2>),
    Crosses(Vec<((f64, f64), String)>),
    Stars(Vec<(f64, f64)>),
}

impl Scene {
    /// An empty scene; a title of many words takes two lines.
    pub fn new(title: impl Into<String>) -> Self {
        Scene { title: title.into(), ..Scene::default() }
    }

    /// A line under the title, in smaller letters.
    #[must_use]
    pub fn subtitle(mut self, subtitle: impl Into<String>) -> Self {
        self.subtitle = subtitle.into();
        self
    }

    /// An image under everything else.
    #[must_use]
    pub fn backdrop(mut self, backdrop: Backdrop) -> Self {
        self.backdrop = Some(backdrop);
        self
    }

    /// A line through points (x, y) \[m\]. Points that would not change the picture by an eighth
    /// of a pixel are left out of the file (see [`simplify`](super::simplify)).
    #[must_use]
    pub fn path(
        self,
        style: impl Into<Style>,
        label: &str,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        self.with(style, label, Shape::Path(points.into_iter().collect()))
    }

    /// Separate lines from one point to another \[m\].
    #[must_use]
    pub fn segments(
        self,
        style: impl Into<Style>,
        label: &str,
        segments: impl IntoIterator<Item = ((f64, f64), (f64, f64))>,
    ) -> Self {
        let finite = |&(a, b): &((f64, f64), (f64, f64))| is_place(a) && is_place(b);
        let segments = segments.into_iter().filter(finite).collect();
        self.with(style, label, Shape::Segments(segments))
    }

    /// Dots at (x, y) \[m\], such as particles or scan points. Of dots within the same half
    /// pixel one is drawn.
    #[must_use]
    pub fn dots(
        self,
        style: impl Into<Style>,
        label: &str,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let points = points.into_iter().filter(|&p| is_place(p)).collect();
        self.with(style, label, Shape::Dots(points))
    }

    /// Ellipses of uncertainty \[m\]. One that is far larger than everything else does not
    /// enlarge the view beyond three times the rest, but runs over its edge.
    #[must_use]
    pub fn ellipses(
        self,
        style: impl Into<Style>,
        label: &str,
        ellipses: impl IntoIterator<Item = Ellipse>,
    ) -> Self {
        let finite = |e: &Ellipse| {
            is_place((e.center.x, e.center.y))
                && is_place((e.semi_major, e.semi_minor))
                && e.angle.is_finite()
        };
        let ellipses = ellipses.into_iter().filter(finite).collect();
        self.with(style, label, Shape::Ellipses(ellipses))
    }

    /// Arrow heads that show positions \[m\] and headings \[rad\].
    #[must_use]
    pub fn poses(
        self,
        style: impl Into<Style>,
        label: &str,
        poses: impl IntoIterator<Item = Pose2>,
    ) -> Self {
        let finite = |pose: &Pose2| is_place((pose.x, pose.y)) && pose.theta.is_finite();
        let poses = poses.into_iter().filter(finite).collect();
        self.with(style, label, Shape::Poses(poses))
    }

    /// Crosses at (x, y) \[m\], each with its name, which may be empty: landmarks. Names are
    /// placed clear of lines and of each other; one that finds no room is left out.
    #[must_use]
    pub fn crosses<S: Into<String>>(
        self,
        style: impl Into<Style>,
        label: &str,
        crosses: impl IntoIterator<Item = ((f64, f64), S)>,
    ) -> Self {
        let crosses = crosses
            .into_iter()
            .filter(|(place, _)| is_place(*place))
            .map(|(place, name)| (place, name.into()))
            .collect();
        self.with(style, label, Shape::Crosses(crosses))
    }

    /// Stars at (x, y) \[m\], such as measurements.
    #[must_use]
    pub fn stars(
        self,
        style: impl Into<Style>,
        label: &str,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let points = points.into_iter().filter(|&p| is_place(p)).collect();
        self.with(style, label, Shape::Stars(points))
    }

    /// The SVG file.
    pub fn render(&self) -> String {
        draw::draw(self)
    }

    fn with(mut self, style: impl Into<Style>, label: &str, shape: Shape) -> Self {
        self.items.push(Item { style: style.into(), label: label.to_owned(), shape });
        self
    }
}

impl Backdrop {
    /// Whether it has an extent, and an image that needs no network.
    fn is_valid(&self) -> bool {
        is_place(self.min)
            && is_place(self.max)
            && self.max.0 > self.min.0
            && self.max.1 > self.min.1
            && self.data_uri.starts_with("data:image/")
    }
}

fn is_place((x, y): (f64, f64)) -> bool {
    drawable(x) && drawable(y)
}
