//! Smoothing against least squares over everything at once, and against the truth.

use approx::assert_relative_eq;
use loc_core::motion::VelocityNoise;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Gaussian, Normal, Pose2, Twist2, gaussian::pose_belief, stats};
use loc_filters::Localizer;
use loc_filters::RobotSettings;
use loc_filters::delayed::Sequential;
use loc_filters::extended::LinearizedMotion;
use loc_filters::kalman::{KalmanFilter, LinearMeasurement, LinearMotion};
use loc_filters::landmark::LandmarkLocalizer;
use loc_filters::localizer::Estimate;
use loc_filters::smoother::{Link, Recorded, Smoothable, Smoother};
use loc_filters::{Error, ExtendedKalmanFilter, Gate, NonlinearFilter, UnscentedKalmanFilter};
use loc_maps::{Landmark, LandmarkMap};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{
    DMatrix, DVector, Matrix1, Matrix1x2, Matrix1x3, Matrix2, Matrix3, SMatrix, Vector1, Vector2,
    Vector3,
};

fn draw(rng: &mut ChaCha8Rng) -> f64 {
    Normal::STANDARD.sample(rng)
}

/// A linear system: x' = F x + noise of covariance Q, z = H x + noise of variance R at some steps.
struct System {
    f: Matrix3<f64>,
    q: Matrix3<f64>,
    h: Matrix1x3<f64>,
    r: f64,
    start: Gaussian<3>,
    readings: Vec<Option<f64>>,
}

fn system(seed: u64, steps: usize) -> System {
    let mut rng = stream(seed, "system");
    let dt = 0.3;
    let f = Matrix3::new(1.0, dt, 0.5 * dt * dt, 0.0, 1.0, dt, 0.0, 0.0, 0.9);
    let root = Matrix3::from_fn(|_, _| 0.2 * draw(&mut rng));
    let q = root * root.transpose() + 0.01 * Matrix3::identity();
    let mean = Vector3::new(1.0, -0.5, 0.2);
    let start = Gaussian::new(mean, Matrix3::from_diagonal(&Vector3::new(2.0, 0.7, 0.3))).unwrap();
    let reading = |rng: &mut ChaCha8Rng, k: usize| (k % 3 != 1).then(|| 2.0 * draw(rng));
    let readings = (0..steps).map(|k| reading(&mut rng, k)).collect();
    System { f, q, h: Matrix1x3::new(1.0, 0.3, 0.0), r: 0.25, start, readings }
}

impl System {
    fn smoothed(&self) -> Vec<Gaussian<3>> {
        let motion = LinearMotion::new(self.f, Matrix3::zeros(), Matrix3::zeros(), self.q).unwrap();
        let sensor = LinearMeasurement::new(self.h, Matrix1::new(self.r)).unwrap();
        let mut filter = Recorded::new(KalmanFilter::new(self.start).unwrap());
        for reading in &self.readings {
            filter.predict(&motion, &Vector3::zeros()).unwrap();
            if let Some(z) = reading {
                filter.correct(&sensor, &Vector1::new(*z), &Gate::OPEN).unwrap();
            }
        }
        assert_eq!(filter.past().len(), self.readings.len() + 1);
        filter.past().smooth().unwrap()
    }

    /// All states at once, by the normal equations of weighted least squares: each prior, motion
    /// and reading is a row block of `A X = b` in units of its standard deviation.
    fn least_squares(&self) -> (DVector<f64>, DMatrix<f64>) {
        let n = 3 * (self.readings.len() + 1);
        let (mut information, mut vector) = (DMatrix::zeros(n, n), DVector::zeros(n));
        let mut add = |a: DMatrix<f64>, weight: DMatrix<f64>, b: DVector<f64>| {
            information += a.transpose() * &weight * &a;
            vector += a.transpose() * weight * b;
        };
        let dense = |m: &Matrix3<f64>| DMatrix::from_fn(3, 3, |i, j| m[(i, j)]);
        let inverse = |m: &Matrix3<f64>| dense(&m.try_inverse().unwrap());
        let mut prior = DMatrix::zeros(3, n);
        prior.view_mut((0, 0), (3, 3)).fill_with_identity();
        let mean = DVector::from_row_slice(self.start.mean.as_slice());
        add(prior, inverse(&self.start.covariance), mean);
        for (k, reading) in self.readings.iter().enumerate() {
            let mut motion = DMatrix::zeros(3, n);
            motion.view_mut((0, 3 * k), (3, 3)).copy_from(&-dense(&self.f));
            motion.view_mut((0, 3 * k + 3), (3, 3)).fill_with_identity();
            add(motion, inverse(&self.q), DVector::zeros(3));
            if let Some(z) = reading {
                let mut row = DMatrix::zeros(1, n);
                for j in 0..3 {
                    row[(0, 3 * k + 3 + j)] = self.h[j];
                }
                add(row, DMatrix::from_element(1, 1, 1.0 / self.r), DVector::from_element(1, *z));
            }
        }
        let covariance = information.cholesky().unwrap().inverse();
        (&covariance * vector, covariance)
    }
}

