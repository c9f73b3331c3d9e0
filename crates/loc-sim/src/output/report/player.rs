//! What the player of a report is given: the run as numbers, quantised for the screen.

use crate::output::backdrop;
use crate::record::{Frame, MethodFrame, MethodRecord, Playback, Run};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use loc_core::{Pose2, Stamped};
use loc_filters::localizer::Estimate;
use loc_maps::Bounds;
use loc_sensors::event::Truth;
use nalgebra::Point2;
use serde::Serialize;
use std::f64::consts::TAU;
use std::io::Write;

/// Steps of a position on the screen over the width of the scene.
const STEPS: f64 = 65535.0;
/// A point of a scan is kept to this \[m\].
const POINT: f32 = 0.01;

/// A run for the player.
#[derive(Debug, Serialize)]
pub(super) struct Player {
    /// Lower left and upper right corner of the scene \[m\].
    bounds: [f64; 4],
    map: Option<MapImage>,
    /// Number, x, y \[m\].
    landmarks: Vec<(u32, f64, f64)>,
    /// Stamps from the start of the run on \[s\].
    stamps: Blob,
    kidnapped_at: Option<f64>,
    truth: Option<Track>,
    scan: Points,
    sights: Points,
    methods: Vec<MethodData>,
}

#[derive(Debug, Serialize)]
struct MapImage {
    uri: String,
    /// Lower left and upper right corner \[m\].
    bounds: [f64; 4],
}

/// Poses, one for each stamp \[m, m, rad\].
#[derive(Debug, Serialize)]
struct Track {
    x: Blob,
    y: Blob,
    theta: Blob,
}

/// Points on the robot: how many at each stamp, then x and y in turns, in steps of 1 cm.
#[derive(Debug, Serialize)]
struct Points {
    counts: Blob,
    xy: Blob,
}

#[derive(Debug, Serialize)]
struct MethodData {
    name: String,
    track: Track,
    /// (xx, xy, yy) of the covariance for each stamp, NaN where there is none.
    covariance: Blob,
    /// Distance from the truth \[m\], NaN without one.
    error: Blob,
    /// Heading off the truth \[deg\].
    heading: Blob,
    nees: Blob,
    /// The probability of being lost, of a method that gives one.
    lost: Option<Blob>,
    /// How many particles there were.
    particle_count: Option<Blob>,
    particles: Option<Particles>,
    weighed: Option<Particles>,
    hypotheses: Option<Hypotheses>,
}

/// Particles: how many at each stamp, then x, y over the scene and the heading, over a turn.
#[derive(Debug, Serialize)]
struct Particles {
    counts: Blob,
    xy: Blob,
    theta: Blob,
}

/// Hypotheses: how many at each stamp, then (share, x, y, xx, xy, yy) in turns.
#[derive(Debug, Serialize)]
struct Hypotheses {
    counts: Blob,
    numbers: Blob,
}

impl Player {
    /// The run, at the moments of its film; `None` without a film, and for a
    /// vehicle on a rail, which has no map to show.
    pub(super) fn of(run: &Run) -> Option<Self> {
        let film = run.playback.as_ref().filter(|film| !film.frames.is_empty())?;
        if run.setup.rail.is_some() {
            return None;
        }
        let moments = Moments { run, film };
        let image = run.setup.map.as_deref().and_then(backdrop);
        let bounds = scene(run, image.as_ref().map(|i| [i.min.0, i.min.1, i.max.0, i.max.1]))?;
        let methods = run.methods.iter().enumerate();
        Some(Player {
            bounds,
            map: image.map(|image| MapImage {
                bounds: [image.min.0, image.min.1, image.max.0, image.max.1],
                uri: image.data_uri,
            }),
            landmarks: run
                .setup
                .landmarks
                .iter()
                .map(|l| (l.id, l.position.x, l.position.y))
                .collect(),
            stamps: Blob::f32(&moments.map(&run.stamps, |t| (t - run.setup.start) as f32)),
            kidnapped_at: run.setup.kidnapped_at.map(|at| at - run.setup.start),
            truth: (!run.truth.is_empty())
                .then(|| Track::of(&moments.map(&run.truth, |truth| truth.value.pose))),
            scan: Points::of(film, |frame| &frame.scan),
            sights: Points::of(film, |frame| &frame.sights),
            methods: methods
                .map(|(k, record)| MethodData::of(&moments, k, record, bounds))
                .collect(),
        })
    }
}

