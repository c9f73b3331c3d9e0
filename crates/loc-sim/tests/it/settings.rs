//! The settings tree: files over defaults, the robot once, old keys.

use loc_core::Pose2;
use loc_filters::RobotSettings;
use loc_filters::lateration::Loss;
use loc_sim::localizer::MethodSettings;
use loc_sim::scenario::{RecordingConfig, Scenario, builtin, recording};
use toml::Table;

fn over(base: &MethodSettings, filter: &str) -> Result<MethodSettings, String> {
    let table: Table = toml::from_str(filter).unwrap();
    base.overlaid(&table).map_err(|error| error.to_string())
}

#[test]
fn the_robot_is_given_once_and_may_differ_for_one_method() {
    let robot = RobotSettings::default().mounting(Pose2::new(0.2, 0.0, 0.1)).horizon(1.0);
    let base = MethodSettings::of(robot);
    let text = "robot = { gate_probability = 0.99, camera = { range_sigma = 0.3 } }\n\
                slam = { robot = { camera = { bearing_sigma = '5 deg' } } }";
    let settings = over(&base, text).unwrap();
    for own in [
        settings.mcl.robot,
        settings.landmark_mcl.robot,
        settings.histogram.robot,
        settings.lateration.robot,
        settings.line_matching.robot,
        settings.fusion.robot,
        settings.fastslam.robot,
    ] {
        assert_eq!(own, settings.robot);
    }
    assert_eq!((settings.robot.gate_probability, settings.robot.camera.range_sigma), (0.99, 0.3));
    assert_eq!((settings.robot.mounting, settings.robot.horizon), (robot.mounting, 1.0));
    let mut camera = settings.robot.camera;
    camera.bearing_sigma = 5_f64.to_radians();
    assert_eq!(settings.slam.robot, settings.robot.camera(camera));
}

#[test]
fn another_choice_takes_the_place_of_the_default_one() {
    let base = MethodSettings::default();
    let settings = over(&base, "lateration.loss = { huber = 2.0 }").unwrap();
    assert_eq!(settings.lateration.loss, Loss::Huber(2.0));
    let settings = over(&base, "mcl.sensor.beam.sigma_hit = 0.3").unwrap();
    assert!(
        matches!(settings.mcl.sensor, loc_pf::mcl::SensorSettings::Beam(b) if b.sigma_hit == 0.3)
    );
    assert!(over(&base, "mcl.sensor.sonar = {}").unwrap_err().contains("unknown variant `sonar`"));
    assert!(over(&base, "mcl.beams = 0").unwrap_err().contains("MclSettings.beams"));
}

/// What `--print-config` prints in full is read as the same settings, to the bit.
#[test]
fn all_settings_survive_their_text() {
    let mut all = vec![MethodSettings::default()];
    for name in builtin::ALL.map(|(name, _)| name) {
        let scenario = Scenario::named(name, &[]).unwrap();
        all.extend((!scenario.methods.is_empty()).then(|| scenario.settings().unwrap()));
    }
    for text in [recording::MRCLAM, recording::VICTORIA_PARK, recording::RANGING] {
        let config = RecordingConfig::parse("settings", text, &[]).unwrap();
        all.push(config.settings(RobotSettings::default()).unwrap());
    }
    assert!(all.len() > 20);
    for settings in all {
        let text = settings.to_toml().unwrap();
        let whole: Table = toml::from_str(&text).unwrap();
        let read = MethodSettings {
            rail: settings.rail.clone(),
            also_global: settings.also_global,
            seed: settings.seed,
            ..MethodSettings::default()
        };
        let read = read.overlaid(whole["filter"].as_table().unwrap()).unwrap();
        assert_eq!(read, settings, "{text}");
        assert!(text.contains("update_turn = 0.1\n") || text.contains("update_turn = 1.0\n"));
        assert!(text.contains("bin_heading = \"10 deg\""));
    }
}

#[test]
fn old_keys_name_the_new_ones() {
    for (scenario, change, hint) in [
        (
            "landmark-drive",
            "drive.time_step_s=0.1",
            "`time_step_s` is now `time_step`, in SI units",
        ),
        ("landmark-drive", "drive.camera.fov_deg=60", "`fov_deg = 6` is now `fov = \"6 deg\"`"),
        ("landmark-drive", "drive.course.0.omega_deg_s=1", "`omega = \"6 deg/s\"`"),
        ("landmark-drive", "drive.start.heading_sigma_deg=1", "start_sigma.heading = \"6 deg\""),
        ("landmark-drive", "filter.gate_probability=0.9", "is now filter.robot.gate_probability"),
        ("landmark-drive", "filter.horizon_s=1", "is now filter.robot.horizon"),
        ("slam-loop", "filter.slam.merge_ratio=10", "is now map.merge_ratio"),
        ("slam-loop", "filter.slam.association=nearest-neighbor", "is now association.rule"),
        ("position-tracking", "tour.laser.forward_m=0.1", "is now mounting = { x = .. }"),
        ("position-tracking", "filter.histogram.motion.along=0.1", "is now filter.robot.path"),
    ] {
        let error = Scenario::named(scenario, &[change.to_owned()]).unwrap_err().to_string();
        assert!(error.contains(hint), "{change}: {error}");
    }
    let text = "[filter]\nhorizon_s = 1.0\n";
    let error = RecordingConfig::parse("my.toml", text, &[]).unwrap_err().to_string();
    assert!(error.starts_with("my.toml: line 2: `horizon_s = 1.0`: `horizon_s` is now"), "{error}");
    let error = RecordingConfig::parse("my.toml", "[start]\n", &[]).unwrap_err().to_string();
    assert!(error.contains("`start` is now start_sigma"), "{error}");
}

/// Half of a start would make the other half certain in silence.
#[test]
fn a_start_sigma_has_both_parts() {
    let text = "[start_sigma]\nposition = 0.5\n";
    let error = RecordingConfig::parse("my.toml", text, &[]).unwrap_err().to_string();
    assert!(error.contains("missing field `heading`"), "{error}");
}
