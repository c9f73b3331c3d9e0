//! An office floor: its plan of corridors, rooms and doors, and the furniture of the rooms.

use super::canvas::{Canvas, Mark, bounds};
use super::{World, WorldSettings, between, chance};
use crate::grid::Occupancy;
use crate::{Bounds, Result};
use loc_core::random::stream;
use nalgebra::Point2;
use rand::Rng;

const OUTER_WALL: f64 = 0.3;
const INNER_WALL: f64 = 0.15;
const MARGIN: f64 = 0.5;
const PLATE_HEIGHT: f64 = 1.5;

/// A floor of an office building, as large as the grid.
///
/// Corridors 2 m wide run along the building, a main one or more across them. Rooms of 3 m to 8 m,
/// now and then an open-plan one, lie on both sides, each with a door of 0.9 m to 1.1 m, some with
/// one to the next room. Desks, shelves, tables and round pillars leave a free width of 0.8 m
/// everywhere, so that every free cell can be reached from every other. Beside each door of a
/// corridor hangs a plate at 1.5 m, which is a landmark.
///
/// Where there is no room for that, it gets simpler: below about 8 m one row of rooms along the
/// corridor, below about 5 m a row of rooms without one, and in the end a single room.
///
/// # Errors
/// As [`by_name`](super::by_name).
pub fn office(settings: &WorldSettings) -> Result<World> {
    let mut canvas = Canvas::new(settings)?;
    let mut rng = stream(settings.seed, "world");
    let building = canvas.area().grown(-canvas.margin(MARGIN));
    let outer = canvas.margin(canvas.thickness(OUTER_WALL));
    let plan = Plan::new(building.grown(-outer), canvas.thickness(INNER_WALL), &mut rng);

    canvas.fill(&building, Occupancy::Occupied);
    let rooms = plan.rooms.iter().map(|room| &room.inside);
    for open in rooms.chain(&plan.corridors).chain(&plan.doors) {
        canvas.fill(open, Occupancy::Free);
    }
    for room in &plan.rooms {
        for piece in furnish(room, &mut rng) {
            piece.draw(&mut canvas);
        }
    }
    let plates = plan.plates.iter().map(|&position| Mark { position, height: PLATE_HEIGHT });
    canvas.into_world("office", &plates.collect::<Vec<_>>())
}

const CORRIDOR: f64 = 2.0;
const MAIN_CORRIDOR: f64 = 2.4;
const DOOR: [f64; 2] = [0.9, 1.1];
/// A corridor with rooms on both sides takes about this much \[m\].
const BAND: f64 = 13.0;
/// Main corridors are about this far apart \[m\].
const WING: f64 = 40.0;
/// The smallest building with rooms on both sides of a corridor, and on one side \[m\].
const BOTH_SIDES: f64 = 8.5;
const ONE_SIDE: f64 = 5.2;
/// The minimum width of a room, the maximum of an ordinary one, and of an open-plan one \[m\].
const ROOM: [f64; 2] = [3.0, 6.5];
const OPEN_PLAN: [f64; 2] = [8.0, 14.0];

/// A floor; everything is in metres, and everything named here is free of walls.
struct Plan {
    rooms: Vec<Room>,
    corridors: Vec<Bounds>,
    /// The openings in the walls.
    doors: Vec<Bounds>,
    /// Where the door plates hang.
    plates: Vec<Point2<f64>>,
    wall: f64,
}

/// A room, and what furniture must leave clear in it.
struct Room {
    inside: Bounds,
    clear: Vec<Bounds>,
}

/// On which side of a row of rooms the corridor runs.
#[derive(Clone, Copy)]
enum Corridor {
    Above,
    Below,
}

impl Plan {
    /// A plan that fills a box, which is at least as wide as high, with inner walls of thickness
    /// `wall` \[m\].
    fn new(floor: Bounds, wall: f64, rng: &mut impl Rng) -> Self {
        let (rooms, corridors, doors, plates) = Default::default();
        let mut plan = Plan { rooms, corridors, doors, plates, wall };
        let (x, [low, high]) = ([floor.min.x, floor.max.x], [floor.min.y, floor.max.y]);
        if floor.height() < ONE_SIDE {
            plan.add_rooms(x, [low, high], 1.0, rng);
        } else if floor.height() < BOTH_SIDES {
            plan.corridors.push(bounds(x, [low, low + CORRIDOR]));
            plan.add_row(x, [low + CORRIDOR + wall, high], Corridor::Below, rng);
        } else {
            plan.add_bands(x, [low, high], rng);
        }
        plan
    }

    /// Corridors one above the other with rooms on both sides, and main corridors across them.
    fn add_bands(&mut self, x: [f64; 2], y: [f64; 2], rng: &mut impl Rng) {
        let count = ((y[1] - y[0]) / BAND).round().max(1.0);
        let mut wings = vec![x];
        if count > 1.0 {
            wings = shares(x, ((x[1] - x[0]) / WING).round().max(1.0) + 1.0, MAIN_CORRIDOR, rng);
            for pair in wings.windows(2) {
                self.corridors.push(bounds([pair[0][1], pair[1][0]], y));
            }
        }
        for [low, high] in shares(y, count, self.wall, rng) {
            let depths = high - low - CORRIDOR - 2.0 * self.wall;
            let lower = low + depths * between(rng, 0.44, 0.56);
            let corridor = [lower + self.wall, lower + self.wall + CORRIDOR];
            self.corridors.push(bounds(x, corridor));
            for (k, wing) in wings.iter().enumerate() {
                // A wall towards the main corridors.
                let inner = |is_inner: bool| if is_inner { self.wall } else { 0.0 };
                let wing = [wing[0] + inner(k > 0), wing[1] - inner(k + 1 < wings.len())];
                self.add_row(wing, [low, lower], Corridor::Above, rng);
                self.add_row(wing, [corridor[1] + self.wall, high], Corridor::Below, rng);
            }
        }
    }

