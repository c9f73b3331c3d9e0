//! Drawing a scene.

use super::bounds::Bounds;
use super::labels;
use super::view::View;
use super::{Backdrop, Item, Scene, Shape};
use crate::output::svg::frame::NAME_HEIGHT;
use crate::output::svg::header::{self, Glyph, Legend};
use crate::output::svg::marks::{self, Px};
use crate::output::svg::room::Room;
use crate::output::svg::style::Style;
use crate::output::svg::writer::{Element, Writer};
use loc_core::Ellipse;

pub(super) fn draw(scene: &Scene) -> String {
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

pub(super) fn legend_of<'a>(items: impl IntoIterator<Item = &'a Item>) -> Legend {
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
pub(super) fn draw_image(
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

pub(super) fn draw_item(writer: &mut Writer, view: &View, item: &Item) {
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
        .map(|&point| if super::is_place(point) { view.px(point) } else { (f64::NAN, f64::NAN) })
        .collect()
}

fn draw_ellipses(writer: &mut Writer, view: &View, style: Style, ellipses: &[Ellipse]) {
    writer.open(Element::new("g").line_style(style, 1.2).region(style));
    for ellipse in ellipses {
        let (x, y) = view.px((ellipse.center.x, ellipse.center.y));
        let turn = -ellipse.angle.to_degrees();
        let [turn, cx, cy] = [turn, x, y].map(crate::output::svg::writer::number);
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
