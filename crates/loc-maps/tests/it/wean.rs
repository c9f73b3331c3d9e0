//! The map file of the Wean Hall recordings.

use crate::data;
use flate2::Compression;
use flate2::write::GzEncoder;
use loc_core::Pose2;
use loc_maps::OccupancyGrid;
use loc_maps::grid::{Cell, io};
use std::io::Write;
use tempfile::TempDir;

const MAP: &str = "robot_specifications->global_mapsize_x  30\n\
    robot_specifications->resolution 10\nrobot_specifications->autoshifted_x 0\n\n\
    global_map[0]: 3 2\n-1.000 0.000\n1.000 0.5\n0.19 0.81\n";

fn load(text: &str) -> Result<OccupancyGrid, String> {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("wean.dat");
    std::fs::write(&file, text).unwrap();
    let path = format!("{}/", folder.path().display());
    io::load(&file).map_err(|error| error.to_string().replace(&path, ""))
}

#[test]
fn rows_run_along_x_and_values_are_free_space() {
    let grid = load(MAP).unwrap();
    assert_eq!((grid.width(), grid.height(), grid.resolution()), (3, 2, 0.1));
    assert_eq!(grid.origin(), Pose2::IDENTITY);
    // Bottom row: the first value of each row of the file.
    assert_eq!(grid.row(0), [-1, 0, 81]);
    assert_eq!(grid.row(1), [100, 50, 19]);
    assert_eq!(grid.value(Cell::new(1, 1)), Some(50));
}

#[test]
fn a_gzipped_one_is_read_as_it_is() {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("wean.dat.gz");
    let mut gzip = GzEncoder::new(std::fs::File::create(&file).unwrap(), Compression::fast());
    gzip.write_all(MAP.as_bytes()).unwrap();
    gzip.finish().unwrap();
    assert_eq!(io::load(&file).unwrap(), load(MAP).unwrap());
}

#[test]
fn broken_files_say_what_is_wrong() {
    for (from, to, message) in [
        ("0.81", "", "global_map: expected 3 x 2 values, got the end of the file before value 5"),
        ("0.81", "0.81 1", "global_map: expected 3 x 2 values, got `1` after them"),
        ("0.5", "1.5", "global_map: expected -1 or 0 to 1 in row 1, column 1, got `1.5`"),
        ("0.5", "NaN", "global_map: expected -1 or 0 to 1 in row 1, column 1, got `NaN`"),
        (
            "resolution 10",
            "resolution 0",
            "resolution: expected a number of centimetres > 0, got `0`",
        ),
        (
            "->resolution 10",
            "->size 10",
            "resolution: expected a line robot_specifications->resolution, got none",
        ),
        (
            "3 2",
            "3",
            "global_map: expected two whole numbers, 1 to 2^28 cells together, got `global_map[0]: 3`",
        ),
        (
            "3 2",
            "16384 16384",
            "global_map: expected 16384 x 16384 values, got the end of the file before value 205",
        ),
        (
            "global_map",
            "map",
            "global_map: expected a line `global_map[0]: rows columns`, got none",
        ),
    ] {
        let error = load(&MAP.replace(from, to)).unwrap_err();
        let (error, _) = error.split_once(" before value").unwrap_or((&error, ""));
        let (message, _) = message.split_once(" before value").unwrap_or((message, ""));
        assert_eq!(error, format!("wean.dat: {message}"));
    }
}

#[test]
fn the_real_map_has_corridors() {
    let Some(folder) = data("wean_hall") else { return };
    let grid = io::load(folder.join("wean.dat.gz")).unwrap();
    let counts = grid.counts();
    // Counted in the file: values >= 0.805 are free, <= 0.355 and >= 0 occupied.
    assert_eq!((counts.free, counts.occupied, counts.unknown), (48289, 20353, 571_358));
}
