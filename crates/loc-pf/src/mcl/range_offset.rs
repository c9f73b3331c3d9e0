//! The common offset between the ranges of a laser and the walls of the map.
//!
//! A laser may report every range some centimetres short or long, and a map may show its walls in
//! front of or behind where beams end: drawn a cell too thick, smeared by the poses that it was
//! made from, or cut off by a simulator's steps. Both have the same effect: all beams end before
//! the walls, or behind them, at any pose. In a room a pose can compensate half of that (the robot
//! seems to be nearer to the wall that it faces), so pose and offset are estimated jointly: around
//! the pose of an update the log-likelihood of the scan is a quadratic function of pose and offset,
//! whose curvature gives the information about the offset with the pose unknown. The offsets of the
//! scans are averaged over the drive, and their scatter gives the standard deviation.

use super::scan::{MountedScan, endpoints};
use loc_core::Pose2;
use loc_core::error::in_range;
use loc_maps::LikelihoodField;
use loc_maps::likelihood_field::Endpoints;
use nalgebra::{Matrix3, Matrix4, Vector3, Vector4};

/// What is added to every range.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum RangeOffset {
    /// Estimated from the scans, and used once it is significant: at least
    /// [`RangeOffset::MIN_CELLS`] and three standard deviations. For the likelihood field as a
    /// product.
    #[default]
    Estimated,
    /// This \[m\]; 0 for ranges as they are.
    Fixed(f64),
}

impl RangeOffset {
    /// An offset below this changes nothing \[sides of a cell\]: half a cell lies between the face
    /// of a drawn wall and the middle of its first cell, and slanting walls have steps.
    pub const MIN_CELLS: f64 = 0.8;

    /// Maximum offset, either way \[m\].
    pub const LARGEST: f64 = 0.15;

    pub(super) fn check(&self) -> loc_core::Result<()> {
        if let RangeOffset::Fixed(offset) = *self {
            let largest = RangeOffset::LARGEST;
            in_range("range_offset [m]", "from -0.15 to 0.15", offset, |x| x.abs() <= largest)?;
        }
        Ok(())
    }
}

/// The estimate of the offset.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct RangeOffsetEstimate {
    /// Sum of the information of the scans \[1/m^2\], of its product with their offsets, and with
    /// the squares of these.
    sums: [f64; 3],
    /// Sum of the squares of the information.
    squares: f64,
    /// Number of scans with information.
    scans: usize,
}

/// Factor of the sums from scan to scan: about 100 scans count.
const DECAY: f64 = 0.99;

/// Minimum number of scans for an estimate.
const MIN_SCANS: usize = 5;

/// Steps over which the log-likelihood is differentiated \[m, m, rad, m\]: about the width of the
/// field.
const STEPS: [f64; 4] = [0.04, 0.04, 0.015, 0.04];

/// Offsets that are tried first, to come near the peak, in these steps \[m\]: as many either way.
const TRIALS: (i32, f64) = (5, 0.03);

/// Maximum errors of pose and offset of a scan \[m, m, rad, m\]; beyond them the quadratic
/// approximation is not valid.
const MAX_ERROR: [f64; 4] = [0.15, 0.15, 0.05, 0.12];

impl RangeOffsetEstimate {
    /// The offset \[m\], `None` before enough scans with information.
    pub fn offset(&self) -> Option<f64> {
        let [information, sum, _] = self.sums;
        (self.scans >= MIN_SCANS && information > 0.0).then(|| sum / information)
    }

    /// Standard deviation of the offset \[m\], from the scatter of the scans.
    pub fn sigma(&self) -> Option<f64> {
        let mean = self.offset()?;
        let [information, _, sum_of_squares] = self.sums;
        let variance = (sum_of_squares / information - mean * mean).max(0.0);
        Some((variance * self.squares).sqrt() / information)
    }

    /// Number of scans with information.
    pub fn scans(&self) -> usize {
        self.scans
    }

    /// The offset where it is significant in a map of cells with this side, else 0; both \[m\].
    pub fn significant(&self, resolution: f64) -> f64 {
        let (Some(offset), Some(sigma)) = (self.offset(), self.sigma()) else { return 0.0 };
        let is_significant = offset.abs() >= (RangeOffset::MIN_CELLS * resolution).max(3.0 * sigma);
        if is_significant { offset.clamp(-RangeOffset::LARGEST, RangeOffset::LARGEST) } else { 0.0 }
    }