/// The smoothed beliefs of a linear system are those of least squares over all at once, means and
/// covariances.
#[test]
fn smoothing_is_least_squares_over_everything() {
    for seed in 0..5 {
        let system = system(seed, 40);
        let (states, covariance) = system.least_squares();
        for (k, smoothed) in system.smoothed().iter().enumerate() {
            let mean = Vector3::from_fn(|i, _| states[3 * k + i]);
            assert_relative_eq!(smoothed.mean, mean, epsilon = 1e-9);
            let block = Matrix3::from_fn(|i, j| covariance[(3 * k + i, 3 * k + j)]);
            assert_relative_eq!(smoothed.covariance, block, epsilon = 1e-9);
        }
    }
}

/// A motion without noise carries what is learnt at the end to the start, all of it: a robot on a
/// rail whose speed never changes.
#[test]
fn without_noise_every_moment_knows_the_same() {
    let motion = LinearMotion::new(
        Matrix2::new(1.0, 0.5, 0.0, 1.0),
        Matrix2::zeros(),
        Matrix2::zeros(),
        Matrix2::zeros(),
    )
    .unwrap();
    let sensor = LinearMeasurement::new(Matrix1x2::new(1.0, 0.0), Matrix1::new(0.04)).unwrap();
    let start = Gaussian::new(Vector2::zeros(), Matrix2::identity() * 4.0).unwrap();
    let mut filter = Recorded::new(KalmanFilter::new(start).unwrap());
    for k in 1..=30 {
        filter.predict(&motion, &Vector2::zeros()).unwrap();
        let z = 1.0 + 0.7 * 0.5 * f64::from(k) + 0.1 * f64::from(k % 3 - 1);
        filter.correct(&sensor, &Vector1::new(z), &Gate::OPEN).unwrap();
    }
    let smoothed = filter.past().smooth().unwrap();
    let last = smoothed.last().unwrap();
    assert_eq!(last, filter.belief());
    for (k, belief) in smoothed.iter().enumerate() {
        let ago = 0.5 * (30 - k) as f64;
        assert_relative_eq!(belief.mean.x, last.mean.x - ago * last.mean.y, epsilon = 1e-8);
        assert_relative_eq!(belief.mean.y, last.mean.y, epsilon = 1e-8);
        let back = Matrix2::new(1.0, -ago, 0.0, 1.0);
        let carried = back * last.covariance * back.transpose();
        assert_relative_eq!(belief.covariance, carried, epsilon = 1e-8);
    }
}

/// What is certain has no inverse covariance, and stays certain.
#[test]
fn certain_states_are_no_trouble() {
    let motion = |noise: f64| LinearizedMotion {
        state: Vector2::zeros(),
        jacobian: Matrix2::identity(),
        noise: Matrix2::from_diagonal(&Vector2::new(noise, 0.0)),
    };
    // The second state is certain, the first is learnt about at the end.
    let start = Gaussian::new(Vector2::new(0.0, 3.0), Matrix2::new(1.0, 0.0, 0.0, 0.0)).unwrap();
    let mut past = Smoother::new(start).unwrap();
    let predicted = Gaussian::new(start.mean, Matrix2::new(2.0, 0.0, 0.0, 0.0)).unwrap();
    past.predicted(&motion(1.0), &predicted);
    let known = Gaussian::new(Vector2::new(1.0, 3.0), Matrix2::new(0.5, 0.0, 0.0, 0.0)).unwrap();
    past.corrected(&known);
    let smoothed = past.smooth().unwrap();
    // By hand: C = 1/2; mean 0 + 1/2 (1 - 0), variance 1 + 1/4 (0.5 - 2).
    assert_relative_eq!(smoothed[0].mean, Vector2::new(0.5, 3.0), epsilon = 1e-12);
    assert_relative_eq!(
        smoothed[0].covariance,
        Matrix2::new(0.625, 0.0, 0.0, 0.0),
        epsilon = 1e-12
    );
    // Two states that are one and the same: the covariance is singular in a slanted direction.
    let ones = Matrix2::new(1.0, 1.0, 1.0, 1.0);
    let start = Gaussian::new(Vector2::zeros(), ones).unwrap();
    let mut past = Smoother::new(start).unwrap();
    past.predicted(&motion(0.0), &start);
    past.corrected(&Gaussian::new(Vector2::new(0.8, 0.8), ones * 0.2).unwrap());
    let smoothed = past.smooth().unwrap();
    assert_relative_eq!(smoothed[0].mean, Vector2::new(0.8, 0.8), epsilon = 1e-9);
    assert_relative_eq!(smoothed[0].covariance, ones * 0.2, epsilon = 1e-9);
    // Nothing is uncertain at all.
    let sure = Gaussian::certain(Vector2::new(1.0, 2.0));
    let mut past = Smoother::new(sure).unwrap();
    past.predicted(&motion(0.0), &sure);
    assert_eq!(past.smooth().unwrap(), [sure, sure]);
}

