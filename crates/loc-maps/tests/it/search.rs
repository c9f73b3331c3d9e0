//! Global search against brute force, on maps of all kinds.

use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, angle};
use loc_maps::grid::{Cell, GridFrame, Occupancy};
use loc_maps::likelihood_field::{
    Endpoints, LikelihoodField, LikelihoodFieldSettings, OffMap, UnknownSpace,
};
use loc_maps::{GlobalSearch, SearchSettings};
use loc_maps::{LikelihoodField as Field, OccupancyGrid};
use nalgebra::Point2;
use rand::RngExt;
use std::f64::consts::TAU;

/// A map of free, occupied and unknown cells, turned and moved.
fn random_map([width, height]: [usize; 2], rng: &mut ChaCha8Rng) -> OccupancyGrid {
    let origin = Pose2::new(rng.random_range(-9.0..9.0), 3.0, rng.random_range(-3.1..3.1));
    let frame = GridFrame::new(width, height, 0.1, origin).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    for _ in 0..width * height / 12 {
        let cell = Cell::new(rng.random_range(0..width), rng.random_range(0..height));
        grid.set(cell, if rng.random() { 100 } else { -1 }).unwrap();
    }
    grid
}

fn random_ends(beams: usize, reach: f64, rng: &mut ChaCha8Rng) -> Endpoints {
    let mut end = || [rng.random_range(-reach..reach), rng.random_range(-reach..reach)];
    (0..beams).map(|_| end()).collect()
}

/// All poses of the search's grid with their sums of codes, best first: every beam by itself, in
/// the map's coordinates.
fn rate_all(
    map: &OccupancyGrid,
    field: &Field,
    endpoints: &Endpoints,
    headings: usize,
) -> Vec<(u64, Pose2)> {
    let lowest = field.log_likelihood_of(0, 1);
    let code = |log: f64| ((log - lowest) / field.code_step()).round() as u64;
    let of_cell = |cell| code(field.log_likelihood_at(&map.frame().center(cell)));
    let codes: Vec<u64> = map.frame().cells().map(of_cell).collect();
    let off_map = code(field.log_likelihood_at(&Point2::new(1e6, 1e6)));
    let ends: Vec<Point2<f64>> = endpoints
        .xs()
        .iter()
        .zip(endpoints.ys())
        .map(|(&x, &y)| Point2::new(f64::from(x), f64::from(y)))
        .collect();
    let free: Vec<Point2<f64>> = map.centers_of(Occupancy::Free).collect();
    let mut all = Vec::new();
    for heading in 0..headings {
        let theta = heading as f64 * TAU / headings as f64;
        for at in &free {
            let pose = Pose2::new(at.x, at.y, theta);
            let beam = |end: &Point2<f64>| {
                let cell = map.frame().cell_at(&pose.transform(end));
                cell.and_then(|cell| map.frame().index(cell)).map_or(off_map, |k| codes[k])
            };
            all.push((ends.iter().map(beam).sum(), pose));
        }
    }
    // Stable: equal sums stay in the order of heading, row and column.
    all.sort_by_key(|(sum, _)| std::cmp::Reverse(*sum));
    all
}

/// The answers by the definition.
fn brute_force(
    map: &OccupancyGrid,
    field: &Field,
    endpoints: &Endpoints,
    settings: &SearchSettings,
) -> Vec<Pose2> {
    let headings = (TAU / settings.angle_step).round() as usize;
    let all = rate_all(map, field, endpoints, headings);
    let mean = |sum| field.log_likelihood_of(sum, endpoints.len()) / endpoints.len() as f64;
    let floor = mean(all[0].0) - settings.within - 1e-9;
    let floor = floor.max(settings.least.unwrap_or(f64::NEG_INFINITY));
    let mut answers: Vec<Pose2> = Vec::new();
    for &(_, pose) in all.iter().take_while(|(sum, _)| mean(*sum) >= floor) {
        let apart = |other: &Pose2| {
            let turn = angle::difference(pose.theta, other.theta).abs();
            pose.distance(*other) >= settings.separation_distance - 1e-9
                || turn >= settings.separation_angle - 1e-9
        };
        if answers.len() < settings.candidates && answers.iter().all(apart) {
            answers.push(pose);
        }
    }
    answers
}

