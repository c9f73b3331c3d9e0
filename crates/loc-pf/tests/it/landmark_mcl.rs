//! Monte Carlo localization with landmarks.

use loc_core::motion::{Integration, VelocityNoise};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Gaussian, Pose2, Twist2, angle, gaussian::pose_belief};
use loc_filters::Localizer;
use loc_filters::RobotSettings;
use loc_filters::delayed::Delayed;
use loc_maps::{Landmark, LandmarkMap};
use loc_pf::landmark_mcl::RecoverySettings;
use loc_pf::{LandmarkMcl, LandmarkMclSettings};
use loc_sensors::landmark_camera::{LandmarkCamera, LandmarkNoise, LandmarkObservation, Observed};
use nalgebra::Matrix3;
use rand_distr::{Distribution, StandardNormal};

const DT: f64 = 0.1;

fn map() -> LandmarkMap {
    let places = [
        (1, 4.5, -1.0),
        (2, 5.5, 4.0),
        (3, 1.0, 5.5),
        (4, -3.0, 2.0),
        (5, -1.0, -2.0),
        (6, 2.0, 1.5),
    ];
    LandmarkMap::new(places.map(|(id, x, y)| Landmark::planar(id, x, y))).unwrap()
}

fn noise() -> VelocityNoise {
    VelocityNoise::from_sigmas(0.03, 0.1, 0.05).unwrap()
}

fn camera() -> LandmarkCamera {
    LandmarkCamera {
        fov: 2.5,
        max_range: 5.0,
        noise: LandmarkNoise { range_sigma: 0.1, range_sigma_per_m: 0.0, bearing_sigma: 0.04 },
        ..LandmarkCamera::default()
    }
}

fn settings() -> LandmarkMclSettings {
    let robot = RobotSettings::default().odometry(noise()).camera(camera().noise);
    LandmarkMclSettings::default().robot(robot).particles(1000)
}

/// A robot that drives a loop among the landmarks.
struct Drive {
    pose: Pose2,
    step: usize,
    camera: LandmarkCamera,
    odometry: ChaCha8Rng,
    eyes: ChaCha8Rng,
}

/// What is known after a step: the velocity at its start, and what was seen at its end.
#[derive(Clone)]
struct Step {
    start: f64,
    end: f64,
    reading: Twist2,
    seen: Vec<LandmarkObservation>,
    truth: Pose2,
}

impl Drive {
    fn new(seed: u64) -> Self {
        let (odometry, eyes) = (stream(seed, "odometry"), stream(seed, "camera"));
        Drive { pose: Pose2::IDENTITY, step: 0, camera: camera(), odometry, eyes }
    }

    fn step(&mut self) -> Step {
        let turn = if (self.step / 80).is_multiple_of(2) { 0.3 } else { 0.0 };
        let twist = Twist2::forward(0.5, turn);
        let variances = noise().variances(twist, DT);
        let mut blur = |variance: f64| -> f64 {
            let unit: f64 = StandardNormal.sample(&mut self.odometry);
            variance.sqrt() * unit
        };
        let reading = Twist2::forward(twist.vx + blur(variances.x), turn + blur(variances.z));
        self.pose = Integration::ExactArc.step(self.pose, twist, DT);
        let start = self.step as f64 * DT;
        self.step += 1;
        let looks = self.step.is_multiple_of(5);
        let seen =
            if looks { self.camera.observe(&map(), self.pose, &mut self.eyes) } else { vec![] };
        Step { start, end: start + DT, reading, seen, truth: self.pose }
    }

    fn steps(seed: u64, count: usize) -> Vec<Step> {
        let mut drive = Drive::new(seed);
        (0..count).map(|_| drive.step()).collect()
    }
}

fn start() -> Gaussian<3> {
    pose_belief(Pose2::IDENTITY, [0.1, 0.1, 0.05])
}

fn mcl(settings: LandmarkMclSettings, seed: u64) -> LandmarkMcl {
    let mut belief = start();
    belief.mean = belief.sample(&mut stream(seed, "start"));
    LandmarkMcl::new(map(), settings, 0.0, &belief, stream(seed, "mcl")).unwrap()
}

