//! The spoke wheel (M9).

use rand::{Rng, RngExt};

/// One random turn of a wheel with `count` spokes, over sectors as wide as the weights.
pub(super) fn draw<R: Rng + ?Sized>(
    log_weights: &[f64],
    count: usize,
    rng: &mut R,
    indices: &mut Vec<u32>,
) {
    indices.clear();
    let total: f64 = log_weights.iter().map(|weight| weight.exp()).sum();
    let spacing = total / count as f64;
    let mut spoke = spacing * rng.random::<f64>();
    let mut passed = 0.0;
    for (index, weight) in log_weights.iter().enumerate() {
        passed += weight.exp();
        while spoke < passed && indices.len() < count {
            indices.push(index as u32);
            spoke += spacing;
        }
    }
    // Rounding may leave the last spoke beyond the last sector.
    while indices.len() < count {
        indices.push(log_weights.len().saturating_sub(1) as u32);
    }
}
