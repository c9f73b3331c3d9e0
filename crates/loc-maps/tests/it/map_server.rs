use crate::data;
use flate2::Compression;
use flate2::write::GzEncoder;
use loc_core::Pose2;
use loc_maps::grid::io::{ImageFormat, MapDescription, Mode};
use loc_maps::grid::{Cell, GridFrame, OccupancyGrid, io};
use std::io::Write;
use std::path::Path;
use tempfile::TempDir;

const YAML: &str = "image: map.pgm\nresolution: 0.1\norigin: [1, 2, 0.5]\nnegate: 0\n\
                    occupied_thresh: 0.65\nfree_thresh: 0.196\n";

/// Loads an image under a YAML text, both written to a fresh folder.
fn load(yaml: &str, image: &[u8]) -> loc_maps::Result<OccupancyGrid> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("map.pgm"), image).unwrap();
    std::fs::write(folder.path().join("map.yaml"), yaml).unwrap();
    io::load(folder.path().join("map.yaml"))
}

/// The message of the error, with file names only.
fn refusal(yaml: &str, image: &[u8]) -> String {
    let error = load(yaml, image).unwrap_err().to_string();
    let name = error.find("map.").unwrap_or(0);
    error[name..].to_owned()
}

fn values(yaml: &str, image: &[u8]) -> Vec<i8> {
    load(yaml, image).unwrap().values().to_vec()
}

/// A grid with every value that a cell can have.
fn every_value() -> OccupancyGrid {
    let frame = GridFrame::new(17, 6, 0.03, Pose2::new(-1.5, 1.0 / 3.0, -2.9)).unwrap();
    OccupancyGrid::new(frame, (-1..=100).collect()).unwrap()
}

#[test]
fn rows_are_flipped_and_the_origin_is_kept() {
    let grid = load(YAML, b"P5 2 2 255\n\x00\xfe\xcd\xfe").unwrap();
    assert_eq!(grid.values(), [-1, 0, 100, 0]);
    assert_eq!(grid.value(Cell::new(0, 1)), Some(100));
    assert_eq!((grid.origin(), grid.resolution()), (Pose2::new(1.0, 2.0, 0.5), 0.1));
}

#[test]
fn thresholds_are_inclusive() {
    let yaml = YAML.replace("0.65", "0.6").replace("0.196", "0.2");
    // p = 1 - g/255: 102 is 0.6 and 204 is 0.2, both to the bit of a rounding.
    assert_eq!(values(&yaml, b"P5 4 1 255\n\x66\x67\xcc\xcb"), [100, -1, 0, -1]);
    let negated = yaml.replace("negate: 0", "negate: true");
    assert_eq!(values(&negated, b"P5 4 1 255\n\x99\x98\x33\x34"), [100, -1, 0, -1]);
}

#[test]
fn modes_in_any_case() {
    let image = b"P5 5 1 255\n\x00\xff\x80\x64\x65";
    let mode = |mode| values(&format!("{YAML}mode: {mode}\n"), image);
    assert_eq!(mode("Trinary"), [100, 0, -1, -1, -1]);
    assert_eq!(mode("SCALE"), [100, 0, 67, 91, 90]);
    assert_eq!(mode("raw"), [0, -1, -1, 100, -1]);
    assert_eq!(
        refusal(&format!("{YAML}mode: other\n"), image),
        "map.yaml: mode: expected trinary, scale or raw, got `other`"
    );
}

#[test]
fn every_kind_of_pgm() {
    let expected = [100, 0, -1];
    assert_eq!(values(YAML, b"P2\n# by hand\n3 1 # size\n255\n0 254\n205\n"), expected);
    assert_eq!(values(YAML, b"P5\n# a\n# b\n3 1\n100\n\x00\x64\x50"), expected, "maxval 100");
    let wide = b"P5 3 1 65535\n\x00\x00\xfe\xfe\xcd\xcd";
    assert_eq!(values(YAML, wide), expected, "16 bits, the high byte first");
    assert_eq!(values(YAML, b"P2 3 1 65535 0 65535 52685"), expected);
    assert_eq!(values(YAML, b"P5 3 1 255\n\n\xff\x20"), [100, 0, 100], "pixels like white space");
    assert_eq!(values(YAML, b"P6 3 1 255\n\x00\x00\x00\xfe\xfe\xfe\xc8\xcd\xd2"), expected);
    let mut zipped = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    zipped.write_all(b"P5 3 1 255\n\x00\xfe\xcd").unwrap();
    assert_eq!(values(YAML, &zipped.finish().unwrap()), expected, "gzipped");
}