fn feed(mcl: &mut impl Localizer, step: &Step) {
    mcl.velocity(step.start, step.reading).unwrap();
    if !step.seen.is_empty() {
        mcl.observations(step.end, &step.seen).unwrap();
    }
}

/// Errors of the position [m] and normalised errors squared, after each step.
fn judged(mcl: &mut LandmarkMcl, steps: &[Step]) -> Vec<(f64, f64)> {
    let judge = |step: &Step| {
        feed(mcl, step);
        let belief = mcl.belief_at(step.end).unwrap();
        let nees = belief.deviation_squared(&belief.pose_deviation(step.truth)).unwrap();
        (belief.pose().distance(step.truth), nees)
    };
    steps.iter().map(judge).collect()
}

fn mean(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().sum::<f64>() / values.count() as f64
}

/// Over 50 drives the covariance promises what the estimate keeps: 3 on average.
#[test]
fn covariances_are_honest() {
    let mut drives = Vec::new();
    for seed in 0..50 {
        let judged = judged(&mut mcl(settings(), seed), &Drive::steps(seed, 300));
        drives.push((mean(judged.iter().map(|e| e.0)), mean(judged.iter().map(|e| e.1))));
    }
    let nees = mean(drives.iter().map(|drive| drive.1));
    let error = mean(drives.iter().map(|drive| drive.0));
    println!("mean NEES {nees:.2}, mean error {error:.3} m");
    assert!((2.0..=5.0).contains(&nees), "{nees}");
    assert!(error < 0.11, "{error}");
}

/// A robot that stands still sees the same landmarks again and again; the cloud must not shrink to
/// copies of one particle that is wrong.
#[test]
fn standing_still_stays_honest() {
    let mut worst = Vec::new();
    for seed in 0..20 {
        let settings = settings().particles(2000);
        let mut filter = mcl(settings, seed);
        let mut eyes = stream(seed, "eyes");
        for k in 1..=100 {
            let seen = camera().observe(&map(), Pose2::IDENTITY, &mut eyes);
            filter.observations(f64::from(k), &seen).unwrap();
        }
        let belief = filter.belief_at(100.0).unwrap();
        let deviation = belief.pose_deviation(Pose2::IDENTITY);
        worst.push(belief.deviation_squared(&deviation).unwrap());
    }
    let nees = mean(worst.iter().copied());
    println!("standing still: mean NEES {nees:.2}");
    assert!((1.0..=6.0).contains(&nees), "{nees} of {worst:?}");
}

#[test]
fn found_from_anywhere() {
    let mut found = 0;
    for seed in 0..20 {
        let steps = Drive::steps(seed, 150);
        let rng = stream(seed, "mcl");
        let mut filter = LandmarkMcl::anywhere(map(), settings(), 0.0, rng).unwrap();
        let judged = judged(&mut filter, &steps);
        found += usize::from(judged[100..].iter().all(|(error, _)| *error < 0.5));
    }
    assert!(found >= 19, "{found} of 20");
}

/// Carried 5 m away and turned round at half time.
#[test]
fn kidnapped_and_recovered() {
    let mut recovered = 0;
    for seed in 0..20 {
        let mut drive = Drive::new(seed);
        let mut filter = mcl(settings(), seed);
        (0..150).for_each(|_| feed(&mut filter, &drive.step()));
        drive.pose = Pose2::new(1.5, 0.0, 0.0);
        let steps: Vec<Step> = (0..200).map(|_| drive.step()).collect();
        let judged = judged(&mut filter, &steps);
        recovered += usize::from(judged[150..].iter().all(|(error, _)| *error < 0.5));
    }
    assert!(recovered >= 18, "{recovered} of 20");
}

