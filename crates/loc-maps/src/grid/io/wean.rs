//! The map format of the Wean Hall recordings (`wean.dat`).
//!
//! A header of `robot_specifications->` lines says the size of a cell in centimetres, a line
//! `global_map[0]: M N` how many rows and columns follow. Each value is the probability that the
//! cell is **free** (the note that comes with the recordings states the opposite), -1 where
//! nothing is known. The row of the file counts along x, the column along y.

use super::wrong;
use crate::Result;
use crate::grid::{GridFrame, MAX_CELLS, OccupancyGrid, UNKNOWN};
use loc_core::Pose2;
use std::path::Path;
use std::str::Lines;

/// How such a file begins.
pub(super) const BEGINNING: &[u8] = b"robot_specifications->";

/// Reads a map; its lower-left corner is the origin.
pub(super) fn parse(file: &Path, text: &str) -> Result<OccupancyGrid> {
    let mut lines = text.lines();
    let header = header(file, &mut lines)?;
    let (width, height) = (header.width, header.height);
    let frame = GridFrame::new(width, height, header.resolution, Pose2::IDENTITY)?;
    // A number and its separator take two bytes at least.
    if text.len() / 2 < width * height {
        return Err(too_few(file, width, height, text.len()));
    }
    let mut cells = vec![UNKNOWN; width * height];
    let mut words = lines.flat_map(str::split_ascii_whitespace);
    for k in 0..width * height {
        let Some(word) = words.next() else { return Err(too_few(file, width, height, k)) };
        let (x, y) = (k / height, k % height);
        cells[y * width + x] = value(word).ok_or_else(|| {
            let expected = format!("-1 or 0 to 1 in row {x}, column {y}");
            wrong(file, "global_map", &expected, &format!("`{}`", shortened(word)))
        })?;
    }
    match words.next() {
        None => OccupancyGrid::new(frame, cells),
        Some(word) => {
            let expected = format!("{width} x {height} values");
            let found = format!("`{}` after them", shortened(word));
            Err(wrong(file, "global_map", &expected, &found))
        }
    }
}

struct Header {
    /// Cells along x: rows of the file.
    width: usize,
    /// Cells along y: columns of the file.
    height: usize,
    /// \[m\]
    resolution: f64,
}

fn header(file: &Path, lines: &mut Lines<'_>) -> Result<Header> {
    let mut resolution = None;
    for line in lines.by_ref() {
        let mut words = line.split_ascii_whitespace();
        match words.next() {
            Some("robot_specifications->resolution") => {
                let word = words.next().unwrap_or_default();
                let number = word.parse::<f64>().ok().filter(|r| r.is_finite() && *r > 0.0);
                let expected = "a number of centimetres > 0";
                let found = format!("`{}`", shortened(word));
                let centimetres =
                    number.ok_or_else(|| wrong(file, "resolution", expected, &found))?;
                resolution = Some(0.01 * centimetres);
            }
            Some("global_map[0]:") => {
                let resolution = resolution.ok_or_else(|| {
                    wrong(file, "resolution", "a line robot_specifications->resolution", &"none")
                })?;
                let sizes: Vec<usize> = words.map_while(|word| word.parse().ok()).collect();
                return match *sizes {
                    [width, height] if (1..=MAX_CELLS).contains(&width.saturating_mul(height)) => {
                        Ok(Header { width, height, resolution })
                    }
                    _ => {
                        let expected = "two whole numbers, 1 to 2^28 cells together";
                        Err(wrong(file, "global_map", expected, &format!("`{}`", shortened(line))))
                    }
                };
            }
            _ => {}
        }
    }
    Err(wrong(file, "global_map", "a line `global_map[0]: rows columns`", &"none"))
}

/// The occupancy of a probability of free, `None` for what is none.
fn value(word: &str) -> Option<i8> {
    let free: f64 = word.parse().ok()?;
    match free {
        -1.0 => Some(UNKNOWN),
        0.0..=1.0 => Some((100.0 * (1.0 - free)).round() as i8),
        _ => None,
    }
}

fn too_few(file: &Path, width: usize, height: usize, found: usize) -> crate::Error {
    let expected = format!("{width} x {height} values");
    wrong(file, "global_map", &expected, &format!("the end of the file before value {found}"))
}

/// Enough of a text to be found by.
fn shortened(text: &str) -> String {
    text.chars().take(40).collect()
}
