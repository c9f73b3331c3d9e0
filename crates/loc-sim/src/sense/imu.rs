//! An inertial measurement unit along a drive, with what its errors become when summed up, and a
//! compass on a drive past iron.

use super::drive::{Drive, DriveSettings, Step, dotted_truth};
use super::{Sensor, Station, Taken, rms};
use crate::Result;
use loc_core::{Ellipse, Pose2, angle};
use loc_plot::{Chart, Figure, Role};
use loc_sensors::compass::{Compass, CompassReading, Disturbance};
use loc_sensors::imu::{Imu, ImuReading, ImuSpec};
use nalgebra::{Vector2, Vector3};
use serde::{Deserialize, Serialize};

pub(super) const SENSOR: Sensor = Sensor {
    name: "imu",
    about: "accelerometers and gyroscopes (B3, B4) along a drive",
    presets: &[
        ("mpu6050", "100 Hz, 400 ug/sqrt(Hz), 0.005 deg/s/sqrt(Hz), 2 g, 250 deg/s"),
        ("adis16448", "200 Hz, 204 ug/sqrt(Hz), 0.0097 deg/s/sqrt(Hz), 18 g, 1000 deg/s"),
    ],
    take: take_samples,
};

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    mounting: Pose2,
    spec: ImuSpec,
    drive: DriveSettings,
}

/// One sample with the truth.
struct Sample {
    read: ImuReading,
    /// Acceleration forward and to the left, and turn rate, at the unit.
    truth: Vector3<f64>,
    biases: (Vector3<f64>, Vector3<f64>),
    /// Turn rate summed up, less the true heading \[rad\].
    heading_error: f64,
    /// Forward acceleration summed up, less the true speed \[m/s\].
    speed_error: f64,
}

fn take_samples(station: &Station) -> Result<Taken> {
    let spec = match station.preset {
        "adis16448" => ImuSpec::adis16448(),
        _ => ImuSpec::mpu6050(),
    };
    let drive = DriveSettings::new(40.0, 1.0 / spec.rate);
    let mut settings = station.settings(Settings { mounting: Pose2::IDENTITY, spec, drive })?;
    settings.spec.check()?;
    settings.drive.time_step = 1.0 / settings.spec.rate;
    let drive = station.drive(&settings.drive)?;
    let samples = sample(station, &settings, &drive)?;

    let mut taken = Taken::new(drive.start, &settings);
    let error = |of: fn(&Sample) -> f64| rms(samples.iter().map(of));
    taken.tell("samples", samples.len());
    taken.tell("acceleration_x_error_rms", error(|s| s.read.acceleration.x - s.truth.x));
    taken.tell("acceleration_y_error_rms", error(|s| s.read.acceleration.y - s.truth.y));
    let turn = error(|s| s.read.angular_velocity.z - s.truth.z);
    taken.tell("turn_rate_error_rms_deg_s", turn.to_degrees());
    if let Some(last) = samples.last() {
        taken.tell("gyro_bias_z_deg_s", last.biases.1.z.to_degrees());
        taken.tell("accelerometer_bias_x", last.biases.0.x);
        taken.tell("heading_drift_deg", last.heading_error.to_degrees());
        taken.tell("speed_drift_m_s", last.speed_error);
    }
    taken.table(
        "imu.csv",
        ["time_s", "ax_m_s2", "ay_m_s2", "az_m_s2", "gx_rad_s", "gy_rad_s", "gz_rad_s"],
        drive.steps.iter().zip(&samples).map(|(step, Sample { read, .. })| {
            let (a, g) = (read.acceleration, read.angular_velocity);
            [step.time, a.x, a.y, a.z, g.x, g.y, g.z]
        }),
    );
    taken.folder.add("drive.svg", drive.draw(station, "The drive that the unit felt"));

    let compared = |name: &str, styles, of: fn(&Sample) -> f64, truth: fn(&Sample) -> f64| {
        drive.compared(name, "reading", styles, |k, _| of(&samples[k]), |k, _| truth(&samples[k]))
    };
    let fine = [Role::Method(1).width(0.6), Role::Truth.width(1.4)];
    let forward = "forward acceleration [m/s²]";
    let forward = compared(forward, fine, |s| s.read.acceleration.x, |s| s.truth.x);
    let left = "acceleration to the left [m/s²]";
    let left = compared(left, fine, |s| s.read.acceleration.y, |s| s.truth.y);
    let turn = |s: &Sample| s.read.angular_velocity.z.to_degrees();
    let turn = compared("turn rate [deg/s]", dotted_truth(), turn, |s| s.truth.z.to_degrees());
    let figure = Figure::new("What an inertial unit feels on a drive").subtitle(station.preset);
    let figure = figure.x_label("time [s]").panel(forward).panel(left).panel(turn);
    taken.folder.add("imu.svg", figure.render());

    let chart = |name: &str, of: fn(&Sample) -> f64| {
        let line = drive.over_time(|k, _| of(&samples[k]));
        Chart::new(name).line(Role::Method(0), "", line).reference(0.0, "")
    };
    let figure = Figure::new("What bias and noise become when summed up")
        .subtitle(station.preset)
        .x_label("time [s]")
        .panel(chart("gyroscope's bias [deg/s]", |s| s.biases.1.z.to_degrees()))
        .panel(chart("heading error [deg]", |s| s.heading_error.to_degrees()))
        .panel(chart("speed error [m/s]", |s| s.speed_error));
    taken.folder.add("drift.svg", figure.render());
    Ok(taken)
}

