//! The map view: paths, ellipses, poses and landmarks in the plane.

use crate::axis::NAME_HEIGHT;
use crate::header::{Glyph, Legend};
use crate::labels::Room;
use crate::marks::Px;
use crate::style::{Role, Style};
use crate::view::{Bounds, View};
use crate::writer::{Element, Writer, number};
use crate::{drawable, header, labels, marks};
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
    pub(crate) backdrop: Option<Backdrop>,
    pub(crate) items: Vec<Item>,
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
pub(crate) struct Item {
    style: Style,
    label: String,
    pub(crate) shape: Shape,
}

#[derive(Debug, Clone)]
pub(crate) enum Shape {
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
    /// of a pixel are left out of the file (see [`simplify`](crate::simplify)).
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
        draw(self)
    }

    fn with(mut self, style: impl Into<Style>, label: &str, shape: Shape) -> Self {
        self.items.push(Item { style: style.into(), label: label.to_owned(), shape });
        self
    }

    /// The true pose as a ring of `radius` \[m\] with a pointer, so that what lies within, such as
    /// particles, can be seen.
    #[must_use]
    pub fn ring(self, label: &str, radius: f64, pose: Pose2) -> Self {
        let center = pose.position().coords;
        let ring = Ellipse { center, semi_major: radius, semi_minor: radius, angle: 0.0 };
        let ahead = |share: f64| {
            let point = pose.transform(&[share * radius, 0.0].into());
            (point.x, point.y)
        };
        let style = Role::Truth.width(1.4);
        self.ellipses(style, label, [ring]).segments(style, "", [(ahead(1.0), ahead(2.0))])
    }
}

impl Backdrop {
    /// Whether it has an extent, and an image that needs no network.
    pub(crate) fn is_valid(&self) -> bool {
        is_place(self.min)
            && is_place(self.max)
            && self.max.0 > self.min.0
            && self.max.1 > self.min.1
            && self.data_uri.starts_with("data:image/")
    }
}

pub(crate) fn is_place((x, y): (f64, f64)) -> bool {
    drawable(x) && drawable(y)
}

fn draw(scene: &Scene) -> String {
    let mut writer = Writer::default();
    let legend = legend_of(&scene.items);
    let top = header::draw(&mut writer, &scene.title, &scene.subtitle, &legend) + NAME_HEIGHT;
    let bounds = Bounds::of(scene);
    let nothing = Bounds { min: (-1.0, -0.5), max: (1.0, 0.5) };
    let mut view = View::fit(bounds.unwrap_or(nothing), top);
    if bounds.is_none() {
        view.x.ticks.clear();
        view.y.ticks.clear();
    }
    // The image covers the grid, whose lines would cut through its walls.
    view.area.draw_grid(&mut writer, &view.x, &view.y);
    if let Some(backdrop) = scene.backdrop.as_ref().filter(|b| b.is_valid()) {
        draw_image(&mut writer, &view, backdrop, None);
    }
    view.area.open_clip(&mut writer, 0.0);
    for item in &scene.items {
        draw_item(&mut writer, &view, item);
    }
    draw_names(&mut writer, &view, scene);
    writer.close();
    if bounds.is_none() {
        view.area.draw_no_data(&mut writer);
    }
    view.area.draw_y_axis(&mut writer, &view.y, "y [m]");
    let end = view.area.draw_x_axis(&mut writer, &view.x, "x [m]");
    writer.finish(&scene.title, end)
}

pub(crate) fn legend_of<'a>(items: impl IntoIterator<Item = &'a Item>) -> Legend {
    let mut legend = Legend::default();
    for item in items {
        let glyph = match item.shape {
            Shape::Path(_) | Shape::Segments(_) => Glyph::Line,
            Shape::Dots(_) => Glyph::Dots,
            Shape::Ellipses(_) => Glyph::Ellipse,
            Shape::Poses(_) => Glyph::Arrow,
            Shape::Crosses(_) => Glyph::Cross,
            Shape::Stars(_) => Glyph::Star,
        };
        legend.add(&item.label, glyph, item.style);
    }
    legend
}

