//! Twelve moments of a particle filter (M3): the map, the cloud, and the robot in it.

use super::FigureFile;
use super::moments::{self, Look};
use crate::localizer::Cloud;
use crate::output::backdrop;
use crate::output::svg::{Frames, Role, Scene, Style};
use crate::record::{MethodRecord, Run};
use loc_core::{Pose2, Stamped};

/// Length of a particle's pointer, as a share of the map's larger side.
const POINTER: f64 = 0.018;

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
    let looks: Vec<Look> = moments.iter().map(|moment| moment.look).collect();
    for index in moments::choose(&looks) {
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
    cloud: &'a Cloud,
    truth: Option<Pose2>,
    carried: bool,
    look: Look,
}

impl<'a> Moment<'a> {
    fn of(run: &Run, snapshot: &'a Stamped<Cloud>) -> Self {
        let Stamped { stamp, value: cloud } = snapshot;
        let truth = moments::truth_at(run, *stamp);
        let total: f64 = cloud.particles.iter().map(|(_, weight)| weight).sum();
        let mean = |of: &dyn Fn(Pose2) -> f64| -> f64 {
            cloud.particles.iter().map(|(pose, weight)| weight * of(*pose)).sum::<f64>() / total
        };
        let (x, y) = (mean(&|pose| pose.x), mean(&|pose| pose.y));
        let squared = mean(&|pose| (pose.x - x).powi(2) + (pose.y - y).powi(2));
        let error = truth.map_or(0.0, |truth| f64::hypot(truth.x - x, truth.y - y));
        Moment {
            cloud,
            truth,
            carried: run.setup.kidnapped_at.is_some_and(|at| *stamp >= at),
            look: Look { time: stamp - run.setup.start, spread: squared.sqrt(), error },
        }
    }

    fn caption(&self) -> String {
        let after = if self.carried { ", kidnapped" } else { "" };
        format!("{:.1} s, ± {:.2} m{after}", self.look.time, self.look.spread)
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
