use loc_maps::OccupancyGrid;
use loc_maps::grid::{Cell, Occupancy};
use loc_maps::worlds::{self, WorldSize};

fn size(columns: usize, rows: usize) -> WorldSize {
    WorldSize { columns, rows, resolution: 0.05 }
}

/// How many free cells can be reached from the first free one, by steps along the axes.
fn reachable(grid: &OccupancyGrid) -> usize {
    let is_free = |cell: Cell| grid.value(cell) == Some(0);
    let mut seen = vec![false; grid.values().len()];
    let mut open: Vec<Cell> =
        grid.frame().cells().find(|&cell| is_free(cell)).into_iter().collect();
    let mut count = 0;
    while let Some(cell) = open.pop() {
        let index = grid.frame().index(cell);
        let Some(index) = index.filter(|&index| is_free(cell) && !seen[index]) else { continue };
        seen[index] = true;
        count += 1;
        let Cell { column, row } = cell;
        open.extend([Cell::new(column + 1, row), Cell::new(column, row + 1)]);
        open.extend([
            Cell::new(column.wrapping_sub(1), row),
            Cell::new(column, row.wrapping_sub(1)),
        ]);
    }
    count
}

#[test]
fn offices_of_all_sizes_can_be_walked_through() {
    for (columns, rows) in [(160, 160), (400, 300), (1000, 300), (300, 1000), (2000, 2000)] {
        for seed in 0..3 {
            let office = worlds::office(size(columns, rows), seed).unwrap();
            let counts = office.counts();
            let (free, cells) = (counts.free as f64, office.values().len() as f64);
            assert!(free > 0.6 * cells && free < 0.95 * cells, "{counts:?}");
            let share = reachable(&office) as f64 / free;
            assert!(share > 0.98, "{columns} x {rows}, seed {seed}: {share} reachable");
            assert!(office.row(0).iter().all(|&value| value == 100), "an outer wall");
        }
    }
}

#[test]
fn the_corridor_is_one_open_space() {
    let corridor = worlds::corridor(size(1000, 100), 5).unwrap();
    assert_eq!(reachable(&corridor), corridor.counts().free);
    assert!(corridor.counts().unknown > 0);
    assert_eq!(corridor.occupancy_at(&[25.0, 2.5].into()), Occupancy::Free);
}

#[test]
fn the_hall_of_mirrors_is_its_own_mirror_image() {
    for (columns, rows) in [(200, 160), (201, 161)] {
        let hall = worlds::hall_of_mirrors(size(columns, rows), 3).unwrap();
        for (cell, value) in hall.iter() {
            let Cell { column, row } = cell;
            let (across, up) = (columns - 1 - column, rows - 1 - row);
            assert_eq!(hall.value(Cell::new(across, row)), Some(value));
            assert_eq!(hall.value(Cell::new(across, up)), Some(value));
        }
        assert!(reachable(&hall) as f64 > 0.95 * hall.counts().free as f64);
    }
}

#[test]
fn the_soccer_field_has_its_landmarks_where_they_stand() {
    for resolution in [0.01, 0.05, 0.07] {
        let (field, landmarks) = worlds::soccer_field(resolution).unwrap();
        assert_eq!(landmarks.len(), 10);
        for landmark in landmarks.iter() {
            let expected = if landmark.id <= 4 { Occupancy::Occupied } else { Occupancy::Free };
            assert_eq!(field.occupancy_at(&landmark.position.xy()), expected, "{landmark:?}");
        }
        let corners = field.frame().corners();
        assert!((corners[0].x + corners[2].x).abs() < 1e-9 && corners[2].x > 5.2);
    }
}

#[test]
fn seeds_decide_and_bad_sizes_are_refused() {
    assert_eq!(
        worlds::office(size(300, 300), 7).unwrap(),
        worlds::office(size(300, 300), 7).unwrap()
    );
    assert_ne!(
        worlds::office(size(300, 300), 7).unwrap(),
        worlds::office(size(300, 300), 8).unwrap()
    );
    let make = [worlds::office, worlds::corridor, worlds::hall_of_mirrors];
    for world in make {
        assert!(world(size(10, 10), 1).is_err());
        assert!(world(size(0, 400), 1).is_err());
        assert!(world(WorldSize { resolution: 0.2, ..size(400, 400) }, 1).is_err());
        assert!(world(WorldSize { resolution: f64::NAN, ..size(400, 400) }, 1).is_err());
    }
    for resolution in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-9, 0.2] {
        assert!(worlds::soccer_field(resolution).is_err());
    }
}
