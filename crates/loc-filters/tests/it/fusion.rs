//! Sensor fusion.

use loc_core::gaussian::pose_belief;
use loc_core::motion::{Integration, VelocityNoise, dead_reckon};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::stats::nees;
use loc_core::{Gaussian, Pose2, Twist2};
use loc_filters::Localizer;
use loc_filters::RobotSettings;
use loc_filters::delayed::Delayed;
use loc_filters::extended::{MeasurementModel, MotionModel};
use loc_filters::fusion::state::{
    DRIFT_X, FORWARD_BIAS, GYRO_BIAS, RANGE_OFFSET, RANGE_SCALE, STATES, THETA,
};
use loc_filters::fusion::{
    CompassModel, DirectionModel, DistanceModel, FusedBelief, FusedLocalizer, FusedMotion,
    FusionSettings, InertialModel, ObservationModel, PositionModel, WheelModel,
};
use loc_filters::landmark::RangeBearingModel;
use loc_filters::lateration::BiasPrior;
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::compass::CompassReading;
use loc_sensors::event::Measurement;
use loc_sensors::gnss::GnssNoise;
use loc_sensors::imu::{ImuReading, ImuSpec, InertialNoise};
use loc_sensors::landmark_camera::{LandmarkNoise, LandmarkObservation, Observed};
use nalgebra::{Matrix2, Point2, SVector, Vector2, Vector3};
use rand_distr::{Distribution, StandardNormal};

type State = SVector<f64, STATES>;
type Robot = Delayed<FusedLocalizer>;

fn belief_of(robot: &Robot, stamp: f64) -> loc_filters::Result<FusedBelief> {
    robot.at(stamp).belief_at(stamp)
}

fn state() -> State {
    State::from_column_slice(&[1.2, -0.7, 0.8, 0.9, 0.4, 0.02, 0.1, -0.05, 1.04, 0.12, 0.6, -0.3])
}

const STEP: f64 = 1e-6;

/// The derivative of `f` by finite differences, column by column.
fn differences<const M: usize>(f: impl Fn(&State) -> SVector<f64, M>) -> Vec<SVector<f64, M>> {
    (0..STATES)
        .map(|k| {
            let (mut above, mut below) = (state(), state());
            above[k] += STEP;
            below[k] -= STEP;
            (f(&above) - f(&below)) / (2.0 * STEP)
        })
        .collect()
}

fn assert_jacobian<const M: usize>(what: &str, model: &impl MeasurementModel<STATES, M>) {
    let (expected, jacobian) = model.linearize(&state());
    assert!((expected - model.predict(&state())).norm() < 1e-12, "{what}");
    for (k, column) in differences(|x| model.predict(x)).iter().enumerate() {
        let off = (column - jacobian.column(k)).norm();
        assert!(off < 1e-7, "{what}, column {k}: {off:e}");
    }
}

#[test]
fn jacobians_are_those_of_finite_differences() {
    for acceleration in [None, Some(0.7)] {
        let motion = FusedMotion::new(&FusionSettings::default(), 0.3, 0.2, acceleration);
        let linear = motion.linearize(&state());
        assert!((linear.state - motion.predict(&state())).norm() < 1e-12);
        for (k, column) in differences(|x| motion.predict(x)).iter().enumerate() {
            let off = (column - linear.jacobian.column(k)).norm();
            assert!(off < 1e-7, "motion, column {k}: {off:e}");
        }
    }
    let variances = Vector2::new(0.1, 0.2);
    assert_jacobian("wheels", &WheelModel { variances });
    assert_jacobian("inertial", &InertialModel { variances });
    assert_jacobian("compass", &CompassModel { variance: 0.1 });
    let antenna = Point2::new(0.3, -0.2);
    assert_jacobian("satellites", &PositionModel { antenna, noise: Matrix2::identity() });
    let model = RangeBearingModel {
        landmark: Point2::new(4.0, 3.0),
        mounting: Pose2::new(0.2, 0.1, 0.3),
        noise: LandmarkNoise::default(),
    };
    let model = ObservationModel { model, bend: 0.07 };
    assert_jacobian("observed", &model);
    assert_jacobian("distance", &DistanceModel(model));
    assert_jacobian("direction", &DirectionModel(model));
}