/// One observation in twenty bears the number of another landmark. A model with outliers loses
/// little; one without is misled.
#[test]
fn misread_numbers_do_not_mislead() {
    let error = |misread: f64, outlier_share: f64| {
        let errors = (0..12).map(|seed| {
            let mut drive = Drive::new(seed);
            drive.camera.wrong_identity_probability = misread;
            let steps: Vec<Step> = (0..300).map(|_| drive.step()).collect();
            let sights = settings().outlier_share(outlier_share);
            let mut filter = mcl(sights, seed);
            mean(judged(&mut filter, &steps).iter().map(|e| e.0))
        });
        mean(errors.collect::<Vec<_>>().into_iter())
    };
    let (clean, robust, credulous) = (error(0.0, 0.05), error(0.05, 0.05), error(0.05, 0.0));
    println!("clean {clean:.3} m, robust {robust:.3} m, credulous {credulous:.3} m");
    assert!(robust < 1.25 * clean && credulous > 1.2 * robust);
}

/// Velocities and observations in any order of arrival within the horizon: equal to the bit.
#[test]
fn late_inputs_change_nothing() {
    let steps = Drive::steps(4, 200);
    // The stamps of the end of a step and of the start of the next one differ by rounding.
    let mut punctual = Delayed::new(mcl(settings(), 4), 2.0).unwrap();
    steps.iter().for_each(|step| feed(&mut punctual, step));
    let mut late = Delayed::new(mcl(settings(), 4), 2.0).unwrap();
    // LandmarkObservations come 0.7 s late, and every seventh velocity 0.4 s.
    for k in 0..steps.len() + 10 {
        if let Some(step) = steps.get(k).filter(|_| !k.is_multiple_of(7)) {
            late.velocity(step.start, step.reading).unwrap();
        }
        let overdue = k.checked_sub(4).filter(|k| k.is_multiple_of(7));
        if let Some(step) = overdue.and_then(|k| steps.get(k)) {
            late.velocity(step.start, step.reading).unwrap();
        }
        let seen = k.checked_sub(7).and_then(|k| steps.get(k));
        if let Some(step) = seen.filter(|step| !step.seen.is_empty()) {
            late.observations(step.end, &step.seen).unwrap();
        }
    }
    assert_eq!(late.newest().particles(), punctual.newest().particles());
    for stamp in [20.0, 22.0] {
        assert_eq!(late.estimate(stamp).unwrap(), punctual.estimate(stamp).unwrap());
    }
}

/// A long way without any observation: the cloud moves on, memory does not grow, and the spread is
/// that of dead reckoning.
#[test]
fn blind_drives_follow_the_odometry() {
    let straight = Twist2::forward(0.4, 0.0);
    let settings = settings().particles(20000);
    let mut filter = LandmarkMcl::new(map(), settings, 0.0, &start(), stream(1, "mcl")).unwrap();
    for k in 0..100 {
        filter.velocity(0.1 * f64::from(k), straight).unwrap();
    }
    let before = filter.belief_at(10.0).unwrap();
    let observed = Observed::Range { range: 4.0 };
    // An observation of a landmark that the map has not moves the cloud and says nothing.
    let update = filter.update(10.0, &[LandmarkObservation { landmark: 99, observed }]).unwrap();
    assert_eq!((update.trust[0].probability, update.resampled), (0.0, false));
    let cloud = loc_pf::estimate::moments(filter.particles());
    for i in 0..3 {
        let (a, b) = (cloud.covariance[(i, i)].sqrt(), before.covariance[(i, i)].sqrt());
        assert!((a / b - 1.0).abs() < 0.06, "{i}: {a} {b}");
        assert!((cloud.mean[i] - before.mean[i]).abs() < 0.2 * b, "{i}");
    }
    assert_eq!(filter.belief_at(10.0).unwrap(), before);
}

#[test]
fn one_seed_one_result_for_any_number_of_threads() {
    let steps = Drive::steps(2, 60);
    let run = |threads, seed| {
        let settings = settings().threads(threads).particles(1500);
        let mut filter = mcl(settings, seed);
        steps.iter().for_each(|step| feed(&mut filter, step));
        filter.particles().clone()
    };
    assert_eq!(run(1, 3), run(2, 3));
    assert_ne!(run(1, 3), run(1, 4));
}

