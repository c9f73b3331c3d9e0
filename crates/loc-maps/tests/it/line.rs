use approx::assert_relative_eq;
use loc_core::Pose2;
use loc_maps::line::VisibleLine;
use loc_maps::{Error, LineMap, LineSegment};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

fn map(lines: &[[f64; 4]]) -> LineMap {
    LineMap::new(lines.iter().map(|l| LineSegment::new([l[0], l[1]], [l[2], l[3]]))).unwrap()
}

fn square(half: f64) -> LineMap {
    let h = half;
    map(&[[-h, -h, h, -h], [h, -h, h, h], [h, h, -h, h], [-h, h, -h, -h]])
}

/// Lines on a coarse lattice, so that common ends, crossings and parallels abound.
fn lattice_lines() -> impl Strategy<Value = Vec<[f64; 4]>> {
    let line = prop::array::uniform4(-8..=8_i32)
        .prop_filter("length", |l| (l[0], l[1]) != (l[2], l[3]))
        .prop_map(|l| l.map(|c| f64::from(c) * 0.5));
    prop::collection::vec(line, 1..40)
}

fn any_lines() -> impl Strategy<Value = Vec<[f64; 4]>> {
    prop::collection::vec(prop::array::uniform4(-10.0..10.0), 1..200)
}

fn brute_force(map: &LineMap, origin: &Point2<f64>, direction: f64, range: f64) -> Option<f64> {
    let hits = map.lines().iter().filter_map(|line| line.cast(origin, direction));
    hits.filter(|far| *far <= range).min_by(f64::total_cmp)
}

proptest! {
    #[test]
    fn rays_agree_with_brute_force(
        lines in prop_oneof![lattice_lines(), any_lines()],
        at in prop::array::uniform2(-9..=9_i32),
        turn in -8..=8_i32,
        free in -PI..PI,
        range in prop_oneof![Just(f64::INFINITY), 0.0..10.0],
    ) {
        let map = map(&lines);
        let origin = Point2::new(f64::from(at[0]) * 0.5, f64::from(at[1]) * 0.5);
        for direction in [f64::from(turn) * FRAC_PI_4, free] {
            let expected = brute_force(&map, &origin, direction, range);
            prop_assert_eq!(map.cast(&origin, direction, range), expected);
            let hit = map.ray(&origin, direction, range);
            prop_assert_eq!(hit.map(|hit| hit.distance), expected);
            if let Some(hit) = hit {
                prop_assert!(map.lines()[hit.line].distance(&hit.point) < 1e-9);
            }
        }
    }

    #[test]
    fn nearest_agrees_with_brute_force(lines in any_lines(), at in prop::array::uniform2(-20.0..20.0)) {
        let (map, point) = (map(&lines), Point2::from(at));
        let nearest = map.nearest(&point).unwrap();
        let least = map.lines().iter().map(|l| l.distance(&point)).min_by(f64::total_cmp).unwrap();
        prop_assert!((nearest.distance - least).abs() < 1e-12);
        prop_assert!((nalgebra::distance(&nearest.point, &point) - least).abs() < 1e-12);
    }

    #[test]
    fn what_rays_hit_is_visible_and_nothing_else(
        lines in prop_oneof![lattice_lines(), any_lines()],
        at in prop::array::uniform3(-4.0..4.0),
        fov in 0.1..7.0,
        range in prop_oneof![Just(f64::INFINITY), 0.5..10.0],
    ) {
        let map = map(&lines);
        let pose = Pose2::new(at[0], at[1], at[2]);
        let seen = map.visible_lines(pose, fov, range).unwrap();
        let half = fov.min(TAU) / 2.0;
        for k in 0..200 {
            let relative = -half + (f64::from(k) + 0.5) / 200.0 * 2.0 * half;
            let Some(hit) = map.ray(&pose.position(), pose.theta + relative, range) else { continue };
            // Lines may lie on each other: then one of them is visible there.
            prop_assert!(seen.iter().any(|line| covers(&map, line, &hit.point)), "{hit:?} {seen:?}");
        }
        for line in &seen {
            for &[from, to] in &line.parts {
                let middle = map.lines()[line.line].at((from + to) / 2.0);
                let to_middle = middle - pose.position();
                prop_assert!(to_middle.norm() <= range + 1e-6);
                let direction = to_middle.y.atan2(to_middle.x);
                if to - from > 1e-6 {
                    let hit = map.ray(&pose.position(), direction, f64::INFINITY).unwrap();
                    prop_assert!((hit.distance - to_middle.norm()).abs() < 1e-5, "{line:?} {hit:?}");
                }
            }
        }
    }
}

fn covers(map: &LineMap, seen: &VisibleLine, point: &Point2<f64>) -> bool {
    let line = map.lines()[seen.line];
    let fraction = line.nearest_fraction(point);
    line.distance(point) < 1e-6
        && seen.parts.iter().any(|[from, to]| (from - 1e-6..=to + 1e-6).contains(&fraction))
}