/// The bend of a circle, against the moments of many positions.
#[test]
fn a_distance_bends_as_its_positions_say() {
    let model = RangeBearingModel {
        landmark: Point2::new(6.0, 0.0),
        mounting: Pose2::IDENTITY,
        noise: LandmarkNoise::default(),
    };
    let mut belief = Gaussian { mean: State::zeros(), covariance: Default::default() };
    belief.mean[RANGE_SCALE] = 1.0;
    belief.covariance[(1, 1)] = 0.8_f64.powi(2);
    let model = ObservationModel::new(model, &belief);
    let mut rng = stream(3, "positions");
    let (mut sum, mut squares, count) = (0.0, 0.0, 200_000.0);
    for _ in 0..200_000 {
        let y: f64 = 0.8 * normal(&mut rng);
        let longer = (36.0 + y * y).sqrt() - 6.0;
        (sum, squares) = (sum + longer, squares + longer * longer);
    }
    let (mean, variance) = (sum / count, squares / count - (sum / count).powi(2));
    assert!((0.5 * model.bend - mean).abs() < 0.03 * mean, "{} {mean}", model.bend);
    let added = 0.5 * model.bend * model.bend;
    assert!((added - variance).abs() < 0.06 * variance, "{added} {variance}");
}

fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

fn settings() -> FusionSettings {
    let axis = |density, start_bias| InertialNoise {
        density,
        bias_walk: density / 50.0,
        start_bias,
        limit: 50.0,
    };
    FusionSettings::default()
        .robot(
            RobotSettings::default()
                .odometry(VelocityNoise::from_sigmas(0.05, 0.1, 0.03).unwrap())
                .camera(LandmarkNoise { range_sigma: 0.2, ..LandmarkNoise::default() }),
        )
        .range_bias(BiasPrior { scale_sigma: 0.05, offset_sigma: 0.2 })
        .imu(ImuSpec { rate: 20.0, accelerometer: axis(0.01, 0.1), gyroscope: axis(0.001, 0.01) })
        .compass_sigma(0.05)
        .gnss(GnssNoise {
            white_sigma: 0.5,
            drift_sigma: 0.5,
            drift_time: 30.0,
            vertical_factor: 1.0,
        })
        .start_speed(0.1)
        .start_turn(0.1)
}

fn map() -> LandmarkMap {
    LandmarkMap::new([
        Landmark::planar(1, -12.0, -14.0),
        Landmark::planar(2, 30.0, -8.0),
        Landmark::planar(3, 8.0, 40.0),
    ])
    .unwrap()
}

/// What a robot is given: `k` in 0..STEPS.
struct Drive {
    truth: Pose2,
    twist: Twist2,
    biases: [f64; 4],
    drift: Vector2<f64>,
    rng: ChaCha8Rng,
}

const DT: f64 = 0.05;

#[derive(Clone, Copy, PartialEq)]
enum Mute {
    Nothing,
    Satellites,
}

impl Drive {
    fn new(seed: u64, settings: &FusionSettings) -> (Self, Gaussian<3>) {
        let mut rng = stream(seed, "drive");
        let mut belief = pose_belief(Pose2::new(1.0, 2.0, 0.3), [0.5, 0.5, 0.1]);
        let truth = belief.mean;
        belief.mean = belief.sample(&mut rng);
        let mut draw = |sigma: f64| sigma * normal(&mut rng);
        let biases = [
            draw(settings.imu.gyroscope.start_bias),
            draw(settings.imu.accelerometer.start_bias),
            draw(settings.range_bias.scale_sigma),
            draw(settings.range_bias.offset_sigma),
        ];
        let drift = Vector2::new(draw(0.5), draw(0.5));
        let twist = Twist2::ZERO;
        (Drive { truth: Pose2::from_vector(&truth), twist, biases, drift, rng }, belief)
    }

