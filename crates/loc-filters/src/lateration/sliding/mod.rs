//! Lateration of a moving robot from ranges measured one after the other.

mod window;

use super::minimize::{Minimum, OFFSET, SCALE};
use super::{BiasPrior, LaterationSettings, Loss, Range, RangeBias, locate};
use crate::delayed::{Clock, Sequential};
use crate::localizer::{Decision, Estimate, Localizer, Outcome};
use crate::{Result, RobotSettings};
use loc_core::gaussian::cholesky;
use loc_core::{Gaussian, Twist2};
use loc_maps::LandmarkMap;
use loc_sensors::event::{Control, Measurement};
use loc_sensors::landmark_camera::LandmarkObservation;
use nalgebra::{Matrix3, Point2, Vector2, Vector3};
use std::collections::VecDeque;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;
use window::{Carried, HEADING, MotionSegment, Track, Travelled, Window, pose_of};

/// Variance of a heading of which nothing is known \[rad^2\].
const NO_HEADING: f64 = PI * PI / 3.0;
/// Minimum variance of a start \[m^2, rad^2\]: 1 mm, 1 mrad.
const CERTAIN: f64 = 1e-6;
/// Number of initial headings of a search without a known pose.
const HEADINGS: usize = 8;
/// A cost per distance above this makes the whole map be searched again.
const LOST: f64 = 9.0;
/// A distance within so many standard deviations fits.
const FITS: f64 = 3.0;

/// Lateration over a sliding window of the last distances.
///
/// A robot seldom measures the distances to all landmarks at one time. Odometry gives the place of each
/// of the last distances relative to the current pose; the estimate is the pose that fits all of them
/// best. Older ones have a larger variance, as the odometry since then adds its own. What has left the
/// window is remembered as a belief over the pose, carried on by odometry, and over the sensor's scale
/// and offset, which vary slowly.
///
/// ```
/// use loc_core::Twist2;
/// use loc_filters::Localizer;
/// use loc_filters::lateration::{SlidingLateration, SlidingSettings};
/// use loc_maps::{Landmark, LandmarkMap};
/// use loc_sensors::landmark_camera::{Observed, LandmarkObservation};
/// let map = LandmarkMap::new([
///     Landmark::planar(1, 0.0, 0.0), Landmark::planar(2, 4.0, 0.0), Landmark::planar(3, 0.0, 4.0),
/// ])?;
/// let mut robot = SlidingLateration::new(map.clone(), SlidingSettings::default(), 0.0)?;
/// robot.velocity(0.0, Twist2::forward(0.5, 0.0))?; // Along y, though it does not know.
/// for k in 0..40 {
///     let (stamp, landmark) = (0.1 * f64::from(k), 1 + k as u32 % 3);
///     let at = nalgebra::Point3::new(2.0, 1.0 + 0.5 * stamp, 0.0);
///     let range = nalgebra::distance(&at, &map.get(landmark).unwrap().position);
///     robot.observations(stamp, &[LandmarkObservation { landmark, observed: Observed::Range { range } }])?;
/// }
/// let pose = robot.estimate(4.0)?.pose;
/// assert!((pose.x - 2.0).abs() < 0.02 && (pose.y - 3.0).abs() < 0.02);
/// assert!((pose.theta - 1.57).abs() < 0.02);
/// # Ok::<(), loc_filters::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct SlidingLateration {
    map: Arc<LandmarkMap>,
    /// The estimate before the first fix: somewhere among the landmarks.
    anywhere: Gaussian<3>,
    clock: Clock,
    settings: SlidingSettings,
    track: Track,
    window: VecDeque<BufferedRange>,
    fix: Option<StampedFix>,
    /// A pose that is known beside the window, with its time: that of the start until the window
    /// is full, then that of the distances that have left it.
    known: Option<(f64, Gaussian<3>)>,
    memory: Memory,
}

/// A measured distance in the window.
#[derive(Debug, Clone, Copy)]
struct BufferedRange {
    stamp: f64,
    landmark: Point2<f64>,
    distance: f64,
}

