//! EKF-SLAM against the formulas of the textbook on full matrices.

use approx::assert_relative_eq;
use loc_core::random::stream;
use loc_core::{Gaussian, Pose2, Twist2, angle};
use loc_filters::RobotSettings;
use loc_filters::localizer::Decision;
use loc_filters::slam::{EkfSlam, Jacobians, SlamSettings};
use loc_sensors::landmark_camera::{LandmarkObservation, Observed};
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use rand::RngExt;

/// All in full: x = (robot, landmarks), P, one observation after the other into one tall H.
struct Textbook {
    x: DVector<f64>,
    p: DMatrix<f64>,
    known: Vec<u32>,
    settings: SlamSettings,
}

impl Textbook {
    fn new(start: &Gaussian<3>, settings: SlamSettings) -> Self {
        Textbook {
            x: DVector::from_column_slice(start.mean.as_slice()),
            p: DMatrix::from_column_slice(3, 3, start.covariance.as_slice()),
            known: Vec::new(),
            settings,
        }
    }

    fn predict(&mut self, twist: Twist2, dt: f64) {
        let pose = Pose2::new(self.x[0], self.x[1], self.x[2]);
        let (moved, j) = self.settings.robot.integration.step_with_jacobians(pose, twist, dt);
        let mut g = DMatrix::identity(self.x.len(), self.x.len());
        g.fixed_view_mut::<3, 3>(0, 0).copy_from(&j.by_pose);
        self.p = &g * &self.p * g.transpose();
        let noise = j.by_twist
            * self.settings.robot.odometry.covariance(twist, dt)
            * j.by_twist.transpose();
        let robot = self.p.fixed_view::<3, 3>(0, 0) + noise;
        self.p.fixed_view_mut::<3, 3>(0, 0).copy_from(&robot);
        self.x.fixed_rows_mut::<3>(0).copy_from(&moved.to_vector());
    }

    fn noise(&self, range: f64) -> Matrix2<f64> {
        let noise = self.settings.robot.camera;
        let sigmas = Vector2::new(noise.range_sigma_at(range), noise.bearing_sigma);
        Matrix2::from_diagonal(&sigmas.component_mul(&sigmas))
    }

