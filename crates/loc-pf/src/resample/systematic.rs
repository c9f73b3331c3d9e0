//! The spoke wheel (M9).

use super::{Wheel, open};
use crate::elementary::ROUND;
use crate::workers::{PART, Workers};
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
    workers: &Workers,
) {
    indices.resize(count, 0);
    let per_unit = count as f64 / wheel.circumference();
    let spokes = Spokes { per_unit, offset: 0.5 - open(rng), count };
    // The spokes of a part of the sectors follow those of the part before.
    let (mut rest, mut first) = (&mut indices[..], 0);
    let parts = wheel.ends().chunks(PART).enumerate().map(|(part, ends)| {
        let last = ends.last().map_or(first, |end| spokes.before(*end));
        let (indices, others) = std::mem::take(&mut rest).split_at_mut(last - first);
        let part = Part { spokes, ends, sector: (part * PART) as u32, first, indices };
        (rest, first) = (others, last);
        part
    });
    workers.for_each(parts, |part| Arch::new().dispatch(part));
}

/// Where the spokes stand: spoke k at `k + 0.5 - offset` spacings.
#[derive(Debug, Clone, Copy)]
struct Spokes {
    /// Spacings in a unit of the wheel.
    per_unit: f64,
    offset: f64,
    count: usize,
}

// ANCHOR: spokes
impl Spokes {
    /// How many spokes stand before a place of the wheel.
    #[inline(always)]
    fn before(&self, place: f64) -> usize {
        (self.passed(place) as usize).min(self.count)
    }

    #[inline(always)]
    fn passed(&self, place: f64) -> u32 {
        ((place * self.per_unit + self.offset) + ROUND).to_bits() as u32
    }
}
// ANCHOR_END: spokes

/// Some sectors and the spokes that stand in them.
struct Part<'a> {
    spokes: Spokes,
    ends: &'a [f64],
    /// The number of the first sector.
    sector: u32,
    /// The number of the first spoke.
    first: usize,
    /// For each of the spokes its sector.
    indices: &'a mut [u32],
}

/// Sectors looked at together.
const BLOCK: usize = 64;

impl WithSimd for Part<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Part { spokes, ends, mut sector, first, indices } = self;
        let mut written = 0;
        for ends in ends.chunks(BLOCK) {
            let mut passed = [0; BLOCK];
            passed.iter_mut().zip(ends).for_each(|(passed, end)| *passed = spokes.passed(*end));
            for &passed in &passed[..ends.len()] {
                let passed = (passed as usize).min(spokes.count) - first;
                match indices.get_mut(written..written + AT_ONCE) {
                    Some(places) if passed <= written + AT_ONCE => places.fill(sector),
                    _ => indices[written..passed].fill(sector),
                }
                written = passed;
                sector += 1;
            }
        }
    }
}
