//! Sums of codes over the beams of a scan, for many neighbouring windows at a time.
//!
//! Plain loops over bytes, which `pulp` has compiled for the vector instructions of several
//! generations of processors; the callers choose among them at run time.

use super::level::Level;
use super::pyramid::{FAN, GROUP};
use std::ops::Range;

/// Codes whose sum fits into 16 bits: 257 x 255 = 65535.
const IN_16_BITS: usize = 257;

/// Rows of windows that are summed together: their sums stay in the fastest memory.
const BAND: usize = 16;

/// Columns and rows from the robot's cell to those in which the beams end.
pub(super) type Ends<'a> = [&'a [i32]; 2];

/// Adds up the codes of all windows of the top level: to row `k` of `sums`, which has `pitch`
/// columns, those of the groups of windows that `extents` names.
#[inline(always)]
pub(super) fn rows(
    level: &Level,
    extents: &[Range<usize>],
    [xs, ys]: Ends<'_>,
    pitch: usize,
    sums: &mut [u32],
) {
    let mut short = vec![0_u16; BAND * pitch];
    sums.fill(0);
    let bands = extents.chunks(BAND).zip(sums.chunks_mut(BAND * pitch)).enumerate();
    for (band, (extents, sums)) in bands {
        for (xs, ys) in xs.chunks(IN_16_BITS).zip(ys.chunks(IN_16_BITS)) {
            short.fill(0);
            for (&x, &y) in xs.iter().zip(ys) {
                for (row, (extent, short)) in
                    extents.iter().zip(short.chunks_exact_mut(pitch)).enumerate()
                {
                    let corner = [extent.start, band * BAND + row];
                    let [column, row] = corner.map(|window| (window << level.shift()) as i32);
                    let start = level.start(column + x, row + y) as usize;
                    let codes = level.codes().get(start..start + extent.len());
                    add(
                        short.get_mut(extent.clone()).unwrap_or_default(),
                        codes.unwrap_or_default(),
                    );
                }
            }
            sums.iter_mut().zip(&short).for_each(|(sum, &short)| *sum += u32::from(short));
        }
    }
}

#[inline(always)]
fn add(sums: &mut [u16], codes: &[u8]) {
    let groups = sums.as_chunks_mut::<GROUP>().0.iter_mut().zip(codes.as_chunks::<GROUP>().0);
    for (sums, codes) in groups {
        let mut group = *sums;
        for k in 0..GROUP {
            group[k] += u16::from(codes[k]);
        }
        *sums = group;
    }
}

/// The sums of [`FAN`] x [`FAN`] windows from that with cell (x, y) in its corner on, column by
/// column. `starts` is scratch.
#[inline(always)]
pub(super) fn block(
    level: &Level,
    [x, y]: [i32; 2],
    [xs, ys]: Ends<'_>,
    starts: &mut Vec<u32>,
) -> [u32; FAN * FAN] {
    starts.clear();
    starts.extend(xs.iter().zip(ys).map(|(dx, dy)| level.start(x + dx, y + dy)));
    let mut sums = [0; FAN * FAN];
    for starts in starts.chunks(IN_16_BITS) {
        let mut short = [0_u16; FAN * FAN];
        for &start in starts {
            let codes = level.codes().get(start as usize..).and_then(<[u8]>::first_chunk);
            let codes: &[u8; FAN * FAN] = codes.unwrap_or(&[0; FAN * FAN]);
            short.iter_mut().zip(codes).for_each(|(sum, &code)| *sum += u16::from(code));
        }
        sums.iter_mut().zip(short).for_each(|(sum, short)| *sum += u32::from(short));
    }
    sums
}