/// The moments of the film among those of the run.
struct Moments<'a> {
    run: &'a Run,
    film: &'a Playback,
}

impl Moments<'_> {
    fn map<T, U>(&self, of_run: &[T], to: impl Fn(&T) -> U) -> Vec<U> {
        of_run.iter().step_by(self.film.every).take(self.film.frames.len()).map(to).collect()
    }
}

impl MethodData {
    fn of(moments: &Moments<'_>, k: usize, record: &MethodRecord, bounds: [f64; 4]) -> Self {
        let estimates = moments.map(&record.estimates, |estimate| *estimate);
        let truth = moments.map(&moments.run.truth, |truth| *truth);
        let inside = || moments.film.frames.iter().filter_map(move |frame| frame.methods.get(k));
        let judged = |figure: &dyn Fn(&Estimate, Pose2) -> Option<f64>| {
            let figure = |(e, t): (&Estimate, &Stamped<Truth>)| {
                figure(e, t.value.pose).map_or(f32::NAN, |value| value as f32)
            };
            Blob::f32(&estimates.iter().zip(&truth).map(figure).collect::<Vec<_>>())
        };
        let poses: Vec<Pose2> = estimates.iter().map(|estimate| estimate.pose).collect();
        let counts: Vec<u32> = inside().map(|inside| inside.particle_count as u32).collect();
        MethodData {
            name: record.name().into_owned(),
            track: Track::of(&poses),
            covariance: Blob::f32(
                &estimates.iter().flat_map(position_covariance).collect::<Vec<_>>(),
            ),
            error: judged(&|estimate, truth| Some(estimate.pose.distance(truth))),
            heading: judged(&|e, truth| {
                let off = loc_core::angle::wrap(e.pose.theta - truth.theta).to_degrees();
                Some(off).filter(|_| moments.run.truth_has_heading)
            }),
            nees: judged(&|e, truth| Some(moments.run.nees(e, truth)?.1)),
            lost: estimates.iter().any(|estimate| estimate.lost.is_some()).then(|| {
                let lost = estimates.iter().map(|e| e.lost.map_or(f32::NAN, |lost| lost as f32));
                Blob::f32(&lost.collect::<Vec<_>>())
            }),
            particle_count: counts.iter().any(|count| *count > 0).then(|| Blob::u32(&counts)),
            particles: Particles::of(&inside().map(|inside| &inside.particles), bounds),
            weighed: Particles::of(&inside().map(|inside| &inside.weighed), bounds),
            hypotheses: Hypotheses::of(inside()),
        }
    }
}

fn position_covariance(estimate: &Estimate) -> [f32; 3] {
    match &estimate.covariance {
        Some(s) => [s.m11 as f32, s.m12 as f32, s.m22 as f32],
        None => [f32::NAN; 3],
    }
}

impl Track {
    fn of(poses: &[Pose2]) -> Self {
        let blob = |of: fn(&Pose2) -> f64| {
            Blob::f32(&poses.iter().map(|pose| of(pose) as f32).collect::<Vec<_>>())
        };
        Track { x: blob(|p| p.x), y: blob(|p| p.y), theta: blob(|p| p.theta) }
    }
}

impl Points {
    fn of(film: &Playback, of: impl Fn(&Frame) -> &Vec<[f32; 2]>) -> Self {
        let counts: Vec<u16> = film.frames.iter().map(|frame| of(frame).len() as u16).collect();
        let numbers = film.frames.iter().flat_map(|frame| of(frame).as_flattened());
        // Casts of numbers out of range saturate, 327 m from the robot.
        let xy: Vec<i16> = numbers.map(|number| (number / POINT).round() as i16).collect();
        Points { counts: Blob::u16(&counts), xy: Blob::i16(&xy) }
    }
}

