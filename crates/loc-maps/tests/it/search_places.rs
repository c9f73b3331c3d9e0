//! Global search in buildings: symmetric ones, noise, several scans, refinement.

use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, angle};
use loc_maps::grid::{Cell, GridFrame, Occupancy};
use loc_maps::likelihood_field::{Endpoints, LikelihoodField, LikelihoodFieldSettings, Obstacles};
use loc_maps::search::Candidate;
use loc_maps::worlds::{self, WorldSettings};
use loc_maps::{DistanceMap, OccupancyGrid, RayCaster};
use loc_maps::{GlobalSearch, SearchSettings};
use loc_sensors::laser::{LaserFaults, LaserNoise, LaserScanner, LaserSpec};
use rand::RngExt;
use std::f64::consts::PI;

fn field(map: &OccupancyGrid) -> LikelihoodField {
    LikelihoodField::new(map, &LikelihoodFieldSettings::nav2()).unwrap()
}

fn search(map: &OccupancyGrid, settings: SearchSettings) -> GlobalSearch {
    GlobalSearch::new(map, field(map), settings).unwrap()
}

/// A laser of `beams` beams over `turn` \[rad\].
fn laser(beams: usize, turn: f64, sigma: f64) -> LaserScanner {
    let spec = LaserSpec {
        angle_min: -0.5 * turn,
        angle_increment: turn / beams as f64,
        beams,
        range_min: 0.05,
        range_max: 30.0,
        noise: LaserNoise { sigma, sigma_per_m: 0.0 },
        rate: 10.0,
    };
    LaserScanner::new(spec).unwrap()
}

fn see(laser: &LaserScanner, walls: &RayCaster, pose: Pose2, rng: &mut ChaCha8Rng) -> Endpoints {
    laser.scan(walls, pose, rng).points(Pose2::IDENTITY).map(|end| [end.x, end.y]).collect()
}

fn is_at(found: &Candidate, pose: Pose2, distance: f64, turn: f64) -> bool {
    found.pose.distance(pose) < distance
        && angle::difference(found.pose.theta, pose.theta).abs() < turn
}

/// A pose in the open, with the heading between two steps of the search.
fn anywhere(map: &OccupancyGrid, rng: &mut ChaCha8Rng) -> Pose2 {
    let clear = DistanceMap::new(map, 1.0).unwrap();
    loop {
        let [u, v]: [f64; 2] = [rng.random(), rng.random()];
        let at = map.frame().to_map(u * map.width() as f64, v * map.height() as f64);
        let free = map.occupancy_at(&at) == Occupancy::Free;
        if free && clear.distance_at(&at).unwrap() > 0.3 {
            return Pose2::new(at.x, at.y, rng.random_range(-PI..PI));
        }
    }
}

#[test]
fn a_hall_of_mirrors_has_two_answers() {
    let size = WorldSettings { width: 240, height: 180, ..Default::default() };
    let map = worlds::hall_of_mirrors(&size).unwrap().grid;
    let walls = RayCaster::new(&map);
    let settings = SearchSettings { angle_step: 2_f64.to_radians(), ..Default::default() };
    let search = search(&map, settings);
    let center = map.frame().to_map(120.0, 90.0);
    let mut rng = stream(1, "mirrors");
    for _ in 0..3 {
        let truth = anywhere(&map, &mut rng);
        let image =
            Pose2::new(2.0 * center.x - truth.x, 2.0 * center.y - truth.y, truth.theta + PI);
        let scan = see(&laser(60, 2.0 * PI, 0.01), &walls, truth, &mut rng);
        let found = search.search(&scan).unwrap();
        let at = |pose| found[..2].iter().any(|found| is_at(found, pose, 0.1, 0.03));
        assert!(at(truth) && at(image), "{truth}: {found:?}");
        let (first, second) = (found[0].log_likelihood, found[1].log_likelihood);
        assert!((first - second).abs() < 2.0, "{first} {second}");
    }
}