fn same(a: &Pose2, b: &Pose2) -> bool {
    a.distance(*b) < 1e-9 && angle::difference(a.theta, b.theta).abs() < 1e-9
}

fn check(map: &OccupancyGrid, field: &Field, endpoints: &Endpoints, settings: &SearchSettings) {
    let expected = brute_force(map, field, endpoints, settings);
    let search = GlobalSearch::new(map, field.clone(), settings.clone()).unwrap();
    let found = search.search(endpoints).unwrap();
    let poses: Vec<Pose2> = found.iter().map(|candidate| candidate.pose).collect();
    let equal =
        poses.len() == expected.len() && poses.iter().zip(&expected).all(|(a, b)| same(a, b));
    assert!(equal, "{settings:?}: {poses:?} is not {expected:?}");
    for candidate in found {
        let rated = field.log_likelihood(candidate.pose, endpoints);
        assert_eq!(candidate.log_likelihood, rated);
    }
}

/// 0.35 m apart is between the centres of no two cells of 0.1 m; the same for turns.
fn settings(candidates: usize) -> SearchSettings {
    SearchSettings {
        angle_step: 6_f64.to_radians(),
        candidates,
        separation_distance: 0.35,
        separation_angle: 15_f64.to_radians(),
        within: 1.0,
        refine: false,
        ..SearchSettings::default()
    }
}

#[test]
fn the_answers_are_those_of_brute_force() {
    let mut rng = stream(1, "global");
    let sizes = [[37, 23], [16, 16], [70, 9], [1, 60], [65, 33]];
    for (number, size) in sizes.into_iter().enumerate() {
        let map = random_map(size, &mut rng);
        let mut field = LikelihoodFieldSettings::nav2().max_distance(0.5);
        if number % 2 == 1 {
            field.unknown_space = UnknownSpace::Likelihood(0.2);
            field.off_map = OffMap::Likelihood(0.3);
        }
        let field = LikelihoodField::new(&map, &field).unwrap();
        let reach = [1.0, 3.0][number % 2];
        let endpoints = random_ends([21, 9, 34][number % 3], reach, &mut rng);
        for candidates in [1, 2, 7] {
            check(&map, &field, &endpoints, &settings(candidates));
        }
        let near = SearchSettings { within: 0.02, ..settings(50) };
        check(&map, &field, &endpoints, &near);
        let least = Some(field.log_likelihood_of(180, 1));
        check(&map, &field, &endpoints, &SearchSettings { least, ..settings(50) });
        // No separation: simply the best poses, neighbours and all.
        let crowd = SearchSettings { separation_distance: 0.0, ..settings(100) };
        check(&map, &field, &endpoints, &crowd);
    }
}

/// With one beam or two thousands of poses are equally good, and only the order counts.
#[test]
fn ties_are_broken_as_by_brute_force() {
    let mut rng = stream(2, "global");
    let map = random_map([40, 30], &mut rng);
    let field = LikelihoodField::new(&map, &LikelihoodFieldSettings::nav2()).unwrap();
    for beams in [1, 2] {
        let endpoints = random_ends(beams, 1.0, &mut rng);
        for candidates in [1, 3, 40] {
            check(&map, &field, &endpoints, &settings(candidates));
        }
    }
}

/// All poses within some nats of the best one, none more than once; a sample of them where there
/// are too many, which says how many there are.
#[test]
fn all_ties_are_found_or_counted() {
    let mut rng = stream(7, "ties");
    for size in [[37, 23], [65, 33], [16, 70]] {
        let map = random_map(size, &mut rng);
        let settings_of_field = LikelihoodFieldSettings::nav2().max_distance(0.5);
        let field = LikelihoodField::new(&map, &settings_of_field).unwrap();
        let search = GlobalSearch::new(&map, field.clone(), settings(5)).unwrap();
        for (beams, drop) in [(1, 0.4), (3, 1.0), (20, 3.0), (20, 0.0)] {
            let endpoints = random_ends(beams, 2.0, &mut rng);
            let all = rate_all(&map, &field, &endpoints, 60);
            let floor = all[0].0 - (drop / field.code_step()) as u64;
            let expected: Vec<Pose2> =
                all.iter().filter(|(sum, _)| *sum >= floor).map(|(_, pose)| *pose).collect();
            let pose_volume = 0.1 * 0.1 * TAU / 60.0;
            let volume = expected.len() as f64 * pose_volume;

            let ties = search.ties(&endpoints, drop, usize::MAX).unwrap();
            assert_eq!(ties.poses.len(), expected.len(), "{beams} beams, {drop}");
            assert!((ties.volume - volume).abs() < 1e-9);
            let is_expected = |pose: &Pose2| expected.iter().any(|other| same(pose, other));
            assert!(ties.poses.iter().all(is_expected));

            let sample = search.ties(&endpoints, drop, 200).unwrap();
            assert!(sample.poses.len() <= 200 && sample.poses.iter().all(is_expected));
            if expected.len() > 400 {
                assert!(sample.poses.len() >= 50, "{}", sample.poses.len());
                assert!((sample.volume / volume - 1.0).abs() < 0.35, "{}", sample.volume / volume);
            }
        }
    }
}

