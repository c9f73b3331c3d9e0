use loc_maps::grid::{Cell, Occupancy};
use loc_maps::topological::{ExtractSettings, PlaceKind};
use loc_maps::worlds::{self, LANDMARK_COLORS, NAMES, World, WorldSettings};
use loc_maps::{Error, OccupancyGrid, TopologicalMap};
use nalgebra::Point2;
use proptest::prelude::*;

fn settings(width: usize, height: usize, resolution: f64, seed: u64) -> WorldSettings {
    WorldSettings { width, height, resolution, seed }
}

/// How many free cells can be reached over the sides of cells from the first free one.
fn reachable(grid: &OccupancyGrid) -> usize {
    let (width, height) = (grid.width(), grid.height());
    let is_free = |index: usize| Occupancy::of(grid.values()[index]) == Occupancy::Free;
    let mut seen: Vec<bool> = vec![false; width * height];
    let mut open: Vec<usize> =
        (0..width * height).find(|&index| is_free(index)).into_iter().collect();
    open.iter().for_each(|&index| seen[index] = true);
    let mut count = 0;
    while let Some(index) = open.pop() {
        count += 1;
        let (column, row) = (index % width, index / width);
        let next = [
            (column > 0).then(|| index - 1),
            (column + 1 < width).then_some(index + 1),
            (row > 0).then(|| index - width),
            (row + 1 < height).then_some(index + width),
        ];
        for next in next.into_iter().flatten() {
            if is_free(next) && !std::mem::replace(&mut seen[next], true) {
                open.push(next);
            }
        }
    }
    count
}

/// What holds for every world: the size asked for, one connected floor, walls all around it.
fn assert_sound(world: &World, settings: &WorldSettings) {
    let grid = &world.grid;
    assert_eq!((grid.width(), grid.height()), (settings.width, settings.height));
    assert_eq!(grid.resolution(), settings.resolution);
    let free = grid.counts().free;
    assert!(free > 0, "{} {settings:?}", world.name);
    assert_eq!(reachable(grid), free, "{} {settings:?}", world.name);
    for (Cell { column, row }, value) in grid.iter() {
        let at_border =
            column == 0 || row == 0 || column + 1 == settings.width || row + 1 == settings.height;
        let closed = Occupancy::of(value) != Occupancy::Free
            || (!at_border
                && [[0, 1], [2, 1], [1, 0], [1, 2]].iter().all(|[x, y]| {
                    let next = Cell::new(column + x - 1, row + y - 1);
                    grid.occupancy(next) != Occupancy::Unknown
                }));
        assert!(closed, "{} {settings:?} ({column}, {row})", world.name);
    }
    for landmark in world.landmarks.iter() {
        let on_wall = grid.occupancy_at(&landmark.position.xy());
        assert_ne!(on_wall, Occupancy::Unknown, "{} {landmark:?}", world.name);
    }
}

#[test]
fn every_world_in_its_own_size_is_sound_and_follows_its_seed() {
    for name in NAMES {
        let own = WorldSettings::suited_to(name).unwrap();
        let world = worlds::by_name(name, &own).unwrap();
        assert_eq!(world.name, name);
        assert_sound(&world, &own);
        assert_eq!(worlds::by_name(name, &own).unwrap(), world);
        let other = worlds::by_name(name, &WorldSettings { seed: 2, ..own }).unwrap();
        assert_eq!(other == world, name == "soccer-field");
    }
}

#[test]
fn offices_of_all_sizes_can_be_walked_through() {
    for resolution in [0.01, 0.05, 0.1, 0.2] {
        for (width, height) in [(60, 60), (60, 400), (333, 217), (700, 700)] {
            for seed in 0..3 {
                let settings = settings(width, height, resolution, seed);
                assert_sound(&worlds::office(&settings).unwrap(), &settings);
            }
        }
    }
    let largest = settings(4000, 4000, 0.05, 1);
    let office = worlds::office(&largest).unwrap();
    assert_eq!(reachable(&office.grid), office.grid.counts().free);
}

#[test]
fn an_office_has_rooms_corridors_and_a_plate_for_each_door() {
    let settings = settings(800, 600, 0.05, 3);
    let office = worlds::office(&settings).unwrap();
    let map = TopologicalMap::from_grid(&office.grid, &ExtractSettings::default()).unwrap();
    let of_kind = |kind| map.places().iter().filter(move |place| place.kind == kind);
    // Four rows of 40 m, rooms of 3 m to 8 m.
    assert!((16..=40).contains(&of_kind(PlaceKind::Room).count()), "{}", map.to_toml());
    assert!((1..=4).contains(&of_kind(PlaceKind::Corridor).count()), "{}", map.to_toml());
    for index in 0..map.places().len() {
        assert!(map.shortest_path(0, index).is_some());
    }
    let mut near = 0;
    for plate in office.landmarks.iter() {
        assert_eq!(plate.position.z, 1.5);
        let mut doors = of_kind(PlaceKind::Door);
        let is_near = |p: &Point2<f64>| nalgebra::distance(p, &plate.position.xy()) < 1.2;
        near += usize::from(doors.any(|door| is_near(&door.position)));
    }
    assert!(near * 10 >= office.landmarks.len() * 9, "{near} of {}", office.landmarks.len());
    let rooms = of_kind(PlaceKind::Room).filter(|room| room.area() > 5.0 && room.area() < 100.0);
    assert!(rooms.count() >= 16);
}