/// Sigma points lead to the same as a tangent, where nothing bends.
#[test]
fn points_do_as_well_as_a_tangent() {
    let system = system(7, 20);
    let expected = system.smoothed();
    let motion = LinearMotion::new(system.f, Matrix3::zeros(), Matrix3::zeros(), system.q).unwrap();
    let sensor = LinearMeasurement::new(system.h, Matrix1::new(system.r)).unwrap();
    let mut filter = KalmanFilter::new(system.start).unwrap();
    let mut past = Smoother::new(system.start).unwrap();
    for reading in &system.readings {
        let root = filter.belief().covariance.cholesky().unwrap().l();
        filter.predict(&motion, &Vector3::zeros()).unwrap();
        let link = Link::Points { root, slopes: system.f * root, noise: system.q };
        past.linked(link, filter.belief());
        if let Some(z) = reading {
            filter.correct(&sensor, &Vector1::new(*z), &Gate::OPEN).unwrap();
            past.corrected(filter.belief());
        }
    }
    for (ours, expected) in past.smooth().unwrap().iter().zip(&expected) {
        assert_relative_eq!(ours.mean, expected.mean, epsilon = 1e-9);
        assert_relative_eq!(ours.covariance, expected.covariance, epsilon = 1e-9);
    }
}

/// A copy of a recorded filter goes its own way, and marks ask for what both of them were like.
#[test]
fn copies_of_a_recorded_filter_keep_their_own_past() {
    let drive = |x: f64| {
        let mean = Vector1::new(x);
        LinearizedMotion { state: mean, jacobian: Matrix1::identity(), noise: Matrix1::new(1.0) }
    };
    let belief = |x: f64, variance: f64| Gaussian {
        mean: Vector1::new(x),
        covariance: Matrix1::new(variance),
    };
    let mut one = Smoother::new(belief(0.0, 1.0)).unwrap();
    one.mark();
    one.predicted(&drive(0.0), &belief(0.0, 2.0));
    let mut other = one.clone();
    one.corrected(&belief(1.0, 0.5));
    other.corrected(&belief(-1.0, 0.5));
    other.mark();
    other.mark();
    // By hand: C = 1/2.
    assert_relative_eq!(one.smooth_marked().unwrap()[0].mean.x, 0.5);
    let of_other: Vec<f64> = other.smooth_marked().unwrap().iter().map(|b| b.mean.x).collect();
    assert_relative_eq!(of_other.as_slice(), [-0.5, -1.0, -1.0].as_slice(), epsilon = 1e-12);
    let filtered: Vec<f64> = other.filtered_marked().iter().map(|belief| belief.mean.x).collect();
    assert_eq!(filtered, [0.0, -1.0, -1.0]);
}

/// Differences of angles are wrapped, and so is what comes out.
#[test]
fn angles_are_wrapped() {
    let turn = LinearizedMotion {
        state: Vector1::new(0.0),
        jacobian: Matrix1::identity(),
        noise: Matrix1::new(1.0),
    };
    let belief = |angle: f64, variance: f64| {
        Gaussian::new(Vector1::new(angle), Matrix1::new(variance)).unwrap()
    };
    let mut past = Smoother::new(belief(3.1, 1.0)).unwrap().with_angles(&[0]);
    past.predicted(&turn, &belief(3.1, 2.0));
    past.corrected(&belief(-3.1, 0.1));
    // The correction turned on by 2 pi - 6.2, not back by 6.2; half of it counts before.
    let ahead = std::f64::consts::TAU - 6.2;
    let smoothed = past.smooth().unwrap();
    let expected = loc_core::angle::wrap(3.1 + 0.5 * ahead);
    assert_relative_eq!(smoothed[0].mean.x, expected, epsilon = 1e-12);
}

