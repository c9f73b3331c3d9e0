//! What can be read from the codes at the ends of a scan's beams.

use super::rating::Reading;
use std::slice::IterMut;

/// How many beams are looked up in a row: their sums do not wait for each other.
const AT_ONCE: usize = 8;

/// The code at a place, which lies in the map as the coordinates that it came from are clamped.
#[inline(always)]
fn code(codes: &[u8], place: u32) -> u8 {
    codes[place as usize]
}

/// The log-likelihood of the whole scan.
pub(super) struct LogLikelihood<'a> {
    /// Logarithm of the likelihood of a scan whose codes are all 0.
    pub(super) lowest: f64,
    /// What one code adds to it.
    pub(super) step: f64,
    pub(super) sum: u64,
    /// One for each pose.
    pub(super) out: IterMut<'a, f64>,
}

impl Reading for LogLikelihood<'_> {
    #[inline(always)]
    fn beams(&mut self, codes: &[u8], places: &[u32], _: usize) {
        let (rows, rest) = places.as_chunks::<AT_ONCE>();
        let mut sum = 0;
        for row in rows {
            let mut of_row = 0;
            for &place in row {
                of_row += u64::from(code(codes, place));
            }
            sum += of_row;
        }
        for &place in rest {
            sum += u64::from(code(codes, place));
        }
        self.sum += sum;
    }

    #[inline(always)]
    fn finish_pose(&mut self) {
        if let Some(out) = self.out.next() {
            *out = self.lowest + self.step * self.sum as f64;
        }
        self.sum = 0;
    }
}

/// The sum of what a table says of the codes.
pub(super) struct TableSum<'a> {
    pub(super) table: &'a [f64; 256],
    /// The sum of every `AT_ONCE`-th beam.
    pub(super) sums: [f64; AT_ONCE],
    /// One for each pose.
    pub(super) out: IterMut<'a, f64>,
}

impl Reading for TableSum<'_> {
    #[inline(always)]
    fn beams(&mut self, codes: &[u8], places: &[u32], _: usize) {
        for places in places.chunks(AT_ONCE) {
            for (sum, &place) in self.sums.iter_mut().zip(places) {
                *sum += self.table[usize::from(code(codes, place))];
            }
        }
    }

    #[inline(always)]
    fn finish_pose(&mut self) {
        if let Some(out) = self.out.next() {
            *out = self.sums.iter().sum();
        }
        self.sums = [0.0; AT_ONCE];
    }
}

/// For each beam, from how many poses its code is at least `least`.
pub(super) struct Count<'a> {
    pub(super) least: u8,
    /// One for each beam.
    pub(super) counts: &'a mut [u32],
}

impl Reading for Count<'_> {
    #[inline(always)]
    fn beams(&mut self, codes: &[u8], places: &[u32], first: usize) {
        let counts = self.counts.get_mut(first..).unwrap_or_default();
        for (count, &place) in counts.iter_mut().zip(places) {
            *count += u32::from(code(codes, place) >= self.least);
        }
    }

    #[inline(always)]
    fn finish_pose(&mut self) {}
}
