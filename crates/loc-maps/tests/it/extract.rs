use loc_core::Pose2;
use loc_maps::grid::{GridFrame, Occupancy};
use loc_maps::topological::{ExtractSettings, PlaceKind};
use loc_maps::{LineMap, LineSegment, OccupancyGrid, TopologicalMap};
use nalgebra::Point2;
use proptest::prelude::*;

/// A corridor of 16 m x 2 m with four rooms of 4 m x 4 m on each side, doors of 0.9 m, and a table
/// in each room.
fn office() -> LineMap {
    let mut lines = vec![[0.0, 0.0, 16.0, 0.0], [0.0, 10.0, 16.0, 10.0]];
    lines.extend([[0.0, 0.0, 0.0, 10.0], [16.0, 0.0, 16.0, 10.0]]);
    for k in 0..4 {
        let x = 4.0 * f64::from(k);
        for (wall, far) in [(4.0, 0.0), (6.0, 10.0)] {
            lines.push([x, wall, x, far]);
            lines.extend([[x, wall, x + 1.0, wall], [x + 1.9, wall, x + 4.0, wall]]);
            let table = f64::midpoint(wall, far);
            lines
                .extend([[x + 1.5, table, x + 2.5, table], [x + 2.5, table, x + 2.5, table + 0.6]]);
        }
    }
    LineMap::new(lines.iter().map(|l| LineSegment::new([l[0], l[1]], [l[2], l[3]]))).unwrap()
}

fn of_kind(map: &TopologicalMap, kind: PlaceKind) -> Vec<usize> {
    (0..map.places().len()).filter(|&k| map.places()[k].kind == kind).collect()
}

#[test]
fn an_office_is_its_rooms_its_corridor_and_its_doors() {
    // Turned and moved, so that the frame counts.
    let pose = Pose2::new(3.0, -2.0, 0.7);
    let moved = |p: &Point2<f64>| pose.transform(p);
    let lines = office();
    let lines =
        lines.lines().iter().map(|l| LineSegment { start: moved(&l.start), end: moved(&l.end) });
    let lines = LineMap::new(lines).unwrap();
    let grid = lines
        .rasterize(&GridFrame::new(325, 205, 0.05, pose * Pose2::new(-0.1, -0.1, 0.0)).unwrap());
    let map = TopologicalMap::from_grid(&grid, &ExtractSettings::default()).unwrap();

    let rooms = of_kind(&map, PlaceKind::Room);
    let corridors = of_kind(&map, PlaceKind::Corridor);
    let doors = of_kind(&map, PlaceKind::Door);
    assert_eq!((rooms.len(), corridors.len(), doors.len()), (8, 1, 8), "{}", map.to_toml());
    let corridor = corridors[0];
    assert!((map.places()[corridor].width.unwrap() - 2.0).abs() < 0.15);
    for k in 0..8 {
        let x = 4.0 * f64::from(k / 2) + 0.5;
        let corner = moved(&Point2::new(x, if k % 2 == 0 { 3.5 } else { 6.5 }));
        let room = map.places_at(&corner).next().unwrap();
        assert!(rooms.contains(&room));
        assert!((map.places()[room].area() - 16.0).abs() < 1.5);
        let route = map.shortest_path(room, corridor).unwrap();
        assert_eq!(route.places.len(), 3);
        let door = &map.places()[route.places[1]];
        let wall = if k % 2 == 0 { 4.0 } else { 6.0 };
        let expected = moved(&Point2::new(x + 0.95, wall));
        assert!(nalgebra::distance(&door.position, &expected) < 0.15, "{door:?} {expected}");
        assert!((door.width.unwrap() - 0.9).abs() < 0.16, "{door:?}");
    }
    for edge in map.edges() {
        let straight = edge.between.map(|place| map.places()[place].position);
        assert!(edge.length >= nalgebra::distance(&straight[0], &straight[1]) - 1e-9);
        assert!(edge.via.iter().all(|p| grid.occupancy_at(p) == Occupancy::Free));
    }
    let again = TopologicalMap::parse_toml("office.toml", &map.to_toml()).unwrap();
    assert_eq!(again, map);
}

