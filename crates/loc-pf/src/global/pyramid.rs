//! The pyramid: the best codes over windows of 1, 4, 16 and 64 cells.

use super::level::{Bordered, Layout, Level};
use crate::{Error, Result};
use loc_maps::grid::Occupancy;
use loc_maps::{LikelihoodField, OccupancyGrid};

/// A window holds 4 x 4 of the level below.
pub(super) const FAN: usize = 4;

/// Windows of the top level are summed in groups of so many side by side.
pub(super) const GROUP: usize = 32;

/// Windows of the top level, times headings, above which there is one more level.
const MANY: usize = 1 << 25;

/// Most bytes of a level: places in it fit into 31 bits.
const MAX_BYTES: usize = 3 << 29;

/// The levels of a map.
#[derive(Debug, Clone)]
pub(super) struct Pyramid {
    /// The largest windows, where a search starts.
    pub(super) top: Level,
    /// The levels below, from single cells up.
    pub(super) levels: Vec<Level>,
}

/// Codes and free cells of windows that grow.
struct Windows {
    codes: Bordered,
    free: Vec<bool>,
    free_size: [usize; 2],
}

impl Pyramid {
    pub(super) fn new(
        map: &OccupancyGrid,
        field: &LikelihoodField,
        headings: usize,
    ) -> Result<Self> {
        let size = [map.width(), map.height()];
        let windows = |shift: u32| size.iter().map(|cells| cells.div_ceil(1 << shift)).product();
        let top = if headings.saturating_mul(windows(4)) > MANY { 6 } else { 4 };
        let group = size[0].div_ceil(1 << top).next_multiple_of(GROUP);
        let layout = |shift| match shift {
            _ if shift == top => Layout { shift, margin: [group, 1], lanes: 1 },
            _ => Layout { shift, margin: [FAN; 2], lanes: FAN },
        };
        let shifts = (0..=top).step_by(2);
        let largest = shifts.clone().map(|shift| layout(shift).bytes(size)).max().unwrap_or(0);
        if largest > MAX_BYTES {
            let (what, expected) = ("map of a global search", "at most 1.5 GiB a level");
            return Err(Error::Core(loc_core::Error::Length { what, expected, found: largest }));
        }
        let mut windows = Windows::new(map, field, 1 << top);
        let levels = shifts.take_while(|shift| *shift < top).map(|shift| {
            let level = windows.level(layout(shift));
            windows.grow(1 << shift);
            level
        });
        let levels = levels.collect();
        Ok(Pyramid { top: windows.level(layout(top)), levels })
    }

    /// Memory \[bytes\].
    pub(super) fn bytes(&self) -> usize {
        self.levels.iter().chain([&self.top]).map(Level::bytes).sum()
    }
}

impl Windows {
    /// Windows of one cell.
    fn new(map: &OccupancyGrid, field: &LikelihoodField, border: usize) -> Self {
        let is_free = |&value: &i8| Occupancy::of(value) == Occupancy::Free;
        let free = map.values().iter().map(is_free).collect();
        let codes = bordered(field, border);
        Windows { free_size: codes.size, codes, free }
    }

    /// From windows of side `side` to those of 4 x 4 of them.
    fn grow(&mut self, side: usize) {
        widen(&mut self.codes, side);
        widen(&mut self.codes, 2 * side);
        (self.free, self.free_size) = any_of(&self.free, self.free_size);
    }

    fn level(&self, layout: Layout) -> Level {
        Level::new(&self.codes, layout, self.free.clone())
    }
}

/// The codes of the map with a border of what lies off it.
fn bordered(field: &LikelihoodField, border: usize) -> Bordered {
    let size = [field.frame().width(), field.frame().height()];
    let [width, height] = size.map(|cells| cells + 2 * border);
    let off_map = field.code_off_map();
    let mut codes = vec![off_map; width * height];
    let rows = codes.chunks_exact_mut(width).skip(border);
    for (target, row) in rows.zip(field.cell_codes().chunks_exact(size[0])) {
        target[border..border + size[0]].copy_from_slice(row);
    }
    Bordered { codes, off_map, size, border }
}

/// Best codes of windows of side `step` become those of windows twice as wide.
fn widen(windows: &mut Bordered, step: usize) {
    let width = windows.size[0] + 2 * windows.border;
    let codes = &mut windows.codes;
    for row in codes.chunks_exact_mut(width) {
        for column in 0..width.saturating_sub(step) {
            row[column] = row[column].max(row[column + step]);
        }
    }
    for row in 0..(codes.len() / width).saturating_sub(step) {
        let (lower, upper) = codes.split_at_mut((row + step) * width);
        let lower = &mut lower[row * width..][..width];
        lower.iter_mut().zip(upper).for_each(|(low, &mut up)| *low = (*low).max(up));
    }
}

/// Whether any of 4 x 4 is true.
fn any_of(free: &[bool], [width, height]: [usize; 2]) -> (Vec<bool>, [usize; 2]) {
    let size = [width.div_ceil(FAN), height.div_ceil(FAN)];
    let mut any = vec![false; size[0] * size[1]];
    for (row, line) in free.chunks_exact(width).enumerate() {
        let target = &mut any[row / FAN * size[0]..][..size[0]];
        for (target, part) in target.iter_mut().zip(line.chunks(FAN)) {
            *target |= part.contains(&true);
        }
    }
    (any, size)
}