#[test]
fn beliefs_that_are_none_are_refused() {
    assert!(Smoother::new(Gaussian::<1>::certain(Vector1::new(f64::NAN))).is_err());
    let motion = LinearizedMotion {
        state: Vector1::new(0.0),
        jacobian: Matrix1::identity(),
        noise: Matrix1::identity(),
    };
    let nan = Gaussian { mean: Vector1::new(0.0), covariance: SMatrix::from_element(f64::NAN) };
    let mut past = Smoother::new(Gaussian::certain(Vector1::new(0.0))).unwrap();
    past.predicted(&motion, &nan);
    let error = past.smooth().unwrap_err();
    assert!(
        matches!(&error, Error::NotFinite { found, .. } if found.contains("at step 1")),
        "{error}"
    );
    let one = Smoother::new(Gaussian::certain(Vector1::new(2.0))).unwrap();
    assert!(one.is_empty() && one.smooth().unwrap().len() == 1);
}

/// One drive among four landmarks with noisy wheels: root mean square error of filter and smoother,
/// and the mean NEES of both.
struct Drive {
    filter: f64,
    smoother: f64,
    filter_nees: Vec<f64>,
    smoother_nees: Vec<f64>,
}

fn drive<F: NonlinearFilter<3>>(seed: u64) -> Drive {
    let motion_noise = VelocityNoise::from_sigmas(0.05, 0.1, 0.05).unwrap();
    let settings = RobotSettings::default().odometry(motion_noise);
    let map = LandmarkMap::new([
        Landmark::planar(1, 4.0, 0.5),
        Landmark::planar(2, 3.0, 4.0),
        Landmark::planar(3, -2.0, 3.0),
        Landmark::planar(4, 0.0, -3.0),
    ])
    .unwrap();
    let mut rng = stream(seed, "drive");
    let start = pose_belief(Pose2::IDENTITY, [0.1, 0.1, 0.05]);
    let mut truth = Pose2::from_vector(&start.sample(&mut rng));
    let mut smoother =
        LandmarkLocalizer::<Recorded<F, 3>>::with_filter(map.clone(), settings, 0.0, start)
            .unwrap();
    let mut online =
        LandmarkLocalizer::<F>::with_filter(map.clone(), settings, 0.0, start).unwrap();
    let (dt, mut filtered, mut truths) = (0.1, Vec::new(), Vec::new());
    for k in 0..200 {
        let stamp = dt * f64::from(k);
        let twist = Twist2::forward(0.5, 0.3);
        // The filter is given the command; the robot executes it with the noise that the filter expects.
        let noise = Gaussian {
            mean: twist.to_vector(),
            covariance: settings.odometry.covariance(twist, dt),
        };
        smoother.velocity(stamp, twist).unwrap();
        online.velocity(stamp, twist).unwrap();
        let real = noise.sample(&mut rng);
        truth = settings.integration.step(truth, Twist2::new(real.x, real.y, real.z), dt);
        let after = dt * f64::from(k + 1);
        if k % 10 == 9 {
            let seen: Vec<_> = map
                .iter()
                .map(|landmark| {
                    let place = truth.inverse().transform(&landmark.position.xy());
                    let range = place.coords.norm();
                    let noise = settings.camera;
                    let observed = Observed::RangeBearing {
                        range: range + noise.range_sigma_at(range) * draw(&mut rng),
                        bearing: place.y.atan2(place.x) + noise.bearing_sigma * draw(&mut rng),
                    };
                    LandmarkObservation { landmark: landmark.id, observed }
                })
                .collect();
            let outcomes = smoother.observations(after, &seen).unwrap();
            for (ours, theirs) in outcomes.iter().zip(online.observations(after, &seen).unwrap()) {
                assert_eq!(ours.accepted(), theirs.accepted());
                assert_relative_eq!(ours.nis.unwrap(), theirs.nis.unwrap(), epsilon = 1e-9);
            }
        }
        smoother.mark(after).unwrap();
        filtered.push(online.estimate(after).unwrap().belief());
        truths.push(truth);
    }
    for (ours, theirs) in smoother.filtered().iter().zip(&filtered) {
        assert_relative_eq!(ours.pose.to_vector(), theirs.mean, epsilon = 1e-9);
    }
    let smoothed: Vec<Gaussian<3>> =
        smoother.smoothed().unwrap().iter().map(Estimate::belief).collect();
    assert_relative_eq!(smoothed[199].mean, filtered[199].mean, epsilon = 1e-12);
    let rmse = |beliefs: &[Gaussian<3>]| {
        let errors: Vec<f64> =
            beliefs.iter().zip(&truths).map(|(b, t)| b.pose().distance(*t)).collect();
        stats::rms(&errors).unwrap()
    };
    let nees = |beliefs: &[Gaussian<3>]| -> Vec<f64> {
        let pairs = beliefs.iter().zip(&truths);
        pairs.map(|(b, t)| stats::nees(&b.pose_deviation(*t), &b.covariance).unwrap()).collect()
    };
    for belief in &smoothed {
        assert_eq!(belief.covariance, belief.covariance.transpose(), "exactly symmetric");
        assert!(belief.covariance.symmetric_eigenvalues().min() > 0.0);
    }
    for (smoothed, filtered) in smoothed.iter().zip(&filtered) {
        assert!(smoothed.covariance.trace() <= filtered.covariance.trace() + 1e-12);
    }
    Drive {
        filter: rmse(&filtered),
        smoother: rmse(&smoothed),
        filter_nees: nees(&filtered),
        smoother_nees: nees(&smoothed),
    }
}