#[test]
fn rays_meet_ends_corners_and_lines_along_them() {
    let room = square(1.0);
    // Into the corner, where two lines meet: nothing slips through.
    for (k, corner) in [[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]].iter().enumerate() {
        let direction = FRAC_PI_4 + k as f64 * FRAC_PI_2;
        let hit = room.ray(&[0.0, 0.0].into(), direction, 10.0).unwrap();
        assert_relative_eq!(hit.point, Point2::from(*corner), epsilon = 1e-12);
    }
    let wall = map(&[[2.0, 0.0, 3.0, 0.0]]);
    let cast = |x: f64, y: f64, direction: f64| wall.cast(&[x, y].into(), direction, 10.0);
    assert_eq!(cast(0.0, 0.0, 0.0), Some(2.0), "along the line: its nearer end");
    assert_eq!(cast(2.5, 0.0, 0.0), Some(0.0), "starting on it");
    assert_eq!(cast(2.5, 0.0, 1.0), Some(0.0));
    assert_eq!(cast(3.0, 0.0, 0.0), Some(0.0), "starting on its end");
    assert_eq!(cast(4.0, 0.0, 0.0), None, "behind");
    assert_eq!(cast(2.5, 1e-6, 0.0), None, "parallel");
    assert_relative_eq!(cast(2.0, -1.0, FRAC_PI_2).unwrap(), 1.0, epsilon = 1e-12);
    assert_eq!(wall.cast(&[0.0, 0.0].into(), 0.0, 1.9), None, "out of range");
    assert_eq!(wall.cast(&[0.0, 0.0].into(), 0.0, 2.0), Some(2.0), "just in range");
    for bad in [f64::NAN, f64::INFINITY] {
        assert_eq!(cast(bad, 0.0, 0.0), None);
        assert_eq!(cast(0.0, 0.0, bad), None);
    }
    assert_eq!(wall.cast(&[0.0, 0.0].into(), 0.0, f64::NAN), None);
    assert_eq!(wall.cast(&[2.5, 0.0].into(), 0.0, -1.0), None);
}

#[test]
fn a_room_is_seen_in_normal_form() {
    let pose = Pose2::new(0.25, 0.0, FRAC_PI_2);
    let seen = square(1.0).visible_lines(pose, TAU, 10.0).unwrap();
    let expected = [(1.0, PI), (0.75, -FRAC_PI_2), (1.0, 0.0), (1.25, FRAC_PI_2)];
    assert_eq!(seen.len(), 4);
    for (line, (r, alpha)) in seen.iter().zip(expected) {
        assert_relative_eq!(line.normal_form.r, r, epsilon = 1e-12);
        assert!(loc_core::angle::difference(line.normal_form.alpha, alpha).abs() < 1e-12);
        assert_relative_eq!(line.share(), 1.0, epsilon = 1e-6);
        assert_relative_eq!(line.visible_length(), 2.0, epsilon = 1e-5);
        assert!(line.normal_form.signed_distance(&line.segment.at(0.3)).abs() < 1e-12);
    }
}

#[test]
fn hidden_and_distant_parts_are_cut_away() {
    // A pillar before a wall, seen at 90 degrees.
    let map = map(&[[2.0, -1.0, 2.0, 1.0], [4.0, -8.0, 4.0, 8.0]]);
    let seen = map.visible_lines(Pose2::IDENTITY, FRAC_PI_2, 100.0).unwrap();
    let wall = &seen[1];
    assert_eq!(wall.parts.len(), 2);
    for (part, ends) in wall.parts.iter().zip([[-4.0, -2.0], [2.0, 4.0]]) {
        for (fraction, y) in part.iter().zip(ends) {
            assert_relative_eq!(-8.0 + 16.0 * fraction, y, epsilon = 1e-6);
        }
    }
    let near = map.visible_lines(Pose2::IDENTITY, FRAC_PI_2, 5.0).unwrap();
    assert_relative_eq!(near[1].visible_length(), 2.0, epsilon = 1e-5);
    let ahead = map.visible_lines(Pose2::IDENTITY, FRAC_PI_2, 3.9).unwrap();
    assert_eq!(ahead.iter().map(|line| line.line).collect::<Vec<_>>(), [0]);
    let away = map.visible_lines(Pose2::new(0.0, 0.0, PI), FRAC_PI_2, 9.0).unwrap();
    assert!(away.is_empty());
}

#[test]
fn crossing_lines_hide_each_other_in_turn() {
    let map = map(&[[2.0, -1.0, 4.0, 1.0], [4.0, -1.0, 2.0, 1.0]]);
    let seen = map.visible_lines(Pose2::IDENTITY, PI, 10.0).unwrap();
    assert_eq!(seen.len(), 2);
    for line in &seen {
        assert_eq!(line.parts.len(), 1);
        assert_relative_eq!(line.share(), 0.5, epsilon = 1e-6);
    }
}

