//! Late and out-of-order inputs, handled once for every method.
//!
//! Cameras need time to compute: their measurements arrive after odometry that is younger. A
//! [`Delayed`] localizer keeps the inputs of the last seconds with the state before each of them. A
//! late input is applied at its own time, and the inputs after it are applied again. The result is
//! the same to the bit as if all inputs had come in order of their stamps.
//!
//! It wraps a localizer that expects its inputs in order, a [`Sequential`] one. To make a method of
//! your own tolerate delays, implement [`Localizer`] and [`Sequential`] for it:
//!
//! ```
//! use loc_core::{Pose2, Twist2, motion::Integration};
//! use loc_filters::delayed::{Delayed, Sequential};
//! use loc_filters::localizer::{Estimate, Localizer, Outcome};
//! use loc_sensors::event::{Control, Measurement};
//!
//! /// Integrates velocities.
//! #[derive(Clone, Default)]
//! struct Integrator { stamp: f64, pose: Pose2, twist: Twist2 }
//! impl Localizer for Integrator {
//!     fn predict(&mut self, stamp: f64, control: &Control) -> loc_filters::Result<()> {
//!         self.pose = self.estimate(stamp)?.pose;
//!         self.stamp = stamp;
//!         if let Control::Velocity(twist) = control { self.twist = *twist; }
//!         Ok(())
//!     }
//!     fn correct(&mut self, _: f64, _: &Measurement) -> loc_filters::Result<Vec<Outcome>> {
//!         Ok(Vec::new())
//!     }
//!     fn estimate(&self, stamp: f64) -> loc_filters::Result<Estimate> {
//!         let pose = Integration::ExactArc.step(self.pose, self.twist, stamp - self.stamp);
//!         Ok(Estimate { pose, covariance: None, lost: None, rail: None })
//!     }
//! }
//! impl Sequential for Integrator {
//!     fn uses(&self, _: &Measurement) -> bool { false }
//! }
//!
//! let mut robot = Delayed::new(Integrator::default(), 1.0)?;
//! for (stamp, speed) in [(0.0, 1.0), (0.9, 0.0), (0.5, 2.0)] {
//!     robot.predict(stamp, &Control::Velocity(Twist2::forward(speed, 0.0)))?;
//! }
//! assert!((robot.estimate(1.0)?.pose.x - 1.3).abs() < 1e-12); // 0.5 s of 1 m/s, 0.4 s of 2 m/s
//! # Ok::<(), loc_filters::Error>(())
//! ```

use crate::line_matching::LineUpdate;
use crate::localizer::{
    Decision, Estimate, EstimatedMap, GridBelief, Hypothesis, Localizer, Outcome, ParticleSet,
    SensorError,
};
use crate::{Error, Result};
use loc_core::{Pose2, Twist2};
use loc_sensors::event::{Control, Event, Measurement, Payload};
use std::collections::VecDeque;

/// A localizer that expects its inputs in order of their stamps, and can be copied to go back.
///
/// A copy should be cheap for inputs that change little: large parts of the state that controls do
/// not touch belong in an `Arc`.
pub trait Sequential: Localizer + Clone {
    /// Whether it uses the poses of an odometry as they are. Otherwise they are converted to the
    /// velocities between them ([`OdometryVelocity`]).
    const USES_POSES: bool = false;

    /// Whether it uses this kind of measurement; others never reach it.
    fn uses(&self, measurement: &Measurement) -> bool;

    /// The time \[s\] from which on a measurement of time `stamp` acts: earlier for one that
    /// averages over the period before it.
    fn acts_from(&self, stamp: f64, _measurement: &Measurement) -> f64 {
        stamp
    }

    /// The place of an input among others of the same stamp, the lowest first. Inputs of one rank
    /// keep the order in which they came.
    fn rank(_input: &Payload) -> u64 {
        0
    }

    /// Keeps the belief of a time \[s\] for smoothing, see [`crate::smoother`].
    ///
    /// # Errors
    /// What the filter refuses.
    fn mark(&mut self, _stamp: f64) -> Result<()> {
        Ok(())
    }
}

/// A localizer that takes inputs up to a horizon late.
#[derive(Debug, Clone)]
pub struct Delayed<F> {
    newest: F,
    past: VecDeque<Moment<F>>,
    horizon: f64,
    odometry: OdometryVelocity,
    late: [usize; 2],
}

/// An input, and the localizer before it.
#[derive(Debug, Clone)]
struct Moment<F> {
    /// The time from which on the input acts \[s\].
    from: f64,
    input: Event,
    before: F,
}