/// A backdrop in its place; one with a name can be shown again elsewhere.
pub(crate) fn draw_image(
    writer: &mut Writer,
    view: &View,
    backdrop: &Backdrop,
    name: Option<&str>,
) {
    let (left, bottom) = view.px(backdrop.min);
    let (right, top) = view.px(backdrop.max);
    let image = Element::new("image");
    // What is shown again gets its dark colours there.
    let image = match name {
        Some(name) => image.attr("id", name),
        None => image.class("loc-image"),
    };
    writer.add(
        image
            .num("x", left)
            .num("y", top)
            .num("width", right - left)
            .num("height", bottom - top)
            .attr("preserveAspectRatio", "none")
            .attr("image-rendering", "optimizeSpeed")
            .attr("style", "image-rendering:pixelated")
            .attr("href", &backdrop.data_uri),
    );
}

pub(crate) fn draw_item(writer: &mut Writer, view: &View, item: &Item) {
    let style = item.style;
    match &item.shape {
        Shape::Path(points) => marks::draw_line(writer, style, &pixels(view, points)),
        Shape::Segments(segments) => {
            let segments: Vec<(Px, Px)> =
                segments.iter().map(|&(a, b)| (view.px(a), view.px(b))).collect();
            marks::draw_segments(writer, style, &segments);
        }
        Shape::Dots(points) => marks::draw_dots(writer, style, 2.2, &pixels(view, points)),
        Shape::Ellipses(ellipses) => draw_ellipses(writer, view, style, ellipses),
        Shape::Poses(poses) => {
            let poses: Vec<(Px, f64)> =
                poses.iter().map(|pose| (view.px((pose.x, pose.y)), pose.theta)).collect();
            marks::draw_arrows(writer, style, &poses);
        }
        Shape::Crosses(crosses) => {
            let places: Vec<Px> = crosses.iter().map(|(place, _)| view.px(*place)).collect();
            marks::draw_crosses(writer, style, &places);
        }
        Shape::Stars(points) => marks::draw_stars(writer, style, &pixels(view, points)),
    }
}

fn pixels(view: &View, points: &[(f64, f64)]) -> Vec<Px> {
    points
        .iter()
        .map(|&point| if is_place(point) { view.px(point) } else { (f64::NAN, f64::NAN) })
        .collect()
}

fn draw_ellipses(writer: &mut Writer, view: &View, style: Style, ellipses: &[Ellipse]) {
    writer.open(Element::new("g").line_style(style, 1.2).region(style));
    for ellipse in ellipses {
        let (x, y) = view.px((ellipse.center.x, ellipse.center.y));
        let turn = -ellipse.angle.to_degrees();
        let [turn, cx, cy] = [turn, x, y].map(number);
        // A certain direction still leaves a line to be seen.
        let radius = |semi_axis: f64| (semi_axis.abs() * view.scale()).clamp(0.3, 1e5);
        writer.add(
            Element::new("ellipse")
                .num("cx", x)
                .num("cy", y)
                .num("rx", radius(ellipse.semi_major))
                .num("ry", radius(ellipse.semi_minor))
                .attr("transform", &format!("rotate({turn} {cx} {cy})")),
        );
    }
    writer.close();
}

/// The names of all crosses, on top of everything.
fn draw_names(writer: &mut Writer, view: &View, scene: &Scene) {
    let crosses = scene.items.iter().filter_map(|item| match &item.shape {
        Shape::Crosses(crosses) => Some(crosses),
        _ => None,
    });
    let names: Vec<(Px, &str)> =
        crosses.flatten().map(|(place, name)| (view.px(*place), name.as_str())).collect();
    if names.iter().any(|(_, name)| !name.is_empty()) {
        labels::draw_names(writer, &mut booked_room(view, scene), &names);
    }
}

/// The room that lines and marks take.
fn booked_room(view: &View, scene: &Scene) -> Room {
    let mut room = Room::new(view.area);
    for item in &scene.items {
        match &item.shape {
            Shape::Path(points) => {
                let pixels = pixels(view, points);
                marks::runs(&pixels).for_each(|run| room.book_path(run));
            }
            Shape::Segments(segments) => {
                segments.iter().for_each(|&(a, b)| room.book_segment(view.px(a), view.px(b)));
            }
            Shape::Crosses(crosses) => {
                crosses.iter().for_each(|(place, _)| room.book_mark(view.px(*place), 3.0));
            }
            Shape::Stars(points) => {
                points.iter().for_each(|&point| room.book_mark(view.px(point), 5.0));
            }
            Shape::Poses(poses) => {
                poses.iter().for_each(|pose| room.book_mark(view.px((pose.x, pose.y)), 7.0));
            }
            Shape::Dots(_) | Shape::Ellipses(_) => {}
        }
    }
    room
}
