//! Small files of every format that is read, written here: what fuzzing starts from.
//!
//! `LOC_FUZZ_CORPUS=$PWD/crates/loc-ros/fuzz/corpus cargo test -p loc-sim --test it seeds` puts
//! them where `cargo fuzz` looks; without it they go into a folder that is deleted. Each is read
//! here by the parser it is for, so that none of them becomes stale.

mod bags;
mod messages;

use loc_core::{Pose2, Trajectory};
use loc_maps::grid::io::{ImageFormat, MapDescription, Mode};
use loc_maps::grid::{Cell, GridFrame, io};
use loc_maps::{LandmarkMap, LineMap, OccupancyGrid, PointMap, TopologicalMap};
use loc_sim::metrics::SpatialTrajectory;
use loc_sim::nav2::AmclParameters;
use loc_sim::scenario::{RecordingConfig, Scenario, builtin, recording};
use loc_sim::source::Mrclam;
use loc_sim::source::carmen::CarmenLog;
use loc_sim::source::laser_log::Reference;
use loc_sim::source::wean::WeanLog;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Where the seeds of a target go.
struct Corpus {
    folder: PathBuf,
    _temporary: Option<TempDir>,
}

impl Corpus {
    fn of(target: &str) -> Self {
        let temporary =
            std::env::var_os("LOC_FUZZ_CORPUS").is_none().then(|| TempDir::new().unwrap());
        let root = match &temporary {
            Some(folder) => folder.path().to_owned(),
            None => PathBuf::from(std::env::var_os("LOC_FUZZ_CORPUS").unwrap()),
        };
        let folder = root.join(target);
        std::fs::create_dir_all(&folder).unwrap();
        Corpus { folder, _temporary: temporary }
    }

    /// Writes a seed; gives its path.
    fn put(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.folder.join(format!("seed-{name}"));
        std::fs::write(&path, bytes).unwrap();
        path
    }

    /// The same for several files in one input, zero bytes between them.
    fn put_files(&self, name: &str, kind: &[u8], files: &[&str]) {
        let joined = files.join("\0");
        assert_eq!(joined.matches('\0').count() + 1, files.len(), "{name}");
        self.put(name, &[kind, joined.as_bytes()].concat());
    }
}

#[test]
fn logs_of_lasers() {
    let log = "PARAM robot_frontlaser_offset 0.2 nohost 0\nODOM 0 0 0 0 0 0 9.5 host 9.5\n\
               FLASER 3 1.0 2.0 90.0 1.2 2.0 0.5 1.0 2.0 0.5 9.6 host 9.6\n\
               ROBOTLASER1 0 -1 2 1 20 0 0 3 1.5 20 3.25 0 0.2 0 0 0 0 0 0 0 0 0 0 10 host 10\n\
               TRUEPOS 5 6 0.5 0 0 0 10 host 10\n";
    let reference = "time_s,x_m,y_m,theta_rad,spread_m\n9.6,1,2,0.5,0.1\n10,1,2,0.5,0.1\n";
    assert_eq!(CarmenLog::parse("a", log.as_bytes()).laser_log().unwrap().entries.len(), 4);
    Reference::parse(Path::new("a"), reference).unwrap();
    let corpus = Corpus::of("carmen");
    corpus.put("log", log.as_bytes());
    corpus.put_files("with-reference", b"", &[log, reference]);
    let corpus = Corpus::of("wean");
    let ranges = vec!["150"; 179].join(" ");
    let log = format!("O 100 0 0 0.1\nL 100 0 0 125 0 0 {ranges} 8183 0.2\n");
    corpus.put("log", log.as_bytes());
    assert_eq!(
        WeanLog::parse("a", std::io::Cursor::new(log)).laser_log().unwrap().entries.len(),
        2
    );
    let map = "robot_specifications->global_mapsize_x  30\nrobot_specifications->resolution 10\n\
               global_map[0]: 3 2\n-1.000 0.000\n1.000 0.5\n0.19 0.81\n";
    assert_eq!(io::load(corpus.put("map", map.as_bytes())).unwrap().width(), 3);
}

#[test]
fn maps_of_map_server() {
    let corpus = Corpus::of("map");
    let mut grid =
        OccupancyGrid::filled(GridFrame::new(4, 3, 0.05, Pose2::new(-1.0, 2.0, 0.3)).unwrap(), 0);
    grid.set(Cell::new(2, 1), 100).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let formats = [("pgm", ImageFormat::Pgm), ("png", ImageFormat::Png), ("bmp", ImageFormat::Bmp)];
    for (name, format) in formats {
        let yaml = folder.path().join(format!("{name}.yaml"));
        io::save(&grid, &yaml, format, Mode::Trinary).unwrap();
        assert_eq!(io::load(&yaml).unwrap(), grid);
        let image = std::fs::read(folder.path().join(format!("{name}.{name}"))).unwrap();
        corpus.put(name, &[&std::fs::read(&yaml).unwrap(), [0].as_slice(), &image].concat());
    }
    let yaml = "image: a.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 1\n\
                occupied_thresh: 0.65\nfree_thresh: 0.196\nmode: scale\n";
    MapDescription::parse("a.yaml", yaml).unwrap();
    corpus.put("text-image", &[yaml.as_bytes(), b"\0P2\n# grey\n3 1 255\n0 254 205\n"].concat());
}

