//! Shapes in pixels: lines, dots, crosses, stars, arrows. Scenes, charts and legends share them.

use super::style::{Paint, Style};
use super::thin;
use super::writer::{Element, Writer, push_point};
use std::collections::HashSet;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A point of the figure \[px\], y down.
pub(super) type Px = (f64, f64);

/// How far thinning may move a line \[px\]: 0.3 px where the figure is shown 1600 px wide.
pub(super) const TOLERANCE: f64 = 0.12;

/// The stretches of a polyline between points that cannot be drawn.
pub(super) fn runs(points: &[Px]) -> impl Iterator<Item = &[Px]> {
    points.split(|(x, y)| !(x.is_finite() && y.is_finite())).filter(|run| !run.is_empty())
}

/// Data of a path through points; a single one becomes a dot under a round pen.
pub(super) fn polyline(points: &[Px]) -> String {
    let mut data = String::new();
    for (index, &point) in points.iter().enumerate() {
        match index {
            0 => data.push('M'),
            1 => data.push('L'),
            _ => data.push(' '),
        }
        push_point(&mut data, point);
    }
    if points.len() == 1 {
        data.push_str("h.01");
    }
    data
}

/// A polyline, broken at points that are not finite and thinned to what can be seen.
pub(super) fn draw_line(writer: &mut Writer, style: Style, points: &[Px]) {
    let data: String = runs(points).map(|run| polyline(&thin::simplify(run, TOLERANCE))).collect();
    if !data.is_empty() {
        let path = Element::new("path").attr("d", &data).no_fill();
        writer.add(path.line_style(style, 1.8));
    }
}

/// Separate segments.
pub(super) fn draw_segments(writer: &mut Writer, style: Style, segments: &[(Px, Px)]) {
    let data: String = segments.iter().map(|&(a, b)| polyline(&[a, b])).collect();
    if !data.is_empty() {
        let path = Element::new("path").attr("d", &data).no_fill();
        writer.add(path.line_style(style, 1.8));
    }
}

/// Dots; of those within the same half pixel, one.
pub(super) fn draw_dots(writer: &mut Writer, style: Style, usual: f64, points: &[Px]) {
    let mut seen = HashSet::new();
    let data: String = points
        .iter()
        .filter(|(x, y)| x.is_finite() && y.is_finite())
        .filter(|(x, y)| seen.insert(((x * 2.0).round() as i64, (y * 2.0).round() as i64)))
        .map(|&point| polyline(&[point]))
        .collect();
    if !data.is_empty() {
        let path = Element::new("path").attr("d", &data).no_fill();
        let path = path.stroke(style.paint(), style.width_or(usual));
        writer.add(path.attr("stroke-linecap", "round"));
    }
}

/// Crosses like the letter x.
pub(super) fn draw_crosses(writer: &mut Writer, style: Style, points: &[Px]) {
    const ARM: f64 = 4.5;
    let data: String = points
        .iter()
        .map(|&(x, y)| {
            let down = polyline(&[(x - ARM, y - ARM), (x + ARM, y + ARM)]);
            down + &polyline(&[(x - ARM, y + ARM), (x + ARM, y - ARM)])
        })
        .collect();
    if !data.is_empty() {
        let path = Element::new("path").attr("d", &data).no_fill();
        writer.add(path.line_style(style, 2.2));
    }
}

/// Five-pointed stars.
pub(super) fn draw_stars(writer: &mut Writer, style: Style, points: &[Px]) {
    let outlines = points.iter().map(|&(x, y)| {
        let corner = |k: usize| {
            let radius = if k.is_multiple_of(2) { 6.0 } else { 2.5 };
            let (sin, cos) = (k as f64 * TAU / 10.0 - FRAC_PI_2).sin_cos();
            (x + radius * cos, y + radius * sin)
        };
        polyline(&(0..10).map(corner).collect::<Vec<_>>()) + "Z"
    });
    draw_solids(writer, style, &outlines.collect::<String>());
}

/// Arrow heads whose middle is the position and whose tip shows the heading \[rad\].
pub(super) fn draw_arrows(writer: &mut Writer, style: Style, poses: &[(Px, f64)]) {
    let outlines = poses.iter().map(|&((x, y), heading)| {
        let corner = |(radius, turn): (f64, f64)| {
            let (sin, cos) = (heading + turn).sin_cos();
            (x + radius * cos, y - radius * sin)
        };
        let corners = [(9.0, 0.0), (7.5, 0.8 * PI), (2.5, PI), (7.5, -0.8 * PI)];
        polyline(&corners.map(corner)) + "Z"
    });
    draw_solids(writer, style, &outlines.collect::<String>());
}

/// Filled outlines with a fine rim of paper, which keeps neighbours apart.
fn draw_solids(writer: &mut Writer, style: Style, data: &str) {
    if !data.is_empty() {
        let path = Element::new("path").attr("d", data).fill(style.paint());
        let path = path.stroke(Paint::PAPER, 0.8);
        writer.add(path.attr("stroke-linejoin", "round"));
    }
}
