//! Sensors simulated and drawn: `loc-sim sense`.

use loc_core::Pose2;
use loc_sim::Error;
use loc_sim::sense::{Reading, Request, SENSORS, WORLDS, sense};
use roxmltree::Document;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn request(sensor: &str) -> Request {
    Request { sensor: sensor.into(), seed: 1, ..Request::default() }
}

fn result(reading: &Reading, name: &str) -> f64 {
    reading.summary["results"][name].as_f64().unwrap_or_else(|| panic!("{name}"))
}

fn files(reading: &Reading) -> Vec<(String, Vec<u8>)> {
    let names: Vec<String> = reading.folder.names().map(str::to_owned).collect();
    names.into_iter().map(|n| (n.clone(), reading.folder.bytes(&n).unwrap().to_vec())).collect()
}

/// The content of what a folder holds is what its names promise.
fn check(reading: &Reading) {
    let mut figures = 0;
    for (name, bytes) in files(reading) {
        let text = || std::str::from_utf8(&bytes).unwrap();
        match Path::new(&name).extension().unwrap().to_str().unwrap() {
            "svg" => {
                figures += 1;
                let doc = Document::parse(text()).unwrap();
                assert!(!text().contains("NaN") && !text().contains(">no data<"), "{name}");
                let images = doc.descendants().filter(|node| node.has_tag_name("image"));
                for image in images {
                    assert!(image.attribute("href").unwrap().starts_with("data:image/png"));
                }
            }
            "csv" => {
                let mut lines = text().lines();
                let columns = lines.next().unwrap().split(',').count();
                assert!(lines.clone().count() > 0, "{name} is empty");
                assert!(lines.all(|line| line.split(',').count() == columns), "{name}");
            }
            "png" => assert!(bytes.starts_with(b"\x89PNG")),
            "json" => assert!(serde_json::from_str::<serde_json::Value>(text()).is_ok()),
            other => panic!("{other}"),
        }
    }
    assert!(figures >= 2);
}

#[test]
fn every_sensor_draws_every_preset_and_the_same_seed_draws_the_same() {
    for sensor in &SENSORS {
        for (preset, _) in sensor.presets {
            let request = Request { preset: Some((*preset).into()), ..request(sensor.name) };
            let reading = sense(&request).unwrap();
            check(&reading);
            assert_eq!(files(&reading), files(&sense(&request).unwrap()), "{preset}");
            let other = sense(&Request { seed: 2, ..request }).unwrap();
            let table = |reading: &Reading| {
                files(reading).into_iter().find(|(name, _)| name.ends_with(".csv")).unwrap()
            };
            // An encoder without noise reads the same whatever the seed.
            assert!(table(&reading) != table(&other) || sensor.name == "encoder", "{preset}");
        }
    }
}

#[test]
fn every_world_can_be_stood_in() {
    for world in WORLDS {
        for sensor in ["laser", "wheels"] {
            let reading = sense(&Request { world: Some(world.into()), ..request(sensor) }).unwrap();
            assert_eq!(reading.summary["world"], world);
        }
    }
}

#[test]
fn errors_are_those_of_the_data_sheets() {
    let laser = sense(&request("laser")).unwrap();
    assert_eq!(result(&laser, "beams"), 1081.0);
    assert!((result(&laser, "error_rms_mm") - 30.0).abs() < 3.0);
    let camera = sense(&request("depth-camera")).unwrap();
    assert!(result(&camera, "pixels_with_depth") > 1e5);
    assert!((1.0..12.0).contains(&result(&camera, "depth_error_rms_mm")));
    let encoder = sense(&request("encoder")).unwrap();
    let step = result(&encoder, "steering_resolution_deg");
    assert!(result(&encoder, "steering_error_rms_deg") < 0.5 * step);
    let wheels = sense(&request("wheels")).unwrap();
    // 0.05 m after 1 m is 0.05 sqrt(v / T) of the speed at v = 0.8 m/s and T = 0.1 s.
    assert!((result(&wheels, "speed_error_rms_m_s") - 0.14).abs() < 0.03);
    let clean = Request { preset: Some("hmc5883l-clean".into()), ..request("compass") };
    assert!((result(&sense(&clean).unwrap(), "error_rms_deg") - 0.57).abs() < 0.1);
}

