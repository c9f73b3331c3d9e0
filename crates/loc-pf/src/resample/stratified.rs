//! One draw in each of equal parts (Kitagawa 1996).

use super::{Wheel, open};
use rand::Rng;

/// Draw k falls evenly into part k of `count` equal parts of the wheel.
pub(super) fn draw<R: Rng + ?Sized>(
    wheel: &Wheel,
    count: usize,
    rng: &mut R,
    indices: &mut Vec<u32>,
) {
    let part = wheel.circumference() / count as f64;
    let last = wheel.last();
    let ends = wheel.ends();
    let mut index = 0;
    indices.extend((0..count).map(|k| {
        let place = (k as f64 + open(rng)) * part;
        while index < last && ends[index] <= place {
            index += 1;
        }
        index as u32
    }));
}
