//! Horizontal lines to compare with, and vertical ones where something happened.

use super::draw::pixels;
use super::{Chart, Data};
use crate::output::svg::axis::{Axis, TICK_SIZE};
use crate::output::svg::frame::Area;
use crate::output::svg::marks;
use crate::output::svg::room::Room;
use crate::output::svg::style::{Paint, Role};
use crate::output::svg::text::{self, Anchor};
use crate::output::svg::writer::Writer;

/// The lines themselves.
pub(super) fn draw_lines(writer: &mut Writer, chart: &Chart, area: &Area, y: &Axis) {
    for (value, _) in &chart.references {
        let at = y.px(*value);
        let line = [(area.left, at), (area.right(), at)];
        marks::draw_line(writer, Role::Reference.dashed().width(1.3), &line);
    }
}

/// Vertical lines, and with `named` what happened there.
pub(super) fn draw_marks(
    writer: &mut Writer,
    marks: &[(f64, String)],
    named: bool,
    area: &Area,
    x: &Axis,
) {
    for (value, label) in marks {
        let at = x.px(*value);
        if !(area.left..=area.right()).contains(&at) {
            continue;
        }
        let line = [(at, area.top), (at, area.bottom())];
        marks::draw_line(writer, Role::Truth.dashed().width(1.1), &line);
        if named {
            let width = text::width(label, TICK_SIZE);
            let left = at + 6.0 + width > area.right();
            let (at, anchor) =
                if left { (at - 6.0, Anchor::End) } else { (at + 6.0, Anchor::Start) };
            let place = (at, area.top + 15.0);
            let element = text::element(place, TICK_SIZE, anchor, Paint::INK);
            text::draw_with_halo(writer, element, label);
        }
    }
}

/// The labels of horizontal lines, above or below the line and at its right or left end, wherever
/// they cover least.
pub(super) fn draw_labels(writer: &mut Writer, chart: &Chart, area: &Area, x: &Axis, y: &Axis) {
    let named = |(value, label): &&(f64, String)| y.px(*value).is_finite() && !label.is_empty();
    let references: Vec<_> = chart.references.iter().filter(named).collect();
    if references.is_empty() {
        return;
    }
    let mut room = booked_room(chart, area, x, y);
    for (value, label) in references {
        let at = y.px(*value);
        let label = text::shorten(label, TICK_SIZE, 0.7 * area.width);
        let width = text::width(&label, TICK_SIZE);
        let (right, left) = (area.right() - 8.0 - width, area.left + 8.0);
        let (above, below) = (at - 18.0, at + 2.5);
        let place = |left: f64, top: f64| [left, top, left + width, top + 15.0];
        let places =
            [place(right, above), place(right, below), place(left, above), place(left, below)];
        if let Some([from, _, to, bottom]) = room.take(&places) {
            let (at, anchor) = if from < right { (from, Anchor::Start) } else { (to, Anchor::End) };
            let element = text::element((at, bottom - 2.5), TICK_SIZE, anchor, Paint::MUTED);
            text::draw_with_halo(writer, element, &label);
        }
    }
}

/// The room that lines and points take.
fn booked_room(chart: &Chart, area: &Area, x: &Axis, y: &Axis) -> Room {
    let mut room = Room::new(*area);
    for (value, _) in &chart.references {
        let at = y.px(*value);
        if at.is_finite() {
            room.book_segment((area.left, at), (area.right(), at));
        }
    }
    for series in &chart.series {
        match &series.data {
            Data::Line(points) => {
                let pixels = pixels(points, x, y);
                marks::runs(&pixels).for_each(|run| room.book_path(run));
            }
            Data::Points(points) => {
                let pixels = pixels(points, x, y);
                let shown = marks::runs(&pixels).flatten();
                shown.for_each(|&point| room.book_mark(point, 2.0));
            }
            Data::Band(_) => {}
        }
    }
    room
}