/// LandmarkObservations that contradict everything, far jumps of time, and a start that is certain.
#[test]
fn nothing_gives_nan() {
    let certain = Gaussian { mean: start().mean, covariance: Matrix3::zeros() };
    let mut filter = LandmarkMcl::new(map(), settings(), 0.0, &certain, stream(1, "mcl")).unwrap();
    let all = |range: f64| -> Vec<LandmarkObservation> {
        let see = |landmark| LandmarkObservation {
            landmark,
            observed: Observed::RangeBearing { range, bearing: 1.0 },
        };
        (1..7).map(see).collect()
    };
    for (stamp, range) in [(1.0, 1e6), (2.0, 0.0), (2.0, 3.0), (1e9, 1e-300), (1e9 + 1.0, 2.0)] {
        filter.velocity(stamp, Twist2::forward(1e3, 50.0)).unwrap();
        filter.observations(stamp, &all(range)).unwrap();
        let belief = filter.belief_at(stamp + 1.0).unwrap();
        assert!(belief.mean.iter().chain(belief.covariance.iter()).all(|v| v.is_finite()));
        let poses = filter.particles().poses();
        assert!(poses.iter().all(|p| p.to_vector().iter().all(|v| v.is_finite())));
        assert!(poses.iter().all(|p| angle::wrap(p.theta) == p.theta));
    }
}

#[test]
fn bad_input_is_refused_and_changes_nothing() {
    let mut filter = mcl(settings(), 1);
    Drive::steps(1, 60).iter().for_each(|step| feed(&mut filter, step));
    let before = (filter.particles().clone(), filter.belief_at(6.0).unwrap());
    let fine = Twist2::forward(1.0, 0.0);
    let nan = Observed::Range { range: f64::NAN };
    assert!(matches!(filter.velocity(3.0, fine), Err(loc_filters::Error::TooLate { .. })));
    let late = filter.observations(3.0, &[]);
    assert!(matches!(late, Err(loc_filters::Error::TooLate { .. })));
    for error in [
        filter.velocity(f64::NAN, fine).unwrap_err(),
        filter.velocity(6.0, Twist2::forward(f64::INFINITY, 0.0)).unwrap_err(),
        filter
            .observations(6.0, &[LandmarkObservation { landmark: 1, observed: nan }])
            .unwrap_err(),
        filter.estimate(f64::NAN).unwrap_err(),
    ] {
        let core = matches!(error, loc_filters::Error::Core(loc_core::Error::OutOfRange { .. }));
        assert!(core, "{error}");
    }
    assert_eq!((filter.particles().clone(), filter.belief_at(6.0).unwrap()), before);

    let refusal = |settings: LandmarkMclSettings, map: LandmarkMap| {
        LandmarkMcl::anywhere(map, settings, 0.0, stream(1, "mcl")).unwrap_err().to_string()
    };
    let none = LandmarkMap::default();
    assert_eq!(
        refusal(settings(), none),
        "landmarks of the map: expected at least 1, got 0 elements"
    );
    let empty = settings().particles(0);
    assert_eq!(
        refusal(empty, map()),
        "LandmarkMclSettings.particles: expected a number >= 1, got 0"
    );
    let recovery = RecoverySettings::default().factor(0.5);
    let half = settings().recovery(recovery);
    assert_eq!(refusal(half, map()), "RecoverySettings.factor: expected a number >= 1.0, got 0.5");
}

/// A million velocities and observations neither wear out the weights nor fill the memory.
#[test]
#[ignore = "a few seconds"]
fn a_million_inputs() {
    let settings = settings().particles(100);
    let mut filter = mcl(settings, 1);
    let mut eyes = stream(1, "eyes");
    for k in 1..1_000_000 {
        let stamp = 0.01 * f64::from(k);
        let twist = Twist2::forward(0.2 * (stamp * 0.5).sin(), 0.0);
        filter.velocity(stamp, twist).unwrap();
        if k % 10 == 0 {
            let x = 0.4 * (1.0 - (stamp * 0.5).cos());
            let seen = camera().observe(&map(), Pose2::new(x, 0.0, 0.0), &mut eyes);
            filter.observations(stamp, &seen).unwrap();
        }
    }
    let total: f64 = filter.particles().weights().sum();
    assert!((total - 1.0).abs() < 1e-9 && filter.belief_at(1e4).unwrap().mean.y.abs() < 0.2);
}