/// A pose with its time and the bias beside it.
#[derive(Debug, Clone, Copy)]
struct StampedFix {
    stamp: f64,
    belief: Gaussian<3>,
    bias: RangeBias,
}

impl SlidingLateration {
    /// Lateration without a known pose at `stamp` \[s\].
    ///
    /// # Errors
    /// Those of [`SlidingSettings::check`], and for a stamp that is not finite.
    pub fn new(
        map: impl Into<Arc<LandmarkMap>>,
        settings: SlidingSettings,
        stamp: f64,
    ) -> Result<Self> {
        settings.check()?;
        let clock = Clock::starting_at(stamp)?;
        let map = map.into();
        let anywhere = among(&map);
        Ok(SlidingLateration {
            map,
            anywhere,
            clock,
            settings,
            track: Track::new(stamp, settings.robot.integration),
            window: VecDeque::new(),
            fix: None,
            known: None,
            memory: Memory::default(),
        })
    }

    /// Sets the pose at the start, as a belief over (x, y, theta).
    ///
    /// # Errors
    /// Those of [`Gaussian::new`].
    pub fn start_at(mut self, belief: &Gaussian<3>) -> Result<Self> {
        let belief = Gaussian::new(belief.mean, belief.covariance)?;
        let stamp = self.track.start();
        self.known = Some((stamp, belief));
        self.fix = Some(StampedFix { stamp, belief, bias: RangeBias::NONE });
        Ok(self)
    }

    fn insert_velocity(&mut self, stamp: f64, twist: Twist2) -> Result<()> {
        crate::innovation::finite("velocity", &twist.to_vector())?;
        self.clock.advance("velocity", stamp)?;
        if self.settings.odometry {
            self.track.insert(stamp, twist);
            self.forget();
        }
        Ok(())
    }

    fn insert_ranges(
        &mut self,
        stamp: f64,
        observations: &[LandmarkObservation],
    ) -> Result<Vec<Outcome>> {
        for observation in observations {
            observation.observed.check()?;
        }
        self.clock.advance("ranges", stamp)?;
        let mut ranges = Vec::with_capacity(observations.len());
        for observation in observations {
            ranges.push(match (self.map.get(observation.landmark), observation.observed.range()) {
                (None, _) => Err(Decision::UnknownLandmark),
                (_, None) => Err(Decision::Undetermined),
                (Some(landmark), Some(distance)) => {
                    Ok(BufferedRange { stamp, landmark: landmark.position.xy(), distance })
                }
            });
        }
        for &range in ranges.iter().flatten() {
            let place = self.window.partition_point(|other| other.stamp <= stamp);
            self.window.insert(place, range);
        }
        while self.window.len() > self.settings.window {
            self.window.pop_front();
        }
        self.forget();
        let now = self.window.back().map_or(stamp, |last| last.stamp);
        let fresh = ranges.iter().flatten().count();
        let solved = (fresh > 0).then(|| self.solve(now, self.memory.bias.as_ref())).flatten();
        let decide = |range: &BufferedRange| match &solved {
            None => Decision::Pending,
            Some((window, found)) => {
                let travelled = self.track.at(now);
                let range = self.carried(range, now, &travelled, &travelled);
                let fits = window.deviation(&range, &found.at).abs() <= FITS;
                if fits { Decision::Accepted } else { Decision::Rejected }
            }
        };
        let decisions = ranges.iter().map(|range| range.as_ref().map_or_else(|d| *d, decide));
        let outcomes = decisions.zip(observations).map(|(decision, observation)| {
            Outcome::of(decision).with_landmark(observation.landmark)
        });
        let outcomes = outcomes.collect();
        if let Some((_, found)) = &solved {
            self.set_fix(now, found);
        }
        self.remember(now, fresh);
        Ok(outcomes)
    }

