use approx::assert_relative_eq;
use loc_core::gaussian::pose_belief;
use loc_core::motion::{Integration, VelocityNoise};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, Twist2, angle};
use loc_filters::Error;
use loc_filters::RobotSettings;
use loc_filters::delayed::Delayed;
use loc_filters::lateration::{RangeBias, SlidingLateration, SlidingSettings};
use loc_filters::localizer::{Decision, Localizer, Outcome};
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::landmark_camera::{LandmarkNoise, LandmarkObservation, Observed};
use nalgebra::{Point2, Vector2};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};

const STEP: f64 = 0.1;

fn map() -> LandmarkMap {
    LandmarkMap::new([
        Landmark::planar(1, 0.0, 0.0),
        Landmark::planar(2, 10.0, 0.0),
        Landmark::planar(3, 10.0, 8.0),
        Landmark::planar(4, 0.0, 8.0),
        Landmark::planar(5, 5.0, 4.0),
    ])
    .unwrap()
}

fn heard(landmark: u32, range: f64) -> LandmarkObservation {
    LandmarkObservation { landmark, observed: Observed::Range { range } }
}

/// A robot on a figure of eight, heard by one landmark after the other.
struct Drive {
    pose: Pose2,
    step: u32,
    rng: ChaCha8Rng,
    bias: RangeBias,
    antenna: Point2<f64>,
}

impl Drive {
    fn new(seed: u64) -> Self {
        let pose = Pose2::new(4.0, 2.0, 0.3);
        let rng = stream(seed, "drive");
        Drive { pose, step: 0, rng, bias: RangeBias::NONE, antenna: Point2::origin() }
    }

    fn stamp(&self) -> f64 {
        STEP * f64::from(self.step)
    }

    /// Velocity that odometry reports of the next step, which is then driven.
    fn drive(&mut self) -> Twist2 {
        let omega = if (self.step / 125).is_multiple_of(2) { 0.5 } else { -0.5 };
        let (truth, noise) = (Twist2::forward(0.5, omega), VelocityNoise::default());
        self.pose = Integration::ExactArc.step(self.pose, truth, STEP);
        self.step += 1;
        let sigmas = noise.variances(truth, STEP).map(f64::sqrt);
        Twist2::forward(truth.vx + sigmas.x * self.normal(), truth.omega + sigmas.z * self.normal())
    }

    fn hear(&mut self) -> LandmarkObservation {
        let landmark = 1 + self.step % 5;
        let place = map().get(landmark).unwrap().position.xy();
        let distance = nalgebra::distance(&self.pose.transform(&self.antenna), &place);
        heard(landmark, self.bias.reported(distance) + 0.1 * self.normal())
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.rng)
    }
}

/// From nothing, with a bias and an antenna in front: RMS error, and mean NEES of the position once
/// the window is full.
fn run(seed: u64, settings: SlidingSettings) -> (f64, f64, Option<RangeBias>) {
    let mut drive = Drive::new(seed);
    drive.bias = RangeBias { scale: 1.05, offset: 0.1 };
    drive.antenna = settings.robot.mounting.position();
    let mut robot = SlidingLateration::new(map(), settings, 0.0).unwrap();
    let (mut square, mut nees, mut count) = (0.0, 0.0, 0.0);
    while drive.step < 400 {
        robot.velocity(drive.stamp(), drive.drive()).unwrap();
        let observation = drive.hear();
        robot.observations(drive.stamp(), &[observation]).unwrap();
        if drive.step > 100 {
            let found = robot.belief_at(drive.stamp()).unwrap().unwrap();
            let error: Vector2<f64> = drive.pose.position() - found.pose().position();
            square += error.norm_squared();
            nees += loc_core::stats::nees(&error, &found.position().covariance).unwrap();
            count += 1.0;
        }
    }
    (f64::sqrt(square / count), nees / count, robot.bias())
}

