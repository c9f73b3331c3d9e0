//! The models of line matching: the measurement (r, alpha) of a line, the motion with its systematic
//! errors, and the lines that a scanner should see.

use super::LineMatchingSettings;
use crate::Result;
use crate::extended::{LinearizedMotion, MeasurementModel, MotionModel};
use loc_core::error::{finite, positive};
use loc_core::motion::{DrivenPath, PathNoise};
use loc_core::{Gaussian, Pose2, angle};
use loc_maps::line::NormalForm;
use loc_maps::{LineMap, LineSegment};
use loc_sensors::laser::LaserScan;
use nalgebra::{Matrix2, Matrix2x3, SMatrix, SVector, Vector2, Vector3};
use std::collections::BTreeMap;
use std::f64::consts::{FRAC_PI_2, PI};

/// (r, alpha) of a line of the map in the frame of a scanner on the robot (H4).
///
/// With the line `X cos A + Y sin A = R` of the map and a scanner at `(x_l, y_l, theta_l)`,
/// `h = (R - x_l cos A - y_l sin A, A - theta_l)`. It is linear in the pose except for
/// the motion of the scanner about the robot's centre as it turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineModel {
    normal: NormalForm,
    mounting: Pose2,
    facing: Option<f64>,
    noise: Matrix2<f64>,
}

impl LineModel {
    /// The model of a line of the map, given by its normal form there, and a scanner at `mounting`
    /// (`base_from_laser`). r is at least 0, and there is no noise.
    pub fn new(normal: NormalForm, mounting: Pose2) -> Self {
        LineModel { normal, mounting, facing: None, noise: Matrix2::zeros() }
    }

    /// The same for one measurement: its alpha \[rad\], and the covariance of (r, alpha).
    ///
    /// A wall close by may be measured on one side of the scanner and expected on the other. The
    /// expectation is then given on the side that `alpha` says, with a negative r.
    #[must_use]
    pub fn measured(self, alpha: f64, noise: Matrix2<f64>) -> Self {
        LineModel { facing: Some(alpha), noise, ..self }
    }

    /// The scanner's place from the robot's, in the map's directions \[m\].
    fn lever(&self, theta: f64) -> Vector2<f64> {
        let (sin, cos) = theta.sin_cos();
        let Pose2 { x, y, .. } = self.mounting;
        Vector2::new(cos * x - sin * y, sin * x + cos * y)
    }

    /// Signed distance of the line from the scanner along its normal in the map \[m\], and 1 where
    /// (r, alpha) has the direction of that normal, -1 where it is opposite.
    fn distance_and_side(&self, state: &Vector3<f64>) -> (f64, f64) {
        let (sin, cos) = self.normal.alpha.sin_cos();
        let lever = self.lever(state.z);
        let distance = self.normal.r - (state.x + lever.x) * cos - (state.y + lever.y) * sin;
        let alpha = self.normal.alpha - state.z - self.mounting.theta;
        let turned = match self.facing {
            None => distance < 0.0,
            Some(facing) => angle::difference(alpha, facing).abs() > FRAC_PI_2,
        };
        (distance, if turned { -1.0 } else { 1.0 })
    }
}

impl MeasurementModel<3, 2> for LineModel {
    fn predict(&self, state: &Vector3<f64>) -> Vector2<f64> {
        let (distance, side) = self.distance_and_side(state);
        let turn = if side < 0.0 { PI } else { 0.0 };
        let alpha = self.normal.alpha - state.z - self.mounting.theta + turn;
        Vector2::new(side * distance, angle::wrap(alpha))
    }

    /// Rows `[-cos A, -sin A, .]`, whose last column is the scanner's swing, and `[0, 0, -1]`.
    // ANCHOR: line-jacobian
    fn jacobian(&self, state: &Vector3<f64>) -> Matrix2x3<f64> {
        let (_, side) = self.distance_and_side(state);
        let (sin, cos) = self.normal.alpha.sin_cos();
        let lever = self.lever(state.z);
        let swing = lever.y * cos - lever.x * sin;
        Matrix2x3::new(-side * cos, -side * sin, side * swing, 0.0, 0.0, -1.0)
    }
    // ANCHOR_END: line-jacobian

    fn noise(&self, _expected: &Vector2<f64>) -> Matrix2<f64> {
        self.noise
    }

    fn residual(&self, z: &Vector2<f64>, expected: &Vector2<f64>) -> Vector2<f64> {
        Vector2::new(z.x - expected.x, angle::difference(z.y, expected.y))
    }
}

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
/// A path of length L turns the heading by `drift L` more, half of it by the middle of the path, and
/// is longer by the share `scale`. Backwards the turn has the opposite sign.
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

/// Standard deviation of the position up to which one viewpoint suffices \[m\].
const WELL_KNOWN: f64 = 0.1;