    /// The belief at a time \[s\], predicted from the last fix; `None` before the first fix.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a stamp that is not finite.
    pub fn belief_at(&self, stamp: f64) -> Result<Option<Gaussian<3>>> {
        loc_core::error::finite("stamp [s]", stamp)?;
        Ok(self.fix.as_ref().map(|fix| self.carry(&fix.belief, fix.stamp, stamp)))
    }

    /// The bias of the ranging sensor as the last fix found it; `None` before.
    pub fn bias(&self) -> Option<RangeBias> {
        self.fix.map(|fix| fix.bias)
    }

    /// Forgets the odometry from before the window, the last fix and the known pose.
    fn forget(&mut self) {
        let end = self.track.end();
        let oldest = self.window.front().map_or(end, |first| first.stamp.min(end));
        let fix = self.fix.map_or(oldest, |fix| fix.stamp.min(oldest));
        self.track.forget_before(self.known.map_or(fix, |(stamp, _)| stamp.min(fix)));
    }

    fn carry(&self, belief: &Gaussian<3>, from: f64, to: f64) -> Gaussian<3> {
        let mut belief = self.track.carry(*belief, from, to, &self.settings.robot.odometry);
        if !self.settings.odometry {
            let walked = (self.settings.walk * (to - from).max(0.0)).powi(2);
            let spread = Vector3::new(walked, walked, 0.0);
            belief.covariance += Matrix3::from_diagonal(&spread);
        }
        belief
    }

    /// A distance carried to the time `now`, with the motion `travelled` up to then; `next` is the motion
    /// up to the distance after it.
    fn carried(
        &self,
        received: &BufferedRange,
        now: f64,
        travelled: &Travelled,
        next: &Travelled,
    ) -> Carried {
        let RobotSettings { odometry: noise, mounting, .. } = &self.settings.robot;
        let antenna = &mounting.position();
        let then = self.track.at(received.stamp);
        let pose = travelled.pose.between(then.pose);
        let (sin, cos) = pose.theta.sin_cos();
        let (length, turn) = (next.distance - then.distance, next.turned - then.turned);
        let segment = MotionSegment {
            start: pose.position().coords,
            ahead: Vector2::new(cos, sin),
            along: noise.k_d() * length,
            turn: noise.k_drift() * length + noise.k_theta() * turn,
        };
        let (distance_since, turned) =
            (travelled.distance - then.distance, travelled.turned - then.turned);
        let antenna = pose.transform(antenna).coords;
        let heading = noise.k_drift() * distance_since + noise.k_theta() * turned;
        let mut own_sigma = self.settings.robot.camera.range_sigma_at(received.distance);
        let mut variance = own_sigma * own_sigma;
        // The mean of a heading error that grows evenly, over a straight path.
        variance += noise.k_d() * distance_since + heading * antenna.norm_squared() / 3.0;
        if !self.settings.odometry {
            variance += (self.settings.walk * (now - received.stamp)).powi(2);
            own_sigma = variance.sqrt();
        }
        let (landmark, distance) = (received.landmark, received.distance);
        Carried { landmark, distance, sigma: variance.sqrt(), antenna, own_sigma, segment }
    }

    /// Once all distances of the window are new since the last time, what it says of the pose and
    /// of the bias is remembered. It counts from the next time on: until then distances that it
    /// came from are still in the window. A window that fits badly ends the memory.
    fn remember(&mut self, now: f64, fresh: usize) {
        self.memory.fresh += fresh;
        if self.memory.fresh < self.settings.window {
            return;
        }
        let solved = self.solve(now, self.memory.bias_next.as_ref());
        let told = solved
            .filter(|(window, found)| found.cost <= TELLING * window.ranges.len() as f64)
            .map(|(_, found)| (pose_of(&found), bias_of(&found)));
        let before = std::mem::take(&mut self.memory);
        let Some((pose, bias)) = told else {
            self.known = None;
            return;
        };
        self.known = before.pose;
        let bias = after_walk(bias, now - before.pose.map_or(now, |(stamp, _)| stamp));
        self.memory = Memory {
            bias: before.bias_next,
            bias_next: Some(bias),
            pose: Some((now, pose)),
            fresh: 0,
        };
    }