impl Particles {
    fn of<'a>(
        moments: &(impl Iterator<Item = &'a Vec<[f32; 3]>> + Clone),
        [left, low, right, high]: [f64; 4],
    ) -> Option<Self> {
        let counts: Vec<u16> = moments.clone().map(|poses| poses.len() as u16).collect();
        counts.iter().any(|count| *count > 0).then(|| {
            let poses = || moments.clone().flatten();
            // Casts of numbers out of range saturate, at the border of the scene.
            let step = |value: f32, low: f64, high: f64| {
                ((f64::from(value) - low) / (high - low) * STEPS).round() as u16
            };
            let xy = poses().flat_map(|[x, y, _]| [step(*x, left, right), step(*y, low, high)]);
            let theta = poses().map(|[.., theta]| (f64::from(*theta) / TAU * 256.0) as u8);
            Particles {
                counts: Blob::u16(&counts),
                xy: Blob::u16(&xy.collect::<Vec<_>>()),
                theta: Blob::u8(&theta.collect::<Vec<_>>()),
            }
        })
    }
}

impl Hypotheses {
    fn of<'a>(moments: impl Iterator<Item = &'a MethodFrame> + Clone) -> Option<Self> {
        let counts: Vec<u16> = moments.clone().map(|m| m.hypotheses.len() as u16).collect();
        counts.iter().any(|count| *count > 0).then(|| {
            let numbers = moments.flat_map(|moment| &moment.hypotheses).flat_map(|hypothesis| {
                let (mean, s) = (hypothesis.belief.mean, hypothesis.belief.covariance);
                [hypothesis.share, mean.x, mean.y, s.m11, s.m12, s.m22].map(|n| n as f32)
            });
            Hypotheses {
                counts: Blob::u16(&counts),
                numbers: Blob::f32(&numbers.collect::<Vec<_>>()),
            }
        })
    }
}

/// The scene: the map, or else the paths and the landmarks, with a margin.
fn scene(run: &Run, map: Option<[f64; 4]>) -> Option<[f64; 4]> {
    let truth = run.truth.iter().map(|truth| truth.value.pose.position());
    let landmarks = run.setup.landmarks.iter().map(|landmark| landmark.position.xy());
    let estimates = run.methods.iter().flat_map(|record| &record.estimates);
    let estimates = estimates.map(|estimate| estimate.pose.position());
    let corners =
        map.map(|[left, low, right, high]| [Point2::new(left, low), Point2::new(right, high)]);
    // A method that drifts away does not shrink the others' scene.
    let shown: Vec<Point2<f64>> =
        corners.into_iter().flatten().chain(truth).chain(landmarks).collect();
    let around = if shown.is_empty() { Bounds::around(estimates) } else { Bounds::around(shown) }?;
    let larger = (around.max.x - around.min.x).max(around.max.y - around.min.y);
    let around = around.grown(0.03 * larger + 0.5);
    Some([around.min.x, around.min.y, around.max.x, around.max.y])
}

/// A long list of numbers inside a page, as its script reads it: little-endian, deflated, in base64.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Blob {
    /// Type of a number: `u8`, `u16`, `i16`, `u32` or `f32`.
    kind: &'static str,
    /// The numbers.
    data: String,
}

impl Blob {
    pub(super) fn u8(numbers: &[u8]) -> Self {
        Blob::new("u8", numbers)
    }

    pub(super) fn u16(numbers: &[u16]) -> Self {
        Blob::new("u16", &bytes(numbers, u16::to_le_bytes))
    }

    pub(super) fn i16(numbers: &[i16]) -> Self {
        Blob::new("i16", &bytes(numbers, i16::to_le_bytes))
    }

    pub(super) fn u32(numbers: &[u32]) -> Self {
        Blob::new("u32", &bytes(numbers, u32::to_le_bytes))
    }

    pub(super) fn f32(numbers: &[f32]) -> Self {
        Blob::new("f32", &bytes(numbers, f32::to_le_bytes))
    }

    fn new(kind: &'static str, bytes: &[u8]) -> Self {
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
        // Writing to memory cannot fail.
        let _ = encoder.write_all(bytes);
        Blob { kind, data: STANDARD.encode(encoder.finish().unwrap_or_default()) }
    }
}

fn bytes<T: Copy, const N: usize>(numbers: &[T], to: impl Fn(T) -> [u8; N]) -> Vec<u8> {
    numbers.iter().flat_map(|number| to(*number)).collect()
}
