//! Resampling: particles drawn in proportion to their weights (M8, M9, M11).

mod systematic;

use rand::Rng;

/// How particles are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Resampling {
    /// The spoke wheel: one draw turns a wheel with M spokes, evenly spaced (M9), O(M).
    #[default]
    Systematic,
}

impl Resampling {
    /// Fills `indices` with `count` particles, drawn in proportion to the weights whose logarithms
    /// are given; they need not add up to 1.
    pub fn draw<R: Rng + ?Sized>(
        self,
        log_weights: &[f64],
        count: usize,
        rng: &mut R,
        indices: &mut Vec<u32>,
    ) {
        match self {
            Resampling::Systematic => systematic::draw(log_weights, count, rng, indices),
        }
    }
}