impl<F: Sequential> Delayed<F> {
    /// A localizer that takes inputs up to `horizon` \[s\] late; 0 for inputs in order only.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a negative horizon.
    pub fn new(localizer: F, horizon: f64) -> Result<Self> {
        let horizon = loc_core::error::non_negative("horizon for late inputs [s]", horizon)?;
        let (past, odometry) = (VecDeque::new(), OdometryVelocity::default());
        Ok(Delayed { newest: localizer, past, horizon, odometry, late: [0; 2] })
    }

    /// The localizer after its newest input.
    pub fn newest(&self) -> &F {
        &self.newest
    }

    /// The localizer after its last input up to `stamp` \[s\]; the oldest copy where that is too far
    /// back.
    pub fn at(&self, stamp: f64) -> &F {
        let later = self.past.partition_point(|moment| moment.from <= stamp);
        self.past.get(later).map_or(&self.newest, |moment| &moment.before)
    }

    /// Applies an input at its stamp. `what` names it in errors.
    ///
    /// # Errors
    /// [`Error::TooLate`] beyond the horizon, [`loc_core::Error::OutOfRange`] for a stamp that is
    /// not finite, and what the localizer refuses; it is then as it was before.
    fn input(&mut self, what: &'static str, from: f64, input: Event) -> Result<Vec<Outcome>> {
        loc_core::error::finite("stamp [s]", from)?;
        let rank = F::rank(&input.payload);
        let comes_before = |other: &Moment<F>| {
            other.from < from || (other.from <= from && F::rank(&other.input.payload) <= rank)
        };
        let place = self.past.partition_point(comes_before);
        let newest = self.past.back().map(|moment| moment.from);
        match newest {
            Some(newest) if place < self.past.len() => {
                if from < newest - self.horizon {
                    let (stamp, horizon) = (input.stamp, self.horizon);
                    return Err(Error::TooLate { what, stamp, newest, horizon });
                }
                self.insert(place, from, input)
            }
            _ => self.append(from, input),
        }
    }

    /// The common case: an input that is the newest.
    fn append(&mut self, from: f64, input: Event) -> Result<Vec<Outcome>> {
        let before = self.newest.clone();
        let outcomes = match apply(&mut self.newest, &input) {
            Ok(outcomes) => outcomes,
            Err(error) => {
                self.newest = before;
                return Err(error);
            }
        };
        let oldest = from - self.horizon;
        self.past.push_back(Moment { from, input, before });
        // The newest moment stays, so that there is always a last stamp to compare with.
        while self.past.len() > 1 && self.past[0].from < oldest {
            self.past.pop_front();
        }
        Ok(outcomes)
    }

    /// Goes back to `place`, applies the input and then again what came after it.
    fn insert(&mut self, place: usize, from: f64, input: Event) -> Result<Vec<Outcome>> {
        let before = self.past[place].before.clone();
        let mut filter = before.clone();
        let outcomes = apply(&mut filter, &input)?;
        let mut repeated = Vec::with_capacity(self.past.len() - place);
        for moment in self.past.range(place..) {
            repeated.push(filter.clone());
            apply(&mut filter, &moment.input)?;
        }
        for (moment, before) in self.past.range_mut(place..).zip(repeated) {
            moment.before = before;
        }
        self.past.insert(place, Moment { from, input, before });
        self.newest = filter;
        Ok(outcomes)
    }
}

/// Gives an input to a localizer.
pub(crate) fn apply(localizer: &mut impl Localizer, input: &Event) -> Result<Vec<Outcome>> {
    match &input.payload {
        Payload::Control(control) => localizer.predict(input.stamp, control).map(|()| Vec::new()),
        Payload::Measurement(measurement) => localizer.correct(input.stamp, measurement),
        Payload::Truth(_) => Ok(Vec::new()),
    }
}

impl<F: Sequential> Localizer for Delayed<F> {
    /// A control from beyond the horizon is dropped; [`Localizer::notes`] counts them.
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        let (stamp, control) = match control {
            Control::Odometry(pose) if !F::USES_POSES => match self.odometry.next(stamp, *pose) {
                Some((from, twist)) => (from, Control::Velocity(twist)),
                None => return Ok(()),
            },
            other => (stamp, *other),
        };
        match self.input("control", stamp, Event::now(stamp, Payload::Control(control))) {
            Err(Error::TooLate { .. }) => self.late[0] += 1,
            other => drop(other?),
        }
        Ok(())
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Outcome>> {
        if !self.newest.uses(measurement) {
            return Ok(Vec::new());
        }
        let from = self.newest.acts_from(stamp, measurement);
        let input = Event::now(stamp, Payload::Measurement(measurement.clone()));
        match self.input("measurement", from, input) {
            Err(Error::TooLate { .. }) => {
                self.late[1] += 1;
                let parts =
                    if let Measurement::Landmarks(all) = measurement { all.len() } else { 1 };
                Ok(vec![Outcome::of(Decision::TooLate); parts])
            }
            other => other,
        }
    }