#[test]
fn a_biased_sensor_and_odometry_find_the_robot() {
    let antenna = Point2::new(0.3, 0.1);
    let camera = LandmarkNoise { range_sigma: 0.1, ..LandmarkNoise::default() };
    let mounting = Pose2::new(antenna.x, antenna.y, 0.0);
    let robot = RobotSettings::default().camera(camera).mounting(mounting);
    let settings = SlidingSettings::default().robot(robot);
    let (mut total, mut worst) = (0.0, 0.0);
    for seed in 0..6 {
        let (rms, nees, bias) = run(seed, settings);
        worst = f64::max(worst, rms);
        total += nees / 6.0;
        let bias = bias.unwrap();
        let at_5_m = bias.reported(5.0) - RangeBias { scale: 1.05, offset: 0.1 }.reported(5.0);
        assert!(at_5_m.abs() < 0.15, "{bias:?}");
    }
    println!("worst RMS {worst:.3} m, mean NEES {total:.2}");
    assert!(worst < 0.12 && (1.0..3.0).contains(&total), "{worst} {total}");
    let blind = settings.odometry(false).window(10);
    assert!(run(0, blind).0 > 1.5 * run(0, settings).0);
}

/// The bias of a sensor is known better by all distances of a drive than by the last dozen.
#[test]
fn the_bias_outlives_the_window() {
    let camera = LandmarkNoise { range_sigma: 0.1, ..LandmarkNoise::default() };
    let robot = RobotSettings::default().camera(camera);
    let settings = SlidingSettings::default().robot(robot).window(12);
    let truth = RangeBias { scale: 1.05, offset: 0.1 };
    let off = |robot: &SlidingLateration| {
        let bias = robot.bias().unwrap();
        (bias.reported(5.0) - truth.reported(5.0)).powi(2)
    };
    let (mut whole, mut recent, mut count) = (0.0, 0.0, 0.0);
    for seed in 0..6 {
        let mut drive = Drive::new(seed);
        drive.bias = truth;
        let mut long = SlidingLateration::new(map(), settings, 0.0).unwrap();
        while drive.step < 300 {
            let mut short = SlidingLateration::new(map(), settings, drive.stamp()).unwrap();
            for _ in 0..12 {
                let (stamp, twist) = (drive.stamp(), drive.drive());
                let observation = drive.hear();
                for robot in [&mut long, &mut short] {
                    robot.velocity(stamp, twist).unwrap();
                    robot.observations(drive.stamp(), &[observation]).unwrap();
                }
            }
            if drive.step > 120 {
                (whole, recent, count) = (whole + off(&long), recent + off(&short), count + 1.0);
            }
        }
    }
    let [whole, recent] = [whole, recent].map(|sum: f64| (sum / count).sqrt());
    assert!(whole < 0.6 * recent && whole < 0.06, "{whole} m, by the last dozen {recent} m");
}

/// While the robot stands, the window holds ranges from one place only; the heading stays.
#[test]
fn the_heading_outlives_the_window() {
    let mut drive = Drive::new(3);
    let mut robot = SlidingLateration::new(map(), SlidingSettings::default(), 0.0).unwrap();
    while drive.step < 200 {
        robot.velocity(drive.stamp(), drive.drive()).unwrap();
        let observation = drive.hear();
        robot.observations(drive.stamp(), &[observation]).unwrap();
    }
    robot.velocity(drive.stamp(), Twist2::ZERO).unwrap();
    for _ in 0..200 {
        drive.step += 1;
        let observation = drive.hear();
        robot.observations(drive.stamp(), &[observation]).unwrap();
    }
    let found = robot.belief_at(drive.stamp()).unwrap().unwrap();
    let off = angle::difference(found.mean.z, drive.pose.theta).abs();
    assert!(off < 0.15 && found.covariance.m33.sqrt() < 0.1, "{off} {}", found.covariance.m33);
    assert!(found.pose().distance(drive.pose) < 0.1);
}

