//! Frames of a run for the playback in the report: scan, landmarks and beliefs over time.

use crate::Result;
use crate::runner::Observer;
use loc_core::Pose2;
use loc_filters::localizer::{Hypothesis, Localizer};
use loc_sensors::event::{Event, Measurement, Payload};
use loc_sensors::landmark_camera::Observed;
use std::f64::consts::TAU;

/// Largest number of frames: a quarter of an hour at 10 Hz.
const FRAMES: usize = 9000;

/// Largest number of points of a scan in a frame.
const POINTS: usize = 72;

/// Largest number of particles of a method in a frame.
const PARTICLES: usize = 120;

/// The frames at the stamps of the estimates.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Playback {
    /// The frames, in order of time.
    pub frames: Vec<Frame>,
    /// Frame k belongs to stamp k * `every` of the run.
    pub every: usize,
    /// Number of stamps so far.
    taken: usize,
    /// Measurements since the last frame.
    next: Detections,
}

/// One frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Frame {
    /// End points of beams since the last frame, on the robot (forward, left) \[m\].
    pub scan: Vec<[f32; 2]>,
    /// Observed landmarks since the last frame, on the robot \[m\].
    pub sights: Vec<[f32; 2]>,
    /// The belief of each method of the run, in their order.
    pub methods: Vec<MethodFrame>,
}

/// The belief of a method in a frame, beside its estimate.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MethodFrame {
    /// Number of particles.
    pub particle_count: usize,
    /// Some of them: x, y \[m\] and heading \[rad\].
    pub particles: Vec<[f32; 3]>,
    /// Some of them before the last resampling, where the method keeps them.
    pub weighed: Vec<[f32; 3]>,
    /// The pose hypotheses.
    pub hypotheses: Vec<Hypothesis>,
}

/// Measurements, on the robot.
#[derive(Debug, Clone, PartialEq, Default)]
struct Detections {
    scan: Vec<[f32; 2]>,
    sights: Vec<[f32; 2]>,
}

/// Records the frames of a run, and reports its progress.
pub struct PlaybackRecorder<'a> {
    /// The frames so far.
    pub playback: Playback,
    progress: &'a mut dyn FnMut(f64),
}

impl<'a> PlaybackRecorder<'a> {
    /// No frames yet; `progress` gets the share of the run that is done.
    pub fn new(progress: &'a mut dyn FnMut(f64)) -> Self {
        PlaybackRecorder { playback: Playback { every: 1, ..Playback::default() }, progress }
    }
}

impl Observer for PlaybackRecorder<'_> {
    fn progress(&mut self, share: f64) {
        (self.progress)(share);
    }

    fn event(&mut self, event: &Event) -> Result<()> {
        if let Payload::Measurement(measurement) = &event.payload {
            self.playback.next.add(measurement);
        }
        Ok(())
    }

    fn estimated(&mut self, _stamp: f64, methods: &[&dyn Localizer]) -> Result<()> {
        if self.playback.is_due() {
            let Detections { scan, sights } = std::mem::take(&mut self.playback.next);
            let methods = methods.iter().map(|method| MethodFrame::of(*method)).collect();
            self.playback.frames.push(Frame { scan, sights, methods });
        }
        Ok(())
    }
}

impl Playback {
    /// Counts a stamp and returns whether it becomes a frame; long runs drop every second one.
    fn is_due(&mut self) -> bool {
        if self.frames.len() >= FRAMES && self.taken.is_multiple_of(2 * self.every) {
            self.every *= 2;
            let mut index = 0_usize;
            self.frames.retain(|_| {
                index += 1;
                index % 2 == 1
            });
        }
        self.taken += 1;
        (self.taken - 1).is_multiple_of(self.every)
    }
}

impl Detections {
    fn add(&mut self, measurement: &Measurement) {
        match measurement {
            Measurement::Scan { scan, mounting } => {
                self.scan = scan.points(*mounting).map(|p| [p.x as f32, p.y as f32]).collect();
                thin(&mut self.scan, POINTS);
            }
            // The camera's mounting is known to the methods only; it is negligible at this scale.
            Measurement::Landmarks(observations) => {
                for observation in observations {
                    if let Observed::RangeBearing { range, bearing } = observation.observed {
                        let (sin, cos) = bearing.sin_cos();
                        self.sights.push([(range * cos) as f32, (range * sin) as f32]);
                    }
                }
            }
            _ => {}
        }
    }
}

impl MethodFrame {
    fn of(method: &dyn Localizer) -> Self {
        let cloud = method.particle_set(super::MAX_PARTICLES).unwrap_or_default();
        MethodFrame {
            particle_count: method.particle_count(),
            particles: poses(&cloud.particles),
            weighed: poses(cloud.weighted.as_deref().unwrap_or_default()),
            hypotheses: method.hypotheses(),
        }
    }
}

fn poses(particles: &[(Pose2, f64)]) -> Vec<[f32; 3]> {
    let pose = |(pose, _): &(Pose2, f64)| {
        [pose.x as f32, pose.y as f32, pose.theta.rem_euclid(TAU) as f32]
    };
    let mut poses: Vec<_> = particles.iter().map(pose).collect();
    thin(&mut poses, PARTICLES);
    poses
}

/// Keeps every k-th item, at most `max`.
fn thin<T>(items: &mut Vec<T>, max: usize) {
    let step = items.len().div_ceil(max).max(1);
    let mut index = 0_usize;
    items.retain(|_| {
        index += 1;
        (index - 1).is_multiple_of(step)
    });
}