#[test]
fn lines_on_each_other_are_seen_once() {
    let twice = map(&[[2.0, -1.0, 2.0, 1.0], [2.0, 1.0, 2.0, -1.0], [2.0, -0.5, 2.0, 2.0]]);
    let seen = twice.visible_lines(Pose2::new(0.0, 0.1, 0.3), PI, 10.0).unwrap();
    let length: f64 = seen.iter().map(VisibleLine::visible_length).sum();
    assert_relative_eq!(length, 3.0, epsilon = 1e-4);
    let on_it = twice.visible_lines(Pose2::new(2.0, 0.1, 0.3), TAU, 10.0).unwrap();
    assert!(on_it.is_empty(), "{on_it:?}");
}

#[test]
fn absurd_views_are_refused() {
    let map = square(1.0);
    let error = |pose, fov, range| map.visible_lines(pose, fov, range).unwrap_err().to_string();
    let here = Pose2::IDENTITY;
    assert!(error(Pose2::new(f64::NAN, 0.0, 0.0), 1.0, 1.0).contains("got NaN"));
    assert!(error(here, 0.0, 1.0).starts_with("field of view [rad]: expected"));
    assert!(error(here, 1.0, -1.0).starts_with("greatest range [m]: expected"));
    assert!(error(here, 1.0, f64::NAN).contains("got NaN"));
}

#[test]
fn csv_round_trip_to_the_bit() {
    let map = map(&[[0.1 + 0.2, -1e-17, 1.0 / 3.0, 1e5], [1.0, 2.0, 3.0, 4.0]]);
    assert_eq!(LineMap::parse_csv("map.csv", &map.to_csv()).unwrap(), map);
    let spaced = LineMap::parse_csv("map.txt", "# walls\n1 2  3 4\n\n 5\t6 7 8 \n").unwrap();
    assert_eq!(spaced.lines()[1], LineSegment::new([5.0, 6.0], [7.0, 8.0]));
    let bounds = spaced.bounds().unwrap();
    assert_eq!((bounds.min, bounds.max), ([1.0, 2.0].into(), [7.0, 8.0].into()));
}

#[test]
fn bad_csv_says_where_and_why() {
    for (text, message) in [
        ("1,2,3,4\n1,2,a,4\n", "map.csv:2: x2: expected a finite number, got `a`"),
        ("1,NaN,3,4\n", "map.csv:1: y1: expected a finite number, got `NaN`"),
        ("1 2 3\n", "map.csv:1: y2: expected a value, got the end of the line after 3 columns"),
        ("1,2,3,4,5\n", "map.csv:1: line: expected 4 columns (x1 y1 x2 y2), got 5 columns"),
        (
            "0,0,1,0\n1,2,1,2.0\n",
            "map.csv:2: x2,y2: expected another point than x1,y1, got `1,2.0`",
        ),
        ("1,2,3e6,4\n", "map.csv:1: x2: expected a number from -1e6 to 1e6, got `3e6`"),
        ("# nothing\n", "map.csv: lines: the file holds none"),
    ] {
        assert_eq!(LineMap::parse_csv("map.csv", text).unwrap_err().to_string(), message);
    }
    let missing = LineMap::read_csv("nowhere.csv").unwrap_err().to_string();
    assert!(missing.starts_with("nowhere.csv: "), "{missing}");
}

#[test]
fn bad_lines_are_refused() {
    let point = LineSegment::new([1.0, 1.0], [1.0, 1.0]);
    assert!(matches!(LineMap::new([point]), Err(Error::LineWithoutLength { .. })));
    let vanishing = LineSegment::new([0.0, 0.0], [1e-200, 0.0]);
    assert!(matches!(LineMap::new([vanishing]), Err(Error::LineWithoutLength { .. })));
    assert!(LineMap::new([LineSegment::new([1.0, f64::NAN], [1.0, 1.0])]).is_err());
    let empty = LineMap::new([]).unwrap();
    assert!(empty.is_empty() && empty.bounds().is_none());
    assert!(empty.nearest(&[0.0, 0.0].into()).is_none());
    assert!(empty.visible_lines(Pose2::IDENTITY, 1.0, 1.0).unwrap().is_empty());
    let nan = [f64::NAN, 0.0].into();
    assert!(square(1.0).nearest(&nan).is_none());
}

#[test]
fn real_buildings_load() {
    let Some(folder) = crate::data("line_maps") else { return };
    for (name, count) in [("AHG2", 1270), ("AHGHallway", 39), ("GHC7", 2171)] {
        let map = LineMap::read_csv(folder.join(format!("{name}.vectormap.txt"))).unwrap();
        assert_eq!(map.len(), count);
        let center = map.bounds().unwrap().center();
        for k in 0..500 {
            let direction = f64::from(k) * 0.01;
            let expected = brute_force(&map, &center, direction, 50.0);
            assert_eq!(map.cast(&center, direction, 50.0), expected);
        }
        let pose = Pose2::new(center.x, center.y, 0.3);
        let seen = map.visible_lines(pose, TAU, 20.0).unwrap();
        assert!(seen.iter().all(|line| line.share() <= 1.0 + 1e-9));
    }
}