#[test]
fn parameter_files() {
    let corpus = Corpus::of("amcl_yaml");
    let every: String =
        crate::nav2::EVERY.iter().map(|(key, value)| format!("    {key}: {value}\n")).collect();
    let nested = "amcl:\n  ros__parameters:\n    max_particles: 800\n    initial_pose:\n      x: \
                  1.0\n      y: 2\n      yaw: .5\n    set_initial_pose: true\n";
    for (name, text) in
        [("every", format!("amcl:\n  ros__parameters:\n{every}")), ("nested", nested.into())]
    {
        AmclParameters::parse(name, &text).unwrap();
        corpus.put(name, text.as_bytes());
    }
    let corpus = Corpus::of("toml");
    for (name, text) in builtin::ALL {
        Scenario::parse(name, text, &[]).unwrap();
        corpus.put(name, &[b"\0", text.as_bytes()].concat());
    }
    RecordingConfig::parse("mrclam", recording::MRCLAM, &[]).unwrap();
    corpus.put("mrclam", &[&[1], recording::MRCLAM.as_bytes()].concat());
    let places = "[[place]]\nname = \"a\"\nkind = \"room\"\nposition = [1.0, 2.0]\n\n[[place]]\n\
                  name = \"b\"\nkind = \"door\"\nposition = [3.0, 2.0]\nwidth = 0.9\n\n[[edge]]\n\
                  between = [\"a\", \"b\"]\nlength = 3.5\n";
    TopologicalMap::parse_toml("a.toml", places).unwrap();
    corpus.put("places", &[&[2], places.as_bytes()].concat());
}

#[test]
fn tables() {
    let corpus = Corpus::of("tables");
    let tum = "# timestamp tx ty tz qx qy qz qw\n1.5 1 2 0 0 0 0 1\n2.5 1 3 0 0 0 0.6 0.8\n";
    let path = corpus.put("space", &[&[1], tum.as_bytes()].concat());
    SpatialTrajectory::parse_tum(&path, tum).unwrap();
    let path = corpus.put("plane", tum.as_bytes());
    assert_eq!(Trajectory::read_tum(&path).unwrap().len(), 2);
    // The kind is given by the first byte, 0 here.
    corpus.put("plane", &[&[0], tum.as_bytes()].concat());
    LandmarkMap::parse_csv("a", "id,x,y,z\n3,1.0,2.0,0.5\n").unwrap();
    corpus.put("landmarks", b"\x02id,x,y,z\n3,1.0,2.0,0.5\n");
    PointMap::parse_csv("a", "x,y\n1.0,2.0\n").unwrap();
    corpus.put("points", b"\x03x,y\n1.0,2.0\n");
    LineMap::parse_csv("a", "x1,y1,x2,y2\n1,2,3,4\n").unwrap();
    corpus.put("lines", b"\x04x1,y1,x2,y2\n1,2,3,4\n");
    let reference = "time_s,x_cm,y_cm,theta_deg\n9.6,1,2,0.5\n10,1,2,0.5\n";
    Reference::parse(Path::new("a"), reference).unwrap();
    corpus.put("reference", &[&[5], reference.as_bytes()].concat());
}

#[test]
fn folders_of_landmarks() {
    let files = [
        ("Barcodes.dat", "1 5\n6 63\n7 81\n"),
        ("Landmark_Groundtruth.dat", "6 2.0 0.0 0.001 0.001\n7 0.0 2.0 0.001 0.001\n"),
        ("Robot1_Groundtruth.dat", "0.0 0 0 0\n0.5 0.05 0 0\n1.0 0.1 0 0\n"),
        ("Robot1_Odometry.dat", "0.0 0.1 0.0\n0.5 0.1 0.0\n1.0 0.0 0.0\n"),
        ("Robot1_Measurement.dat", "0.5 63 1.95 0.0\n0.5 81 2.0 1.6\n0.7 5 1.0 0.0\n"),
    ];
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        std::fs::write(folder.path().join(name), text).unwrap();
    }
    Mrclam::open(folder.path(), 1).unwrap();
    Corpus::of("mrclam").put_files("small", b"", &files.map(|(_, text)| text));
    let corpus = Corpus::of("beacons");
    let gps = "time_s,x_east_m,y_north_m\n21.7,0,0\n21.9,1,0\n22.1,2,0\n";
    let of_every_kind: [&[&str]; 6] = [
        &[
            "range2 0.1 5.0 0.02 1 2 7 -80\nodom2diff 0.1 0.5 0.5 0 0.2 1 1 1\n",
            "point2 0.1 0 0 1 0 0 1\npoint2 0.6 0 1 1 0 0 1\n",
        ],
        &[
            "time_s,antenna_id,beacon_id,range_m\n10.3,2.0,0.0,5.0\n",
            "time_s,delta_distance_m,delta_heading_rad\n10.2,0.1,0.02\n10.4,0.3,0.0\n",
            "beacon_id,x_m,y_m\n0.0,0.0,0.0\n6.0,9.0,0.0\n",
            "time_s,x_m,y_m,theta_rad\n10.0,3.0,4.0,0.5\n10.4,3.3,4.1,0.5\n",
        ],
        &["ODOMETRY 0.1 0.1 0\nSENSOR 1 2.5 0.3\nODOMETRY 0 1 0\n", "1 2 3\n"],
        &[
            "1,0.0,7,3.0,1.1,0.0,0.01,0.002\n",
            "1,0.0,inc,0.1,0.0,0.0\n2,0.0,inc,0.1,0.0,0.0\n",
            "1.0 2.0 0 0 0 0 7\n",
            "% x y\n0 0 0 0 0 0\n0.1 0 0 0 0 0\n",
        ],
        &[gps, "0,1,21.8,1.0,0,0\n1,2,22.0,1,0,0.1\n", "1,2,1.0,0.0,1.0,0.0\n"],
        &[gps, "21.5,5.0,0.1\n22.0,5,0\n22.5,5,0\n", "0,3.0,1.5,0.4\n2,3.0,1.4,0.4\n"],
    ];
    for (kind, files) in (0_u8..).zip(of_every_kind) {
        corpus.put_files(&format!("kind-{kind}"), &[kind], files);
    }
}