    /// One step of 0.05 s.
    fn step(&mut self, k: u32, robot: &mut Robot, settings: &FusionSettings, mute: Mute) {
        let from = f64::from(k) * DT;
        let stamp = f64::from(k + 1) * DT;
        let speed = (0.4 * stamp).min(1.2);
        let next = Twist2::forward(speed, 0.3 * (0.25 * stamp).sin());
        let mean =
            Twist2::forward(0.5 * (self.twist.vx + next.vx), 0.5 * (self.twist.omega + next.omega));
        let acceleration = (next.vx - self.twist.vx) / DT;
        self.truth = Integration::ExactArc.step(self.truth, mean, DT);
        self.twist = next;
        let rng = &mut self.rng;
        let mut draw = |sigma: f64| sigma * normal(rng);
        if k.is_multiple_of(2) {
            let sigma = settings.robot.odometry.variances(mean, 2.0 * DT).map(f64::sqrt);
            let seen = Twist2::forward(mean.vx + draw(sigma.x), mean.omega + draw(sigma.z));
            robot.velocity(from, seen).unwrap();
        }
        let (gyro, force) = (settings.imu.gyroscope, settings.imu.accelerometer);
        let reading = ImuReading {
            acceleration: Vector3::new(
                acceleration + self.biases[1] + draw(force.sample_sigma(DT)),
                mean.vx * mean.omega + draw(force.sample_sigma(DT)),
                9.8,
            ),
            angular_velocity: Vector3::new(
                0.0,
                0.0,
                mean.omega + self.biases[0] + draw(gyro.sample_sigma(DT)),
            ),
        };
        robot.correct(stamp, &Measurement::Inertial(reading)).unwrap();
        if k % 10 == 3 {
            let heading = self.truth.theta + draw(settings.compass_sigma);
            robot
                .correct(stamp, &Measurement::Compass(CompassReading { heading, strength: 20.0 }))
                .unwrap();
        }
        if k % 20 == 7 {
            let decay = (-20.0 * DT / settings.gnss.drift_time).exp();
            let fresh = settings.gnss.drift_sigma * (1.0 - decay * decay).sqrt();
            self.drift = self.drift * decay + Vector2::new(draw(fresh), draw(fresh));
            let white = Vector2::new(draw(0.5), draw(0.5));
            if mute != Mute::Satellites {
                robot
                    .correct(stamp, &Measurement::Position(fix(self.truth, self.drift + white)))
                    .unwrap();
            }
        }
        if k % 15 == 5 && mute != Mute::Satellites {
            let observations: Vec<_> = map()
                .iter()
                .map(|landmark| {
                    let true_range = (landmark.position.xy() - self.truth.position()).norm();
                    let range = (1.0 + self.biases[2]) * true_range + self.biases[3] + draw(0.2);
                    LandmarkObservation {
                        landmark: landmark.id,
                        observed: Observed::Range { range },
                    }
                })
                .collect();
            robot.observations(stamp, &observations).unwrap();
        }
    }
}

fn fix(pose: Pose2, off: Vector2<f64>) -> Gaussian<2> {
    let mean = pose.position().coords + off;
    Gaussian::new(mean, Matrix2::identity() * 0.5).unwrap()
}

fn pose_nees(belief: &FusedBelief, truth: Pose2) -> f64 {
    let pose = belief.about_pose();
    nees(&pose.pose_deviation(truth), &pose.covariance).unwrap()
}