/// The drive of the sensors that feel motion stays in free space, and gets somewhere.
#[test]
fn drives_stay_in_free_space() {
    for world in WORLDS {
        let request = Request { world: Some(world.into()), ..request("imu") };
        let place = loc_sim::sense::Place::named(world, request.seed).unwrap();
        let wheels = sense(&Request { sensor: "wheels".into(), ..request }).unwrap();
        assert!(result(&wheels, "distance_m") > 5.0, "{world}");
        let start = &wheels.summary["pose"];
        let at = |key: &str| start[key].as_f64().unwrap();
        let mut pose = Pose2::new(at("x_m"), at("y_m"), at("heading_deg").to_radians());
        for line in wheels.folder.text("wheels.csv").unwrap().lines().skip(1) {
            let row: Vec<f64> = line.split(',').map(|number| number.parse().unwrap()).collect();
            let twist = loc_core::Twist2::forward(row[3], row[4]);
            pose = loc_core::motion::Integration::ExactArc.step(pose, twist, 0.1);
            assert!(place.check(pose).is_ok(), "{world}: {pose}");
        }
    }
}

#[test]
fn settings_change_what_is_read() {
    let changed = |sensor: &str, changes: &[&str]| {
        let changes = changes.iter().map(|&change| change.to_owned()).collect();
        sense(&Request { changes, ..request(sensor) })
    };
    let laser = changed("laser", &["spec.beams=181", "faults.dropout=1"]).unwrap();
    assert_eq!((result(&laser, "beams"), result(&laser, "valid")), (181.0, 0.0));
    let moving = changed("laser", &["velocity.omega=3"]).unwrap();
    assert!(moving.folder.text("scan.svg").unwrap().contains("with the robot"));
    assert_eq!(result(&changed("sonar", &["count=4"]).unwrap(), "sonars"), 4.0);
    assert_eq!(result(&changed("radar", &["people=0"]).unwrap(), "echoes"), 0.0);
    for (sensor, change) in [
        ("laser", "spec.beam=3"),
        ("laser", "spec.beams=0"),
        ("laser", "spec.beams"),
        ("laser", "spec.range_max=nan"),
        ("laser", "velocity.vx=inf"),
        ("laser", "mounting=3"),
        ("depth-camera", "camera.spec.width=99999999"),
        ("depth-camera", "wall_height=-1"),
        ("landmarks", "count=0"),
        ("sonar", "count=100000"),
        ("radar", "people=100000000"),
        ("wheels", "track=0"),
        ("wheels", "drive.duration=1e12"),
        ("wheels", "drive.time_step=0"),
        ("encoder", "steering_counts=1"),
        ("imu", "spec.rate=0"),
        ("compass", "compass.horizontal_field=0"),
        ("gnss", "interval=-1"),
        ("gnss", "origin.latitude=9"),
    ] {
        let error = changed(sensor, &[change]).unwrap_err().to_string();
        assert!(!error.contains('\n') && error.len() < 400, "{sensor} {change}: {error}");
    }
}

#[test]
fn poses_must_be_in_free_space() {
    let at = |x, y| sense(&Request { pose: Some(Pose2::new(x, y, 0.0)), ..request("laser") });
    assert!(at(3.0, 4.0).is_ok());
    for (pose, found) in [((7.0, 1.0), "a wall"), ((-5.0, 0.0), "off the map")] {
        let error = at(pose.0, pose.1).unwrap_err();
        assert!(matches!(error, Error::Config { .. }));
        let error = error.to_string();
        assert!(error.starts_with("--pose: expected a place in free space of room (x 0.0 to"));
        assert!(error.contains(found), "{error}");
    }
}

