//! The drive on the map: true and estimated paths, ellipses, landmarks and what was measured; and
//! lines of scans beside lines of the map, at the moments that corrected the pose most (H4).

use super::{FigureFile, every};
use crate::localizer::Method;
use crate::output::backdrop;
use crate::record::{MethodRecord, Run};
use loc_core::{Ellipse, Gaussian, Pose2, Stamped};
use loc_filters::line_matching::LineUpdate;
use loc_filters::localizer::Estimate;
use loc_maps::LineSegment;
use loc_plot::{Frames, Role, Scene, Style};
use loc_sensors::features::Line;
use nalgebra::Point2;

/// More methods than this get neither arrows nor an entry each for their ellipses.
const FEW: usize = 4;

/// About how many ellipses and arrows are drawn along a path.
const MARKS: usize = 24;

/// Longest half axis of an ellipse that is drawn beside other methods, as a share of the extent.
const LARGEST_ELLIPSE: f64 = 0.2;

/// An estimate that moves farther at once does not follow a robot \[m\].
const JUMP: f64 = 1.0;

/// About how many measured landmark positions are drawn.
const STARS: usize = 400;

pub(super) fn map(run: &Run, title: &str) -> FigureFile {
    let mut scene = Scene::new(title).subtitle(subtitle(run));
    if let Some(image) = run.setup.map.as_deref().and_then(backdrop) {
        scene = scene.backdrop(image);
    }
    let largest = LARGEST_ELLIPSE * extent(run);
    for (k, record) in run.methods.iter().enumerate() {
        let label = match (run.methods.len() > FEW, k) {
            (false, _) => format!("{}, 2 sigma", record.name()),
            (true, 0) => "2 sigma, each in its colour".into(),
            (true, _) => String::new(),
        };
        let ellipses = marked(&record.estimates).filter_map(two_sigma);
        // The ellipses of a method that is lost would hide everything else.
        let alone = run.methods.len() == 1 && record.snapshots.is_empty();
        let fits = |ellipse: &Ellipse| alone || ellipse.semi_major < largest;
        scene = scene.ellipses(Role::Method(k).width(0.9), &label, ellipses.filter(fits));
    }
    for (k, record) in run.methods.iter().enumerate() {
        scene = drawn_map(scene, k, record);
    }
    // Beside the landmarks of a drawn map the single observations would be too much.
    let draws = run.methods.iter().any(|record| record.map.is_some());
    if let Some(seen) = run.methods.iter().rev().filter(|_| !draws).find_map(measured) {
        scene = scene.stars(Role::Measurement, "landmark as measured", seen);
    }
    for (k, record) in run.methods.iter().enumerate() {
        scene = scene.path(line(run, k), &record.name(), estimated_path(record));
        let arrows = record.method != Method::DeadReckoning && record.snapshots.is_empty();
        if (arrows && run.methods.len() <= FEW) || run.methods.len() == 1 {
            scene = scene.poses(Role::Method(k), "", marked(&record.estimates).map(|e| e.pose));
        }
    }
    let style = if has_particles(run) { Role::Truth.width(1.4) } else { Role::Truth.dotted() };
    if !run.truth.is_empty() {
        scene = scene.path(style, "true path", true_path(run));
    }
    scene = kidnapping(run, scene);
    let landmarks = run
        .setup
        .landmarks
        .iter()
        .map(|landmark| ((landmark.position.x, landmark.position.y), landmark.id.to_string()));
    if !run.setup.landmarks.is_empty() {
        scene = scene.crosses(Role::Landmark, "landmark", landmarks);
    }
    FigureFile::new(
        "map.svg",
        "True and estimated paths with 2-sigma ellipses, landmarks and measurements",
        scene.render(),
    )
}

/// The map that a method has drawn: its landmarks with their uncertainty.
fn drawn_map(scene: Scene, k: usize, record: &MethodRecord) -> Scene {
    let Some(map) = &record.map else { return scene };
    let confirmed = || map.landmarks.iter().filter(|landmark| landmark.confirmed);
    let label = format!("landmark of {}, 2 sigma", record.method);
    let places = confirmed().map(|landmark| landmark.position.mean).map(|p| (p.x, p.y));
    scene
        .ellipses(Role::Method(k).width(1.2), &label, confirmed().map(|l| l.position.ellipse(2.0)))
        .dots(Role::Method(k).width(3.0), "", places)
}