#[test]
fn one_seed_is_one_building_at_any_resolution() {
    let (fine, coarse) = (settings(1200, 900, 0.025, 5), settings(600, 450, 0.05, 5));
    let fine = worlds::office(&fine).unwrap();
    let coarse = worlds::office(&coarse).unwrap();
    assert_eq!(fine.landmarks.len(), coarse.landmarks.len());
    let frame = coarse.grid.frame();
    let same = coarse.grid.iter().filter(|&(cell, value)| {
        fine.grid.value_at(&(frame.center(cell) + nalgebra::Vector2::repeat(0.01))) == Some(value)
    });
    assert!(same.count() as f64 > 0.98 * coarse.grid.values().len() as f64);
}

#[test]
fn doors_and_corridors_measure_what_they_do_in_buildings() {
    let office = worlds::office(&settings(700, 270, 0.05, 1)).unwrap();
    let map = TopologicalMap::from_grid(&office.grid, &ExtractSettings::default()).unwrap();
    let width = |kind| {
        let of_kind = map.places().iter().filter(move |place| place.kind == kind);
        let mut widths: Vec<f64> = of_kind.filter_map(|place| place.width).collect();
        widths.sort_by(f64::total_cmp);
        widths[widths.len() / 2]
    };
    assert!((0.8..1.2).contains(&width(PlaceKind::Door)), "{}", width(PlaceKind::Door));
    assert!((1.8..2.6).contains(&width(PlaceKind::Corridor)), "{}", width(PlaceKind::Corridor));
}

#[test]
fn the_hall_of_mirrors_equals_itself_turned_by_half_a_turn() {
    for (width, height) in [(400, 280), (401, 281), (281, 401), (300, 300), (60, 60), (20, 33)] {
        for seed in 0..4 {
            let settings = settings(width, height, 0.05, seed);
            let hall = worlds::hall_of_mirrors(&settings).unwrap();
            assert!(hall.grid.values().iter().eq(hall.grid.values().iter().rev()));
            assert!(hall.landmarks.is_empty());
            assert_sound(&hall, &settings);
        }
    }
    // It is no more symmetric than that.
    let hall = worlds::hall_of_mirrors(&settings(400, 280, 0.05, 1)).unwrap().grid;
    assert!((0..280).any(|row| !hall.row(row).iter().eq(hall.row(row).iter().rev())));
}

#[test]
fn the_corridor_repeats_itself() {
    let corridor = worlds::corridor(&settings(1200, 100, 0.05, 1)).unwrap().grid;
    let column = |at: usize| -> Vec<i8> { (0..100).map(|row| corridor.row(row)[at]).collect() };
    // Away from the ends, moved by the distance of the doors, nearly all columns are the same.
    let alike = |by: usize| (100..1000).filter(|&at| column(at) == column(at + by)).count();
    let best = (65..=105).map(alike).max().unwrap();
    assert!(best > 650, "{best} of 900");
    assert!((20..80).contains(&alike(1).abs_diff(900)), "{}", alike(1));
    // An upright grid holds the same, turned.
    let upright = worlds::corridor(&settings(100, 1200, 0.05, 1)).unwrap().grid;
    assert!((0..1200).all(|at| upright.row(at) == column(at)));
}

#[test]
fn the_soccer_field_has_six_landmarks_on_its_border() {
    let own = WorldSettings::suited_to("soccer-field").unwrap();
    let field = worlds::soccer_field(&own).unwrap();
    assert_eq!((field.landmarks.len(), LANDMARK_COLORS.len()), (6, 6));
    for landmark in field.landmarks.iter() {
        assert_eq!(field.grid.occupancy_at(&landmark.position.xy()), Occupancy::Occupied);
    }
    let at = |id| field.landmarks.get(id).unwrap().position;
    assert!((nalgebra::distance(&at(1), &at(3)) - 4.3).abs() < 1e-9);
    assert!((nalgebra::distance(&at(2), &at(5)) - 2.8).abs() < 1e-9);
    // 4.2 m x 2.7 m, and two goals of 0.8 m x 0.3 m.
    let area = field.grid.counts().free as f64 * 0.02 * 0.02;
    assert!((area - (4.2 * 2.7 + 2.0 * 0.8 * 0.3)).abs() < 0.2, "{area}");
    for (k, colors) in LANDMARK_COLORS.iter().enumerate() {
        assert!(!LANDMARK_COLORS[..k].contains(colors));
    }
}

#[test]
fn bad_settings_and_names_are_refused() {
    let good = settings(100, 80, 0.05, 1);
    for name in NAMES {
        for bad in [
            WorldSettings { width: 0, ..good },
            WorldSettings { height: 0, ..good },
            WorldSettings { width: 19, ..good },
            WorldSettings { width: usize::MAX, height: usize::MAX, ..good },
            WorldSettings { width: 10_001, height: 10_000, ..good },
            WorldSettings { resolution: 0.0, ..good },
            WorldSettings { resolution: -0.05, ..good },
            WorldSettings { resolution: 1e9, ..good },
            WorldSettings { resolution: f64::NAN, ..good },
            WorldSettings { resolution: f64::INFINITY, ..good },
        ] {
            assert!(matches!(worlds::by_name(name, &bad), Err(Error::Core(_))), "{name} {bad:?}");
        }
    }
    for wrong in ["", "Office", "castle"] {
        let error = worlds::by_name(wrong, &good).unwrap_err();
        assert!(matches!(&error, Error::UnknownWorld { found } if found == wrong));
        assert!(NAMES.iter().all(|name| error.to_string().contains(name)), "{error}");
        assert!(WorldSettings::suited_to(wrong).is_err());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]
    #[test]
    fn any_settings_give_a_sound_world(
        name in prop::sample::select(NAMES.to_vec()),
        width in 20..260_usize,
        height in 20..260_usize,
        resolution in 0.001..0.25,
        seed in any::<u64>(),
    ) {
        let settings = settings(width, height, resolution, seed);
        assert_sound(&worlds::by_name(name, &settings).unwrap(), &settings);
    }
}