#[test]
fn transparent_is_unknown_except_in_mode_raw() {
    let pixels: Vec<u8> = [[0, 255], [0, 254], [255, 255], [255, 0]].concat();
    let mut png = std::io::Cursor::new(Vec::new());
    let color = image::ColorType::La8;
    let format = image::ImageFormat::Png;
    image::write_buffer_with_format(&mut png, &pixels, 4, 1, color, format).unwrap();
    let mode = |mode| values(&format!("{YAML}mode: {mode}\n"), png.get_ref());
    assert_eq!(mode("trinary"), [100, -1, 0, -1]);
    assert_eq!(mode("scale"), [100, -1, 0, -1]);
    assert_eq!(mode("raw"), [0, 0, -1, -1]);
}

#[test]
fn round_trips_without_loss() {
    let folder = tempfile::tempdir().unwrap();
    let all = every_value();
    let classes = all.values().iter().map(|&v| loc_maps::grid::Occupancy::of(v).value());
    let trinary = OccupancyGrid::new(*all.frame(), classes.collect()).unwrap();
    for format in [ImageFormat::Pgm, ImageFormat::Png, ImageFormat::Bmp] {
        let yaml = folder.path().join("a \"room\".yaml");
        io::save(&trinary, &yaml, format, Mode::Trinary).unwrap();
        assert_eq!(io::load(&yaml).unwrap(), trinary, "{format:?}");
        io::save(&all, &yaml, format, Mode::Raw).unwrap();
        assert_eq!(io::load(&yaml).unwrap(), all, "{format:?}");
        let scaled = io::save(&all, &yaml, format, Mode::Scale);
        match format {
            ImageFormat::Png => assert_eq!(scaled.map(|()| io::load(&yaml).unwrap()).unwrap(), all),
            _ => assert!(scaled.unwrap_err().to_string().contains("unknown cells")),
        }
    }
    let text = MapDescription::read(folder.path().join("a \"room\".yaml")).unwrap();
    assert_eq!(MapDescription::parse("again.yaml", &text.to_yaml()).unwrap(), text);
}

#[test]
fn trinary_is_written_as_the_field_does() {
    let folder = tempfile::tempdir().unwrap();
    let frame = GridFrame::new(3, 1, 0.05, Pose2::IDENTITY).unwrap();
    let grid = OccupancyGrid::new(frame, vec![0, 100, -1]).unwrap();
    io::save(&grid, folder.path().join("m.yaml"), ImageFormat::Pgm, Mode::Trinary).unwrap();
    let image = std::fs::read(folder.path().join("m.pgm")).unwrap();
    assert_eq!(image, b"P5\n3 1\n255\n\xfe\x00\xcd");
    let yaml = std::fs::read_to_string(folder.path().join("m.yaml")).unwrap();
    assert!(yaml.contains("occupied_thresh: 0.65\nfree_thresh: 0.196\n"), "{yaml}");
}

#[test]
fn bad_yaml_names_file_and_field() {
    let image = b"P5 1 1 255\n\x00";
    for (from, to, message) in [
        (
            "resolution: 0.1",
            "resolution: 0",
            "map.yaml: resolution: expected a finite number > 0, got 0",
        ),
        (
            "resolution: 0.1",
            "resolution: -0.1",
            "map.yaml: resolution: expected a finite number > 0, got -0.1",
        ),
        (
            "resolution: 0.1",
            "resolution: .nan",
            "map.yaml: resolution: expected a finite number > 0, got NaN",
        ),
        (
            "resolution: 0.1",
            "resolution: .inf",
            "map.yaml: resolution: expected a finite number > 0, got inf",
        ),
        (
            ", 0.5]",
            "]",
            "map.yaml: origin: expected [x, y, yaw], three finite numbers, got [1.0, 2.0]",
        ),
        (
            "0.5]",
            ".nan]",
            "map.yaml: origin: expected [x, y, yaw], three finite numbers, got [1.0, 2.0, NaN]",
        ),
        ("0.65", "65", "map.yaml: occupied_thresh: expected 0 to 1, got 65"),
        ("free_thresh: 0.196", "", "map.yaml: free_thresh: expected a value, got none"),
        ("image: map.pgm", "", "map.yaml: image: expected a value, got none"),
    ] {
        assert_eq!(refusal(&YAML.replace(from, to), image), message);
    }
    for (from, to) in [
        ("resolution: 0.1", "resolution: wide"),
        ("[1, 2, 0.5]", "1"),
        ("negate: 0", "negate: often"),
    ] {
        let message = refusal(&YAML.replace(from, to), image);
        let field = to.split(':').next().unwrap();
        let named = message.contains(field) || message.contains("origin: ");
        assert!(message.starts_with("map.yaml:") && named, "{message}");
    }
    for broken in ["", "[", "a: [b", "\0", "- 1", "image: *x"] {
        let message = refusal(broken, image);
        assert!(message.starts_with("map.yaml:") && !message.contains('\n'), "{message}");
    }
}