    fn correct(&mut self, observations: &[LandmarkObservation]) {
        let size = self.x.len();
        let (mut h, mut r): (Vec<DVector<f64>>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut variances = Vec::new();
        for observation in observations {
            let Some(k) = self.known.iter().position(|id| *id == observation.landmark) else {
                continue;
            };
            let (lx, ly) = (3 + 2 * k, 4 + 2 * k);
            let (dx, dy) = (self.x[lx] - self.x[0], self.x[ly] - self.x[1]);
            let (q, range) = (dx * dx + dy * dy, dx.hypot(dy));
            let noise = self.noise(range);
            let mut row = |entries: [(usize, f64); 5], residual: f64, variance: f64| {
                let mut full = DVector::zeros(size);
                entries.iter().for_each(|&(at, value)| full[at] = value);
                h.push(full);
                r.push(residual);
                variances.push(variance);
            };
            if let Some(seen) = observation.observed.range() {
                let [a, b] = [dx / range, dy / range];
                row([(0, -a), (1, -b), (2, 0.0), (lx, a), (ly, b)], seen - range, noise.m11);
            }
            if let Some(seen) = observation.observed.bearing() {
                let residual = angle::wrap(seen - (dy.atan2(dx) - self.x[2]));
                let [a, b] = [dy / q, dx / q];
                row([(0, a), (1, -b), (2, -1.0), (lx, -a), (ly, b)], residual, noise.m22);
            }
        }
        if !h.is_empty() {
            let h = DMatrix::from_columns(&h).transpose();
            let q = DMatrix::from_diagonal(&DVector::from_vec(variances));
            let s = &h * &self.p * h.transpose() + q;
            let k = &self.p * h.transpose() * s.try_inverse().unwrap();
            self.x += &k * DVector::from_vec(r);
            self.p = (DMatrix::identity(size, size) - &k * h) * &self.p;
        }
        for observation in observations {
            if !self.known.contains(&observation.landmark) {
                self.append(observation);
            }
        }
    }

    fn append(&mut self, observation: &LandmarkObservation) {
        let Observed::RangeBearing { range, bearing } = observation.observed else { return };
        let (sin, cos) = (self.x[2] + bearing).sin_cos();
        let (dx, dy) = (range * cos, range * sin);
        let size = self.x.len();
        let mut g = DMatrix::zeros(2, size);
        g[(0, 0)] = 1.0;
        g[(1, 1)] = 1.0;
        (g[(0, 2)], g[(1, 2)]) = (-dy, dx);
        let polar = Matrix2::new(cos, -dy, sin, dx);
        let own = &g * &self.p * g.transpose() + polar * self.noise(range) * polar.transpose();
        let with = &g * &self.p;
        let mut p = DMatrix::zeros(size + 2, size + 2);
        p.view_mut((0, 0), (size, size)).copy_from(&self.p);
        p.view_mut((size, 0), (2, size)).copy_from(&with);
        p.view_mut((0, size), (size, 2)).copy_from(&with.transpose());
        p.view_mut((size, size), (2, 2)).copy_from(&own);
        self.p = p;
        self.x = self.x.push(self.x[0] + dx).push(self.x[1] + dy);
        self.known.push(observation.landmark);
    }
}

/// A landmark somewhere in the room, as seen from a pose, off by a little.
fn see(pose: Pose2, id: u32, off: f64) -> LandmarkObservation {
    let place = stream(u64::from(id), "place").random_range(-6.0..6.0);
    let (dx, dy) = (place - pose.x, 7.0 + f64::from(id % 5) - pose.y);
    let (range, bearing) = (dx.hypot(dy) + off, angle::wrap(dy.atan2(dx) - pose.theta - off));
    let observed = match id % 7 {
        // Some are seen in full only at first.
        5 if off > 0.0 => Observed::Range { range },
        6 if off > 0.0 => Observed::Bearing { bearing },
        _ => Observed::RangeBearing { range, bearing },
    };
    LandmarkObservation { landmark: id, observed }
}

/// Every size of map from none to 21 landmarks, every number of observations from one to nine at
/// once: whatever remains beside the whole vectors of the processor, the matrices are the same.
#[test]
fn equals_the_textbook_on_full_matrices() {
    let settings = SlamSettings::default()
        .robot(RobotSettings::default().gate_probability(1.0))
        .jacobians(Jacobians::Current);
    let start = loc_core::gaussian::pose_belief(Pose2::new(0.3, -0.2, 0.4), [0.2, 0.1, 0.05]);
    let mut slam = EkfSlam::new(start, settings).unwrap();
    let mut book = Textbook::new(&start, settings);
    let mut rng = stream(4, "drive");
    let mut truth = Pose2::new(0.3, -0.2, 0.4);
    for step in 0..21_u32 {
        let twist = Twist2::forward(rng.random_range(0.1..0.5), rng.random_range(-0.5..0.5));
        slam.predict(twist, 0.2).unwrap();
        book.predict(twist, 0.2);
        truth = settings.robot.integration.step(truth, twist, 0.2);
        let mut seen = vec![see(truth, step, 0.0)];
        for k in 0..(step % 9).min(step) {
            seen.push(see(truth, (step * 5 + 3 * k) % step, 0.01 * f64::from(k + 1)));
        }
        seen.dedup_by_key(|observation| observation.landmark);
        let outcomes = slam.correct(&seen).unwrap();
        book.correct(&seen);
        assert_eq!(outcomes[0].decision, Decision::NewLandmark);
        let (p, pose) = (slam.covariance().unwrap(), slam.pose().unwrap());
        assert_eq!(p.shape(), book.p.shape());
        assert!((&p - &book.p).amax() < 1e-12 * step.max(1) as f64, "step {step}");
        assert!((pose.mean - book.x.fixed_rows::<3>(0)).amax() < 1e-11);
        for (k, landmark) in slam.landmarks().unwrap().into_iter().enumerate() {
            let expected = book.x.fixed_rows::<2>(3 + 2 * k);
            assert!((landmark.position.mean - expected).amax() < 1e-10, "step {step}");
            let own = p.fixed_view::<2, 2>(3 + 2 * k, 3 + 2 * k);
            assert_relative_eq!(landmark.position.covariance, own.into_owned());
        }
    }
}

/// The innovations are those of the landmark EKF: one landmark, hand-computed.
#[test]
fn two_observations_of_one_landmark_by_hand() {
    let start = Gaussian::certain(Pose2::IDENTITY.to_vector());
    let mut slam = EkfSlam::new(start, SlamSettings::default()).unwrap();
    let ahead = |range| LandmarkObservation {
        landmark: 3,
        observed: Observed::RangeBearing { range, bearing: 0.0 },
    };
    slam.correct(&[ahead(4.0)]).unwrap();
    let born = slam.landmark(3).unwrap().unwrap().position;
    // Along the view the range's 5 cm, across it 4 m times 1 degree.
    let across = (4.0 * 1_f64.to_radians()).powi(2);
    assert_relative_eq!(born.covariance, Matrix2::new(0.0025, 0.0, 0.0, across), epsilon = 1e-15);
    let outcome = slam.correct(&[ahead(4.1)]).unwrap()[0];
    // S = 0.0025 + 0.0025, residual 0.1: NIS = 0.01 / 0.005 = 2.
    assert_relative_eq!(outcome.nis.unwrap(), 2.0, epsilon = 1e-12);
    let seen_twice = slam.landmark(3).unwrap().unwrap();
    assert_relative_eq!(seen_twice.position.mean.x, 4.05, epsilon = 1e-12);
    assert_relative_eq!(seen_twice.position.covariance.m11, 0.00125, epsilon = 1e-15);
    assert_eq!((seen_twice.observations, seen_twice.confirmed), (2, false));
    // The robot was certain where it is, and still is.
    assert_eq!(slam.pose().unwrap(), start);
}
