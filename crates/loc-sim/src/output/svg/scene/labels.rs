//! Names beside landmarks.

use crate::output::svg::axis::TICK_SIZE;
use crate::output::svg::marks::Px;
use crate::output::svg::room::{Rect, Room};
use crate::output::svg::style::Paint;
use crate::output::svg::text::{self, Anchor};
use crate::output::svg::writer::Writer;

/// Writes names, each at the place around its mark that covers least.
pub(super) fn draw_names(writer: &mut Writer, room: &mut Room, names: &[(Px, &str)]) {
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
