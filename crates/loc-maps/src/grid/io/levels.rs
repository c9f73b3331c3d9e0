//! From grey values to occupancies, and back.

use super::raster::{Raster, Samples};
use super::{MapDescription, Mode};
use crate::grid::{Occupancy, UNKNOWN};

/// The occupancies of an image, bottom row first.
pub(super) fn occupancies(raster: &Raster, description: &MapDescription) -> Vec<i8> {
    // Every grey value is judged once; the pixels then look up.
    let table: Vec<i8> =
        (0..=raster.white).map(|sample| occupancy(sample, raster.white, description)).collect();
    let look_up = |sample: usize| table.get(sample).copied().unwrap_or(UNKNOWN);
    let mut cells = Vec::with_capacity(raster.width * raster.height);
    match &raster.samples {
        Samples::Bytes(bytes) => {
            let whole: [i8; 256] = std::array::from_fn(look_up);
            for row in bytes.chunks_exact(raster.width).rev() {
                cells.extend(row.iter().map(|&sample| whole[usize::from(sample)]));
            }
        }
        Samples::Words(words) => {
            for row in words.chunks_exact(raster.width).rev() {
                cells.extend(row.iter().map(|&sample| look_up(usize::from(sample))));
            }
        }
    }
    if let (Some(opaque), Mode::Trinary | Mode::Scale) = (&raster.opaque, description.mode) {
        let opaque = opaque.chunks_exact(raster.width).rev().flatten();
        for (cell, _) in cells.iter_mut().zip(opaque).filter(|(_, opaque)| !**opaque) {
            *cell = UNKNOWN;
        }
    }
    cells
}

/// The occupancy of one grey value.
fn occupancy(sample: u16, white: u16, description: &MapDescription) -> i8 {
    let brightness = f64::from(sample) / f64::from(white);
    let darkness = f64::from(white - sample) / f64::from(white);
    let (free, occupied) = match description.negate {
        true => (darkness, brightness),
        false => (brightness, 1.0 - brightness),
    };
    let (from, to) = (description.free_thresh, description.occupied_thresh);
    match description.mode {
        Mode::Raw => match (255.0 * free).round() {
            percent if percent <= 100.0 => percent as i8,
            _ => UNKNOWN,
        },
        _ if occupied >= to => 100,
        _ if occupied <= from => 0,
        Mode::Trinary => UNKNOWN,
        Mode::Scale => (100.0 * (occupied - from) / (to - from)).round() as i8,
    }
}

/// The grey value that a cell is written as, and whether it is opaque.
pub(super) fn grey_value(value: i8, mode: Mode) -> (u8, bool) {
    match (mode, value) {
        (Mode::Trinary, _) => match Occupancy::of(value) {
            Occupancy::Free => (254, true),
            Occupancy::Occupied => (0, true),
            Occupancy::Unknown => (205, true),
        },
        (Mode::Scale, 0..=100) => ((2.55 * f64::from(100 - value)).round() as u8, true),
        (Mode::Scale, _) => (128, false),
        (Mode::Raw, 0..=100) => (value.unsigned_abs(), true),
        (Mode::Raw, _) => (255, true),
    }
}
