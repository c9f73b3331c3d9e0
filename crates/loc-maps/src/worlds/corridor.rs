//! A long corridor that looks the same every few metres.

use super::canvas::{Canvas, bounds};
use super::{World, WorldSettings, between, chance};
use crate::Result;
use crate::grid::Occupancy;
use loc_core::random::stream;
use rand::Rng;

const WIDTH: f64 = 2.0;
const WALL: f64 = 0.2;
const MARGIN: f64 = 0.5;
const DOOR: f64 = 1.0;
/// How deep a closed door stands in the wall \[m\].
const DOOR_DEPTH: f64 = 0.12;
/// A niche to sit in: width along the wall and depth \[m\].
const NICHE: [f64; 2] = [1.8, 0.6];

/// A corridor 2 m wide along the whole grid, with closed doors on both sides.
///
/// The doors come at one distance of 3.5 m to 5 m, so a robot sees how far it is from the walls
/// but not along which door it passes; only the ends, and up to three niches in place of doors,
/// tell. There are no landmarks.
///
/// # Errors
/// As [`by_name`](super::by_name).
pub fn corridor(settings: &WorldSettings) -> Result<World> {
    let mut canvas = Canvas::new(settings)?;
    let mut rng = stream(settings.seed, "world");
    let wall = canvas.margin(canvas.thickness(WALL));
    let ends = canvas.margin(MARGIN) + wall;
    let [from, to] = [ends, canvas.area().max.x - ends];
    let middle = canvas.area().center().y;
    // In a low grid the niches take three tenths of the height.
    let half = (WIDTH / 2.0).min(0.7 * (middle - ends));
    let deepest = middle - ends - half;
    let [low, high] = [middle - half, middle + half];

    let mut open = vec![bounds([from, to], [low, high])];
    let door_depth = canvas.thickness(DOOR_DEPTH);
    for (places, above) in places(from, to, &mut rng) {
        for Place { at, niche } in places {
            let [width, depth] = if niche { NICHE } else { [DOOR, door_depth] };
            let depth = depth.min(deepest);
            let side = if above { [high, high + depth] } else { [low - depth, low] };
            open.push(bounds([at - width / 2.0, at + width / 2.0], side));
        }
    }
    for part in &open {
        canvas.fill(&part.grown(wall), Occupancy::Occupied);
    }
    for part in &open {
        canvas.fill(part, Occupancy::Free);
    }
    canvas.into_world("corridor", &[])
}

/// A door, or a niche in place of one, by its middle \[m\].
struct Place {
    at: f64,
    niche: bool,
}

/// The places along both sides, below and above.
fn places(from: f64, to: f64, rng: &mut impl Rng) -> [(Vec<Place>, bool); 2] {
    let step = between(rng, 3.5, 5.0);
    let first = from + between(rng, 1.5, step);
    // Across from a door is another one, or the wall between two.
    let shift = if chance(rng, 0.5) { step / 2.0 } else { 0.0 };
    let count = ((to - 1.5 - first - shift) / step).floor() + 1.0;
    let count = count as usize;
    let niches = [0, 1, 2].map(|_| (between(rng, 0.0, count as f64) as usize, chance(rng, 0.5)));
    [(0.0, false), (shift, true)].map(|(shift, above)| {
        let place = |k: usize| Place {
            at: first + shift + step * k as f64,
            niche: niches.contains(&(k, above)),
        };
        ((0..count).map(place).collect(), above)
    })
}