/// Whether the run is drawn as the lectures draw Monte Carlo localization (M10): the true path
/// solid, odometry dotted, the estimate dashed. With Kalman filters (H2) the true path is dotted.
fn has_particles(run: &Run) -> bool {
    let kalman = run.methods.iter().any(|record| record.method == Method::Ekf);
    !kalman && run.methods.iter().any(|record| !record.snapshots.is_empty())
}

/// How the path of the k-th method is drawn.
fn line(run: &Run, k: usize) -> Style {
    match run.methods[k].method {
        _ if !has_particles(run) => Role::Method(k).into(),
        Method::DeadReckoning => Role::Method(k).dotted(),
        _ => Role::Method(k).dashed().width(2.2),
    }
}

/// The estimated path, broken where the estimate of a particle filter jumps: no path leads there.
fn estimated_path(record: &MethodRecord) -> Vec<(f64, f64)> {
    let mut path = Vec::with_capacity(record.estimates.len());
    let mut last: Option<Pose2> = None;
    for Estimate { pose, .. } in &record.estimates {
        let jumped = last.is_some_and(|last| last.distance(*pose) > JUMP);
        path.extend((jumped && !record.snapshots.is_empty()).then_some((f64::NAN, f64::NAN)));
        path.push((pose.x, pose.y));
        last = Some(*pose);
    }
    path
}

/// The true path, broken where the robot was carried.
fn true_path(run: &Run) -> Vec<(f64, f64)> {
    let mut path = Vec::with_capacity(run.truth.len() + 1);
    for (k, truth) in run.truth.iter().enumerate() {
        let carried = k > 0 && run.was_kidnapped(run.truth[k - 1].stamp, truth.stamp);
        path.extend(carried.then_some((f64::NAN, f64::NAN)));
        path.push((truth.value.pose.x, truth.value.pose.y));
    }
    path
}

/// Where the robot was picked up and put down.
fn kidnapping(run: &Run, scene: Scene) -> Scene {
    let pairs = run.truth.windows(2);
    let carried = pairs.filter(|pair| run.was_kidnapped(pair[0].stamp, pair[1].stamp));
    let places = carried.flat_map(|pair| {
        let [from, to] = [0, 1].map(|k| (pair[k].value.pose.x, pair[k].value.pose.y));
        [(from, "carried off"), (to, "put down")]
    });
    let places: Vec<_> = places.collect();
    if places.is_empty() { scene } else { scene.crosses(Role::Measurement, "kidnapping", places) }
}

/// Diagonal of the box around the true path \[m\]; without one, around what the last method
/// believes.
fn extent(run: &Run) -> f64 {
    let last = run.methods.last().filter(|_| run.truth.is_empty());
    let believed = || last.into_iter().flat_map(|record| &record.estimates).map(|e| e.pose);
    let poses = || run.truth.iter().map(|truth| truth.value.pose).chain(believed());
    let span = |of: fn(&Pose2) -> f64| {
        let values = || poses().map(|pose| of(&pose));
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
    };
    f64::hypot(span(|pose| pose.x), span(|pose| pose.y))
}

fn subtitle(run: &Run) -> String {
    let names: Vec<_> = run.methods.iter().map(MethodRecord::name).collect();
    let many = names.len() > FEW;
    let methods = if many { format!("{} methods", names.len()) } else { names.join(" and ") };
    let distance = run.distance().map_or(String::new(), |distance| format!("{distance:.1} m in "));
    format!("{methods}, {distance}{:.1} s", run.duration())
}

fn marked(estimates: &[Estimate]) -> impl Iterator<Item = &Estimate> {
    estimates.iter().skip(1).step_by(every(estimates.len(), MARKS))
}

fn two_sigma(estimate: &Estimate) -> Option<Ellipse> {
    let belief = Gaussian { mean: estimate.pose.to_vector(), covariance: estimate.covariance? };
    Some(belief.position().ellipse(2.0))
}

/// Where a method's accepted measurements put the landmarks, thinned; `None` without any.
fn measured(record: &MethodRecord) -> Option<Vec<(f64, f64)>> {
    let seen: Vec<(f64, f64)> = record
        .outcomes
        .iter()
        .filter(|outcome| outcome.value.accepted())
        .filter_map(|outcome| outcome.value.observed_at)
        .map(|place| (place.x, place.y))
        .collect();
    let step = every(seen.len(), STARS);
    (!seen.is_empty()).then(|| seen.into_iter().step_by(step).collect())
}

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
    Some(FigureFile::new(
        "lines.svg",
        "Lines of a scan, lines that the map predicts, and the pairs of both",
        frames.render(),
    ))
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
