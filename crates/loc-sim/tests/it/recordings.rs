//! Small recordings, the same on every machine, as the text of TUM files.

use std::fmt::Write;

/// An estimate and its reference.
pub(crate) struct Recording {
    pub(crate) estimate: String,
    pub(crate) reference: String,
}

/// Planar: a reference at 20 Hz, an estimate at 7 Hz, 3 ms late, with a gap of two seconds.
pub(crate) fn planar() -> Recording {
    let (mut estimate, mut reference) = (String::from("# t x y z qx qy qz qw\n"), String::new());
    for i in 0..200 {
        let t = 0.05 * f64::from(i);
        write_pose(&mut reference, t, [curve_x(t), curve_y(t), 0.0], turn(t), 1.0);
    }
    for i in (0..70).filter(|i| !(20..34).contains(i)) {
        let t = 0.003 + f64::from(i) / 7.0;
        let position = [1.2 + curve_x(t) + 0.02 * t, curve_y(t) - 0.1 * t.sin(), 0.0];
        write_pose(&mut estimate, t, position, turn(t + 0.05 * t.cos()), 1.0);
    }
    Recording { estimate, reference }
}

/// In space: an estimate at 50 Hz whose stamps come in twos, its quaternions not of unit length,
/// and a reference at 30 Hz, 4 ms early, at a stamp of the year 2020.
pub(crate) fn space() -> Recording {
    let (mut estimate, mut reference) = (String::new(), String::new());
    let start = 1_600_000_000.0;
    for i in 0..90 {
        let t = f64::from(i) / 30.0 - 0.004;
        let position = [curve_x(t), curve_y(t), 0.5 * t.cos()];
        write_pose(&mut reference, start + t, position, tumble(t), 1.0);
    }
    for i in 0..150 {
        let t = 0.02 * f64::from(i);
        let position = [curve_x(t) + 0.3, 0.9 * curve_y(t), 0.4 * t.cos() - 0.2];
        let stretch = 0.5 + 0.01 * f64::from(i);
        write_pose(&mut estimate, start + t, position, tumble(1.1 * t), stretch);
        let late = position.map(|value| value + 0.01);
        write_pose(&mut estimate, start + t, late, tumble(t), 1.0);
    }
    Recording { estimate, reference }
}

fn curve_x(t: f64) -> f64 {
    3.0 * (0.4 * t).sin() + 0.1 * t
}

fn curve_y(t: f64) -> f64 {
    2.0 * (0.7 * t + 0.3).cos()
}

/// The quaternion (x, y, z, w) of a heading that runs through several full turns.
fn turn(t: f64) -> [f64; 4] {
    let half = 0.5 * (1.5 * t - 2.0);
    [0.0, 0.0, half.sin(), half.cos()]
}

/// A quaternion (x, y, z, w) of unit length that turns about all axes.
fn tumble(t: f64) -> [f64; 4] {
    let q = [0.4 * t.sin(), 0.3 * (2.0 * t).cos(), (0.8 * t).sin(), (0.8 * t).cos()];
    let norm = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    q.map(|v| v / norm)
}

fn write_pose(text: &mut String, stamp: f64, position: [f64; 3], q: [f64; 4], stretch: f64) {
    let [x, y, z] = position;
    let [qx, qy, qz, qw] = q.map(|v| v * stretch);
    writeln!(text, "{stamp} {x} {y} {z} {qx} {qy} {qz} {qw}").unwrap();
}
