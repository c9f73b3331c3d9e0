//! Late inputs give the state that inputs in order give.

use loc_core::random::stream;
use loc_core::{Pose2, Twist2};
use loc_filters::delayed::{Clock, Delayed, Sequential};
use loc_filters::localizer::{Decision, Estimate, Localizer, Outcome};
use loc_filters::{Error, Result};
use loc_sensors::compass::CompassReading;
use loc_sensors::event::{Control, Measurement};
use rand::RngExt;

/// A localizer whose state depends on the order of its inputs, and that refuses headings below 0.
#[derive(Clone, Debug, PartialEq)]
struct Hash(f64);

impl Localizer for Hash {
    fn predict(&mut self, stamp: f64, control: &Control) -> Result<()> {
        if let Control::Velocity(twist) = control {
            self.0 = (self.0 * 1.7 + twist.vx + stamp).sin();
        }
        Ok(())
    }

    fn correct(&mut self, stamp: f64, measurement: &Measurement) -> Result<Vec<Outcome>> {
        let Measurement::Compass(reading) = measurement else { return Ok(Vec::new()) };
        // The state changes before the input is refused.
        self.0 = (self.0 * 1.7 + reading.heading + stamp).sin();
        if reading.heading < 0.0 {
            return Err(Error::NotFinite { what: "input", found: "-1".into() });
        }
        Ok(vec![Outcome::of(Decision::Accepted)])
    }

    fn estimate(&self, _stamp: f64) -> Result<Estimate> {
        Ok(Estimate {
            pose: Pose2::new(self.0, 0.0, 0.0),
            covariance: None,
            lost: None,
            rail: None,
        })
    }
}

impl Sequential for Hash {
    fn uses(&self, measurement: &Measurement) -> bool {
        matches!(measurement, Measurement::Compass(_))
    }
}

fn heading(heading: f64) -> Measurement {
    Measurement::Compass(CompassReading { heading, strength: 1.0 })
}

#[test]
fn any_order_within_the_horizon_gives_the_same_state() {
    let mut rng = stream(5, "order");
    let in_order: Vec<(f64, f64)> =
        (0..300).map(|k| (f64::from(k / 2) * 0.01, rng.random::<f64>())).collect();
    let mut reference = Delayed::new(Hash(0.0), 0.25).unwrap();
    for &(stamp, input) in &in_order {
        reference.correct(stamp, &heading(input)).unwrap();
    }
    for seed in 0..20 {
        let mut rng = stream(seed, "shuffle");
        // Every input arrives up to 0.2 s after its stamp; inputs of one stamp keep their order.
        let mut arrivals: Vec<(f64, f64, f64)> = Vec::new();
        for pair in in_order.chunks(2) {
            let delay = 0.2 * rng.random::<f64>();
            arrivals.extend(pair.iter().map(|&(stamp, input)| (stamp + delay, stamp, input)));
        }
        arrivals.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut filter = Delayed::new(Hash(0.0), 0.25).unwrap();
        for (_, stamp, input) in arrivals {
            filter.correct(stamp, &heading(input)).unwrap();
        }
        assert_eq!(filter.newest(), reference.newest());
        assert_eq!(filter.at(1.4), reference.at(1.4));
        assert!(filter.notes().is_empty());
    }
}

#[test]
fn inputs_beyond_the_horizon_are_outcomes_and_are_counted() {
    let mut filter = Delayed::new(Hash(0.0), 0.5).unwrap();
    filter.correct(1.0, &heading(1.0)).unwrap();
    filter.correct(2.0, &heading(1.0)).unwrap();
    let before = filter.newest().clone();
    let outcomes = filter.correct(1.4, &heading(1.0)).unwrap();
    assert_eq!(outcomes[0].decision, Decision::TooLate);
    filter.velocity(1.4, Twist2::ZERO).unwrap();
    assert_eq!(
        filter.notes(),
        [
            "1 controls came more than 0.5 s late and were not used",
            "1 measurements came more than 0.5 s late and were not used"
        ]
    );
    assert_eq!(*filter.newest(), before);
    assert_eq!(filter.correct(1.5, &heading(1.0)).unwrap()[0].decision, Decision::Accepted);
    assert!(filter.correct(f64::NAN, &heading(1.0)).is_err());
    assert!(Delayed::new(Hash(0.0), -1.0).is_err());
}

#[test]
fn a_refused_input_changes_nothing_in_order_or_late() {
    let mut filter = Delayed::new(Hash(0.0), 1.0).unwrap();
    for stamp in [0.0, 0.1, 0.2, 0.3] {
        filter.correct(stamp, &heading(0.5)).unwrap();
    }
    let before = filter.newest().clone();
    assert!(filter.correct(0.4, &heading(-1.0)).is_err());
    assert!(filter.correct(0.15, &heading(-1.0)).is_err());
    assert_eq!(*filter.newest(), before);
    assert_eq!(filter.at(0.3), &before);
}

/// The poses of an odometry arrive as velocities from the pose before on, so that measurements in
/// between come before them in time.
#[test]
fn poses_of_an_odometry_are_velocities_between_them() {
    let mut poses = Delayed::new(Hash(0.0), 1.0).unwrap();
    let mut velocities = Delayed::new(Hash(0.0), 1.0).unwrap();
    for k in 0..5 {
        let stamp = f64::from(k);
        poses.predict(stamp, &Control::Odometry(Pose2::new(0.5 * stamp, 0.0, 0.0))).unwrap();
        poses.correct(stamp + 0.5, &heading(0.3)).unwrap();
        if k < 4 {
            velocities.velocity(stamp, Twist2::forward(0.5, 0.0)).unwrap();
        }
        velocities.correct(stamp + 0.5, &heading(0.3)).unwrap();
    }
    assert_eq!(poses.newest(), velocities.newest());
}

#[test]
fn a_clock_runs_forward_and_starts_at_the_start() {
    let mut clock = Clock::starting_at(5.0).unwrap();
    assert_eq!((clock.advance("x", 4.0).unwrap(), clock.now()), (0.0, 5.0));
    assert_eq!((clock.advance("x", 5.5).unwrap(), clock.until(6.0)), (0.5, 0.5));
    assert!(matches!(clock.advance("x", 5.4), Err(Error::TooLate { .. })));
    assert!(clock.advance("x", f64::NAN).is_err() && Clock::starting_at(f64::INFINITY).is_err());
}
