//! Maps that others made, under `LOC_DATA_DIR`.

use crate::data;
use image::GenericImageView;
use loc_maps::grid::io::{self, MapDescription};
use loc_maps::grid::{Cell, Occupancy, OccupancyGrid};
use std::path::Path;

#[test]
fn every_map_loads_and_the_broken_one_says_why() {
    let Some(folder) = data("ros_maps") else { return };
    let mut loaded = 0;
    for entry in walk(&folder) {
        let map = io::load(&entry);
        if entry.ends_with("invalid_image.yaml") {
            let message = map.unwrap_err().to_string();
            assert!(message.contains("invalid.png: "), "{message}");
            continue;
        }
        let counts = map.unwrap_or_else(|error| panic!("{error}")).counts();
        assert!(counts.occupied > 0, "{}: {counts:?}", entry.display());
        loaded += 1;
    }
    assert_eq!(loaded, 15);
}

#[test]
fn test_map_is_the_same_as_pgm_png_and_bmp() {
    let Some(folder) = data("ros_maps/testmap") else { return };
    let description = MapDescription::read(folder.join("testmap.yaml")).unwrap();
    let load = |name| io::load_image(folder.join(name), &description).unwrap();
    let grid = load("testmap.pgm");
    assert_eq!((grid.width(), grid.height()), (10, 10));
    assert_eq!(grid, load("testmap.png"));
    assert_eq!(grid, load("testmap.bmp"));
    assert_eq!(grid, io::load(folder.join("testmap.yaml")).unwrap());
    let counts = grid.counts();
    assert!(counts.free > 0 && counts.occupied > 0, "{counts:?}");
}

/// Whether the viewer shows a value in this colour: 0 white to 100 black, unknown a greenish
/// grey. The raw mode of the version photographed let through values that no map may have, above
/// 100 and below -1, which the viewer shows in green, yellow and red; here they are unknown.
fn is_shown_as(value: i8, [red, green, blue]: [u8; 3]) -> bool {
    let near = |expected: [u8; 3]| (0..3).all(|k| [red, green, blue][k].abs_diff(expected[k]) <= 4);
    match value {
        0..=100 => near([255 - (255 * i32::from(value) / 100) as u8; 3]),
        _ => near([0x70, 0x89, 0x86]) || (blue < 4 && red.max(green) > 250),
    }
}

/// The part of cells away from edges whose colour on the screenshot is as it should be.
fn agreement(map: &Path, screenshot: &Path) -> f64 {
    let grid = io::load(map).unwrap();
    let screen = image::open(screenshot).unwrap();
    let background = screen.get_pixel(0, 0);
    let (w, h) = screen.dimensions();
    let is_map = |x: u32, y: u32| screen.get_pixel(x, y) != background;
    let (left, right) =
        ((0..w).find(|&x| is_map(x, h / 2)).unwrap(), (0..w).rfind(|&x| is_map(x, h / 2)).unwrap());
    let (top, bottom) =
        ((0..h).find(|&y| is_map(w / 2, y)).unwrap(), (0..h).rfind(|&y| is_map(w / 2, y)).unwrap());
    let (mut same, mut all) = (0, 0);
    for (cell, value) in grid.iter().filter(|&(cell, value)| is_inner(&grid, cell, value)) {
        let along = (cell.column as f64 + 0.5) / grid.width() as f64;
        let up = (cell.row as f64 + 0.5) / grid.height() as f64;
        let x = f64::from(left) + along * f64::from(right + 1 - left);
        let y = f64::from(bottom + 1) - up * f64::from(bottom + 1 - top);
        let [red, green, blue, _] = screen.get_pixel(x as u32, y as u32).0;
        all += 1;
        same += u32::from(is_shown_as(value, [red, green, blue]));
    }
    f64::from(same) / f64::from(all)
}

fn is_inner(grid: &OccupancyGrid, cell: Cell, value: i8) -> bool {
    let around = (-2..=2_isize).flat_map(|du| (-2..=2_isize).map(move |dv| (du, dv)));
    around.into_iter().all(|(du, dv)| {
        let (column, row) = (cell.column.wrapping_add_signed(du), cell.row.wrapping_add_signed(dv));
        grid.value(Cell::new(column, row)) == Some(value)
    })
}

#[test]
fn modes_look_as_the_viewer_shows_them() {
    let Some(folder) = data("ros_maps/modes") else { return };
    for (map, screenshot) in [
        ("dummy_map_trinary.yaml", "mode_trinary_rviz_map.png"),
        ("dummy_map_scale.yaml", "mode_scale_rviz_map.png"),
        ("dummy_map_raw.yaml", "mode_raw_rviz_map.png"),
        ("dummy_map_raw_negate.yaml", "mode_raw_negate_rviz_map.png"),
    ] {
        let agreement = agreement(&folder.join(map), &folder.join(screenshot));
        assert!(agreement > 0.999, "{map}: {agreement}");
    }
}

#[test]
#[allow(clippy::approx_constant)]
fn a_turned_map_puts_its_walls_where_they_belong() {
    let Some(folder) = data("ros_maps/mit_racecar") else { return };
    let grid = io::load(folder.join("basement_fixed.map.yaml")).unwrap();
    let (frame, yaw) = (grid.frame(), 3.14_f64);
    let mut walls = 0;
    for (cell, value) in grid.iter().filter(|&(_, value)| value == 100) {
        let (u, v) = ((cell.column as f64 + 0.5) * 0.0504, (cell.row as f64 + 0.5) * 0.0504);
        let x = 25.9 + u * yaw.cos() - v * yaw.sin();
        let y = 48.5 + u * yaw.sin() + v * yaw.cos();
        assert_eq!(grid.occupancy_at(&[x, y].into()), Occupancy::Occupied);
        assert!((frame.center(cell) - nalgebra::Point2::new(x, y)).norm() < 1e-9);
        assert!(x < 25.9 + 0.2 && y < 48.5 + 0.2, "turned by half a circle: {value} at {x}, {y}");
        walls += 1;
    }
    assert!(walls > 1000);
}

fn walk(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let deeper = |path: std::path::PathBuf| if path.is_dir() { walk(&path) } else { vec![path] };
    let mut files: Vec<_> = entries.flat_map(deeper).collect();
    files.retain(|path| path.extension().is_some_and(|ending| ending == "yaml"));
    files.sort();
    files
}