/// What a scanner can see: an angle, about a direction of its own, and a distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldOfView {
    /// The middle of it, from the scanner's x axis \[rad\].
    pub middle: f64,
    /// The whole angle \[rad\].
    pub angle: f64,
    /// The greatest distance \[m\]; may be infinite.
    pub max_range: f64,
}

/// A stretch of a map line, as a scanner should see it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PredictedLine {
    /// Index of the line in the map.
    pub line: usize,
    /// The visible stretch, in the scanner's frame \[m\].
    pub stretch: LineSegment,
    /// (r, alpha) of the line in the scanner's frame.
    pub normal_form: NormalForm,
    /// Covariance of (r, alpha) that comes of the map.
    pub covariance: Matrix2<f64>,
}

impl FieldOfView {
    /// Checks that something can be seen.
    fn check(&self) -> Result<()> {
        finite("middle of a field of view [rad]", self.middle)?;
        positive("angle of a field of view [rad]", self.angle)?;
        Ok(())
    }

    /// That of the scanner that made a scan.
    pub fn of(scan: &LaserScan) -> Self {
        let (first, last) = (scan.angle_min, scan.angle_max);
        FieldOfView {
            middle: 0.5 * (first + last),
            angle: (last - first).abs().max(scan.angle_increment.abs()),
            max_range: scan.range_max,
        }
    }
}

/// The stretches of map lines that the scanner of a robot should see, in the order of the map.
///
/// What a wall hides depends on where the scanner is: where that is not well known, the view from
/// two standard deviations on each side counts as well. Lines shorter than `min_map_length` are
/// left out, but hide what is behind them.
///
/// # Errors
/// Those of [`LineMap::visible_lines`].
pub(super) fn predicted_lines(
    map: &LineMap,
    belief: &Gaussian<3>,
    mounting: Pose2,
    view: FieldOfView,
    settings: &LineMatchingSettings,
) -> Result<Vec<PredictedLine>> {
    view.check()?;
    let mut parts: BTreeMap<usize, Vec<[f64; 2]>> = BTreeMap::new();
    // Where the heading is off, the view reaches farther on one side.
    let angle = view.angle + 4.0 * belief.covariance.m33.max(0.0).sqrt();
    for pose in viewpoints(belief) {
        let scanner = pose * mounting;
        let ahead = Pose2::new(scanner.x, scanner.y, scanner.theta + view.middle);
        for visible in map.visible_lines(ahead, angle, view.max_range)? {
            parts.entry(visible.line).or_default().extend(visible.parts);
        }
    }
    let scanner = belief.pose() * mounting;
    let mut predicted = Vec::new();
    for (line, parts) in parts {
        let segment = map.lines()[line].seen_from(scanner);
        if segment.length() < settings.min_map_length {
            continue;
        }
        let normal_form = segment.normal_form();
        let covariance = map_covariance(&segment, &normal_form, settings.map_sigma);
        predicted.extend(joined(parts).into_iter().map(|[from, to]| {
            let stretch = LineSegment { start: segment.at(from), end: segment.at(to) };
            PredictedLine { line, stretch, normal_form, covariance }
        }));
    }
    Ok(predicted)
}

/// The pose and, where the position is known worse than [`WELL_KNOWN`], four more around it.
fn viewpoints(belief: &Gaussian<3>) -> Vec<Pose2> {
    let pose = belief.pose();
    let ellipse = belief.position().ellipse(2.0);
    let mut poses = vec![pose];
    for (half, direction) in
        [(ellipse.semi_major, ellipse.angle), (ellipse.semi_minor, ellipse.angle + FRAC_PI_2)]
    {
        if half > 2.0 * WELL_KNOWN {
            let (sin, cos) = direction.sin_cos();
            let offset = |far: f64| Pose2 { x: pose.x + far * cos, y: pose.y + far * sin, ..pose };
            poses.extend([offset(half), offset(-half)]);
        }
    }
    poses
}

/// Parts of a line in order, those that touch as one.
fn joined(mut parts: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    parts.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut joined: Vec<[f64; 2]> = Vec::with_capacity(parts.len());
    for part in parts {
        match joined.last_mut().filter(|last| part[0] <= last[1]) {
            Some(last) => last[1] = last[1].max(part[1]),
            None => joined.push(part),
        }
    }
    joined
}

/// Covariance of (r, alpha) where both ends of a segment may be off across it, independently.
fn map_covariance(segment: &LineSegment, normal: &NormalForm, sigma: f64) -> Matrix2<f64> {
    let (sin, cos) = normal.alpha.sin_cos();
    // The middle is off by half the sum of both, the direction by their difference over the
    // length; a turn about the middle moves the foot of the perpendicular by their distance.
    let middle = segment.at(0.5).coords.dot(&Vector2::new(-sin, cos));
    let (across, turn) = (sigma * sigma / 2.0, 2.0 * (sigma / segment.length()).powi(2));
    let both = middle * turn;
    Matrix2::new(across + middle * both, both, both, turn)
}
