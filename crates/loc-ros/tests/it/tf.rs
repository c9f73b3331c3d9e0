//! Transforms between frames.

use loc_core::nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};
use loc_ros::messages::Stamp;
use loc_ros::tf::{Moving, TransformBuffer};

const SECOND: i64 = 1_000_000_000;

fn motion(x: f64, yaw: f64) -> Isometry3<f64> {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
    Isometry3::from_parts(Translation3::new(x, 0.0, 0.0), turn)
}

fn robot() -> TransformBuffer {
    let mut frames = TransformBuffer::new(10.0);
    frames.insert("/odom", "/base", Stamp(0), motion(0.0, 3.0), Moving::Yes);
    frames.insert("odom", "base", Stamp(SECOND), motion(1.0, -3.0), Moving::Yes);
    frames.insert("base", "laser", Stamp(0), motion(0.2, 0.0), Moving::No);
    frames.insert("base", "camera", Stamp(0), motion(-0.1, 0.0), Moving::No);
    frames
}

/// From yaw 3 to -3 the short way leads through pi, not through 0.
#[test]
fn rotations_take_the_short_way() {
    let frames = robot();
    let half = frames.lookup("odom", "base", Stamp(SECOND / 2), 0.0).unwrap();
    assert!((half.rotation.angle() - std::f64::consts::PI).abs() < 1e-12);
    assert!((half.translation.x - 0.5).abs() < 1e-12);
    let there = frames.lookup("odom", "laser", Stamp(SECOND / 4), 0.0).unwrap();
    let back = frames.lookup("laser", "odom", Stamp(SECOND / 4), 0.0).unwrap();
    assert!((there * back).translation.vector.norm() < 1e-12);
    // Both are fixed on the robot: any time will do, and the root is not asked.
    let both = frames.lookup("camera", "laser", Stamp(99 * SECOND), 0.0).unwrap();
    assert!((both.translation.x - 0.3).abs() < 1e-12);
}

#[test]
fn errors_name_frames_and_times() {
    let mut frames = robot();
    let error = |frames: &TransformBuffer, target: &str, source: &str, at: i64| {
        frames.lookup(target, source, Stamp(at), 0.1).unwrap_err().to_string()
    };
    let unknown = error(&frames, "base", "lidar", 0);
    assert!(unknown.starts_with("no transform base <- lidar at 0 s"), "{unknown}");
    assert!(unknown.ends_with("known frames: base, camera, laser, odom"), "{unknown}");
    let late = error(&frames, "odom", "base", 2 * SECOND);
    assert!(late.contains("from 0.000 s to 1.000 s only"), "{late}");
    assert!(frames.lookup("odom", "base", Stamp(SECOND + 50_000_000), 0.1).is_ok());
    frames.insert("arm", "hand", Stamp(0), motion(1.0, 0.0), Moving::No);
    let apart = error(&frames, "hand", "laser", 0);
    assert!(apart.contains("separate trees, below arm and odom"), "{apart}");
    frames.insert("laser", "odom", Stamp(0), motion(1.0, 0.0), Moving::No);
    assert!(error(&frames, "hand", "laser", 0).contains("ring"));
    assert!(TransformBuffer::new(1.0).lookup("a", "b", Stamp(0), 0.0).is_err());
}

#[test]
fn old_transforms_go_and_late_ones_find_their_place() {
    let mut frames = TransformBuffer::new(10.0);
    for second in [0, 2, 1, 15] {
        let place = motion(second as f64, 0.0);
        frames.insert("odom", "base", Stamp(second * SECOND), place, Moving::Yes);
    }
    assert!(frames.lookup("odom", "base", Stamp(2 * SECOND), 0.0).is_err());
    frames.insert("odom", "base", Stamp(10 * SECOND), motion(20.0, 0.0), Moving::Yes);
    let between = frames.lookup("odom", "base", Stamp(12 * SECOND + SECOND / 2), 0.0).unwrap();
    assert!((between.translation.x - 17.5).abs() < 1e-12);
}
