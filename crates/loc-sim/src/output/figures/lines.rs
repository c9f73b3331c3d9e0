//! Lines of scans and lines of the map, at the moments that corrected the pose most (H4).

use super::FigureFile;
use crate::output::svg::{Frames, Role, Scene};
use crate::record::{MethodRecord, Run};
use loc_core::{Pose2, Stamped};
use loc_filters::line_matching::LineUpdate;
use loc_maps::LineSegment;
use loc_sensors::features::Line;
use nalgebra::Point2;

/// What is drawn lies this far from the robot at most, along both axes \[m\].
const REACH: f64 = 7.0;

/// Green for what was seen, pink for what was predicted, as the lectures have it.
const SEEN: Role = Role::Method(2);
const PREDICTED: Role = Role::Method(3);

/// The matching of the last method that matches lines.
pub(super) fn lines(run: &Run) -> Option<FigureFile> {
    let has_lines = |(_, record): &(usize, &MethodRecord)| record.lines.iter().next().is_some();
    let (k, record) = run.methods.iter().enumerate().rfind(has_lines)?;
    let mut frames = Frames::new(format!("{}: lines of the scan and of the map", record.method))
        .subtitle("where they moved the pose most; dotted: the scan from the predicted pose")
        .columns(2);
    for Stamped { stamp, value } in record.lines.iter() {
        let time = stamp - run.setup.start;
        frames = frames.frame(caption(time, value), scene(value, Role::Method(k)));
    }
    Some(FigureFile {
        file: "lines.svg".into(),
        caption: "Lines of a scan, lines that the map predicts, and the pairs of both".into(),
        svg: frames.render(),
    })
}

fn caption(time: f64, update: &LineUpdate) -> String {
    let (before, after) = (update.before.pose(), update.after.pose());
    let turn = before.between(after).theta.to_degrees();
    let (matched, seen) = (update.matched(), update.seen.len());
    let moved = 100.0 * before.distance(after);
    format!("{time:.1} s: {matched} of {seen} lines, {moved:.1} cm, {turn:+.1} deg")
}

/// All of it about the predicted pose.
fn scene(update: &LineUpdate, role: Role) -> Scene {
    let (before, after) = (update.before.pose(), update.after.pose());
    let here = Pose2 { theta: 0.0, ..before };
    let local = |segment: LineSegment| clipped(&segment.seen_from(here));
    let from = |pose: Pose2, line: &Line| {
        let scanner = pose * update.mounting;
        LineSegment { start: scanner.transform(&line.start), end: scanner.transform(&line.end) }
    };
    let matched = |index: usize| update.pairs[index].is_some_and(|pair| pair.innovation.accepted);
    let seen = |pose: Pose2, wanted: bool| {
        let lines = update.seen.iter().enumerate().filter(move |(k, _)| matched(*k) == wanted);
        lines.filter_map(move |(_, line)| local(from(pose, line)))
    };
    let pairs = update.seen.iter().zip(&update.pairs).filter_map(|(line, pair)| {
        let pair = pair.filter(|pair| pair.innovation.accepted)?;
        let dotted = from(before, line);
        let stretch = update.predicted_in_map().nth(pair.predicted)?;
        let middle = dotted.at(0.5);
        let foot = stretch.at(stretch.nearest_fraction(&middle));
        local(LineSegment { start: middle, end: foot })
    });
    let relative = |pose: Pose2| Pose2 { x: pose.x - here.x, y: pose.y - here.y, ..pose };
    Scene::new("")
        .segments(
            PREDICTED.width(3.4),
            "predicted",
            update.predicted_in_map().filter_map(local).map(ends),
        )
        .segments(SEEN.dotted().width(1.4), "", seen(before, true).map(ends))
        .segments(Role::Truth.width(0.8), "pair", pairs.map(ends))
        .segments(SEEN.width(1.5), "scan", seen(after, true).map(ends))
        .segments(
            Role::Measurement.width(1.5),
            "scan, without partner",
            seen(after, false).map(ends),
        )
        .poses(Role::Reference, "predicted pose", [relative(before)])
        .poses(role, "corrected pose", [relative(after)])
}

fn ends(segment: LineSegment) -> ((f64, f64), (f64, f64)) {
    ((segment.start.x, segment.start.y), (segment.end.x, segment.end.y))
}

/// The part of a segment in the square that is drawn; `None` for nothing.
fn clipped(segment: &LineSegment) -> Option<LineSegment> {
    let (start, along) = (segment.start, segment.end - segment.start);
    let (mut from, mut to) = (0.0_f64, 1.0_f64);
    for axis in 0..2 {
        let borders = [-REACH, REACH].map(|border| (border - start[axis]) / along[axis]);
        if along[axis] != 0.0 {
            from = from.max(borders[0].min(borders[1]));
            to = to.min(borders[0].max(borders[1]));
        } else if start[axis].abs() > REACH {
            return None;
        }
    }
    let at = |fraction: f64| -> Point2<f64> { segment.at(fraction) };
    (from <= to).then(|| LineSegment { start: at(from), end: at(to) })
}
