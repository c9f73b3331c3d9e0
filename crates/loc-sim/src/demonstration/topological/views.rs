//! Scans from spots all over each place.

use super::{TopologicalConfig, place_of};
use crate::Result;
use crate::source::tour::TourWorld;
use loc_core::Pose2;
use loc_core::random::ChaCha8Rng;
use loc_maps::topological::Place;
use loc_maps::{Bounds, TopologicalMap};
use loc_sensors::laser::LaserScan;
use nalgebra::Point2;
use rand::RngExt;
use std::f64::consts::PI;

/// How often a spot is drawn anew that does not suit.
const TRIES: usize = 200;

/// How far spots of a door lie from its middle, along both axes \[m\].
const DOOR: f64 = 0.4;

/// For each place of the map so many scans.
pub(super) fn take(
    map: &TopologicalMap,
    world: &TourWorld,
    config: &TopologicalConfig,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Vec<LaserScan>>> {
    let scanner = config.tour.laser.scanner()?;
    let radius = config.tour.robot.radius_m;
    let mut places = Vec::with_capacity(map.places().len());
    for (index, place) in map.places().iter().enumerate() {
        let suits =
            |spot: &Point2<f64>| world.clearance(spot) >= radius && place_of(map, spot) == index;
        let mut scans = Vec::with_capacity(config.views);
        for _ in 0..config.views {
            let spot = draw(place, &suits, rng);
            let robot = Pose2::new(spot.x, spot.y, rng.random_range(-PI..PI));
            scans.push(scanner.scan(world.walls(), robot, rng));
        }
        places.push(scans);
    }
    Ok(places)
}

/// A spot of a place; its middle where none suits.
fn draw(place: &Place, suits: &impl Fn(&Point2<f64>) -> bool, rng: &mut ChaCha8Rng) -> Point2<f64> {
    let around = Bounds::around(place.outline.iter().copied());
    let [low, high] = around.map_or_else(
        || [-DOOR, DOOR].map(|off| Point2::new(place.position.x + off, place.position.y + off)),
        |bounds| [bounds.min, bounds.max],
    );
    for _ in 0..TRIES {
        let mut between = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
        let spot = Point2::new(between(low.x, high.x), between(low.y, high.y));
        if suits(&spot) {
            return spot;
        }
    }
    place.position
}
