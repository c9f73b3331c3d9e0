//! The spoke wheel (M9).

use super::{Wheel, open};
use crate::elementary::ROUND;
use pulp::{Arch, Simd, WithSimd};
use rand::Rng;

/// Places written at once, whether needed or not: most particles have fewer copies, and no branch
/// has to guess how many.
const AT_ONCE: usize = 4;

/// One random turn of a wheel with `count` spokes.
pub(super) fn draw<R: Rng + ?Sized>(
    wheel: &Wheel,
    count: usize,
    rng: &mut R,
    indices: &mut Vec<u32>,
) {
    indices.resize(count + AT_ONCE, 0);
    let turn = open(rng);
    Arch::new().dispatch(Spokes { wheel, count, turn, indices });
    indices.truncate(count);
}

struct Spokes<'a> {
    wheel: &'a Wheel,
    count: usize,
    /// Where the first spoke stands, in spacings.
    turn: f64,
    indices: &'a mut [u32],
}

/// Sectors looked at together.
const BLOCK: usize = 64;

impl WithSimd for Spokes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let per_unit = self.count as f64 / self.wheel.circumference();
        let mut written = 0;
        let mut index = 0;
        for ends in self.wheel.ends().chunks(BLOCK) {
            let passed = passed(ends, per_unit, self.turn);
            for &passed in &passed[..ends.len()] {
                let passed = (passed as usize).min(self.count);
                self.indices[written..written + AT_ONCE].fill(index);
                if passed > written + AT_ONCE {
                    self.indices[written + AT_ONCE..passed].fill(index);
                }
                written = passed;
                index += 1;
            }
        }
    }
}

/// How many spokes stand before the end of each sector: spoke k stands at `k + turn` spacings.
#[inline(always)]
fn passed(ends: &[f64], per_unit: f64, turn: f64) -> [u32; BLOCK] {
    let mut passed = [0; BLOCK];
    for (passed, end) in passed.iter_mut().zip(ends) {
        *passed = ((end * per_unit + (0.5 - turn)) + ROUND).to_bits() as u32;
    }
    passed
}
