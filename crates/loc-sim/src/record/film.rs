//! A run as a film: what was to be seen at each moment.

use crate::Result;
use crate::localizer::{Hypothesis, Localizer};
use crate::runner::Watcher;
use loc_core::Pose2;
use loc_sensors::event::{Event, Measurement, Payload};
use loc_sensors::landmark_camera::Observed;
use std::f64::consts::TAU;

/// The most moments that are kept: a quarter of an hour at 10 Hz.
const FRAMES: usize = 9000;

/// The most points of a scan that are kept.
const POINTS: usize = 72;

/// The most particles of a method that are kept at one moment.
const PARTICLES: usize = 120;

/// What was to be seen at every moment at which the methods were asked for their estimates.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Film {
    /// The moments, in order of time.
    pub frames: Vec<Frame>,
    /// Frame k belongs to stamp k * `every` of the run.
    pub every: usize,
    /// How many stamps there have been.
    taken: usize,
    /// What the sensors have reported since the last frame.
    next: Seen,
}

/// One moment.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Frame {
    /// Where beams ended since the last frame, on the robot (forward, left) \[m\].
    pub scan: Vec<[f32; 2]>,
    /// Where landmarks were seen since the last frame, on the robot \[m\].
    pub sights: Vec<[f32; 2]>,
    /// What each method of the run believed, in their order.
    pub methods: Vec<Inside>,
}

/// What a method believed at one moment, beside its estimate.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Inside {
    /// How many particles it had.
    pub particle_count: usize,
    /// Some of them: x, y \[m\] and heading \[rad\].
    pub particles: Vec<[f32; 3]>,
    /// Some of them before the last resampling, where the method keeps them.
    pub weighed: Vec<[f32; 3]>,
    /// The poses that it held possible.
    pub hypotheses: Vec<Hypothesis>,
}

/// What sensors reported.
#[derive(Debug, Clone, PartialEq, Default)]
struct Seen {
    scan: Vec<[f32; 2]>,
    sights: Vec<[f32; 2]>,
}

/// Keeps the film of a run, and tells somebody else about its progress.
pub struct Filming<'a> {
    /// What has been filmed.
    pub film: Film,
    told: &'a mut dyn FnMut(f64),
}

impl<'a> Filming<'a> {
    /// Nothing yet; `told` is told the share of the run that is done.
    pub fn new(told: &'a mut dyn FnMut(f64)) -> Self {
        Filming { film: Film { every: 1, ..Film::default() }, told }
    }
}

impl Watcher for Filming<'_> {
    fn progress(&mut self, share: f64) {
        (self.told)(share);
    }

    fn event(&mut self, event: &Event) -> Result<()> {
        if let Payload::Measurement(measurement) = &event.payload {
            self.film.next.see(measurement);
        }
        Ok(())
    }

    fn estimated(&mut self, _stamp: f64, methods: &[&dyn Localizer]) -> Result<()> {
        if self.film.is_due() {
            let Seen { scan, sights } = std::mem::take(&mut self.film.next);
            let methods = methods.iter().map(|method| Inside::of(*method)).collect();
            self.film.frames.push(Frame { scan, sights, methods });
        }
        Ok(())
    }
}

impl Film {
    /// Counts a stamp and says whether it is to be filmed; of a long run every second one is not.
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

impl Seen {
    fn see(&mut self, measurement: &Measurement) {
        match measurement {
            Measurement::Scan { scan, mounting } => {
                self.scan = scan.points(*mounting).map(|p| [p.x as f32, p.y as f32]).collect();
                thin(&mut self.scan, POINTS);
            }
            // Where the camera sits is known to the methods alone; at this scale it is the robot.
            Measurement::Landmarks(observations) => {
                for observation in observations {
                    if let Observed::RangeBearing { range, bearing } = observation.sight {
                        let (sin, cos) = bearing.sin_cos();
                        self.sights.push([(range * cos) as f32, (range * sin) as f32]);
                    }
                }
            }
            _ => {}
        }
    }
}

impl Inside {
    fn of(method: &dyn Localizer) -> Self {
        let cloud = method.cloud().unwrap_or_default();
        Inside {
            particle_count: method.particle_count(),
            particles: poses(&cloud.particles),
            weighed: poses(cloud.weighed.as_deref().unwrap_or_default()),
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

/// Keeps every k-th, at most `most`.
fn thin<T>(items: &mut Vec<T>, most: usize) {
    let step = items.len().div_ceil(most).max(1);
    let mut index = 0_usize;
    items.retain(|_| {
        index += 1;
        (index - 1).is_multiple_of(step)
    });
}