    /// Updates with scans, given the pose estimated from them and the offset used there \[m\].
    pub(super) fn update(
        &mut self,
        field: &LikelihoodField,
        scans: &[MountedScan<'_>],
        beams: &[Vec<usize>],
        pose: Pose2,
        used: f64,
    ) {
        let fit = |offset: f64| {
            let fit = log_likelihood(field, pose, &endpoints(scans, beams, offset));
            (offset, fit)
        };
        let (count, step) = TRIALS;
        let trials = (-count..=count).map(|k| f64::from(k) * step).chain([used]).map(fit);
        let Some((near, _)) = trials.max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
        let at = |shift: f64| endpoints(scans, beams, near + shift);
        let [shorter, same, longer] = [-STEPS[3], 0.0, STEPS[3]].map(at);
        let ends = |k: i32| match k {
            -1 => &shorter,
            0 => &same,
            _ => &longer,
        };
        let around = Surface::of(|pose, k| log_likelihood(field, pose, ends(k)), pose);
        let Some((offset, information)) = around.and_then(|around| around.offset()) else { return };
        let offset = near + offset;
        for (sum, new) in self.sums.iter_mut().zip([1.0, offset, offset * offset]) {
            *sum = DECAY * *sum + information * new;
        }
        self.squares = DECAY * DECAY * self.squares + information * information;
        self.scans += 1;
    }
}

fn log_likelihood(field: &LikelihoodField, pose: Pose2, ends: &Endpoints) -> f64 {
    let mut out = [0.0];
    field.log_likelihoods([&[pose.x], &[pose.y], &[pose.theta]], ends, &mut out);
    out[0]
}

/// Gradient and curvature of the log-likelihood over x, y, theta and offset.
struct Surface {
    gradient: Vector4<f64>,
    hessian: Matrix4<f64>,
}

impl Surface {
    /// By central differences of `value` at a pose and an offset in steps.
    fn of(value: impl Fn(Pose2, i32) -> f64, pose: Pose2) -> Option<Self> {
        let at = |steps: [i32; 4]| {
            let by = |k: usize| f64::from(steps[k]) * STEPS[k];
            value(
                Pose2 { x: pose.x + by(0), y: pose.y + by(1), theta: pose.theta + by(2) },
                steps[3],
            )
        };
        let unit = |k: usize, sign: i32| std::array::from_fn(|j| if j == k { sign } else { 0 });
        let middle = at([0; 4]);
        let (mut gradient, mut hessian) = (Vector4::zeros(), Matrix4::zeros());
        for a in 0..4 {
            let (plus, minus) = (at(unit(a, 1)), at(unit(a, -1)));
            gradient[a] = (plus - minus) / (2.0 * STEPS[a]);
            hessian[(a, a)] = (plus - 2.0 * middle + minus) / (STEPS[a] * STEPS[a]);
            for b in 0..a {
                let both = |s: i32, t: i32| {
                    at(std::array::from_fn(|j| {
                        if j == a {
                            s
                        } else if j == b {
                            t
                        } else {
                            0
                        }
                    }))
                };
                let mixed = both(1, 1) - both(1, -1) - both(-1, 1) + both(-1, -1);
                hessian[(a, b)] = mixed / (4.0 * STEPS[a] * STEPS[b]);
                hessian[(b, a)] = hessian[(a, b)];
            }
        }
        let is_finite = gradient.iter().chain(hessian.iter()).all(|value| value.is_finite());
        is_finite.then_some(Surface { gradient, hessian })
    }

    /// The offset at the greatest likelihood \[m\], and its information with the pose unknown
    /// \[1/m^2\]; `None` where the function has no peak nearby.
    fn offset(&self) -> Option<(f64, f64)> {
        // A prior, for directions that the scan does not determine.
        let trust = Vector4::from(MAX_ERROR).map(|sigma| 1.0 / (sigma * sigma));
        let curvature = Matrix4::from_diagonal(&trust) - self.hessian;
        let step = curvature.cholesky()?.solve(&self.gradient);
        let is_near = (0..4).all(|k| step[k].abs() <= MAX_ERROR[k]);
        let of_pose: Matrix3<f64> = curvature.fixed_view::<3, 3>(0, 0).into();
        let mixed: Vector3<f64> = curvature.fixed_view::<3, 1>(0, 3).into();
        let open = of_pose.cholesky()?.solve(&mixed).dot(&mixed);
        let information = curvature[(3, 3)] - trust[3] - open;
        (is_near && information > 0.0).then_some((step[3], information))
    }
}
