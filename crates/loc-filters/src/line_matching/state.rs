//! The state of the filter: the pose, and what the odometry gets wrong all the time.

use super::LineModel;
use crate::extended::{LinearizedMotion, MeasurementModel, MotionModel};
use loc_core::motion::{DrivenPath, PathNoise};
use loc_core::{Gaussian, Pose2};
use nalgebra::{Matrix2, Matrix2x3, SMatrix, SVector, Vector2, Vector3};

/// Number of states: x, y, theta, the drift of the odometry's heading \[rad/m\], and the share by
/// which its distances are too short.
pub const STATES: usize = 5;

pub(super) type State = SVector<f64, STATES>;

/// A pose that is known so well, with an odometry of which only the usual errors are known.
pub(super) fn with_odometry(pose: &Gaussian<3>, drift: f64, scale: f64) -> Gaussian<STATES> {
    let mut belief = Gaussian::certain(State::zeros());
    set_pose(&mut belief, pose);
    belief.covariance[(3, 3)] = drift * drift;
    belief.covariance[(4, 4)] = scale * scale;
    belief
}

/// Another pose with the odometry that is known already.
pub(super) fn set_pose(belief: &mut Gaussian<STATES>, pose: &Gaussian<3>) {
    belief.mean.fixed_rows_mut::<3>(0).copy_from(&pose.mean);
    belief.covariance.fixed_view_mut::<3, 2>(0, 3).fill(0.0);
    belief.covariance.fixed_view_mut::<2, 3>(3, 0).fill(0.0);
    belief.covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&pose.covariance);
}

/// The belief about the pose alone.
pub(super) fn pose_of(belief: &Gaussian<STATES>) -> Gaussian<3> {
    Gaussian {
        mean: belief.mean.fixed_rows::<3>(0).into(),
        covariance: belief.covariance.fixed_view::<3, 3>(0, 0).into(),
    }
}

/// A step of the odometry, without what it gets wrong all the time.
///
/// A way of length L turns the heading by `drift L` more, half of it by the middle of the way, and
/// is longer by the share `scale`. Backwards it turns the other way round.
pub(super) struct OdometryStep {
    pub(super) path: DrivenPath,
    /// Variances along the step, across it, and of the heading.
    pub(super) variances: Vector3<f64>,
    /// Variances that both systematic errors gain.
    pub(super) wander: Vector2<f64>,
}

impl OdometryStep {
    fn signed_length(&self) -> f64 {
        self.path.length().copysign(self.path.step().x)
    }

    /// The step as it most likely was.
    fn corrected(&self, state: &State) -> Pose2 {
        let (step, turn) = (self.path.step(), state[3] * self.signed_length());
        let (sin, cos) = (0.5 * turn).sin_cos();
        let longer = 1.0 + state[4];
        Pose2 {
            x: longer * (cos * step.x - sin * step.y),
            y: longer * (sin * step.x + cos * step.y),
            theta: step.theta + turn,
        }
    }
}

impl MotionModel<STATES> for OdometryStep {
    fn predict(&self, state: &State) -> State {
        let pose = Pose2::new(state[0], state[1], state[2]) * self.corrected(state);
        State::new(pose.x, pose.y, pose.theta, state[3], state[4])
    }

    fn linearize(&self, state: &State) -> LinearizedMotion<STATES> {
        let pose = Pose2::new(state[0], state[1], state[2]);
        let mut path = DrivenPath::starting_at(Pose2::IDENTITY);
        path.extend(self.corrected(state));
        let step = PathNoise::step(&path, pose, &self.variances);
        let (dx, dy) = (step.pose.x - pose.x, step.pose.y - pose.y);
        let (length, longer) = (self.signed_length(), 1.0 + state[4]);
        let mut jacobian = SMatrix::<f64, STATES, STATES>::identity();
        jacobian.fixed_view_mut::<3, 3>(0, 0).copy_from(&step.by_pose);
        let by_drift = Vector3::new(-0.5 * length * dy, 0.5 * length * dx, length);
        jacobian.fixed_view_mut::<3, 1>(0, 3).copy_from(&by_drift);
        let by_scale = Vector3::new(dx / longer, dy / longer, 0.0);
        jacobian.fixed_view_mut::<3, 1>(0, 4).copy_from(&by_scale);
        let mut noise = SMatrix::<f64, STATES, STATES>::zeros();
        noise.fixed_view_mut::<3, 3>(0, 0).copy_from(&step.noise);
        (noise[(3, 3)], noise[(4, 4)]) = (self.wander.x, self.wander.y);
        LinearizedMotion { state: self.predict(state), jacobian, noise }
    }
}

/// The model of a line over all states.
pub(super) struct OfPose(pub(super) LineModel);

impl MeasurementModel<STATES, 2> for OfPose {
    fn predict(&self, state: &State) -> Vector2<f64> {
        self.0.predict(&state.fixed_rows::<3>(0).into())
    }

    fn jacobian(&self, state: &State) -> SMatrix<f64, 2, STATES> {
        let by_pose: Matrix2x3<f64> = self.0.jacobian(&state.fixed_rows::<3>(0).into());
        let mut jacobian = SMatrix::<f64, 2, STATES>::zeros();
        jacobian.fixed_view_mut::<2, 3>(0, 0).copy_from(&by_pose);
        jacobian
    }

    fn noise(&self, expected: &Vector2<f64>) -> Matrix2<f64> {
        self.0.noise(expected)
    }

    fn residual(&self, z: &Vector2<f64>, expected: &Vector2<f64>) -> Vector2<f64> {
        self.0.residual(z, expected)
    }
}