fn sample(station: &Station, settings: &Settings, drive: &Drive) -> Result<Vec<Sample>> {
    let mut imu = Imu::new(settings.spec)?.with_mounting(settings.mounting)?;
    let (dt, mut rng) = (settings.drive.time_step, station.errors());
    let (mut heading_error, mut speed_error) = (0.0, 0.0);
    let samples = drive.steps.iter().map(|step| {
        let read = imu.measure(step.twist, step.change, dt, &mut rng);
        let truth = truth(step, settings.mounting);
        heading_error += (read.angular_velocity.z - truth.z) * dt;
        speed_error += (read.acceleration.x - truth.x) * dt;
        let biases = imu.biases().unwrap_or_default();
        Sample { read, truth, biases, heading_error, speed_error }
    });
    Ok(samples.collect())
}

/// The true acceleration forward and to the left, and the turn rate, at the unit.
fn truth(step: &Step, mounting: Pose2) -> Vector3<f64> {
    let (twist, change) = (step.twist, step.change);
    let middle = Vector2::new(change.vx, twist.omega * twist.vx);
    let arm = mounting.position().coords;
    let tangential = Vector2::new(-arm.y, arm.x) * change.omega;
    let planar = middle + tangential - arm * twist.omega.powi(2);
    let turned = mounting.rotation().transpose() * planar;
    Vector3::new(turned.x, turned.y, twist.omega)
}

pub(super) const COMPASS: Sensor = Sensor {
    name: "compass",
    about: "a compass (B5): heading along a drive past iron",
    presets: &[
        ("hmc5883l", "sigma 0.2 uT in 20 uT (0.6 deg), a steel door and a motor beside the way"),
        ("hmc5883l-clean", "the same without iron in the world"),
    ],
    take: take_headings,
};

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CompassSettings {
    compass: Compass,
    drive: DriveSettings,
}

fn take_headings(station: &Station) -> Result<Taken> {
    let (compass, drive) = (Compass::default(), DriveSettings::new(40.0, 0.1));
    let mut settings = station.settings(CompassSettings { compass, drive })?;
    let drive = station.drive(&settings.drive)?;
    // Without iron of the user's own: beside the path, after 40 % and 75 % of the drive.
    if station.preset == "hmc5883l" && settings.compass.disturbances.is_empty() {
        let door = beside(&drive, 0.4, 0.9, [9.0, -7.0], 1.0);
        let motor = beside(&drive, 0.75, -0.5, [-6.0, -9.0], 0.7);
        settings.compass.disturbances.extend(door.into_iter().chain(motor));
    }
    let compass = &settings.compass;
    compass.check()?;
    let mut rng = station.errors();
    let read = drive.steps.iter().map(|step| compass.measure(step.pose, &mut rng));
    let read: Vec<CompassReading> = read.collect();

    let mut taken = Taken::new(drive.start, &settings);
    let error = |k: usize, step: &Step| angle::difference(read[k].heading, step.pose.theta);
    let errors = || drive.steps.iter().enumerate().map(|(k, step)| error(k, step));
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
        drive.steps.iter().zip(&read).map(|(s, r)| [s.time, r.heading, r.strength, s.pose.theta]),
    );

    let iron = compass.disturbances.iter().map(|iron| Ellipse {
        center: Vector2::from(iron.center),
        semi_major: iron.radius,
        semi_minor: iron.radius,
        angle: 0.0,
    });
    let every = drive.steps.len().div_ceil(40).max(1);
    let arrows = drive.steps.iter().zip(&read).skip(every / 2).step_by(every);
    let arrows = arrows.map(|(step, read)| Pose2::new(step.pose.x, step.pose.y, read.heading));
    let note = "arrows point where the compass believes that the robot heads";
    let scene = station
        .scene("A compass on a drive past iron", note)
        .ellipses(Role::Method(3).width(2.0), "iron, where its field has fallen to 61 %", iron)
        .path(Role::Truth.dotted(), "true path", drive.path())
        .poses(Role::Method(1), "heading as read", arrows);
    taken.folder.add("compass.svg", scene.render());

    // Turned to the branch nearest the truth, whose own jumps break the line.
    let mut sum = drive.steps.first().map_or(0.0, |step| step.pose.theta);
    let turns = drive.steps.iter().map(|step| {
        sum += angle::difference(step.pose.theta, sum);
        sum.to_degrees()
    });
    let turns: Vec<f64> = turns.collect();
    let degrees = |k: usize, step: &Step| error(k, step).to_degrees();
    let heading = drive.compared(
        "heading [deg]",
        "reading",
        dotted_truth(),
        |k, step| turns[k] + degrees(k, step),
        |k, _| turns[k],
    );
    let sigma = 2.0 * compass.heading_sigma().to_degrees();
    let band = drive.steps.iter().map(|step| (step.time, -sigma, sigma));
    let fine = Role::Method(1).width(1.0);
    let errors = Chart::new("heading error [deg]").band(Role::Method(1), "2 sigma", band).line(
        fine,
        "reading",
        drive.over_time(degrees),
    );
    let strength = Chart::new("strength of the field [uT]")
        .line(fine, "reading", drive.over_time(|k, _| read[k].strength))
        .reference(compass.horizontal_field, "the Earth's");
    let figure = Figure::new("Heading by the compass along a drive").subtitle(station.preset);
    let figure = figure.x_label("time [s]").panel(heading).panel(errors).panel(strength);
    taken.folder.add("heading.svg", figure.render());
    Ok(taken)
}

/// Iron beside the path at a share of the drive, `aside` to the left of it \[m\].
fn beside(
    drive: &Drive,
    share: f64,
    aside: f64,
    field: [f64; 2],
    radius: f64,
) -> Option<Disturbance> {
    let step = drive.steps.get((share * drive.steps.len() as f64) as usize)?;
    let place = step.pose * Pose2::new(0.0, aside, 0.0);
    Some(Disturbance { center: [place.x, place.y], radius, field })
}