    /// The pose that fits the window best, with what is known of the bias from older distances.
    fn solve(&self, now: f64, remembered: Option<&Gaussian<2>>) -> Option<(Window, Minimum)> {
        let travelled = self.track.at(now);
        let next = self.window.iter().skip(1).map(|received| self.track.at(received.stamp));
        let pairs = self.window.iter().zip(next.chain([travelled]));
        let ranges: Vec<Carried> =
            pairs.map(|(received, next)| self.carried(received, now, &travelled, &next)).collect();
        let known = self.known.and_then(|(stamp, belief)| {
            let mut belief = self.carry(&belief, stamp, now);
            // A start that is certain would leave nothing to weigh.
            belief.covariance += Matrix3::identity() * CERTAIN;
            Some((belief.mean, cholesky("start", &belief.covariance).ok()?))
        });
        let size = |r: &Carried| r.distance + r.antenna.norm() + r.sigma;
        let extent = ranges.iter().map(size).fold(0.0, f64::max);
        let (loss, bias) = (self.settings.loss, self.settings.bias);
        let heading = (!self.settings.odometry).then_some(0.0);
        let remembered = remembered
            .and_then(|belief| Some((belief.mean, cholesky("bias", &belief.covariance).ok()?)));
        let mut window = Window { ranges, loss, bias, remembered, known, heading, extent };
        let carried = self.fix.map(|fix| self.carry(&fix.belief, fix.stamp, now));
        let from_last = carried.and_then(|belief| window.solve(belief.mean));
        let lost = |found: &Minimum| found.cost > LOST * window.ranges.len() as f64;
        let mut best = match from_last {
            Some(found) if !lost(&found) => found,
            lost => self.search(&window).into_iter().chain(lost).min_by(by_cost)?,
        };
        // Odometry since the last fix may know the heading better than the window does.
        if let Some(belief) = carried.filter(|_| window.heading.is_none()) {
            let kept = belief.covariance[(HEADING, HEADING)];
            if best.covariance[(HEADING, HEADING)] > kept {
                window.heading = Some(kept);
                best.at[HEADING] = belief.mean.z;
                best = window.solve(best.at.fixed_rows::<3>(0).into())?;
                best.covariance[(HEADING, HEADING)] = kept;
            }
        }
        Some((window, best))
    }

    /// The best of all minima over the map; `None` where the window leaves it open.
    fn search(&self, window: &Window) -> Option<Minimum> {
        let circle =
            |r: &Carried| Range { landmark: r.landmark, distance: r.distance, sigma: r.sigma };
        let circles: Vec<Range<2>> = window.ranges.iter().map(circle).collect();
        if window.known.is_none() && circles.len() < 3 + window.bias.free() {
            return None;
        }
        let solution = locate(&circles, None, &LaterationSettings::default()).ok()?;
        let places = std::iter::once(&solution.best).chain(&solution.other);
        let headings = if window.heading.is_none() { HEADINGS } else { 1 };
        let starts = places.flat_map(|fix| {
            let pose = move |k| Vector3::new(fix.position.x, fix.position.y, turn(k, headings));
            (0..headings).map(pose)
        });
        starts.filter_map(|start| window.solve(start)).min_by(by_cost)
    }

    /// Keeps a minimum as the fix.
    fn set_fix(&mut self, stamp: f64, found: &Minimum) {
        let mut belief = pose_of(found);
        if !self.settings.odometry {
            belief.mean.z = self.known.map_or(0.0, |(_, start)| start.mean.z);
            belief.covariance[(HEADING, HEADING)] = NO_HEADING;
        }
        let bias = RangeBias { scale: found.at[SCALE], offset: found.at[OFFSET] };
        self.fix = Some(StampedFix { stamp, belief, bias });
        self.forget();
    }
}

