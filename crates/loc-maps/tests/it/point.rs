use approx::assert_relative_eq;
use loc_core::Pose2;
use loc_maps::PointMap;
use loc_maps::point::PointMapBuilder;
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

fn points(list: &[[f64; 2]]) -> Vec<Point2<f64>> {
    list.iter().map(|&p| Point2::from(p)).collect()
}

fn any_points() -> impl Strategy<Value = Vec<[f64; 2]>> {
    let lattice = prop::array::uniform2((-6..=6_i32).prop_map(|c| f64::from(c) * 0.5));
    prop_oneof![
        prop::collection::vec(lattice, 1..100),
        prop::collection::vec(prop::array::uniform2(-10.0..10.0), 1..300),
    ]
}

proptest! {
    #[test]
    fn queries_agree_with_brute_force(
        list in any_points(),
        at in prop::array::uniform2(-12.0..12.0),
        radius in 0.0..8.0,
    ) {
        let (map, place) = (PointMap::new(points(&list)).unwrap(), Point2::from(at));
        let far: Vec<f64> =
            map.points().iter().map(|p| nalgebra::distance_squared(p, &place)).collect();
        let least = far.iter().copied().min_by(f64::total_cmp).unwrap();
        let nearest = map.nearest(&place).unwrap();
        prop_assert_eq!(nearest.distance, least.sqrt());
        prop_assert_eq!(far[nearest.point], least);
        prop_assert_eq!(map.nearest_within(&place, radius).is_some(), least <= radius * radius);
        let expected: Vec<usize> =
            (0..far.len()).filter(|&k| far[k] <= radius * radius).collect();
        prop_assert_eq!(map.within(&place, radius), expected);
    }

    #[test]
    fn rays_agree_with_brute_force(
        list in any_points(),
        at in prop::array::uniform2((-6..=6_i32).prop_map(|c| f64::from(c) * 0.5)),
        direction in prop_oneof![(-4..4_i32).prop_map(|k| f64::from(k) * FRAC_PI_4), -3.0..3.0],
        half_width in prop_oneof![Just(0.0), Just(0.5), 0.01..1.0],
        range in prop_oneof![Just(f64::INFINITY), 0.0..10.0],
    ) {
        let (map, origin) = (PointMap::new(points(&list)).unwrap(), Point2::from(at));
        let (sin, cos) = f64::sin_cos(direction);
        let along = nalgebra::Vector2::new(cos, sin);
        let passed = map.points().iter().map(|p| p - origin).filter_map(|to| {
            let far = to.dot(&along);
            let beside = to.perp(&along).abs() <= half_width;
            (beside && (0.0..=range).contains(&far)).then_some(far)
        });
        let expected = passed.min_by(f64::total_cmp);
        let hit = map.ray(&origin, direction, range, half_width);
        prop_assert_eq!(hit.map(|hit| hit.distance), expected);
    }
}

#[test]
fn a_wall_of_points_stops_every_beam() {
    let wall = (0..=200).map(|k| Point2::new(3.0, f64::from(k) * 0.05 - 5.0));
    let map = PointMap::new(wall).unwrap().with_half_width(0.03).unwrap();
    for k in -100..=100 {
        let direction = f64::from(k) * 0.008;
        let far = map.cast(&[0.0, 0.0].into(), direction, 30.0).unwrap();
        assert!((far * direction.cos() - 3.0).abs() < 0.03, "{k}: {far}");
    }
    assert_eq!(map.cast(&[0.0, 0.0].into(), FRAC_PI_2, 30.0), None);
    assert_eq!(map.cast(&[f64::NAN, 0.0].into(), 0.0, 30.0), None);
    assert_eq!(map.cast(&[0.0, 0.0].into(), 0.0, f64::NAN), None);
}

#[test]
fn scans_are_laid_into_the_map_and_thinned() {
    let ahead = points(&[[2.0, 0.0], [f64::INFINITY, 0.0], [f64::NAN, 1.0]]);
    let scans = [
        (Pose2::new(1.0, 1.0, FRAC_PI_2), &ahead[..]),
        (Pose2::new(1.02, 1.04, FRAC_PI_2), &ahead[..]),
        (Pose2::new(0.0, 0.0, 0.0), &ahead[..]),
    ];
    let map = PointMap::from_scans(scans, 0.5).unwrap();
    assert_eq!(map.len(), 2);
    assert_relative_eq!(map.points()[0], Point2::new(1.01, 3.02), epsilon = 1e-12);
    assert_relative_eq!(map.points()[1], Point2::new(2.0, 0.0), epsilon = 1e-12);
    let thinner = map.thinned(100.0).unwrap();
    assert_eq!(thinner.len(), 1);
    assert!(PointMap::from_scans([], 0.1).unwrap().is_empty());
}

#[test]
fn csv_round_trip_to_the_bit() {
    let map = PointMap::new(points(&[[0.1 + 0.2, -1e-17], [1.0 / 3.0, 1e5]])).unwrap();
    assert_eq!(PointMap::parse_csv("map.csv", &map.to_csv()).unwrap(), map);
    let spaced = PointMap::parse_csv("map.txt", "x y\n1 2\n# more\n3\t4\n").unwrap();
    assert_eq!(spaced.bounds().unwrap().max, [3.0, 4.0].into());
}

#[test]
fn bad_input_says_where_and_why() {
    for (text, message) in [
        ("1,2\n2,a\n", "map.csv:2: y: expected a finite number, got `a`"),
        ("inf 2\n", "map.csv:1: x: expected a finite number, got `inf`"),
        ("1\n", "map.csv:1: y: expected a value, got the end of the line after 1 columns"),
        ("1,1e300\n", "map.csv:1: y: expected a number from -1e6 to 1e6, got `1e300`"),
        ("", "map.csv: points: the file holds none"),
    ] {
        assert_eq!(PointMap::parse_csv("map.csv", text).unwrap_err().to_string(), message);
    }
    assert!(PointMap::new(points(&[[0.0, f64::NAN]])).is_err());
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(PointMapBuilder::new(bad).is_err());
        assert!(PointMap::new([]).unwrap().with_half_width(bad).is_err());
    }
    let mut builder = PointMapBuilder::new(0.1).unwrap();
    assert!(builder.add_scan(Pose2::new(f64::NAN, 0.0, 0.0), &[]).is_err());
    assert!(builder.add_scan(Pose2::IDENTITY, &points(&[[1e9, 0.0]])).is_err());
    let empty = PointMap::new([]).unwrap();
    assert!(empty.nearest(&[0.0, 0.0].into()).is_none());
    let map = PointMap::new(points(&[[0.0, 0.0]])).unwrap();
    assert!(map.nearest(&[f64::NAN, 0.0].into()).is_none());
    assert!(map.nearest_within(&[0.0, 0.0].into(), -1.0).is_none());
    assert!(map.within(&[0.0, 0.0].into(), f64::NAN).is_empty());
    assert!(map.ray(&[-1.0, 0.0].into(), 0.0, 9.0, f64::NAN).is_none());
}
