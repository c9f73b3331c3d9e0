//! One level of the pyramid: the best code in each window of the map.

/// How the codes of a level lie in memory, which depends on how many are read at once.
#[derive(Debug, Clone, Copy)]
pub(super) struct Layout {
    /// Sides of a window: `2^shift` cells.
    pub(super) shift: u32,
    /// Width and height of what is read at once \[windows\]; a margin as wide catches what falls
    /// off the map.
    pub(super) margin: [usize; 2],
    /// So many windows on top of each other stand together, and those one row up again.
    pub(super) lanes: usize,
}

/// For every cell, the largest code in the square window that has this cell in its lower-left
/// corner.
///
/// A search reads windows that lie a whole number of windows apart, many at a time. These stand
/// side by side: windows are sorted by the remainders of their column and row modulo their side,
/// and all of the same remainders form an image.
#[derive(Debug, Clone)]
pub(super) struct Level {
    shift: u32,
    margin: [i32; 2],
    lanes: i32,
    /// Windows that begin on the map, in a row and in a column of the first image.
    size: [i32; 2],
    /// From one row of an image to the next, and from one image to the next \[windows\].
    pitch: i32,
    image: i32,
    codes: Vec<u8>,
    /// Whether the windows of the first image hold a free cell.
    free: Vec<bool>,
}

/// Codes of windows for every cell of a map with a border of what lies off it.
#[derive(Debug)]
pub(super) struct Bordered {
    pub(super) codes: Vec<u8>,
    pub(super) off_map: u8,
    /// Columns and rows of the map.
    pub(super) size: [usize; 2],
    pub(super) border: usize,
}

impl Layout {
    /// Pitch and rows of an image for a map of this many cells. Right of a row lies the margin of
    /// the next one, and a column more, since the windows of column -1 reach into the map.
    fn image(self, cells: [usize; 2]) -> [usize; 2] {
        let [columns, rows] = cells.map(|cells| cells.div_ceil(1 << self.shift));
        [columns + self.margin[0] + 1, rows + 2 * self.margin[1]]
    }

    /// Bytes of the codes for a map of this many cells.
    pub(super) fn bytes(self, cells: [usize; 2]) -> usize {
        let images = self.lanes << (2 * self.shift);
        self.image(cells).into_iter().fold(images, usize::saturating_mul)
    }
}

impl Level {
    pub(super) fn new(from: &Bordered, layout: Layout, free: Vec<bool>) -> Self {
        let Layout { shift, margin, lanes } = layout;
        let side = 1_usize << shift;
        let [columns, rows] = from.size.map(|cells| cells.div_ceil(side));
        let [pitch, height] = layout.image(from.size);
        let image = pitch * height;
        // What is read from the last margin of all ends beyond it.
        let mut codes = vec![from.off_map; layout.bytes(from.size) + 2 * margin[0] * lanes];
        let width = from.size[0] + 2 * from.border;
        for (phase, image) in codes.chunks_exact_mut(image * lanes).take(side * side).enumerate() {
            // From row -1 on, whose windows reach into the map.
            for row in 0..=rows {
                let line = (from.border - side + phase / side + row * side) * width;
                let first = line + from.border - side + phase % side;
                let windows = from.codes[first..line + width].iter().step_by(side);
                for lane in 0..lanes {
                    let start = (row + margin[1] - 1 - lane) * pitch + margin[0] - 1;
                    let target = &mut image[start * lanes..(start + columns + 1) * lanes];
                    let target = target.iter_mut().skip(lane).step_by(lanes);
                    target.zip(windows.clone()).for_each(|(target, &code)| *target = code);
                }
            }
        }
        let [pitch, image, lanes] = [pitch, image, lanes].map(|size| size as i32);
        let [margin, size] = [margin, [columns, rows]].map(|pair| pair.map(|size| size as i32));
        Level { shift, margin, lanes, size, pitch, image, codes, free }
    }

    pub(super) fn bytes(&self) -> usize {
        self.codes.len() + self.free.len()
    }

    pub(super) fn shift(&self) -> u32 {
        self.shift
    }

    /// Windows that begin on the map a whole number of windows from cell (0, 0).
    pub(super) fn size(&self) -> [usize; 2] {
        self.size.map(|size| size as usize)
    }

    /// Whether each window of a row holds a free cell; empty above the map.
    pub(super) fn free_row(&self, row: usize) -> &[bool] {
        self.free.chunks_exact(self.size()[0]).nth(row).unwrap_or_default()
    }

    /// Whether a window holds a free cell; not off the map.
    #[inline(always)]
    pub(super) fn is_free(&self, column: u32, row: u32) -> bool {
        let inside = (column as i32) < self.size[0];
        let place = row as usize * self.size[0] as usize + column as usize;
        inside && self.free.get(place).copied().unwrap_or(false)
    }

    /// Where the codes begin of what is read from the window on that has cell (x, y), on the map
    /// or off it, in its corner.
    #[inline(always)]
    pub(super) fn start(&self, x: i32, y: i32) -> u32 {
        let mask = (1 << self.shift) - 1;
        let phase = ((y & mask) << self.shift) | (x & mask);
        let clamp = |at: i32, margin: i32, size: i32| (at >> self.shift).max(-margin).min(size);
        let column = clamp(x, self.margin[0], self.size[0]) + self.margin[0];
        let row = clamp(y, self.margin[1], self.size[1]) + self.margin[1];
        ((phase * self.image + row * self.pitch + column) * self.lanes) as u32
    }

    /// All codes; a start is where some begin.
    #[inline(always)]
    pub(super) fn codes(&self) -> &[u8] {
        &self.codes
    }
}