#[test]
fn bad_images_name_file_and_field() {
    for (image, message) in [
        (
            &b"P5 100000 100000 255\n"[..],
            "image size: expected 1 to 2^28 pixels, got 100000 x 100000",
        ),
        (b"P5 0 4 255\n", "image size: expected 1 to 2^28 pixels, got 0 x 4"),
        (
            b"P5 16000 16000 255\n",
            "pixels: expected the pixels of 16000 x 16000, got a file of 19 bytes",
        ),
        (
            b"P5 2 2 255\n\x00\x00\x00",
            "pixels: expected 2 x 2 values of 0 to 255, got a file of 14 bytes",
        ),
        (
            b"P5 2 2 65535\n\x00\x00\x00",
            "pixels: expected 2 x 2 values of 0 to 65535, got a file of 16 bytes",
        ),
        (b"P2 2 2 255 1 2 3", "pixels: expected 2 x 2 values of 0 to 255, got a file of 16 bytes"),
        (b"P2 2 1 255 1 x", "pixels: expected 2 x 1 values of 0 to 255, got a file of 14 bytes"),
        (b"P5 2 1 100\n\x65\x00", "pixels: expected 2 x 1 values of 0 to 100, got 101"),
        (b"P5 2 2 0\n\x00\x00\x00\x00", "maxval: expected 1 to 65535, got 0"),
        (b"P5 2 2 65536\n\x00\x00\x00\x00", "maxval: expected 1 to 65535, got 65536"),
        (b"P5 2 -2 255\n\x00", "height: expected a whole number, got `-2`"),
        (b"P5", "width: expected a whole number, got ``"),
        (
            b"P5 99999999999999999999999 1 255\n",
            "width: expected a whole number, got `99999999999999999999`",
        ),
    ] {
        assert_eq!(refusal(YAML, image), format!("map.pgm: {message}"));
    }
    for broken in
        [&b""[..], b"hello", b"\x1f\x8b\x08", b"BM", b"\x89PNG\r\n\x1a\n", b"P6 2 2 255\n\0"]
    {
        let message = refusal(YAML, broken);
        assert!(message.starts_with("map.pgm: "), "{message}");
    }
}

#[test]
fn a_picture_may_not_promise_more_than_its_file_holds() {
    // The header of a bitmap of 16000 x 16000 pixels, and nothing after it.
    let mut bitmap = b"BM\x36\0\0\0\0\0\0\0\x36\0\0\0\x28\0\0\0".to_vec();
    bitmap.extend([16_000_u32, 16_000].iter().flat_map(|size| size.to_le_bytes()));
    bitmap.extend(b"\x01\0\x18\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0");
    let message = refusal(YAML, &bitmap);
    assert!(message.contains("16000 x 16000"), "{message}");
}

#[test]
fn missing_files_are_named() {
    let error = io::load("no/such/map.yaml").unwrap_err().to_string();
    assert!(error.starts_with("no/such/map.yaml: "), "{error}");
    let message = refusal(&YAML.replace("map.pgm", "../../no/such.png"), b"");
    assert!(message.is_empty() || message.contains("such.png"), "{message}");
    assert!(io::load(Path::new("/")).is_err());
}

const MAP: &str = "robot_specifications->global_mapsize_x  30\n\
    robot_specifications->resolution 10\nrobot_specifications->autoshifted_x 0\n\n\
    global_map[0]: 3 2\n-1.000 0.000\n1.000 0.5\n0.19 0.81\n";

fn load_wean(text: &str) -> Result<OccupancyGrid, String> {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("wean.dat");
    std::fs::write(&file, text).unwrap();
    let path = format!("{}/", folder.path().display());
    io::load(&file).map_err(|error| error.to_string().replace(&path, ""))
}

#[test]
fn rows_run_along_x_and_values_are_free_space() {
    let grid = load_wean(MAP).unwrap();
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
    assert_eq!(io::load(&file).unwrap(), load_wean(MAP).unwrap());
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
        let error = load_wean(&MAP.replace(from, to)).unwrap_err();
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
