//! Wheel odometry along a drive, and where it leads when summed up.

use super::drive::{DriveSettings, Step, over_time, path};
use super::station::rms;
use super::{Place, Sensor, Station, Taken};
use crate::Result;
use loc_core::motion::{Integration, VelocityNoise};
use loc_core::{Pose2, Twist2, angle};
use loc_plot::{Chart, Figure, Role};
use loc_sensors::wheel::{WheelFaults, WheelOdometry};
use serde::{Deserialize, Serialize};

pub(super) const SENSOR: Sensor = Sensor {
    name: "wheels",
    about: "wheel odometry (B1): forward speed and turn rate along a drive",
    presets: &[
        ("lectures", "5 cm per m, 5 deg per turn, 2 deg per m (E7)"),
        ("worn-tyre", "the same, and the left wheel is 3 % too small"),
    ],
    take,
};

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Distance between the wheels \[m\].
    track: f64,
    noise: VelocityNoise,
    faults: WheelFaults,
    drive: DriveSettings,
}

fn take(station: &Station) -> Result<Taken> {
    let left_radius = if station.preset == "worn-tyre" { 0.97 } else { 1.0 };
    let settings = station.settings(Settings {
        track: 0.4,
        noise: VelocityNoise::default(),
        faults: WheelFaults { left_radius, ..WheelFaults::NONE },
        drive: DriveSettings::new(40.0, 0.1),
    })?;
    settings.noise.check()?;
    let odometry = WheelOdometry::new(settings.track)?.with_noise(settings.noise);
    let odometry = odometry.with_faults(settings.faults)?;
    let start = station.pose_or(Place::middle)?;
    let drive = settings.drive.drive(station.place, start)?;
    let (dt, mut rng) = (settings.drive.time_step, station.errors());
    let read: Vec<Twist2> =
        drive.iter().map(|step| odometry.measure(step.twist, dt, &mut rng)).collect();
    let mut pose = start;
    let mut summed = Vec::with_capacity(read.len());
    for twist in &read {
        pose = Integration::ExactArc.step(pose, *twist, dt);
        summed.push(pose);
    }

    let mut taken = Taken::new(start, &settings);
    let pairs = || read.iter().zip(&drive);
    let last = drive.last().map_or(start, |step| step.pose);
    taken.tell("readings", read.len());
    taken.tell("distance_m", drive.iter().map(|step| step.twist.vx.abs() * dt).sum::<f64>());
    taken.tell("speed_error_rms_m_s", rms(pairs().map(|(read, step)| read.vx - step.twist.vx)));
    let turn = rms(pairs().map(|(read, step)| read.omega - step.twist.omega));
    taken.tell("turn_rate_error_rms_deg_s", turn.to_degrees());
    taken.tell("end_error_m", pose.distance(last));
    taken.tell("end_heading_error_deg", angle::difference(pose.theta, last.theta).to_degrees());
    taken.table(
        "wheels.csv",
        ["time_s", "v_m_s", "omega_rad_s", "true_v_m_s", "true_omega_rad_s"],
        pairs().map(|(r, s)| [s.time, r.vx, r.omega, s.twist.vx, s.twist.omega]),
    );
    taken.folder.add("drive.svg", over_map(station, start, &drive, &summed));
    taken.folder.add("wheels.svg", in_time(&drive, &read, &summed, station.preset));
    Ok(taken)
}

fn over_map(station: &Station, start: Pose2, drive: &[Step], summed: &[Pose2]) -> String {
    let subtitle = format!("{} in {}", station.preset, station.place.name());
    let scene = station.scene("Where the wheels lead when their readings are summed up", &subtitle);
    let summed = summed.iter().map(|pose| (pose.x, pose.y));
    scene
        .path(Role::Method(1), "summed up", summed)
        .path(Role::Truth.dotted(), "true path", path(drive))
        .poses(Role::Truth, "start", [start])
        .render()
}

fn in_time(drive: &[Step], read: &[Twist2], summed: &[Pose2], preset: &str) -> String {
    let speed = Chart::new("speed [m/s]")
        .line(Role::Method(1).width(1.0), "reading", over_time(drive, |k, _| read[k].vx))
        .line(Role::Truth, "truth", over_time(drive, |_, step| step.twist.vx));
    let turns = over_time(drive, |k, _| read[k].omega.to_degrees());
    let turn = Chart::new("turn rate [deg/s]")
        .line(Role::Method(1).width(1.0), "reading", turns)
        .line(Role::Truth, "truth", over_time(drive, |_, s| s.twist.omega.to_degrees()));
    let error = over_time(drive, |k, step| summed[k].distance(step.pose));
    let error = Chart::new("position error [m]").line(Role::Method(0), "of the sum", error);
    let figure = Figure::new("Wheel odometry along a drive").subtitle(preset);
    figure.x_label("time [s]").panel(speed).panel(turn).panel(error).render()
}
