//! What is written is read by others: `docs/scripts/read_mcap.py` with mcap-ros2-support and
//! rosbags, where Python has these packages. `LOC_PYTHON` names another interpreter than `python3`.

use super::formats::{at, bags, odometry, place, stored};
use loc_ros::messages::*;
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;

const RANGES: [f32; 6] = [1.5, f32::INFINITY, f32::NAN, f32::NEG_INFINITY, 0.1, 7.0];

/// A number as the script wants it.
fn number(value: f32) -> Value {
    match value {
        value if value.is_nan() => json!("nan"),
        value if value.is_infinite() => json!(if value > 0.0 { "inf" } else { "-inf" }),
        value => json!(f64::from(value)),
    }
}

/// Runs the script; what it prints, or `None` where the packages are missing.
fn read_by_others(file: &Path, expected: &Value) -> Option<String> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/scripts/read_mcap.py");
    let wanted = file.with_extension("json");
    std::fs::write(&wanted, expected.to_string()).unwrap();
    let python = std::env::var_os("LOC_PYTHON").unwrap_or("python3".into());
    let Ok(output) = Command::new(python).arg(script).arg(file).arg(&wanted).output() else {
        println!("skipped: there is no python3");
        return None;
    };
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(output.status.success(), "{said}{}", String::from_utf8_lossy(&output.stderr));
    if said.starts_with("skipped") {
        println!("{}", said.trim());
        return None;
    }
    Some(said)
}

fn loc_sim(folder: &Path, arguments: &[&str]) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_loc-sim"));
    let output = command.current_dir(folder).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn others_read_the_same_values() {
    let scan = |k: i64| LaserScan {
        header: Header::new(at(k), "laser"),
        angle_min: -0.5,
        angle_max: 0.75,
        angle_increment: 0.25,
        range_max: 8.0,
        ranges: RANGES.to_vec(),
        ..LaserScan::default()
    };
    let mut messages = vec![place()];
    for k in 1..4 {
        messages.extend([odometry(k), stored("/scan", k as u32, &scan(k))]);
    }
    let mut imu = Imu { header: Header::new(at(4), "imu"), ..Imu::default() };
    imu.angular_velocity = [f64::NAN, f64::NEG_INFINITY, 0.125];
    let last = stored("/imu", 4, &imu);
    messages.push(last);
    let folder = tempfile::tempdir().unwrap();
    let bags = bags(&messages);
    for name in ["a.bag", "a.mcap"] {
        let (_, bytes) = bags.iter().find(|(of, _)| *of == name).unwrap();
        std::fs::write(folder.path().join(name), bytes).unwrap();
    }
    let ranges = Value::Array(RANGES.map(number).to_vec());
    loc_sim(folder.path(), &["convert", "a.bag", "converted.mcap", "--to", "mcap"]);
    let expected = json!({
        "/scan": {
            "ranges": [&ranges, &ranges, &ranges],
            "header.frame_id": ["laser", "laser", "laser"],
            "header.stamp.sec": [1, 2, 3],
        },
        "/odom": { "pose.pose.position.x": [1, 2, 3], "child_frame_id": ["base", "base", "base"] },
        "/imu": { "angular_velocity.x": ["nan"], "angular_velocity.y": ["-inf"], "angular_velocity.z": [0.125] },
        "/tf_static": { "transforms.0.transform.translation.x": [0.2] },
    });
    let Some(said) = read_by_others(&folder.path().join("converted.mcap"), &expected) else {
        return;
    };
    assert!(said.contains("8 messages, 8 in the index, 0 differ"), "{said}");
    assert!(said.contains("9 fields expected, 0 wrong"), "{said}");
    // The robot starts at (10, 20) and drives on from there by its odometry.
    let replay = ["replay", "a.mcap", "--initial-pose", "10,20,0", "--method", "dead-reckoning"];
    loc_sim(
        folder.path(),
        &[&replay[..], &["--mcap", "run.mcap", "--reference-topic", "none"]].concat(),
    );
    let expected = json!({
        "/scan": { "ranges": [&ranges, &ranges, &ranges], "angle_max": [0.75, 0.75, 0.75] },
        "/amcl_pose": { "pose.pose.position.x": [10, 11, 12], "pose.pose.position.y": [20, 20, 20] },
    });
    let said = read_by_others(&folder.path().join("run.mcap"), &expected).unwrap();
    assert!(said.contains(" 0 differ") && said.contains("4 fields expected, 0 wrong"), "{said}");
}