#[test]
fn the_covariance_is_honest_and_the_biases_are_found() {
    let settings = settings();
    let (mut sum, mut count, mut biases) = (0.0, 0.0, [0.0; 4]);
    let runs = 40;
    for seed in 0..runs {
        let (mut drive, start) = Drive::new(seed, &settings);
        let mut robot =
            Delayed::new(FusedLocalizer::new(map(), settings, 0.0, start).unwrap(), 2.0).unwrap();
        for k in 0..600 {
            drive.step(k, &mut robot, &settings, Mute::Nothing);
            if k % 100 == 99 {
                let belief = belief_of(&robot, f64::from(k + 1) * DT).unwrap();
                (sum, count) = (sum + pose_nees(&belief, drive.truth), count + 1.0);
            }
        }
        let belief = belief_of(&robot, 600.0 * DT).unwrap();
        let indices = [GYRO_BIAS, FORWARD_BIAS, RANGE_SCALE, RANGE_OFFSET];
        for (k, index) in indices.into_iter().enumerate() {
            let (mean, sigma) = belief.state(index).unwrap();
            let truth = drive.biases[k] + if index == RANGE_SCALE { 1.0 } else { 0.0 };
            biases[k] += ((mean - truth) / sigma).powi(2) / runs as f64;
        }
    }
    let nees = sum / count;
    println!("NEES {nees:.2} of 3, squared errors of the biases {biases:.2?}");
    assert!((2.3..3.8).contains(&nees), "{nees}");
    assert!(biases.iter().all(|error| (0.3..2.0).contains(error)), "{biases:?}");
}

#[test]
fn an_outage_widens_the_belief_and_its_end_narrows_it() {
    let settings = settings();
    let (mut drive, start) = Drive::new(5, &settings);
    let mut robot =
        Delayed::new(FusedLocalizer::new(map(), settings, 0.0, start).unwrap(), 2.0).unwrap();
    let spread = |robot: &Robot, k: u32| {
        let belief = belief_of(robot, f64::from(k) * DT).unwrap();
        belief.about_pose().covariance.fixed_view::<2, 2>(0, 0).trace().sqrt()
    };
    let mut sigmas = Vec::new();
    for k in 0..1600 {
        let mute = if (400..1200).contains(&k) { Mute::Satellites } else { Mute::Nothing };
        drive.step(k, &mut robot, &settings, mute);
        if k % 200 == 199 {
            sigmas.push(spread(&robot, k + 1));
            let belief = belief_of(&robot, f64::from(k + 1) * DT).unwrap();
            assert!(pose_nees(&belief, drive.truth) < 16.3, "beyond 99.9 %");
        }
    }
    // Stamps 10, 20 s | outage 30 .. 60 s | 70, 80 s.
    assert!(sigmas[2..6].windows(2).all(|pair| pair[1] > pair[0]), "{sigmas:?}");
    assert!(sigmas[5] > 1.5 * sigmas[1] && sigmas[7] < 0.6 * sigmas[5], "{sigmas:?}");
    let drift = belief_of(&robot, 80.0).unwrap().state(DRIFT_X).unwrap();
    assert!(drift.1 < settings.gnss.drift_sigma, "what the ranges tell about the receiver");
}

/// Wheels alone are dead reckoning, as if there was no other state.
#[test]
fn sensors_that_never_come_change_nothing() {
    let settings = settings().start_speed(10.0).start_turn(10.0);
    let start = pose_belief(Pose2::new(1.0, 2.0, 0.3), [0.1, 0.1, 0.05]);
    let mut robot = Delayed::new(
        FusedLocalizer::new(LandmarkMap::default(), settings, 0.0, start).unwrap(),
        2.0,
    )
    .unwrap();
    let mut expected = start;
    for k in 0..100 {
        let twist = Twist2::forward(1.0, 0.2);
        robot.velocity(f64::from(k) * 0.1, twist).unwrap();
        let (arc, noise) = (Integration::ExactArc, settings.robot.odometry);
        expected = dead_reckon(&expected, twist, 0.1, arc, &noise);
    }
    let belief = belief_of(&robot, 10.0).unwrap().about_pose();
    assert!((belief.mean - expected.mean).norm() < 1e-3, "{} {}", belief.mean, expected.mean);
    for i in 0..3 {
        let ratio = belief.covariance[(i, i)] / expected.covariance[(i, i)];
        assert!((0.8..1.2).contains(&ratio), "{i}: {ratio}");
    }
}