#[test]
fn noise_and_people_leave_the_answer_right() {
    let size = WorldSettings { width: 400, height: 300, seed: 5, ..Default::default() };
    let map = worlds::office(&size).unwrap().grid;
    let walls = RayCaster::new(&map);
    let settings = SearchSettings { angle_step: 2_f64.to_radians(), ..Default::default() };
    // Beams end on surfaces only, and near them: see the module's words about wrong answers.
    let obstacles = Obstacles::Surfaces;
    let field = LikelihoodFieldSettings::nav2().sigma_hit(0.1).obstacles(obstacles);
    let field = LikelihoodField::new(&map, &field).unwrap();
    let search = GlobalSearch::new(&map, field, settings).unwrap();
    let faults = LaserFaults { dropout: 0.05, erroneous: 0.02, short: 0.2 };
    let laser = LaserScanner { faults, ..laser(90, 1.5 * PI, 0.02) };
    let mut rng = stream(2, "noise");
    let mut right = 0;
    for _ in 0..8 {
        let truth = anywhere(&map, &mut rng);
        let found = search.search(&see(&laser, &walls, truth, &mut rng)).unwrap();
        right += usize::from(is_at(&found[0], truth, 0.1, 0.03));
    }
    assert!(right >= 7, "{right} of 8");
}

/// Two rooms of the same shape, 12 m apart; in one of them stands a cupboard at the right wall.
fn twin_rooms() -> OccupancyGrid {
    let frame = GridFrame::new(400, 120, 0.05, Pose2::new(-2.0, 1.0, 0.3)).unwrap();
    let mut map = OccupancyGrid::filled(frame, -1);
    let mut fill = |columns: std::ops::Range<usize>, rows: std::ops::Range<usize>, value| {
        for row in rows {
            columns.clone().try_for_each(|column| map.set(Cell::new(column, row), value)).unwrap();
        }
    };
    for left in [20, 260] {
        fill(left..left + 100, 20..90, 100);
        fill(left + 2..left + 98, 22..88, 0);
        fill(left + 2..left + 12, 22..40, 100);
    }
    fill(340..358, 60..75, 100);
    map
}

#[test]
fn several_scans_tell_twins_apart() {
    let map = twin_rooms();
    let (walls, grid) = (RayCaster::new(&map), map.frame().origin());
    let settings = SearchSettings { angle_step: 2_f64.to_radians(), ..Default::default() };
    let search = search(&map, settings);
    let laser = laser(60, PI, 0.01);
    let mut rng = stream(3, "twins");
    // In the right room: first the left wall ahead, then after a turn and a step the cupboard.
    let then = grid * Pose2::new(15.0, 2.5, PI);
    let now = grid * Pose2::new(15.3, 2.8, 0.2);
    let twin = grid * Pose2::new(3.0, 2.5, PI);
    let [first, second] = [then, now].map(|pose| see(&laser, &walls, pose, &mut rng));
    let one = search.search(&first).unwrap();
    let at = |pose| one.iter().any(|found| is_at(found, pose, 0.1, 0.03));
    assert!(at(then) && at(twin), "{one:?}");
    let earlier = now.between(then);
    let both = search.search_many(&[(earlier, &first), (Pose2::IDENTITY, &second)]).unwrap();
    assert!(is_at(&both[0], now, 0.05, 0.02), "{both:?}");
    assert!(both.len() == 1, "{both:?}");
}

#[test]
fn refinement_goes_beyond_the_grid() {
    let size = WorldSettings { width: 300, height: 200, seed: 3, ..Default::default() };
    let map = worlds::office(&size).unwrap().grid;
    let walls = RayCaster::new(&map);
    let search = search(&map, SearchSettings::default());
    let mut rng = stream(4, "refine");
    let (mut distances, mut turns) = (Vec::new(), Vec::new());
    for _ in 0..15 {
        let truth = anywhere(&map, &mut rng);
        let scan = see(&laser(180, 2.0 * PI, 0.02), &walls, truth, &mut rng);
        let start = map.frame().center(map.frame().cell_at(&truth.position()).unwrap());
        let theta = truth.theta.to_degrees().round().to_radians();
        let found = search.refine(Pose2::new(start.x, start.y, theta), &scan);
        assert_eq!(found.log_likelihood, search.field().log_likelihood(found.pose, &scan));
        distances.push(found.pose.distance(truth));
        turns.push(angle::difference(found.pose.theta, truth.theta).abs().to_degrees());
    }
    distances.sort_by(f64::total_cmp);
    turns.sort_by(f64::total_cmp);
    println!("medians {:.4} m, {:.3} deg", distances[7], turns[7]);
    assert!(distances[7] < 0.016 && turns[7] < 0.2, "{distances:?} {turns:?}");
}
