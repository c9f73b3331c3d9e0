//! Labels within a plot: the free room, clear of lines and of each other, and names in it.

use crate::axis::{Area, TICK_SIZE};
use crate::marks::Px;
use crate::style::Paint;
use crate::text;
use crate::text::Anchor;
use crate::writer::Writer;

/// Side of the cells in which the room of the figure is booked \[px\].
const CELL: f64 = 3.0;

/// What the cells of the plot hold already.
pub(crate) struct Room {
    area: Area,
    columns: usize,
    rows: usize,
    cells: Vec<Cell>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Cell {
    Free,
    Drawn,
    Text,
}

/// A rectangle: left, top, right, bottom \[px\].
pub(crate) type Rect = [f64; 4];

impl Room {
    pub(crate) fn new(area: Area) -> Self {
        let columns = (area.width / CELL).ceil().max(1.0) as usize;
        let rows = (area.height / CELL).ceil().max(1.0) as usize;
        Room { area, columns, rows, cells: vec![Cell::Free; columns * rows] }
    }

    /// Books the cells along a segment.
    pub(crate) fn book_segment(&mut self, a: Px, b: Px) {
        let (a, b) = (self.near(a), self.near(b));
        let length = f64::hypot(b.0 - a.0, b.1 - a.1);
        let steps = (length / CELL).ceil().max(1.0);
        for k in 0..=steps as usize {
            let share = k as f64 / steps;
            let (x, y) = (a.0 + share * (b.0 - a.0), a.1 + share * (b.1 - a.1));
            self.book([x, y, x, y], Cell::Drawn);
        }
    }

    /// The point itself, or where it is far out, one just outside the plot.
    fn near(&self, (x, y): Px) -> Px {
        let area = &self.area;
        (
            x.clamp(area.left - CELL, area.right() + CELL),
            y.clamp(area.top - CELL, area.bottom() + CELL),
        )
    }

    /// Books the cells along a polyline.
    pub(crate) fn book_path(&mut self, points: &[Px]) {
        for pair in points.windows(2) {
            self.book_segment(pair[0], pair[1]);
        }
    }

    /// Books the square around a mark.
    pub(crate) fn book_mark(&mut self, (x, y): Px, half: f64) {
        self.book([x - half, y - half, x + half, y + half], Cell::Drawn);
    }

    /// Books the first rectangle of those that cover least; none where all of them leave the plot
    /// or meet a text.
    pub(crate) fn take(&mut self, places: &[Rect]) -> Option<Rect> {
        let costs = places.iter().filter_map(|&rect| Some((self.cost(rect)?, rect)));
        let (_, best) = costs.min_by_key(|(cost, _)| *cost)?;
        self.book(best, Cell::Text);
        Some(best)
    }

    /// Number of booked cells under a rectangle; none where it leaves the plot or meets a text.
    fn cost(&self, rect: Rect) -> Option<usize> {
        let area = &self.area;
        let inside = rect[0] >= area.left + 1.0
            && rect[1] >= area.top + 1.0
            && rect[2] <= area.right() - 1.0
            && rect[3] <= area.bottom() - 1.0;
        let mut cost = 0;
        for index in self.indices(rect) {
            match self.cells[index] {
                Cell::Free => {}
                Cell::Drawn => cost += 1,
                Cell::Text => return None,
            }
        }
        inside.then_some(cost)
    }

    fn book(&mut self, rect: Rect, cell: Cell) {
        for index in self.indices(rect) {
            if self.cells[index] != Cell::Text {
                self.cells[index] = cell;
            }
        }
    }

    /// Indices of the cells that a rectangle touches, as far as they lie in the plot.
    fn indices(&self, [left, top, right, bottom]: Rect) -> impl Iterator<Item = usize> + use<> {
        let columns = cells(left - self.area.left, right - self.area.left, self.columns);
        let rows = cells(top - self.area.top, bottom - self.area.top, self.rows);
        let stride = self.columns;
        rows.flat_map(move |row| columns.clone().map(move |column| row * stride + column))
    }
}

/// Cells between two coordinates, among `count`.
fn cells(low: f64, high: f64, count: usize) -> std::ops::Range<usize> {
    let first = (low / CELL).floor().max(0.0) as usize;
    let end = ((high / CELL).floor() + 1.0).clamp(0.0, count as f64) as usize;
    first..end
}

/// Writes names, each at the place around its mark that covers least.
pub(crate) fn draw_names(writer: &mut Writer, room: &mut Room, names: &[(Px, &str)]) {
    for &(at, name) in names.iter().filter(|(_, name)| !name.trim().is_empty()) {
        let name = text::shorten(name, TICK_SIZE, 240.0);
        if let Some(rect) = room.take(&places(at, text::width(&name, TICK_SIZE))) {
            let (x, anchor) = if rect[0] > at.0 {
                (rect[0], Anchor::Start)
            } else if rect[2] < at.0 {
                (rect[2], Anchor::End)
            } else {
                (at.0, Anchor::Middle)
            };
            let element = text::element((x, rect[3] - 3.0), TICK_SIZE, anchor, Paint::INK);
            text::draw_with_halo(writer, element, &name);
        }
    }
}

/// The places for a name around its mark, the best first.
fn places((x, y): Px, width: f64) -> [Rect; 8] {
    const GAP: f64 = 6.0;
    const HEIGHT: f64 = 14.0;
    let half = 0.5 * width;
    let rect = |left: f64, top: f64| [left, top, left + width, top + HEIGHT];
    let (right, left) = (x + GAP, x - GAP - width);
    let (above, below) = (y - GAP - HEIGHT + 1.0, y + GAP - 1.0);
    let level = y - 0.5 * HEIGHT;
    [
        rect(right, above + 3.0),
        rect(left, above + 3.0),
        rect(right, below - 3.0),
        rect(left, below - 3.0),
        rect(right + 1.0, level),
        rect(left - 1.0, level),
        rect(x - half, above - 1.0),
        rect(x - half, below + 1.0),
    ]
}