/// Satellites alone: a robot of which nothing else is known is found, and its speed too.
#[test]
fn positions_alone_follow_a_robot() {
    let settings = settings();
    let start = pose_belief(Pose2::new(0.0, 0.0, 0.0), [5.0, 5.0, 0.5]);
    let mut robot = Delayed::new(
        FusedLocalizer::new(LandmarkMap::default(), settings, 0.0, start).unwrap(),
        2.0,
    )
    .unwrap();
    for k in 0..60 {
        let stamp = f64::from(k);
        robot
            .correct(
                stamp,
                &Measurement::Position(fix(Pose2::new(stamp, 0.2 * stamp, 0.0), Vector2::zeros())),
            )
            .unwrap();
    }
    let belief = belief_of(&robot, 59.0).unwrap();
    assert!(belief.pose().distance(Pose2::new(59.0, 11.8, 0.0)) < 0.5, "{:?}", belief.pose());
    assert!((belief.pose().theta - 0.2_f64.atan()).abs() < 0.15);
}

#[test]
fn the_order_of_one_moment_and_late_inputs_do_not_matter() {
    let settings = settings();
    let start = pose_belief(Pose2::new(1.0, 2.0, 0.3), [0.5, 0.5, 0.1]);
    let new =
        || Delayed::new(FusedLocalizer::new(map(), settings, 0.0, start).unwrap(), 2.0).unwrap();
    let imu = ImuReading {
        acceleration: Vector3::new(0.2, 0.1, 9.8),
        angular_velocity: Vector3::new(0.0, 0.0, 0.1),
    };
    let give = |robot: &mut Robot, which: usize, stamp: f64| match which {
        0 => robot.velocity(stamp, Twist2::forward(1.0, 0.1)).map(|_| ()).unwrap(),
        1 => robot.correct(stamp, &Measurement::Inertial(imu)).map(|_| ()).unwrap(),
        2 => {
            let reading = CompassReading { heading: 0.35, strength: 20.0 };
            robot.correct(stamp, &Measurement::Compass(reading)).map(|_| ()).unwrap();
        }
        3 => {
            let at = fix(Pose2::new(1.3, 2.2, 0.0), Vector2::zeros());
            robot.correct(stamp, &Measurement::Position(at)).map(|_| ()).unwrap();
        }
        _ => {
            let observed = Observed::Range { range: 21.0 };
            robot
                .observations(stamp, &[LandmarkObservation { landmark: 1, observed }])
                .map(|_| ())
                .unwrap();
        }
    };
    let mut in_order = new();
    for moment in 1..=3 {
        (0..5).for_each(|which| give(&mut in_order, which, 0.2 * f64::from(moment)));
    }
    let expected = belief_of(&in_order, 0.7).unwrap();
    for order in [[4, 3, 2, 1, 0], [2, 0, 4, 1, 3]] {
        let mut robot = new();
        for moment in 1..=3 {
            order.iter().for_each(|&which| give(&mut robot, which, 0.2 * f64::from(moment)));
        }
        assert_eq!(belief_of(&robot, 0.7).unwrap(), expected);
    }
    let mut late = new();
    for which in 0..5 {
        (1..=3).rev().for_each(|moment| give(&mut late, which, 0.2 * f64::from(moment)));
    }
    assert_eq!(belief_of(&late, 0.7).unwrap(), expected);
    late.velocity(-5.0, Twist2::ZERO).unwrap();
    assert_eq!(late.notes(), ["1 controls came more than 2 s late and were not used"]);
    assert_eq!(belief_of(&late, 0.7).unwrap(), expected);
}

