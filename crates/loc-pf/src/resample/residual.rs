//! Whole shares first, roulette for what is left (Liu and Chen 1998).

use super::{Wheel, open};
use rand::Rng;

/// Particle i comes `floor(count w_i)` times for certain; the rest is drawn in proportion to the
/// remainders.
pub(super) fn draw<R: Rng + ?Sized>(
    wheel: &Wheel,
    count: usize,
    rng: &mut R,
    indices: &mut Vec<u32>,
) {
    let per_unit = count as f64 / wheel.circumference();
    let mut remainders = Vec::with_capacity(wheel.len());
    let (mut before, mut rest) = (0.0, 0.0);
    for (index, &end) in wheel.ends().iter().enumerate() {
        let share = (end - before) * per_unit;
        // A share that rounding left just below a whole number is that number.
        let copies = (share + 1e-9).floor();
        indices.extend(std::iter::repeat_n(index as u32, copies as usize));
        rest += (share - copies).max(0.0);
        remainders.push(rest);
        before = end;
    }
    indices.truncate(count);
    let last = wheel.last();
    while indices.len() < count {
        let place = open(rng) * rest;
        let index = remainders.partition_point(|&end| end <= place).min(last);
        indices.push(index as u32);
    }
}
