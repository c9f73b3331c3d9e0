//! The roulette wheel (M8).

use super::{Wheel, open};
use rand::Rng;

/// `count` independent draws, each found by binary search.
// ANCHOR: roulette
pub(super) fn draw<R: Rng + ?Sized>(
    wheel: &Wheel,
    count: usize,
    rng: &mut R,
    indices: &mut Vec<u32>,
) {
    indices.extend((0..count).map(|_| wheel.index_at(open(rng)) as u32));
}
// ANCHOR_END: roulette