    /// Rooms side by side, with doors to the corridor.
    fn add_row(&mut self, x: [f64; 2], y: [f64; 2], corridor: Corridor, rng: &mut impl Rng) {
        let first = self.rooms.len();
        self.add_rooms(x, y, 0.15, rng);
        for k in first..self.rooms.len() {
            let inside = self.rooms[k].inside;
            let count = if inside.width() > OPEN_PLAN[0] { 2.0 } else { 1.0 };
            for part in 0..count as usize {
                let part = part as f64;
                let from = inside.min.x + inside.width() * part / count;
                let span = [from, from + inside.width() / count];
                let [left, right] = self.opening(span, rng);
                let (wall, face, clear) = match corridor {
                    Corridor::Above => {
                        ([y[1], y[1] + self.wall], y[1] + self.wall, [y[1] - 1.0, y[1]])
                    }
                    Corridor::Below => {
                        ([y[0] - self.wall, y[0]], y[0] - self.wall, [y[0], y[0] + 1.0])
                    }
                };
                self.doors.push(bounds([left, right], wall));
                self.plates.push(Point2::new(right + 0.2, face));
                self.rooms[k].clear.push(bounds([left - 0.2, right + 0.2], clear));
            }
        }
    }

    /// Rooms side by side, joined with this probability by doors in the walls between them.
    fn add_rooms(&mut self, x: [f64; 2], y: [f64; 2], joined: f64, rng: &mut impl Rng) {
        let first = self.rooms.len();
        let can_be_parted = y[1] - y[0] > 1.2;
        let spans = if can_be_parted { self.room_spans(x, rng) } else { vec![x] };
        for span in spans {
            self.rooms.push(Room { inside: bounds(span, y), clear: Vec::new() });
        }
        for k in first + 1..self.rooms.len() {
            if chance(rng, joined) {
                let door = self.opening(y, rng);
                let [left, right] = [self.rooms[k - 1].inside.max.x, self.rooms[k].inside.min.x];
                let clear = [door[0] - 0.2, door[1] + 0.2];
                self.doors.push(bounds([left, right], door));
                self.rooms[k - 1].clear.push(bounds([left - 1.0, left], clear));
                self.rooms[k].clear.push(bounds([right, right + 1.0], clear));
            }
        }
    }

    /// Cuts a row into rooms.
    fn room_spans(&self, x: [f64; 2], rng: &mut impl Rng) -> Vec<[f64; 2]> {
        let mut spans = Vec::new();
        let mut from = x[0];
        while x[1] - from > ROOM[1] {
            let [least, most] = if chance(rng, 0.1) { OPEN_PLAN } else { ROOM };
            let width = between(rng, least, most).min(x[1] - from - ROOM[0] - self.wall);
            spans.push([from, from + width]);
            from += width + self.wall;
        }
        spans.push([from, x[1]]);
        spans
    }

    /// Where a door opens in a wall.
    fn opening(&self, wall: [f64; 2], rng: &mut impl Rng) -> [f64; 2] {
        let width = between(rng, DOOR[0], DOOR[1]).min(0.8 * (wall[1] - wall[0]));
        let from = between(rng, wall[0] + 0.1 * width, wall[1] - 1.1 * width);
        [from, from + width]
    }
}

/// Cuts a length into about equal parts with gaps between them.
fn shares(span: [f64; 2], count: f64, gap: f64, rng: &mut impl Rng) -> Vec<[f64; 2]> {
    let step = (span[1] - span[0] + gap) / count;
    let mut from = span[0];
    let mut parts = Vec::new();
    for part in 1..count as usize {
        let to = span[0] + step * (part as f64 + between(rng, -0.08, 0.08)) - gap;
        parts.push([from, to]);
        from = to + gap;
    }
    parts.push([from, span[1]]);
    parts
}

/// Minimum free width between two pieces of furniture \[m\].
const GAP: f64 = 0.8;
/// The minimum area of a room with pillars \[m^2\].
const WITH_PILLARS: f64 = 35.0;

/// A piece of furniture, seen from above.
#[derive(Debug, Clone, Copy)]
struct Piece {
    bounds: Bounds,
    round: bool,
}

impl Piece {
    fn draw(&self, canvas: &mut Canvas) {
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

/// The furniture of a room, drawn by a number of trials in proportion to the room's area.
///
/// A piece stands flush to a wall, in a corner, or at least [`GAP`] from each wall, and pieces are
/// at least that far from each other, so no piece closes off a part of the room.
fn furnish(room: &Room, rng: &mut impl Rng) -> Vec<Piece> {
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