/// Whatever the order of arrival within the horizon, the window is the same.
#[test]
fn late_inputs_end_where_punctual_ones_do() {
    let mut drive = Drive::new(5);
    let mut inputs: Vec<(f64, f64, Result<LandmarkObservation, Twist2>)> = Vec::new();
    while drive.step < 120 {
        let stamp = drive.stamp();
        let twist = drive.drive();
        inputs.push((stamp + 0.25, stamp, Err(twist)));
        let stamp = drive.stamp();
        let observation = drive.hear();
        let delay = drive.rng.random_range(0.0..1.0);
        inputs.push((stamp + delay, stamp, Ok(observation)));
    }
    let start = pose_belief(Pose2::new(4.0, 2.0, 0.3), [0.1, 0.1, 0.05]);
    let follow = |inputs: &[(f64, f64, Result<LandmarkObservation, Twist2>)]| {
        let robot = SlidingLateration::new(map(), SlidingSettings::default(), 0.0)
            .unwrap()
            .start_at(&start)
            .unwrap();
        let mut robot = Delayed::new(robot, 2.0).unwrap();
        for (_, stamp, input) in inputs {
            match input {
                Ok(observation) => drop(robot.observations(*stamp, &[*observation]).unwrap()),
                Err(twist) => robot.velocity(*stamp, *twist).unwrap(),
            }
        }
        // One more for both, so that both solve the same window last.
        robot.observations(12.5, &[heard(1, 4.0)]).unwrap();
        robot.newest().belief_at(12.5).unwrap().unwrap()
    };
    let punctual = follow(&inputs);
    inputs.sort_by(|a, b| a.0.total_cmp(&b.0));
    assert_relative_eq!(follow(&inputs).mean, punctual.mean, epsilon = 1e-6);
}

#[test]
fn what_cannot_be_used_is_told() {
    let mut robot = SlidingLateration::new(map(), SlidingSettings::default(), 0.0).unwrap();
    assert!(robot.belief_at(0.0).unwrap().is_none() && robot.bias().is_none());
    let bearing = LandmarkObservation { landmark: 1, observed: Observed::Bearing { bearing: 0.1 } };
    let decisions = |outcomes: Vec<Outcome>| -> Vec<Decision> {
        outcomes.iter().map(|outcome| outcome.decision).collect()
    };
    let outcomes = robot.observations(0.0, &[heard(99, 1.0), bearing, heard(1, 5.0)]).unwrap();
    let expected = [Decision::UnknownLandmark, Decision::Undetermined, Decision::Pending];
    assert_eq!(decisions(outcomes), expected);
    // Three circles through (3, 4); the fourth is far off.
    let near = [heard(2, 65_f64.sqrt()), heard(4, 5.0), heard(5, 2.0), heard(3, 65_f64.sqrt())];
    assert_eq!(decisions(robot.observations(0.1, &near).unwrap()), [Decision::Accepted; 4]);
    let outlier = robot.observations(0.2, &[heard(3, 3.0)]).unwrap();
    assert_eq!(decisions(outlier), [Decision::Rejected]);
    let before = robot.belief_at(0.3).unwrap().unwrap();
    for range in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(robot.observations(0.3, &[heard(1, 5.0), heard(1, range)]).is_err());
    }
    assert!(robot.velocity(0.3, Twist2::forward(f64::NAN, 0.0)).is_err());
    assert!(robot.observations(f64::NAN, &[heard(1, 5.0)]).is_err());
    assert_eq!(robot.belief_at(0.3).unwrap().unwrap(), before);
    robot.velocity(10.0, Twist2::ZERO).unwrap();
    let error = robot.observations(7.9, &[heard(1, 5.0)]).unwrap_err();
    assert!(matches!(error, Error::TooLate { .. }), "{error}");
    assert!(robot.belief_at(f64::INFINITY).is_err());
}

#[test]
fn settings_that_make_no_sense_are_refused() {
    let usual = SlidingSettings::default();
    for settings in [
        usual.window(0),
        usual.walk(0.0),
        usual.robot(RobotSettings::default().mounting(Pose2 { x: f64::NAN, ..Pose2::IDENTITY })),
    ] {
        assert!(SlidingLateration::new(map(), settings, 0.0).is_err());
    }
    assert!(SlidingLateration::new(map(), usual, f64::NAN).is_err());
}
