//! The drive on the map: true and estimated paths, ellipses, landmarks and what was measured.

use super::{FigureFile, every};
use crate::localizer::{Estimate, Method};
use crate::output::backdrop;
use crate::output::svg::{Role, Scene};
use crate::record::{MethodRecord, Run};
use loc_core::{Ellipse, Gaussian, Pose2};

/// About how many ellipses and arrows are drawn along a path.
const MARKS: usize = 24;

/// Longest half axis of an ellipse that is drawn beside other methods, as a share of the extent.
const LARGEST_ELLIPSE: f64 = 0.2;

/// About how many measured landmark positions are drawn.
const STARS: usize = 400;

pub(super) fn map(run: &Run, title: &str) -> FigureFile {
    let mut scene = Scene::new(title).subtitle(subtitle(run));
    if let Some(image) = run.setup.map.as_deref().and_then(backdrop) {
        scene = scene.backdrop(image);
    }
    let largest = LARGEST_ELLIPSE * extent(run);
    for (k, record) in run.methods.iter().enumerate() {
        let label = format!("{}, 2 sigma", record.method);
        let ellipses = marked(&record.estimates).filter_map(two_sigma);
        // The ellipses of a method that is lost would hide everything else.
        let fits = |ellipse: &Ellipse| run.methods.len() == 1 || ellipse.semi_major < largest;
        scene = scene.ellipses(Role::Method(k).width(0.9), &label, ellipses.filter(fits));
    }
    if let Some(seen) = run.methods.iter().rev().find_map(measured) {
        scene = scene.stars(Role::Measurement, "landmark as measured", seen);
    }
    for (k, record) in run.methods.iter().enumerate() {
        let path = record.estimates.iter().map(|e| (e.pose.x, e.pose.y));
        scene = scene.path(Role::Method(k), record.method.name(), path);
        if record.method != Method::DeadReckoning || run.methods.len() == 1 {
            scene = scene.poses(Role::Method(k), "", marked(&record.estimates).map(|e| e.pose));
        }
    }
    let truth = run.truth.iter().map(|t| (t.value.pose.x, t.value.pose.y));
    scene = scene.path(Role::Truth.dotted(), "true path", truth);
    let landmarks = run
        .setup
        .landmarks
        .iter()
        .map(|landmark| ((landmark.position.x, landmark.position.y), landmark.id.to_string()));
    scene = scene.crosses(Role::Landmark, "landmark", landmarks);
    FigureFile {
        file: "map.svg",
        caption: "True and estimated paths with 2-sigma ellipses, landmarks and measurements",
        svg: scene.render(),
    }
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
    let methods: Vec<&str> = run.methods.iter().map(|record| record.method.name()).collect();
    let distance = run.distance().map_or(String::new(), |distance| format!("{distance:.1} m in "));
    format!("{}, {distance}{:.1} s", methods.join(" and "), run.duration())
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
        .judgements
        .iter()
        .filter(|judgement| judgement.value.accepted)
        .filter_map(|judgement| judgement.value.seen_at)
        .map(|place| (place.x, place.y))
        .collect();
    let step = every(seen.len(), STARS);
    (!seen.is_empty()).then(|| seen.into_iter().step_by(step).collect())
}