#[test]
fn bad_input_is_refused_and_leaves_the_filter_as_it_was() {
    let start = pose_belief(Pose2::IDENTITY, [0.5, 0.5, 0.1]);
    let mut robot =
        Delayed::new(FusedLocalizer::new(map(), settings(), 0.0, start).unwrap(), 2.0).unwrap();
    robot.velocity(0.0, Twist2::forward(1.0, 0.0)).unwrap();
    let before = belief_of(&robot, 1.0).unwrap();
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for value in bad {
        let force = Vector3::new(value, 0.0, 0.0);
        let reading = ImuReading { acceleration: force, angular_velocity: Vector3::zeros() };
        assert!(robot.correct(0.5, &Measurement::Inertial(reading)).is_err());
        let turning =
            ImuReading { acceleration: Vector3::zeros(), angular_velocity: Vector3::repeat(value) };
        assert!(robot.correct(0.5, &Measurement::Inertial(turning)).is_err());
        assert!(robot.velocity(0.5, Twist2::forward(value, 0.0)).is_err());
        assert!(robot.velocity(value, Twist2::ZERO).is_err());
        assert!(
            robot
                .correct(
                    0.5,
                    &Measurement::Compass(CompassReading { heading: value, strength: 20.0 })
                )
                .is_err()
        );
        let fix = Gaussian { mean: Vector2::new(value, 0.0), covariance: Matrix2::identity() };
        assert!(robot.correct(0.5, &Measurement::Position(fix)).is_err());
        let observed = Observed::Range { range: value };
        assert!(robot.observations(0.5, &[LandmarkObservation { landmark: 1, observed }]).is_err());
        assert!(belief_of(&robot, value).is_err());
    }
    let negative = Gaussian { mean: Vector2::zeros(), covariance: -Matrix2::identity() };
    assert!(robot.correct(0.5, &Measurement::Position(negative)).is_err());
    assert!(
        robot
            .observations(
                0.5,
                &[LandmarkObservation { landmark: 1, observed: Observed::Range { range: -1.0 } }]
            )
            .is_err()
    );
    assert_eq!(belief_of(&robot, 1.0).unwrap(), before);
    // A landmark that the map does not have, none at all, and one that cannot be so far away.
    let seen =
        |landmark, range| LandmarkObservation { landmark, observed: Observed::Range { range } };
    let outcomes = robot.observations(0.5, &[seen(99, 3.0), seen(1, 500.0)]).unwrap();
    assert!(!outcomes[0].accepted() && outcomes[0].nis.is_none());
    assert!(!outcomes[1].accepted() && outcomes[1].nis.unwrap() > 10.0);
    assert!(robot.observations(0.5, &[]).unwrap().is_empty());
    // An absurdly long silence ends, and says honestly that nothing is known.
    let lost = belief_of(&robot, 1e7).unwrap();
    assert!(lost.state(0).unwrap().1 > 1e6 && lost.state(THETA).unwrap().0.abs() <= 3.15);
}

#[test]
fn settings_that_are_none_are_refused() {
    let start = pose_belief(Pose2::IDENTITY, [0.5, 0.5, 0.1]);
    let refuse = |settings: FusionSettings, part: &str| {
        let error = FusedLocalizer::new(map(), settings, 0.0, start).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    };
    refuse(settings().compass_sigma(0.0), "compass");
    refuse(settings().speed_walk(f64::NAN), "speed");
    refuse(settings().range_bias(BiasPrior::FREE_SCALE), "range scale");
    refuse(settings().robot(settings().robot.gate_probability(0.0)), "gate");
    let mut wrong = start;
    wrong.covariance[(0, 0)] = -1.0;
    assert!(FusedLocalizer::new(map(), settings(), 0.0, wrong).is_err());
    assert!(FusedLocalizer::new(map(), settings(), f64::NAN, start).is_err());
}
