//! Twelve moments of a particle filter (M3): the map, the cloud, and the robot in it.

use super::FigureFile;
use crate::event::Truth;
use crate::localizer::Cloud;
use crate::output::backdrop;
use crate::output::svg::{Frames, Role, Scene, Style};
use crate::record::{MethodRecord, Run};
use loc_core::{Pose2, Stamped};

/// How many moments are shown.
const FRAMES: usize = 12;
/// Length of a particle's pointer, as a share of the map's larger side.
const POINTER: f64 = 0.018;
/// Spreads and errors below this are all the same \[m\].
const SMALL: f64 = 0.3;
/// How much time counts beside spread and error, which count 1 each.
const TIME: f64 = 0.5;

/// The clouds of the last method that has any.
pub(super) fn clouds(run: &Run) -> Option<FigureFile> {
    let with_clouds = |(_, record): &(usize, &MethodRecord)| !record.snapshots.is_empty();
    let (k, record) = run.methods.iter().enumerate().rfind(with_clouds)?;
    let moments: Vec<Moment> = record.snapshots.iter().map(|s| Moment::of(run, s)).collect();
    let mut frames = Frames::new(format!("The particles of {} over time", record.method))
        .subtitle("with the standard deviation of the position; at most 500 particles are drawn");
    let mut size = extent(&moments);
    if let Some(image) = run.setup.map.as_deref().and_then(backdrop) {
        size = (image.max.0 - image.min.0).max(image.max.1 - image.min.1);
        frames = frames.backdrop(image);
    }
    for index in choose(&moments) {
        let moment = &moments[index];
        frames = frames.frame(moment.caption(), moment.scene(Role::Method(k), POINTER * size));
    }
    Some(FigureFile {
        file: "clouds.svg".into(),
        caption: "The particles over the map at twelve moments, with the true pose".into(),
        svg: frames.render(),
    })
}

/// A cloud with what is known about it.
struct Moment<'a> {
    stamp: f64,
    cloud: &'a Cloud,
    truth: Option<Pose2>,
    carried: bool,
    /// Standard deviation of the position, over both axes \[m\].
    spread: f64,
    /// Distance of the mean from the true position \[m\].
    error: f64,
}

impl<'a> Moment<'a> {
    fn of(run: &Run, snapshot: &'a Stamped<Cloud>) -> Self {
        let Stamped { stamp, value: cloud } = snapshot;
        let truth = truth_at(&run.truth, *stamp).map(|truth| truth.value.pose);
        let total: f64 = cloud.particles.iter().map(|(_, weight)| weight).sum();
        let mean = |of: &dyn Fn(Pose2) -> f64| -> f64 {
            cloud.particles.iter().map(|(pose, weight)| weight * of(*pose)).sum::<f64>() / total
        };
        let (x, y) = (mean(&|pose| pose.x), mean(&|pose| pose.y));
        let squared = mean(&|pose| (pose.x - x).powi(2) + (pose.y - y).powi(2));
        let error = truth.map_or(0.0, |truth| f64::hypot(truth.x - x, truth.y - y));
        Moment {
            stamp: stamp - run.setup.start,
            cloud,
            truth,
            carried: run.setup.kidnapped_at.is_some_and(|at| *stamp >= at),
            spread: squared.sqrt(),
            error,
        }
    }

    fn caption(&self) -> String {
        let after = if self.carried { ", kidnapped" } else { "" };
        format!("{:.1} s, ± {:.2} m{after}", self.stamp, self.spread)
    }

    fn scene(&self, role: Role, pointer: f64) -> Scene {
        let poses = || self.cloud.particles.iter().map(|(pose, _)| *pose);
        let pointers = poses().map(|pose| {
            let tip = pose.transform(&[pointer, 0.0].into());
            ((pose.x, pose.y), (tip.x, tip.y))
        });
        let scene = Scene::new("").segments(role.width(0.6), "", pointers).dots(
            Style::from(role).width(1.7),
            "particle",
            poses().map(|pose| (pose.x, pose.y)),
        );
        match self.truth {
            Some(truth) => scene.ring("robot", 1.6 * pointer, truth),
            None => scene,
        }
    }

    /// How different this moment looks from another one: in time, spread and error.
    fn difference(&self, other: &Moment) -> [f64; 3] {
        let ratio = |a: f64, b: f64| ((a + SMALL) / (b + SMALL)).ln().abs();
        [
            (self.stamp - other.stamp).abs(),
            ratio(self.spread, other.spread),
            ratio(self.error, other.error),
        ]
    }
}

/// The moments to show: the first, the last, and between them those that are equally different
/// from one to the next, so that most frames show what changes most.
fn choose(moments: &[Moment]) -> Vec<usize> {
    if moments.len() <= FRAMES {
        return (0..moments.len()).collect();
    }
    let steps: Vec<[f64; 3]> =
        moments.windows(2).map(|pair| pair[1].difference(&pair[0])).collect();
    let total = |k: usize| steps.iter().map(|step| step[k]).sum::<f64>().max(1e-9);
    let totals = [total(0), total(1), total(2)];
    let mut passed = vec![0.0];
    for step in &steps {
        let weighted = (0..3).map(|k| [TIME, 1.0, 1.0][k] * step[k] / totals[k]);
        passed.push(passed[passed.len() - 1] + weighted.sum::<f64>());
    }
    let all = passed[passed.len() - 1];
    let mut chosen: Vec<usize> = Vec::with_capacity(FRAMES);
    for frame in 0..FRAMES {
        let wanted = all * frame as f64 / (FRAMES - 1) as f64;
        let at = passed.partition_point(|share| *share < wanted - 1e-9);
        // Each frame another moment, and enough of them left for the others.
        let least = chosen.last().map_or(0, |last| last + 1);
        chosen.push(at.clamp(least, moments.len() - FRAMES + frame));
    }
    chosen
}

fn truth_at(truth: &[Stamped<Truth>], stamp: f64) -> Option<&Stamped<Truth>> {
    let next = truth.partition_point(|truth| truth.stamp < stamp - 1e-6);
    truth.get(next).or(truth.last())
}

/// The larger side of the box around all particles \[m\].
fn extent(moments: &[Moment]) -> f64 {
    let poses = || moments.iter().flat_map(|m| m.cloud.particles.iter().map(|(pose, _)| *pose));
    let span = |of: fn(Pose2) -> f64| {
        let (low, high) = poses()
            .map(of)
            .fold((f64::MAX, f64::MIN), |(low, high), value| (low.min(value), high.max(value)));
        (high - low).max(0.0)
    };
    span(|pose| pose.x).max(span(|pose| pose.y))
}