/// Over many drives the smoother errs less than the filter, and knows how much.
#[test]
fn smoothed_drives_err_less_and_stay_honest() {
    judge(&(1..=60).map(drive::<ExtendedKalmanFilter<3>>).collect::<Vec<_>>());
}

#[test]
fn so_they_do_with_sigma_points() {
    judge(&(1..=60).map(drive::<UnscentedKalmanFilter<3>>).collect::<Vec<_>>());
}

fn judge(drives: &[Drive]) {
    let better = drives.iter().filter(|drive| drive.smoother < drive.filter).count();
    let mean = |of: fn(&Drive) -> f64| drives.iter().map(of).sum::<f64>() / 60.0;
    let (filter, smoother) = (mean(|d| d.filter), mean(|d| d.smoother));
    println!(
        "RMSE of the filter {filter:.4} m, smoothed {smoother:.4} m, better in {better} of 60"
    );
    assert!(better >= 57 && smoother < 0.8 * filter);
    let share = |of: fn(&Drive) -> &Vec<f64>| {
        let mut ensemble = stats::consistency::NeesEnsemble::new(0.95).unwrap();
        for drive in drives {
            ensemble.push_run(of(drive).iter().map(|nees| Some((3, *nees)))).unwrap();
        }
        (ensemble.share_in_band().unwrap(), ensemble.mean_per_degree().unwrap())
    };
    let (filter, smoother) = (share(|d| &d.filter_nees), share(|d| &d.smoother_nees));
    println!(
        "share of steps in band and NEES per degree: filter {filter:?}, smoothed {smoother:?}"
    );
    assert!(filter.0 > 0.75 && smoother.0 > 0.75);
    assert!((smoother.1 - 1.0).abs() < 0.12);
}

#[test]
fn inputs_out_of_order_are_refused() {
    let map = LandmarkMap::new([Landmark::planar(1, 4.0, 0.0)]).unwrap();
    let start = pose_belief(Pose2::IDENTITY, [0.1, 0.1, 0.1]);
    let mut drive = LandmarkLocalizer::<Recorded<ExtendedKalmanFilter<3>, 3>>::with_filter(
        map,
        RobotSettings::default(),
        5.0,
        start,
    )
    .unwrap();
    // What comes from before the start belongs to the start.
    drive.velocity(4.9, Twist2::forward(1.0, 0.0)).unwrap();
    drive.mark(5.0).unwrap();
    drive.mark(6.0).unwrap();
    assert!(matches!(drive.velocity(5.5, Twist2::ZERO), Err(Error::TooLate { .. })));
    assert!(
        drive.mark(f64::NAN).is_err()
            && drive.velocity(7.0, Twist2::forward(f64::NAN, 0.0)).is_err()
    );
    let bad = LandmarkObservation { landmark: 1, observed: Observed::Range { range: -1.0 } };
    assert!(drive.observations(6.5, &[bad]).is_err());
    let smoothed = drive.smoothed().unwrap();
    assert_eq!(smoothed.len(), 2);
    assert_relative_eq!(smoothed[1].pose.x, 1.0, epsilon = 1e-12);
}
