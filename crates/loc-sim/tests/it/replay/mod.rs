//! Replays of recordings with a laser: small ones written here, real ones where LOC_DATA_DIR is
//! set.

mod command;
mod recording;

use loc_core::Pose2;
use loc_maps::OccupancyGrid;
use loc_maps::grid::{Cell, GridFrame};
use loc_sensors::world::RangeWorld;
use loc_sim::Result;
use loc_sim::source::carmen::CarmenLog;
use loc_sim::source::laser_log::{LaserRecording, ReplayOptions};
use std::fmt::Write;
use std::io::Cursor;

/// A hall of 20 m x 6 m with pillars at irregular places; its corner lies at (-1, -2).
pub(crate) fn hall() -> OccupancyGrid {
    let frame = GridFrame::new(200, 60, 0.1, Pose2::new(-1.0, -2.0, 0.0)).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    for cell in frame.cells() {
        let (column, row) = (cell.column, cell.row);
        if column == 0 || row == 0 || column == 199 || row == 59 {
            grid.set(cell, 100).unwrap();
        }
    }
    for (column, row, side) in
        [(30, 8, 6), (52, 50, 4), (75, 6, 9), (90, 44, 12), (128, 9, 5), (150, 49, 7), (171, 5, 14)]
    {
        for k in 0..side * side {
            grid.set(Cell::new(column + k % side, row + k / side), 100).unwrap();
        }
    }
    grid
}

/// The true poses of a drive through the hall, 0.25 m and 0.5 s apart.
pub(crate) fn drive() -> Vec<Pose2> {
    let pose = |k: i32| {
        let x = 0.25 * f64::from(k);
        Pose2::new(x, 1.0 + 0.5 * (0.5 * x).sin(), (0.25 * (0.5 * x).cos()).atan())
    };
    (0..64).map(pose).collect()
}

/// Odometry that starts elsewhere, counts 2 % too much, and drifts.
fn odometry(drive: &[Pose2]) -> Vec<Pose2> {
    let mut pose = Pose2::new(100.0, -50.0, 2.0);
    let mut poses = vec![pose];
    for pair in drive.windows(2) {
        let step = pair[0].between(pair[1]);
        pose = pose * Pose2::new(1.02 * step.x, step.y, step.theta + 0.002);
        poses.push(pose);
    }
    poses
}

/// The drive as a CARMEN log: a line of odometry between any two scans, `reference` as it says.
fn carmen(reference: impl Fn(usize, Pose2) -> Pose2) -> String {
    let (hall, truth) = (hall(), drive());
    let odometry = odometry(&truth);
    let mut text = String::from("# a drive through a hall\n");
    for (k, (truth, odom)) in truth.iter().zip(&odometry).enumerate() {
        let stamp = 50.0 + 0.5 * k as f64;
        if k > 0 {
            let half = odometry[k - 1] * halfway(odometry[k - 1].between(*odom));
            writeln!(text, "ODOM {} 0 0 0 {} host 0", numbers(half), stamp - 0.25).unwrap();
        }
        let mut ranges = [0.0; 90];
        let increment = std::f64::consts::PI / 90.0;
        let first = truth.theta - std::f64::consts::FRAC_PI_2;
        hall.cast_fan(&truth.position(), first, increment, 30.0, &mut ranges);
        let ranges: Vec<String> = ranges.iter().map(|range| format!("{range:.3}")).collect();
        let laser = reference(k, *truth);
        let (ranges, laser, odom) = (ranges.join(" "), numbers(laser), numbers(*odom));
        writeln!(text, "FLASER 90 {ranges} {laser} {odom} {stamp} host {stamp}").unwrap();
    }
    text
}

/// The same with the true poses as its reference.
pub(crate) fn corrected() -> String {
    carmen(|_, truth| truth)
}

/// The same without any: the laser's pose is the odometry's.
pub(crate) fn uncorrected() -> String {
    let odometry = odometry(&drive());
    carmen(|k, _| odometry[k])
}

fn halfway(step: Pose2) -> Pose2 {
    Pose2::new(0.5 * step.x, 0.5 * step.y, 0.5 * step.theta)
}

fn numbers(pose: Pose2) -> String {
    format!("{} {} {}", pose.x, pose.y, pose.theta)
}

pub(crate) fn open(text: &str, options: &ReplayOptions) -> Result<LaserRecording> {
    let log = CarmenLog::parse("hall.log", Cursor::new(text.to_owned())).laser_log()?;
    LaserRecording::new(log, options)
}

fn refusal(text: &str, options: &ReplayOptions) -> String {
    open(text, options).unwrap_err().to_string()
}
