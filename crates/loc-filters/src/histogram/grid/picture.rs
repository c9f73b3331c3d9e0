//! The codes of a map as a picture, the maxima in windows of it, and its parts.

use loc_maps::LikelihoodField;

/// Codes row by row, with a margin that stands for what lies off the map.
#[derive(Debug, Clone)]
pub(super) struct Picture {
    width: usize,
    codes: Vec<u8>,
}

/// A picture sorted by column and row modulo the side of a square: each part holds every `side`-th
/// column of every `side`-th row.
#[derive(Debug, Clone)]
pub(super) struct Phases {
    codes: Vec<u8>,
    side: usize,
    /// Columns and rows of each part.
    part: [usize; 2],
}

impl Picture {
    /// The codes of a field with a margin of so many cells.
    pub(super) fn padded(field: &LikelihoodField, margin: usize) -> Self {
        let (width, height) = (field.frame().width(), field.frame().height());
        let pitch = width + 2 * margin;
        let mut codes = vec![field.code_off_map(); pitch * (height + 2 * margin)];
        let rows = codes.chunks_exact_mut(pitch).skip(margin);
        for (padded, row) in rows.zip(field.cell_codes().chunks_exact(width)) {
            padded[margin..margin + width].copy_from_slice(row);
        }
        Picture { width: pitch, codes }
    }

    /// Columns, margin included.
    pub(super) fn width(&self) -> usize {
        self.width
    }

    /// The codes row by row.
    pub(super) fn codes(&self) -> &[u8] {
        &self.codes
    }

    /// The highest code in the window that reaches so many cells to all sides of each cell, at most
    /// as many as the margin is wide.
    ///
    /// Rows are taken as one long line: what a window sees of the row before or after it is margin,
    /// as what it would see beyond the edge is.
    pub(super) fn highest(&self, reach: usize) -> Picture {
        let across = highest_of_line(&self.codes, reach, 1);
        Picture { width: self.width, codes: highest_of_line(&across, reach, self.width) }
    }
}

/// The highest value within `reach` steps of each place, by windows that double in length.
fn highest_of_line(line: &[u8], reach: usize, step: usize) -> Vec<u8> {
    // `ahead` holds the highest of `covered` values from each place on; two of them side by side
    // make one that covers twice as many.
    let (mut ahead, mut covered) = (line.to_vec(), 1);
    while 2 * covered <= 2 * reach + 1 {
        let mut twice = ahead.clone();
        take_higher(&mut twice, ahead.get(covered * step..).unwrap_or_default());
        ahead = twice;
        covered *= 2;
    }
    // One window from the first place within reach on, and one up to the last.
    let mut highest = line.to_vec();
    for back in [reach, covered - reach - 1] {
        take_higher(highest.get_mut(back * step..).unwrap_or_default(), &ahead);
    }
    highest
}

fn take_higher(values: &mut [u8], others: &[u8]) {
    values.iter_mut().zip(others).for_each(|(value, other)| *value = (*value).max(*other));
}

impl Phases {
    pub(super) fn of(picture: &Picture, side: usize) -> Self {
        let height = picture.codes.len() / picture.width;
        let part = [picture.width.div_ceil(side), height.div_ceil(side)];
        let last = [picture.width - 1, height - 1];
        let mut codes = Vec::with_capacity(part[0] * part[1] * side * side);
        // What the last squares have beyond the picture counts as its edge, which is margin.
        for phase in 0..side * side {
            let (phase_x, phase_y) = (phase % side, phase / side);
            for row in (0..part[1]).map(|row| (row * side + phase_y).min(last[1])) {
                let row = &picture.codes[row * picture.width..(row + 1) * picture.width];
                let column = |column: usize| (column * side + phase_x).min(last[0]);
                codes.extend((0..part[0]).map(|k| row[column(k)]));
            }
        }
        Phases { codes, side, part }
    }

    /// Columns and rows of each part.
    pub(super) fn part_size(&self) -> [usize; 2] {
        self.part
    }

    /// The part of these columns and rows, row by row.
    pub(super) fn part(&self, phase_x: usize, phase_y: usize) -> &[u8] {
        let length = self.part[0] * self.part[1];
        let first = (phase_y * self.side + phase_x) * length;
        self.codes.get(first..first + length).unwrap_or_default()
    }
}
