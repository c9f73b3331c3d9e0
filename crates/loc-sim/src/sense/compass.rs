//! A compass along a drive past iron.

use super::drive::{DriveSettings, Step, over_time, path};
use super::station::rms;
use super::{Place, Sensor, Station, Taken};
use crate::Result;
use loc_core::{Ellipse, Pose2, angle};
use loc_plot::{Chart, Figure, Role};
use loc_sensors::compass::{Compass, CompassReading, Disturbance};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

pub(super) const SENSOR: Sensor = Sensor {
    name: "compass",
    about: "a compass (B5): heading along a drive past iron",
    presets: &[
        ("hmc5883l", "sigma 0.2 uT in 20 uT (0.6 deg), a steel door and a motor beside the way"),
        ("hmc5883l-clean", "the same without iron in the world"),
    ],
    take,
};

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    compass: Compass,
    drive: DriveSettings,
}

fn take(station: &Station) -> Result<Taken> {
    let drive = DriveSettings::new(40.0, 0.1);
    let mut settings = station.settings(Settings { compass: Compass::default(), drive })?;
    let start = station.pose_or(Place::middle)?;
    let drive = settings.drive.drive(station.place, start)?;
    // Without iron of the user's own: beside the way, where it passes a third and two thirds.
    if station.preset == "hmc5883l" && settings.compass.disturbances.is_empty() {
        let door = beside(&drive, 0.4, 0.9, [9.0, -7.0], 1.0);
        let motor = beside(&drive, 0.75, -0.5, [-6.0, -9.0], 0.7);
        settings.compass.disturbances.extend(door.into_iter().chain(motor));
    }
    let compass = &settings.compass;
    compass.check()?;
    let mut rng = station.errors();
    let read: Vec<CompassReading> =
        drive.iter().map(|step| compass.measure(step.pose, &mut rng)).collect();

    let mut taken = Taken::new(start, &settings);
    let error = |k: usize| angle::difference(read[k].heading, drive[k].pose.theta);
    let errors = || (0..drive.len()).map(error);
    taken.tell("readings", read.len());
    taken.tell("sigma_deg", compass.heading_sigma().to_degrees());
    taken.tell("error_rms_deg", rms(errors()).to_degrees());
    taken.tell("error_max_deg", errors().map(f64::abs).fold(0.0, f64::max).to_degrees());
    let strengths = || read.iter().map(|read| read.strength);
    taken.tell("strength_min_ut", strengths().fold(f64::INFINITY, f64::min));
    taken.tell("strength_max_ut", strengths().fold(0.0, f64::max));
    taken.table(
        "compass.csv",
        ["time_s", "heading_rad", "strength_ut", "true_heading_rad"],
        drive.iter().zip(&read).map(|(s, r)| [s.time, r.heading, r.strength, s.pose.theta]),
    );
    taken.folder.add("compass.svg", over_map(station, compass, &drive, &read));
    taken.folder.add("heading.svg", in_time(compass, &drive, &read, station.preset));
    Ok(taken)
}

/// Iron at a share of the way, `aside` to the left of it \[m\].
fn beside(
    drive: &[Step],
    share: f64,
    aside: f64,
    field: [f64; 2],
    radius: f64,
) -> Option<Disturbance> {
    let step = drive.get((share * drive.len() as f64) as usize)?;
    let place = step.pose * Pose2::new(0.0, aside, 0.0);
    Some(Disturbance { center: [place.x, place.y], radius, field })
}

fn over_map(
    station: &Station,
    compass: &Compass,
    drive: &[Step],
    read: &[CompassReading],
) -> String {
    let subtitle = format!(
        "{} in {}: arrows point where the compass believes that the robot heads",
        station.preset,
        station.place.name()
    );
    let iron = compass.disturbances.iter().map(|iron| Ellipse {
        center: Vector2::from(iron.center),
        semi_major: iron.radius,
        semi_minor: iron.radius,
        angle: 0.0,
    });
    let every = drive.len().div_ceil(40).max(1);
    let arrows = drive.iter().zip(read).skip(every / 2).step_by(every);
    let arrows = arrows.map(|(step, read)| Pose2::new(step.pose.x, step.pose.y, read.heading));
    station
        .scene("A compass on a drive past iron", &subtitle)
        .ellipses(Role::Method(3).width(2.0), "iron, where its field has fallen to 61 %", iron)
        .path(Role::Truth.dotted(), "true path", path(drive))
        .poses(Role::Method(1), "heading as read", arrows)
        .render()
}

fn in_time(compass: &Compass, drive: &[Step], read: &[CompassReading], preset: &str) -> String {
    let error = |k: usize, s: &Step| angle::difference(read[k].heading, s.pose.theta).to_degrees();
    // Turned to the branch nearest the truth, whose own jumps break the line.
    let mut turns = Vec::with_capacity(drive.len());
    let mut sum = drive.first().map_or(0.0, |step| step.pose.theta);
    for step in drive {
        sum += angle::difference(step.pose.theta, sum);
        turns.push(sum.to_degrees());
    }
    let heading = Chart::new("heading [deg]")
        .line(Role::Method(1), "reading", over_time(drive, |k, s| turns[k] + error(k, s)))
        .line(Role::Truth.dotted(), "truth", over_time(drive, |k, _| turns[k]));
    let sigma = 2.0 * compass.heading_sigma().to_degrees();
    let errors = Chart::new("heading error [deg]")
        .band(Role::Method(1), "2 sigma", drive.iter().map(|step| (step.time, -sigma, sigma)))
        .line(Role::Method(1).width(1.0), "reading", over_time(drive, error));
    let strength = Chart::new("strength of the field [uT]")
        .line(Role::Method(1).width(1.0), "reading", over_time(drive, |k, _| read[k].strength))
        .reference(compass.horizontal_field, "the Earth's");
    let figure = Figure::new("Heading by the compass along a drive").subtitle(preset);
    figure.x_label("time [s]").panel(heading).panel(errors).panel(strength).render()
}
