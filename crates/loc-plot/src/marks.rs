//! Shapes in pixels: lines, dots, crosses, stars, arrows. Scenes, charts and legends share them.
//!
//! A recording has a hundred thousand poses, a figure some hundred pixels. Points are left out
//! only where the eye cannot tell: [`simplify`] for shapes, [`thin_columns`] for curves that swing
//! faster than pixels follow.

use crate::style::{Paint, Style};
use crate::writer::{Element, Writer, push_point};
use std::collections::HashSet;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A point of the figure \[px\], y down.
pub(crate) type Px = (f64, f64);

/// How far thinning may move a line \[px\]: 0.3 px where the figure is shown 1600 px wide.
pub(crate) const TOLERANCE: f64 = 0.12;

/// The stretches of a polyline between points that cannot be drawn.
pub(crate) fn runs(points: &[Px]) -> impl Iterator<Item = &[Px]> {
    points.split(|(x, y)| !(x.is_finite() && y.is_finite())).filter(|run| !run.is_empty())
}

/// Data of a path through points; a single one becomes a dot under a round pen.
pub(crate) fn polyline(points: &[Px]) -> String {
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
pub(crate) fn draw_line(writer: &mut Writer, style: Style, points: &[Px]) {
    let data: String = runs(points).map(|run| polyline(&simplify(run, TOLERANCE))).collect();
    if !data.is_empty() {
        let path = Element::new("path").attr("d", &data).no_fill();
        writer.add(path.line_style(style, 1.8));
    }
}

/// Separate segments.
pub(crate) fn draw_segments(writer: &mut Writer, style: Style, segments: &[(Px, Px)]) {
    let data: String = segments.iter().map(|&(a, b)| polyline(&[a, b])).collect();
    if !data.is_empty() {
        let path = Element::new("path").attr("d", &data).no_fill();
        writer.add(path.line_style(style, 1.8));
    }
}

/// Dots; of those within the same half pixel, one.
pub(crate) fn draw_dots(writer: &mut Writer, style: Style, usual: f64, points: &[Px]) {
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
pub(crate) fn draw_crosses(writer: &mut Writer, style: Style, points: &[Px]) {
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
pub(crate) fn draw_stars(writer: &mut Writer, style: Style, points: &[Px]) {
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
pub(crate) fn draw_arrows(writer: &mut Writer, style: Style, poses: &[(Px, f64)]) {
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

/// Points per block of [`simplify`]; its time is at worst this many times the number of points.
const BLOCK: usize = 1024;

/// The points of a polyline that matter: each point left out lies within `tolerance` of the
/// segment that replaces it.
///
/// The algorithm is that of Ramer (1972), Douglas and Peucker (1973): keep the point farthest
/// from the segment between the ends, and go on on both sides of it, until none is farther than
/// `tolerance`. It runs over blocks of 1024 points, whose ends are always kept, so that it stays
/// linear for any input. Distances are taken to the segment, not to its line: a path that turns
/// back keeps its tip. The points must be finite.
pub fn simplify(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let last = points.len() - 1;
    let mut keep = vec![false; points.len()];
    let mut open: Vec<(usize, usize)> =
        (0..last).step_by(BLOCK).map(|start| (start, (start + BLOCK).min(last))).collect();
    for &(start, end) in &open {
        (keep[start], keep[end]) = (true, true);
    }
    while let Some((start, end)) = open.pop() {
        if let Some((index, distance)) = farthest(points, start, end)
            && distance > tolerance
        {
            keep[index] = true;
            open.push((start, index));
            open.push((index, end));
        }
    }
    points.iter().zip(keep).filter_map(|(&point, kept)| kept.then_some(point)).collect()
}

/// The inner point farthest from the segment between two points, with its distance.
fn farthest(points: &[(f64, f64)], start: usize, end: usize) -> Option<(usize, f64)> {
    (start + 1..end)
        .map(|index| {
            let distance = distance_to_segment(points[index], points[start], points[end]);
            (index, distance)
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

fn distance_to_segment(point: (f64, f64), from: (f64, f64), to: (f64, f64)) -> f64 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let (px, py) = (point.0 - from.0, point.1 - from.1);
    let length_squared = dx * dx + dy * dy;
    let share = if length_squared > 0.0 {
        ((px * dx + py * dy) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    f64::hypot(px - share * dx, py - share * dy)
}

/// A curve over x with at most four points per column of the given `width`: of each run of points
/// in one column the first, the lowest, the highest and the last.
///
/// This is M4 of Jugel et al. (2014): the vertical stroke that a column shows stays exactly the
/// same. The points must be finite, the width positive.
pub fn thin_columns(points: &[(f64, f64)], width: f64) -> Vec<(f64, f64)> {
    let column = |point: &(f64, f64)| (point.0 / width).floor();
    points
        .chunk_by(|a, b| column(a).total_cmp(&column(b)).is_eq())
        .flat_map(|run| {
            let by_y = |a: &usize, b: &usize| run[*a].1.total_cmp(&run[*b].1);
            let lowest = (0..run.len()).min_by(by_y).unwrap_or(0);
            let highest = (0..run.len()).max_by(by_y).unwrap_or(0);
            let mut kept = vec![0, lowest, highest, run.len() - 1];
            kept.sort_unstable();
            kept.dedup();
            kept.into_iter().map(|index| run[index])
        })
        .collect()
}