/// Many small searches: equal sums on both sides of a lot of windows, and zones that hold whole
/// windows.
#[test]
fn lots_and_zones_lose_nothing() {
    let mut rng = stream(6, "global");
    for round in 0..120 {
        let map = random_map([36, 50], &mut rng);
        let field = LikelihoodFieldSettings::nav2().max_distance(0.4);
        let field = LikelihoodField::new(&map, &field).unwrap();
        let endpoints = random_ends(2 + round % 5, 2.0, &mut rng);
        let settings = SearchSettings {
            angle_step: 45_f64.to_radians(),
            separation_distance: [0.35, 2.45][round % 2],
            separation_angle: 60_f64.to_radians(),
            within: 3.0,
            ..settings(12)
        };
        check(&map, &field, &endpoints, &settings);
    }
}

/// 300 beams do not fit into sums of 16 bits, 70000 not into bounds of that size without loss.
#[test]
fn many_beams_do_not_overflow() {
    let mut rng = stream(3, "global");
    let map = random_map([30, 20], &mut rng);
    let field = LikelihoodField::new(&map, &LikelihoodFieldSettings::nav2()).unwrap();
    let endpoints = random_ends(300, 1.5, &mut rng);
    check(&map, &field, &endpoints, &settings(4));

    let few = random_ends(7, 1.5, &mut rng);
    let often = few.xs().iter().zip(few.ys()).cycle().take(70_000);
    let often: Endpoints = often.map(|(&x, &y)| (x, y)).collect();
    let settings = SearchSettings { angle_step: 30_f64.to_radians(), ..settings(4) };
    let search = GlobalSearch::new(&map, field.clone(), settings.clone()).unwrap();
    let poses = |ends| search.search(ends).unwrap().into_iter().map(|found| found.pose);
    assert!(
        poses(&often).eq(brute_force(&map, &field, &few, &settings)) || {
            poses(&often).zip(brute_force(&map, &field, &few, &settings)).all(|(a, b)| same(&a, &b))
        }
    );
}

/// So many windows and headings that the pyramid has a level more; few free cells, for brute
/// force to end.
#[test]
fn a_large_map_has_one_more_level() {
    let mut rng = stream(4, "global");
    let frame = GridFrame::new(1300, 1310, 0.05, Pose2::new(1.0, 2.0, 0.5)).unwrap();
    let mut map = OccupancyGrid::filled(frame, -1);
    for (count, value) in [(20_000, 100), (60, 0)] {
        for _ in 0..count {
            let cell = Cell::new(rng.random_range(0..1300), rng.random_range(0..1310));
            map.set(cell, value).unwrap();
        }
    }
    let field = LikelihoodFieldSettings::nav2().max_distance(0.3);
    let field = LikelihoodField::new(&map, &field).unwrap();
    let settings = SearchSettings { angle_step: TAU / 6200.0, ..settings(3) };
    check(&map, &field, &random_ends(6, 4.0, &mut rng), &settings);
}

#[test]
fn threads_change_nothing() {
    let mut rng = stream(5, "global");
    let map = random_map([90, 80], &mut rng);
    let field = LikelihoodField::new(&map, &LikelihoodFieldSettings::nav2()).unwrap();
    let endpoints = random_ends(20, 3.0, &mut rng);
    let search = |threads| {
        let settings = SearchSettings { threads, refine: true, ..settings(10) };
        GlobalSearch::new(&map, field.clone(), settings).unwrap().search(&endpoints).unwrap()
    };
    assert_eq!(search(1), search(3));
}