#[test]
fn without_walls_there_is_one_place_and_without_floor_none() {
    let frame = GridFrame::new(100, 60, 0.1, Pose2::IDENTITY).unwrap();
    let settings = ExtractSettings::default();
    let hall = TopologicalMap::from_grid(&OccupancyGrid::filled(frame, 0), &settings).unwrap();
    assert_eq!((hall.places().len(), hall.edges().len()), (1, 0));
    assert_eq!(hall.places()[0].outline.len(), 4);
    assert!((hall.places()[0].area() - 60.0).abs() < 1e-9);
    for value in [-1, 50, 100] {
        let solid = OccupancyGrid::filled(frame, value);
        assert!(TopologicalMap::from_grid(&solid, &settings).unwrap().places().is_empty());
    }
}

#[test]
fn absurd_settings_are_refused() {
    let frame = GridFrame::new(4, 4, 0.1, Pose2::IDENTITY).unwrap();
    let grid = OccupancyGrid::filled(frame, 0);
    let base = ExtractSettings::default();
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        for settings in [
            ExtractSettings { max_door_width: bad, ..base },
            ExtractSettings { narrowing: bad, ..base },
            ExtractSettings { openness: bad, ..base },
            ExtractSettings { min_width: bad, ..base },
            ExtractSettings { min_area: bad, ..base },
            ExtractSettings { max_clutter: bad, ..base },
            ExtractSettings { robot_radius: bad, ..base },
            ExtractSettings { elongation: bad, ..base },
        ] {
            assert!(TopologicalMap::from_grid(&grid, &settings).is_err(), "{settings:?}");
        }
    }
}

proptest! {
    #[test]
    fn any_grid_gives_a_sound_map(
        width in 1..30_usize,
        cells in prop::collection::vec(prop_oneof![3 => Just(0_i8), 1 => Just(100), 1 => Just(-1)], 1..600),
        small in any::<bool>(),
    ) {
        let height = cells.len() / width;
        prop_assume!(height > 0);
        let frame = GridFrame::new(width, height, 0.5, Pose2::new(1.0, 2.0, 0.3)).unwrap();
        let grid = OccupancyGrid::new(frame, cells[..width * height].to_vec()).unwrap();
        let fine = ExtractSettings {
            min_area: 0.0, min_width: 0.0, robot_radius: 0.0, max_clutter: 0.0, narrowing: 1.0, openness: 1.0,
            ..ExtractSettings::default()
        };
        let settings = if small { fine } else { ExtractSettings::default() };
        let map = TopologicalMap::from_grid(&grid, &settings).unwrap();
        for (index, place) in map.places().iter().enumerate() {
            if place.kind == PlaceKind::Door {
                prop_assert_eq!(map.neighbours(index).len(), 2);
            } else {
                prop_assert!(place.area() > 0.1, "{place:?}");
            }
        }
        prop_assert_eq!(TopologicalMap::from_grid(&grid, &settings).unwrap(), map);
    }
}

#[test]
fn real_buildings_are_one_connected_graph() {
    let Some(folder) = crate::data("carmen") else { return };
    for (name, rooms, corridors) in [("intel", 12..18, 2..4), ("freiburg-079", 10..16, 1..3)] {
        let grid = loc_maps::grid::io::load(folder.join(format!("{name}.yaml"))).unwrap();
        let map = TopologicalMap::from_grid(&grid, &ExtractSettings::default()).unwrap();
        assert!(rooms.contains(&of_kind(&map, PlaceKind::Room).len()), "{name}");
        assert!(corridors.contains(&of_kind(&map, PlaceKind::Corridor).len()), "{name}");
        for (index, place) in map.places().iter().enumerate() {
            assert!(map.shortest_path(0, index).is_some(), "{name}: {}", place.name);
            assert_eq!(
                grid.occupancy_at(&place.position),
                Occupancy::Free,
                "{name}: {}",
                place.name
            );
            let inside = place.outline.is_empty() || place.contains(&place.position);
            assert!(inside, "{name}: {}", place.name);
        }
    }
}