impl Localizer for SlidingLateration {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        let Control::Velocity(twist) = control else { return Ok(()) };
        self.insert_velocity(stamp, *twist)
    }

    /// A range that is more than three standard deviations off the solution is rejected.
    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Outcome>> {
        let Measurement::Landmarks(observations) = measurement else { return Ok(Vec::new()) };
        self.insert_ranges(stamp, observations)
    }

    /// The last fix carried on; before the first fix, anywhere among the landmarks.
    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        Ok(self.belief_at(stamp)?.unwrap_or(self.anywhere).into())
    }
}

impl Sequential for SlidingLateration {
    fn uses(&self, measurement: &Measurement) -> bool {
        matches!(measurement, Measurement::Landmarks(_))
    }
}

/// What the distances that have left the window say.
#[derive(Debug, Clone, Default)]
struct Memory {
    /// Scale and offset of the ranging sensor, by all distances before the last full window ..
    bias: Option<Gaussian<2>>,
    /// .. and by those of that window as well, with the pose at its end; these count from the next
    /// full window on.
    bias_next: Option<Gaussian<2>>,
    pose: Option<(f64, Gaussian<3>)>,
    /// How many distances came since then.
    fresh: usize,
}

/// A bias that has varied for some time \[s\].
fn after_walk(mut bias: Gaussian<2>, time: f64) -> Gaussian<2> {
    for (k, sigma) in WALK.into_iter().enumerate() {
        bias.covariance[(k, k)] += (sigma * sigma * time.max(0.0) / 60.0).max(1e-12);
    }
    bias
}

/// Random walk of scale and offset, after a minute \[1, m\].
const WALK: [f64; 2] = [0.005, 0.02];

/// A window whose cost per distance is above this says nothing about the bias.
const TELLING: f64 = 3.0;

/// The bias of a minimum, as a belief over scale and offset \[m\].
fn bias_of(found: &Minimum) -> Gaussian<2> {
    Gaussian {
        mean: Vector2::new(found.at[SCALE], found.at[OFFSET]),
        covariance: found.covariance.fixed_view::<2, 2>(SCALE, SCALE).into_owned(),
    }
}

/// A robot that may be anywhere among the landmarks.
fn among(landmarks: &LandmarkMap) -> Gaussian<3> {
    let count = landmarks.len().max(1) as f64;
    let positions = || landmarks.iter().map(|landmark| landmark.position.xy().coords);
    let middle = positions().sum::<Vector2<f64>>() / count;
    let spread = positions().map(|p| (p - middle).norm_squared()).sum::<f64>() / count;
    let variances = Vector3::new(spread, spread, PI * PI / 3.0);
    let mean = Vector3::new(middle.x, middle.y, 0.0);
    Gaussian { mean, covariance: Matrix3::from_diagonal(&variances) }
}

fn by_cost(a: &Minimum, b: &Minimum) -> std::cmp::Ordering {
    a.cost.total_cmp(&b.cost)
}

/// The k-th of so many headings all around \[rad\].
fn turn(k: usize, count: usize) -> f64 {
    TAU * k as f64 / count as f64
}

loc_core::settings! {
    /// Settings of sliding lateration.
    ///
    /// 50 distances with odometry, a robust loss, and a sensor whose scale is known to 10 % and
    /// whose offset to 20 cm, as radio ranging is out of the box.
    #[derive(Copy)]
    pub struct SlidingSettings {
        /// The robot and its sensors.
        pub robot: RobotSettings = RobotSettings::default() => check;
        /// How many of the last distances count.
        pub window: usize = 50 => within(1, 10_000);
        /// Whether odometry carries older distances to now. Without it the robot is taken to stay
        /// about where it is.
        pub odometry: bool = true => any;
        /// Without odometry: how fast the robot may be \[m/s\].
        pub walk: f64 = 0.5 => positive;
        /// How much outliers cost.
        pub loss: Loss = Loss::CAUCHY => check;
        /// What is known of the sensor's bias.
        pub bias: BiasPrior = BiasPrior { scale_sigma: 0.1, offset_sigma: 0.2 } => check;
    }
}