#[cfg(feature = "cli")]
fn loc_sim(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_loc-sim"));
    command.current_dir(folder).args(arguments).output().unwrap()
}

#[cfg(feature = "cli")]
#[test]
fn the_command_writes_a_folder_or_nothing() {
    let folder = TempDir::new().unwrap();
    let output = loc_sim(folder.path(), &["sense", "laser", "--json", "--pose", "3,4,-90"]);
    let summary: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(summary["pose"]["heading_deg"], -90.0);
    let written = std::fs::read(folder.path().join("out/sense-laser/summary.json")).unwrap();
    assert_eq!(serde_json::from_slice::<serde_json::Value>(&written).unwrap(), summary);

    let list = loc_sim(folder.path(), &["sense", "--list"]);
    let list = String::from_utf8(list.stdout).unwrap();
    assert!(SENSORS.iter().all(|sensor| list.contains(sensor.name)));

    let empty = TempDir::new().unwrap();
    for (arguments, message) in [
        (vec!["lidar"], "sensor: expected one of laser, depth-camera, landmarks, sonar, radar,"),
        (vec!["imu", "--preset", "x"], "preset: expected one of mpu6050, adis16448, got `x`"),
        (vec!["imu", "--world", "moon"], "world: expected one of room, "),
        (vec!["imu", "--map", "no.yaml"], "no.yaml: No such file"),
        (vec!["imu", "--pose", "1,2"], "--pose: expected three finite numbers x,y,deg, got `1,2`"),
        (vec!["imu", "--pose", "nan,2,3"], "--pose: expected three finite numbers x,y,deg"),
        (vec!["laser", "--pose", "99,0,0"], "--pose: expected a place in free space of room"),
        (vec!["laser", "--set", "x=1"], "hokuyo-ust-10lx with --set x=1: unknown field `x`"),
    ] {
        let arguments = [vec!["sense"], arguments].concat();
        let output = loc_sim(empty.path(), &arguments);
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!((output.status.code(), stderr.lines().count()), (Some(1), 1), "{arguments:?}");
        assert!(stderr.starts_with(&format!("error: {message}")), "{stderr}");
        assert!(std::fs::read_dir(empty.path()).unwrap().next().is_none());
    }
}

/// Lines found in a scan of a log: a wall 2 m ahead of the scanner, seen in half a turn.
#[test]
fn lines_in_a_recorded_scan_are_drawn() {
    let folder = TempDir::new().unwrap();
    let ranges = (0..181).map(|k| {
        let cos = (f64::from(k) - 90.0).to_radians().cos();
        format!("{}", (2.0 / cos.max(1e-3)).min(81.9))
    });
    let ranges: Vec<String> = ranges.collect();
    let log = format!("FLASER 181 {} 1 2 0 1 2 0 5.0 host 5.0\n", ranges.join(" "));
    std::fs::write(folder.path().join("wall.log"), log).unwrap();
    let run = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_loc-sim"));
        command.current_dir(&folder).args(["sense", "laser", "--log", "wall.log"]);
        command.args(arguments).output().unwrap()
    };
    let output = run(&["--out", "o"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = std::fs::read_to_string(folder.path().join("o/lines.csv")).unwrap();
    let cells: Vec<f64> =
        lines.lines().nth(1).unwrap().split(',').map(|cell| cell.parse().unwrap()).collect();
    assert!((cells[0] - 2.0).abs() < 1e-3 && cells[1].abs() < 1e-3, "{lines}");
    let svg = std::fs::read_to_string(folder.path().join("o/scan.svg")).unwrap();
    assert!(svg.contains("line found"));
    let missing = run(&["--scan", "1", "--out", "none"]);
    assert_eq!(missing.status.code(), Some(1));
    let error = String::from_utf8(missing.stderr).unwrap();
    assert_eq!(error, "error: wall.log: expected one of its 1 scans, counted from 0, got scan 1\n");
    assert!(!folder.path().join("none").exists());
}
