//! Clouds before and after resampling, each with its covariance (M10).

use super::FigureFile;
use crate::localizer::Cloud;
use crate::output::backdrop;
use crate::output::svg::{Frames, Role, Scene};
use crate::record::{MethodRecord, Run};
use loc_core::{Ellipse, Gaussian, Pose2, Stamped};
use nalgebra::{Matrix2, Vector2};

/// Particles with their weights.
type Weighted = [(Pose2, f64)];

/// How many moments are shown.
const MOMENTS: usize = 4;

/// A particle of so many equal shares is drawn with the second, third and fourth width.
const SHARES: [f64; 3] = [0.3, 1.0, 3.0];

/// Widths of particles of little to much weight \[px\].
const WIDTHS: [f64; 4] = [0.7, 1.2, 1.9, 2.8];

/// The resamplings of the last method that keeps them; `None` without any.
pub(super) fn resampling(run: &Run) -> Option<FigureFile> {
    let (k, record) = run.methods.iter().enumerate().rfind(|(_, r)| pairs(r).next().is_some())?;
    let mut frames =
        Frames::new(format!("Clouds of {} before and after resampling", record.method))
            .subtitle("a larger dot is a particle of more weight; ellipses of 2 sigma")
            .columns(2);
    if let Some(image) = run.setup.map.as_deref().and_then(backdrop) {
        frames = frames.backdrop(image);
    }
    for (stamp, cloud, weighed) in chosen(record) {
        let time = stamp - run.setup.start;
        let scene = |particles| scene(run, Role::Method(k), stamp, particles);
        frames = frames.frame(format!("{time:.1} s, weighed"), scene(weighed));
        frames = frames.frame(format!("{time:.1} s, resampled"), scene(&cloud.particles));
    }
    Some(FigureFile {
        file: "resampling.svg".into(),
        caption: "Clouds before and after resampling with their covariances".into(),
        svg: frames.render(),
    })
}

/// Stamps \[s\], clouds, and what they were resampled from.
fn pairs(record: &MethodRecord) -> impl Iterator<Item = (f64, &Cloud, &Weighted)> {
    record.snapshots.iter().filter_map(|Stamped { stamp, value }| {
        value.weighed.as_deref().map(|weighed| (*stamp, value, weighed))
    })
}

/// Of each part of the run the resampling with the widest cloud.
fn chosen(record: &MethodRecord) -> Vec<(f64, &Cloud, &Weighted)> {
    let all: Vec<_> = pairs(record).collect();
    let parts = all.chunks(all.len().div_ceil(MOMENTS).max(1));
    let spread = |weighed: &Weighted| covariance(weighed).covariance.trace();
    let widest = |part: &[(f64, &'_ Cloud, &'_ Weighted)]| {
        (0..part.len()).max_by(|&a, &b| spread(part[a].2).total_cmp(&spread(part[b].2)))
    };
    parts.filter_map(|part| widest(part).map(|index| part[index])).collect()
}

fn scene(run: &Run, role: Role, stamp: f64, particles: &Weighted) -> Scene {
    let equal = particles.iter().map(|(_, weight)| weight).sum::<f64>() / particles.len() as f64;
    let class =
        |weight: f64| SHARES.iter().filter(|share| weight >= *share * equal * 0.999).count();
    let mut scene = Scene::new("");
    for (kind, width) in WIDTHS.iter().enumerate() {
        let dots = particles.iter().filter(|(_, weight)| class(*weight) == kind);
        let dots = dots.map(|(pose, _)| (pose.x, pose.y));
        let label = if kind == 2 { "particle" } else { "" };
        scene = scene.dots(role.width(*width), label, dots);
    }
    let landmarks = run.setup.landmarks.iter();
    let landmarks = landmarks.map(|l| ((l.position.x, l.position.y), ""));
    scene = scene.ellipses(Role::Landmark.width(1.6), "2 sigma", [ellipse(particles)]).crosses(
        Role::Landmark,
        "landmark",
        landmarks,
    );
    let next = run.truth.partition_point(|truth| truth.stamp < stamp - 1e-6);
    let truth = run.truth.get(next).or(run.truth.last()).map(|truth| truth.value.pose);
    scene.poses(Role::Truth, "robot", truth)
}

fn ellipse(particles: &Weighted) -> Ellipse {
    covariance(particles).ellipse(2.0)
}

/// Weighted mean and covariance of the positions.
fn covariance(particles: &Weighted) -> Gaussian<2> {
    let total: f64 = particles.iter().map(|(_, weight)| weight).sum();
    let places = || particles.iter().map(|(pose, w)| (Vector2::new(pose.x, pose.y), w / total));
    let mean: Vector2<f64> = places().map(|(place, weight)| weight * place).sum();
    let squares = places().map(|(place, weight)| {
        let deviation = place - mean;
        weight * deviation * deviation.transpose()
    });
    Gaussian { mean, covariance: squares.sum::<Matrix2<f64>>() }
}
