//! What a driven path does to a stack of positions: shift each layer, blur it, turn.

use super::stack::LayerMove;
use crate::Result;
use crate::histogram::Kernel;
use loc_core::Pose2;
use loc_core::motion::{DrivenPath, PathNoise};
use nalgebra::Vector3;

/// Errors of a usual step beyond so many standard deviations are left out ..
const USUAL_TAIL: f64 = 4.0;

/// .. and of a step in which odometry has failed, which is a rough guess anyway.
const FAULTY_TAIL: f64 = 3.0;

/// A step with its noise, ready to move layers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Step {
    pub(super) by: Pose2,
    /// Variances along, across \[m^2\] and of the heading \[rad^2\].
    variances: Vector3<f64>,
    tail: f64,
}

/// The cells that a step moves probabilities between.
#[derive(Debug, Clone, Copy)]
pub(super) struct Lattice {
    /// Side of a cell \[m\].
    pub(super) cell: f64,
    /// From one layer to the next \[rad\].
    pub(super) heading_step: f64,
}

impl Step {
    /// The step as odometry usually reports it.
    pub(super) fn usual(path: &DrivenPath, noise: &PathNoise) -> Self {
        let least = [noise.min_position, noise.min_position, noise.min_heading];
        let variances = noise.variances(path) + Vector3::from(least.map(|sigma| sigma * sigma));
        Step { by: path.step(), variances, tail: USUAL_TAIL }
    }

    /// The step of an odometry that has failed.
    pub(super) fn faulty(path: &DrivenPath, noise: &PathNoise) -> Self {
        let usual = Step::usual(path, noise);
        let fault = PathNoise::fault_sigmas(path);
        let variances = usual.variances + fault.component_mul(&fault);
        Step { variances, tail: FAULTY_TAIL, ..usual }
    }

    /// How a layer moves in which the robot looks along `heading` \[rad\] of the lattice, while the
    /// lattice itself moves by `drift` \[m\].
    ///
    /// The heading is anything within its layer, and on the average over the way off by half of
    /// what it is off at the end: both blur across the way. Kernels work along columns and rows,
    /// so the correlation of the errors of x and y is left out.
    pub(super) fn layer_move(&self, lattice: &Lattice, heading: f64, drift: [f64; 2]) -> LayerMove {
        let (sin, cos) = heading.sin_cos();
        let (dx, dy) = (cos * self.by.x - sin * self.by.y, sin * self.by.x + cos * self.by.y);
        let [along, across, turn] = [0, 1, 2].map(|k| self.variances[k]);
        let of_heading = lattice.heading_step.powi(2) / 12.0 + 0.25 * turn;
        let x = cos * cos * along + sin * sin * across + dy * dy * of_heading;
        let y = sin * sin * along + cos * cos * across + dx * dx * of_heading;
        let kernel = |shift: f64, variance: f64| {
            Kernel::cut_off(shift / lattice.cell, variance.sqrt() / lattice.cell, self.tail)
        };
        LayerMove { across: kernel(dx - drift[0], x), up: kernel(dy - drift[1], y) }
    }

    /// How probability moves between layers, which themselves turn by `drift` \[rad\].
    pub(super) fn turn(&self, lattice: &Lattice, drift: f64) -> Kernel {
        let step = lattice.heading_step;
        Kernel::cut_off((self.by.theta - drift) / step, self.variances[2].sqrt() / step, self.tail)
    }

    /// Largest standard deviations of the position \[m\] and the heading \[rad\].
    pub(super) fn deviations(&self) -> [f64; 2] {
        let way = self.by.x.powi(2) + self.by.y.powi(2);
        let position = self.variances[0].max(self.variances[1]) + 0.25 * way * self.variances[2];
        [position.sqrt(), self.variances[2].sqrt()]
    }

    /// Whether kernels of this step stay small enough to be computed.
    pub(super) fn check(&self, lattice: &Lattice) -> Result<()> {
        let [position, _] = self.deviations();
        let largest = (position + self.by.x.abs() + self.by.y.abs()) / lattice.cell;
        Kernel::check(largest, largest)
    }
}
