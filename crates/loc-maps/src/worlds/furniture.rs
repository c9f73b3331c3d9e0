//! Furniture for a room, which leaves a way everywhere.
//!
//! A piece stands flush to a wall, in a corner, or at least [`GAP`] from each wall, and pieces are
//! at least that far from each other. So no piece ever closes off a part of the room.

use super::canvas::{Canvas, bounds};
use super::plan::Room;
use super::{between, chance};
use crate::Bounds;
use crate::grid::Occupancy;
use rand::Rng;

/// The narrowest way between two pieces \[m\].
const GAP: f64 = 0.8;
/// The least area of a room with pillars \[m^2\].
const WITH_PILLARS: f64 = 35.0;

/// A piece of furniture, seen from above.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    bounds: Bounds,
    round: bool,
}

impl Piece {
    pub(super) fn draw(&self, canvas: &mut Canvas) {
        if self.round {
            let radius = self.bounds.width() / 2.0;
            canvas.disc(self.bounds.center(), radius, Occupancy::Occupied);
        } else {
            canvas.fill(&self.bounds, Occupancy::Occupied);
        }
    }

    fn fits(&self, room: &Room, others: &[Piece]) -> bool {
        let with_gap = self.bounds.grown(GAP);
        room.clear.iter().all(|clear| !overlap(&self.bounds, clear))
            && others.iter().all(|other| !overlap(&with_gap, &other.bounds))
    }
}

/// The furniture of a room: as much as finds a place in a number of trials that grows with it.
pub(super) fn furnish(room: &Room, rng: &mut impl Rng) -> Vec<Piece> {
    let area = room.inside.width() * room.inside.height();
    let mut pieces = Vec::new();
    for _ in 0..(area / 2.5) as usize {
        let piece = draw_piece(&room.inside, area > WITH_PILLARS, rng);
        pieces.extend(piece.filter(|piece| piece.fits(room, &pieces)));
    }
    pieces
}

/// A piece somewhere in a room; `None` where it is too large for it.
fn draw_piece(room: &Bounds, with_pillars: bool, rng: &mut impl Rng) -> Option<Piece> {
    let kind = between(rng, 0.0, 1.0);
    let round = with_pillars && kind < 0.12;
    // Pillars, tables, shelves, desks.
    let [length, depth] = match kind {
        _ if round => [between(rng, 0.4, 0.7); 2],
        ..0.25 => [between(rng, 1.2, 2.0), between(rng, 0.8, 1.2)],
        0.25..0.55 => [between(rng, 0.8, 2.4), 0.4],
        _ => [between(rng, 1.4, 1.8), 0.8],
    };
    let free_standing = round || kind < 0.25;
    let (x, y) = ([room.min.x, room.max.x], [room.min.y, room.max.y]);
    let upright = chance(rng, 0.5);
    let [wide, high] = if upright { [depth, length] } else { [length, depth] };
    let bounds = if free_standing {
        bounds(apart(x, wide, rng)?, apart(y, high, rng)?)
    } else if upright {
        bounds(flush(x, wide, rng)?, somewhere(y, high, rng)?)
    } else {
        bounds(somewhere(x, wide, rng)?, flush(y, high, rng)?)
    };
    Some(Piece { bounds, round })
}

/// A place for a length between two walls, away from both.
fn apart(walls: [f64; 2], length: f64, rng: &mut impl Rng) -> Option<[f64; 2]> {
    let [low, high] = [walls[0] + GAP, walls[1] - GAP - length];
    let from = between(rng, low, high);
    (low <= high).then_some([from, from + length])
}

/// A place against one of two walls, away from the other.
fn flush(walls: [f64; 2], length: f64, rng: &mut impl Rng) -> Option<[f64; 2]> {
    let [low, high] = walls;
    let place = if chance(rng, 0.5) { [low, low + length] } else { [high - length, high] };
    (high - low >= length + GAP).then_some(place)
}

/// A place against one of two walls or away from both.
fn somewhere(walls: [f64; 2], length: f64, rng: &mut impl Rng) -> Option<[f64; 2]> {
    if chance(rng, 0.5) { apart(walls, length, rng) } else { flush(walls, length, rng) }
}

fn overlap(a: &Bounds, b: &Bounds) -> bool {
    let meet = |axis: usize| a.min[axis] < b.max[axis] && b.min[axis] < a.max[axis];
    meet(0) && meet(1)
}
