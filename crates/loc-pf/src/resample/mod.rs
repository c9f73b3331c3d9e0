//! Resampling: particles drawn in proportion to their weights (M8, M9, M11).
//!
//! After a measurement some particles are far likelier than others. Resampling draws a new cloud
//! from the old one, likely particles several times, unlikely ones never, and so puts the effort
//! where the robot may be. Picture a wheel with one sector for each particle, as wide as its
//! weight ([`Wheel`]): the schemes differ in how they point at it. All give each particle on
//! average its share; from roulette over stratified to the spoke wheel, the number of copies strays
//! less and less from that average, and what strays is lost diversity (M11).
//!
//! ```
//! use loc_core::random::stream;
//! use loc_pf::Resampling;
//! let log_weights = [0.1_f64, 0.6, 0.3].map(f64::ln);
//! let mut drawn = Vec::new();
//! Resampling::Systematic.draw(&log_weights, 10, &mut stream(1, "filter"), &mut drawn);
//! assert_eq!(drawn, [0, 1, 1, 1, 1, 1, 1, 2, 2, 2]);
//! ```

mod residual;
mod roulette;
mod stratified;
mod systematic;
mod wheel;

pub use wheel::Wheel;

use crate::Workers;
use rand::{Rng, RngExt};

/// How particles are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Resampling {
    /// The roulette wheel: every draw is independent and found by binary search (M8), O(M log M).
    Roulette,
    /// The spoke wheel: one draw turns a wheel with evenly spaced spokes (M9), O(M). Equal weights
    /// stay as they are.
    #[default]
    Systematic,
    /// One draw in each of M equal parts of the wheel, O(M).
    Stratified,
    /// Every particle as often as the whole part of its share says; roulette for the rest.
    Residual,
}

impl Resampling {
    /// All schemes.
    pub const ALL: [Resampling; 4] = [
        Resampling::Roulette,
        Resampling::Residual,
        Resampling::Stratified,
        Resampling::Systematic,
    ];

    /// Fills `indices` with `count` particles, drawn in proportion to the weights whose logarithms
    /// are given; they need not add up to 1.
    ///
    /// Weights that are all 0 count as equal; without any weights nothing is drawn. See [`Wheel`].
    pub fn draw<R: Rng + ?Sized>(
        self,
        log_weights: &[f64],
        count: usize,
        rng: &mut R,
        indices: &mut Vec<u32>,
    ) {
        let mut wheel = Wheel::new();
        wheel.set(log_weights);
        self.spin(&wheel, count, rng, indices);
    }

    /// The same from a wheel, which keeps its memory from one resampling to the next.
    pub fn spin<R: Rng + ?Sized>(
        self,
        wheel: &Wheel,
        count: usize,
        rng: &mut R,
        indices: &mut Vec<u32>,
    ) {
        self.spin_by(&Workers::one(), wheel, count, rng, indices);
    }

    /// The same by several threads, of which only the spoke wheel makes use.
    pub(crate) fn spin_by<R: Rng + ?Sized>(
        self,
        workers: &Workers,
        wheel: &Wheel,
        count: usize,
        rng: &mut R,
        indices: &mut Vec<u32>,
    ) {
        if self != Resampling::Systematic {
            indices.clear();
        }
        if wheel.is_empty() || count == 0 {
            return indices.clear();
        }
        match self {
            Resampling::Roulette => roulette::draw(wheel, count, rng, indices),
            Resampling::Systematic => systematic::draw(wheel, count, rng, indices, workers),
            Resampling::Stratified => stratified::draw(wheel, count, rng, indices),
            Resampling::Residual => residual::draw(wheel, count, rng, indices),
        }
    }
}

/// An even draw from (0, 1) that keeps 2^-33 away from either end, further than rounding reaches.
fn open<R: Rng + ?Sized>(rng: &mut R) -> f64 {
    (f64::from(rng.random::<u32>()) + 0.5) / (1_u64 << 32) as f64
}