    fn estimate(&self, stamp: f64) -> Result<Estimate> {
        self.at(loc_core::error::finite("stamp [s]", stamp)?).estimate(stamp)
    }

    fn hypotheses(&self) -> Vec<Hypothesis> {
        self.newest.hypotheses()
    }

    fn particle_count(&self) -> usize {
        self.newest.particle_count()
    }

    fn particle_set(&self, max: usize) -> Option<ParticleSet> {
        self.newest.particle_set(max)
    }

    fn grid_belief(&self) -> Option<GridBelief> {
        self.newest.grid_belief()
    }

    fn map(&self) -> Result<Option<EstimatedMap>> {
        self.newest.map()
    }

    fn sensor_errors(&self, stamp: f64) -> Result<Vec<SensorError>> {
        self.at(stamp).sensor_errors(stamp)
    }

    fn line_matches(&self) -> Option<&LineUpdate> {
        self.newest.line_matches()
    }

    fn notes(&self) -> Vec<String> {
        let counted = self.late.iter().zip(["controls", "measurements"]);
        let late = counted.filter(|(count, _)| **count > 0).map(|(count, what)| {
            format!("{count} {what} came more than {} s late and were not used", self.horizon)
        });
        self.newest.notes().into_iter().chain(late).collect()
    }
}

/// Stamps that are computed in different ways differ by so much \[s\].
const ROUNDING: f64 = 1e-6;

/// The time of a localizer that expects its inputs in order.
///
/// ```
/// use loc_filters::delayed::Clock;
/// let mut clock = Clock::starting_at(10.0)?;
/// assert_eq!(clock.advance("velocity", 9.5)?, 0.0); // before the start: belongs to the start
/// assert_eq!(clock.advance("velocity", 12.0)?, 2.0);
/// assert!(clock.advance("velocity", 11.0).is_err());
/// # Ok::<(), loc_filters::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Clock {
    start: f64,
    now: f64,
}

impl Clock {
    /// A clock at the start of a run \[s\].
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a stamp that is not finite.
    pub fn starting_at(stamp: f64) -> Result<Self> {
        let start = loc_core::error::finite("start time [s]", stamp)?;
        Ok(Clock { start, now: start })
    }

    /// The time of the last input, or of the start \[s\].
    pub fn now(&self) -> f64 {
        self.now
    }

    /// The time from now to `stamp` \[s\]; 0 for one before now.
    pub fn until(&self, stamp: f64) -> f64 {
        (stamp - self.now).max(0.0)
    }

    /// Moves to the time of an input, and returns the time that passes \[s\]. Inputs from before the
    /// start belong to the start. `what` names the input in errors.
    ///
    /// # Errors
    /// [`Error::TooLate`] for an input before the last one, rounding apart; [`loc_core::Error::OutOfRange`] for a
    /// stamp that is not finite.
    pub fn advance(&mut self, what: &'static str, stamp: f64) -> Result<f64> {
        let dt = loc_core::error::finite("stamp [s]", stamp)? - self.now;
        if dt < -ROUNDING && self.now > self.start {
            return Err(Error::TooLate { what, stamp, newest: self.now, horizon: 0.0 });
        }
        // Adding the difference keeps the rounding of the time that the filter has integrated.
        let dt = dt.max(0.0);
        self.now += dt;
        Ok(dt)
    }
}

/// Converts the poses of an odometry to the velocities between them, for filters that want those.
#[derive(Debug, Clone, Copy, Default)]
pub struct OdometryVelocity {
    /// Time \[s\] and pose of the last report.
    last: Option<(f64, Pose2)>,
}

impl OdometryVelocity {
    /// The velocity that has led to a pose at `stamp` \[s\], along the arc that joins it with the
    /// pose before, and the time from which on it holds. `None` for the first pose, and where no
    /// time has passed.
    pub fn next(&mut self, stamp: f64, pose: Pose2) -> Option<(f64, Twist2)> {
        let (before, start) = self.last.replace((stamp, pose))?;
        let dt = stamp - before;
        let arc = start.between(pose).log() / dt;
        (dt > 0.0).then(|| (before, Twist2::new(arc.x, arc.y, arc.z)))
    }
}
