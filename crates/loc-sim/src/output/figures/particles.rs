//! Particles (M3) and grids (K1) at twelve moments over the map, and particle sets before and after
//! resampling, each with its covariance (M10).

use super::FigureFile;
use crate::output::Canvas;
use crate::output::backdrop;
use crate::record::{MethodRecord, Run};
use loc_core::{Ellipse, Gaussian, Pose2, Stamped};
use loc_filters::localizer::{GridBelief, ParticleSet};
use loc_maps::OccupancyGrid;
use loc_plot::color::LIKELIHOOD;
use loc_plot::{Backdrop, Frames, Role, Scene, Style, color};
use nalgebra::{Matrix2, Vector2};

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
    let stats: Vec<MomentStats> = moments.iter().map(|moment| moment.stats).collect();
    for index in choose(&stats) {
        let moment = &moments[index];
        frames = frames.frame(moment.caption(), moment.scene(Role::Method(k), POINTER * size));
    }
    Some(FigureFile::new(
        "clouds.svg",
        "The particles over the map at twelve moments, with the true pose",
        frames.render(),
    ))
}

/// A cloud with what is known about it.
struct Moment<'a> {
    cloud: &'a ParticleSet,
    truth: Option<Pose2>,
    kidnapped: bool,
    stats: MomentStats,
}

impl<'a> Moment<'a> {
    fn of(run: &Run, snapshot: &'a Stamped<ParticleSet>) -> Self {
        let Stamped { stamp, value: cloud } = snapshot;
        let truth = truth_at(run, *stamp);
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
            kidnapped: run.setup.kidnapped_at.is_some_and(|at| *stamp >= at),
            stats: MomentStats { time: stamp - run.setup.start, spread: squared.sqrt(), error },
        }
    }

    fn caption(&self) -> String {
        let after = if self.kidnapped { ", kidnapped" } else { "" };
        format!("{:.1} s, ± {:.2} m{after}", self.stats.time, self.stats.spread)
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

/// Powers of 10 that the colours reach down to.
const DECADES: f64 = 6.0;
/// Radius of the ring around the robot, as a share of the map's larger side.
const RING: f64 = 0.03;

/// The beliefs of the last method that keeps a grid.
pub(super) fn histogram(run: &Run) -> Option<FigureFile> {
    let record = run.methods.iter().rfind(|record| !record.beliefs.is_empty())?;
    let map = run.setup.map.as_deref()?;
    let canvas = Canvas::new(map)?;
    let moments: Vec<&Stamped<GridBelief>> = record.beliefs.iter().collect();
    let stats: Vec<MomentStats> = moments.iter().map(|moment| stats(run, moment)).collect();
    let mut frames = Frames::new(format!("What {} believes over time", record.method))
        .subtitle("whatever the heading; with the standard deviation of the position")
        .bar(color::bar(&LIKELIHOOD, -DECADES, 0.0, "log10 of the probability of a square"));
    for index in choose(&stats) {
        let scene = Scene::new("").backdrop(paint(&canvas, map, &moments[index].value));
        let scene = match truth_at(run, moments[index].stamp) {
            Some(truth) => scene.ring("robot", RING * canvas.larger_side(), truth),
            None => scene,
        };
        frames = frames.frame(caption(run, moments[index], stats[index]), scene);
    }
    Some(FigureFile::new(
        "histogram.svg",
        "The probability of each place of the map at twelve moments, with the true pose",
        frames.render(),
    ))
}

fn stats(run: &Run, moment: &Stamped<GridBelief>) -> MomentStats {
    let (mean, spread) = moment.value.mean_and_spread();
    let off = |truth: Pose2| f64::hypot(truth.x - mean[0], truth.y - mean[1]);
    let error = truth_at(run, moment.stamp).map_or(0.0, off);
    MomentStats { time: moment.stamp - run.setup.start, spread, error }
}

fn caption(run: &Run, moment: &Stamped<GridBelief>, stats: MomentStats) -> String {
    let kidnapped = run.setup.kidnapped_at.is_some_and(|at| moment.stamp >= at);
    let after = if kidnapped { ", kidnapped" } else { "" };
    format!("{:.1} s, ± {:.2} m{after}", stats.time, stats.spread)
}

/// The belief in colours.
fn paint(canvas: &Canvas, map: &OccupancyGrid, belief: &GridBelief) -> Backdrop {
    canvas.paint(map, |_, place| {
        let square = belief.cells.cell_at(place).and_then(|cell| belief.cells.index(cell));
        let p = square.and_then(|k| belief.probabilities.get(k)).copied();
        color::along(&LIKELIHOOD, 1.0 + f64::from(p.unwrap_or(0.0)).log10() / DECADES)
    })
}

/// How many moments are shown.
const FRAMES: usize = 12;
/// Spreads and errors below this are all the same \[m\].
const SMALL: f64 = 0.3;
/// How much time counts beside spread and error, which count 1 each.
const TIME: f64 = 0.5;

/// How a moment stats.
#[derive(Debug, Clone, Copy)]
pub(super) struct MomentStats {
    /// Since the start \[s\].
    pub(super) time: f64,
    /// Standard deviation of the position, over both axes \[m\].
    pub(super) spread: f64,
    /// Distance of the mean from the true position \[m\].
    pub(super) error: f64,
}

impl MomentStats {
    /// How different this moment stats from another one: in time, spread and error.
    fn difference(&self, other: &MomentStats) -> [f64; 3] {
        let ratio = |a: f64, b: f64| ((a + SMALL) / (b + SMALL)).ln().abs();
        [
            (self.time - other.time).abs(),
            ratio(self.spread, other.spread),
            ratio(self.error, other.error),
        ]
    }
}

/// The moments to show: the first, the last, and between them those that are equally different
/// from one to the next, so that most frames show what changes most.
pub(super) fn choose(moments: &[MomentStats]) -> Vec<usize> {
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

/// Where the robot was, where that is known.
pub(super) fn truth_at(run: &Run, stamp: f64) -> Option<Pose2> {
    let next = run.truth.partition_point(|truth| truth.stamp < stamp - 1e-6);
    run.truth.get(next).or(run.truth.last()).map(|truth| truth.value.pose)
}

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
    Some(FigureFile::new(
        "resampling.svg",
        "Clouds before and after resampling with their covariances",
        frames.render(),
    ))
}

/// Stamps \[s\], clouds, and what they were resampled from.
fn pairs(record: &MethodRecord) -> impl Iterator<Item = (f64, &ParticleSet, &Weighted)> {
    record.snapshots.iter().filter_map(|Stamped { stamp, value }| {
        value.weighted.as_deref().map(|weighed| (*stamp, value, weighed))
    })
}

/// Of each part of the run the resampling with the widest cloud.
fn chosen(record: &MethodRecord) -> Vec<(f64, &ParticleSet, &Weighted)> {
    let all: Vec<_> = pairs(record).collect();
    let parts = all.chunks(all.len().div_ceil(MOMENTS).max(1));
    let spread = |weighed: &Weighted| covariance(weighed).covariance.trace();
    let widest = |part: &[(f64, &'_ ParticleSet, &'_ Weighted)]| {
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
