use loc_core::Pose2;
use loc_maps::grid::{GridFrame, Occupancy};
use loc_maps::topological::{Edge, ExtractSettings, Place, PlaceKind};
use loc_maps::{Error, LineMap, LineSegment, OccupancyGrid, TopologicalMap};
use nalgebra::Point2;
use proptest::prelude::*;

const FLAT: &str = r#"# measured by hand
[[place]]
name = "kitchen"
kind = "room"
position = [1.0, 2.0]
outline = [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [0, 4]]

[[place]]
name = "door \"A\""
kind = "door"
position = [3.0, 2.0]
width = 0.9

[[place]]
name = "hall"
kind = "corridor"
position = [4.0, 2]

[[edge]]
between = ["kitchen", "door \"A\""]

[[edge]]
between = ["door \"A\"", "hall"]
length = 3.5
"#;

#[test]
fn toml_is_read_and_written_to_the_bit() {
    let map = TopologicalMap::parse_toml("flat.toml", FLAT).unwrap();
    assert_eq!((map.places().len(), map.edges().len()), (3, 2));
    assert_eq!(map.places()[1].width, Some(0.9));
    assert_eq!(map.edges()[0], Edge::new(0, 1, 2.0));
    assert_eq!(map.neighbours(1), [(0, 2.0), (2, 3.5)]);
    assert!(map.neighbours(9).is_empty());
    assert_eq!(map.find("hall"), Some(2));
    let again = TopologicalMap::parse_toml("again.toml", &map.to_toml()).unwrap();
    assert_eq!(again, map);

    let route = map.shortest_path(0, 2).unwrap();
    assert_eq!((route.places, route.length), (vec![0, 1, 2], 5.5));
    assert_eq!(map.shortest_path(1, 1).unwrap().places, [1]);
    assert_eq!(map.shortest_path(0, 7), None);
    assert_eq!(map.places_at(&[2.9, 3.9].into()).collect::<Vec<_>>(), [0]);
    assert_eq!(map.places_at(&[3.1, 3.9].into()).count(), 0);
    assert_eq!(map.nearest(&[4.5, 2.0].into()), Some((2, 0.5)));
    assert_eq!(map.bounds().unwrap().width(), 4.0);
}

#[test]
fn bad_toml_says_where_and_why() {
    for (from, to, message) in [
        ("[1.0, 2.0]", "[1.0, nan]", "flat.toml:5: position [m]: expected a finite number"),
        ("[1.0, 2.0]", "[1.0]", "flat.toml:5: invalid length 1, expected an array of length 2"),
        ("[1.0, 2.0]", "\"here\"", "flat.toml:5: invalid type: string \"here\", expected"),
        (
            "kind = \"room\"",
            "kind = \"cave\"",
            "flat.toml:4: unknown variant `cave`, expected one of",
        ),
        ("position = [1.0, 2.0]\n", "", "flat.toml:2: missing field `position`"),
        ("width = 0.9", "wide = 0.9", "flat.toml:12: unknown field `wide`, expected one of"),
        ("width = 0.9", "width = -1", "flat.toml:12: width [m]: expected a finite number >= 0"),
        ("\"hall\"\n", "\"kitchen\"\n", "flat.toml:15: name: expected one place called `kitchen`"),
        (
            "\", \"hall\"]",
            "\", \"hell\"]",
            "flat.toml:23: between: expected the name of a place, got `hell`",
        ),
        (
            "\", \"hall\"]",
            "\", \"kitchen\"]",
            "flat.toml:23: between: expected two different places",
        ),
        ("[0, 4]]", "[0, 4e9]]", "flat.toml:6: outline [m]: expected"),
        ("3.5", "inf", "flat.toml:24: length [m]: expected a finite number >= 0, got inf"),
        ("[[edge]]", "[[edge", "flat.toml:19: "),
    ] {
        assert!(FLAT.contains(from), "{from}");
        let error = TopologicalMap::parse_toml("flat.toml", &FLAT.replace(from, to)).unwrap_err();
        assert!(error.to_string().starts_with(message), "{error}\nexpected {message}");
        assert!(!error.to_string().contains('\n'), "{error}");
    }
    let empty = TopologicalMap::parse_toml("flat.toml", "# nothing\n").unwrap_err();
    assert_eq!(empty.to_string(), "flat.toml: places: the file holds none");
    assert!(
        TopologicalMap::read_toml("nowhere.toml").unwrap_err().to_string().starts_with("nowhere")
    );
}

#[test]
fn graphs_that_cannot_be_are_refused() {
    let places = || ["a", "b"].map(|name| Place::new(name, PlaceKind::Room, 0.0, 0.0));
    let edge = Edge::new;
    let new = |edges: &[Edge]| TopologicalMap::new(places(), edges.iter().cloned());
    assert!(new(&[edge(0, 1, 1.0)]).is_ok());
    assert!(matches!(new(&[edge(0, 2, 1.0)]), Err(Error::UnknownPlace { found: 2, .. })));
    assert!(matches!(new(&[edge(1, 1, 1.0)]), Err(Error::UselessEdge { .. })));
    let twice = [edge(0, 1, 1.0), edge(1, 0, 2.0)];
    assert!(matches!(new(&twice), Err(Error::UselessEdge { edge: 1, .. })));
    for length in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(new(&[edge(0, 1, length)]).is_err());
    }
    let same = ["a", "a"].map(|name| Place::new(name, PlaceKind::Room, 0.0, 0.0));
    assert!(matches!(TopologicalMap::new(same, []), Err(Error::DuplicatePlace { .. })));
    let nowhere = Place::new("a", PlaceKind::Room, f64::NAN, 0.0);
    assert!(TopologicalMap::new([nowhere], []).is_err());
    let empty = TopologicalMap::default();
    assert!(empty.bounds().is_none() && empty.nearest(&[0.0, 0.0].into()).is_none());
}

proptest! {
    #[test]
    fn shortest_paths_agree_with_relaxing_all_edges(
        count in 1..15_usize,
        edges in prop::collection::vec((0..15_usize, 0..15_usize, 0.0..10.0), 0..40),
    ) {
        let places = (0..count).map(|k| Place::new(format!("p{k}"), PlaceKind::Room, 0.0, 0.0));
        let mut joined = std::collections::HashSet::new();
        let edges: Vec<Edge> = edges
            .into_iter()
            .filter(|(a, b, _)| a < b && *b < count && joined.insert((*a, *b)))
            .map(|(a, b, length)| Edge::new(a, b, length))
            .collect();
        let map = TopologicalMap::new(places, edges.iter().cloned()).unwrap();
        let mut expected = vec![f64::INFINITY; count];
        expected[0] = 0.0;
        for _ in 0..count {
            for Edge { between: [a, b], length, .. } in &edges {
                expected[*b] = expected[*b].min(expected[*a] + length);
                expected[*a] = expected[*a].min(expected[*b] + length);
            }
        }
        for (to, expected) in expected.iter().enumerate() {
            let route = map.shortest_path(0, to);
            prop_assert_eq!(route.is_some(), expected.is_finite());
            let Some(route) = route else { continue };
            prop_assert!((route.length - expected).abs() < 1e-9);
            let steps = route.places.windows(2).map(|step| {
                let mut ways = map.neighbours(step[0]).iter();
                ways.find(|(next, _)| *next == step[1]).unwrap().1
            });
            prop_assert!((steps.sum::<f64>() - expected).abs() < 1e-9);
            prop_assert_eq!((route.places[0], *route.places.last().unwrap()), (0, to));
        }
    }
}

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
