//! An inertial measurement unit along a drive, and what its errors become when summed up.

use super::drive::{DriveSettings, Step, over_time, path};
use super::station::rms;
use super::{Place, Sensor, Station, Taken};
use crate::Result;
use loc_core::Pose2;
use loc_plot::{Chart, Figure, Role};
use loc_sensors::imu::{Imu, ImuReading, ImuSpec};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

pub(super) const SENSOR: Sensor = Sensor {
    name: "imu",
    about: "accelerometers and gyroscopes (B3, B4) along a drive",
    presets: &[
        ("mpu6050", "100 Hz, 400 ug/sqrt(Hz), 0.005 deg/s/sqrt(Hz), 2 g, 250 deg/s"),
        ("adis16448", "200 Hz, 204 ug/sqrt(Hz), 0.0097 deg/s/sqrt(Hz), 18 g, 1000 deg/s"),
    ],
    take,
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
    truth: Vector3<f64>,
    biases: (Vector3<f64>, Vector3<f64>),
    /// Turn rate summed up, less the true heading \[rad\].
    heading_error: f64,
    /// Forward acceleration summed up, less the true speed \[m/s\].
    speed_error: f64,
}

fn take(station: &Station) -> Result<Taken> {
    let spec = match station.preset {
        "adis16448" => ImuSpec::adis16448(),
        _ => ImuSpec::mpu6050(),
    };
    let drive = DriveSettings::new(40.0, 1.0 / spec.rate);
    let mut settings = station.settings(Settings { mounting: Pose2::IDENTITY, spec, drive })?;
    settings.spec.check()?;
    settings.drive.time_step = 1.0 / settings.spec.rate;
    let start = station.pose_or(Place::middle)?;
    let drive = settings.drive.drive(station.place, start)?;
    let samples = sample(station, &settings, &drive)?;

    let mut taken = Taken::new(start, &settings);
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
        drive.iter().zip(&samples).map(|(step, Sample { read, .. })| {
            let (a, g) = (read.acceleration, read.angular_velocity);
            [step.time, a.x, a.y, a.z, g.x, g.y, g.z]
        }),
    );
    let subtitle = format!("{} in {}", station.preset, station.place.name());
    let scene = station.scene("The drive that the unit felt", &subtitle);
    let scene = scene.path(Role::Method(0), "true path", path(&drive));
    taken.folder.add("drive.svg", scene.poses(Role::Truth, "start", [start]).render());
    taken.folder.add("imu.svg", readings(&drive, &samples, station.preset));
    taken.folder.add("drift.svg", drift(&drive, &samples, station.preset));
    Ok(taken)
}

fn sample(station: &Station, settings: &Settings, drive: &[Step]) -> Result<Vec<Sample>> {
    let mut imu = Imu::new(settings.spec)?.with_mounting(settings.mounting)?;
    let (dt, mut rng) = (settings.drive.time_step, station.errors());
    let (mut heading_error, mut speed_error) = (0.0, 0.0);
    let samples = drive.iter().map(|step| {
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
    let middle = nalgebra::Vector2::new(change.vx, twist.omega * twist.vx);
    let arm = mounting.position().coords;
    let tangential = nalgebra::Vector2::new(-arm.y, arm.x) * change.omega;
    let planar = middle + tangential - arm * twist.omega.powi(2);
    let turned = mounting.rotation().transpose() * planar;
    Vector3::new(turned.x, turned.y, twist.omega)
}

fn readings(drive: &[Step], samples: &[Sample], preset: &str) -> String {
    let chart = |name: &str, read: &dyn Fn(&Sample) -> f64, truth: &dyn Fn(&Sample) -> f64| {
        Chart::new(name)
            .line(Role::Method(1).width(0.6), "reading", over_time(drive, |k, _| read(&samples[k])))
            .line(Role::Truth.width(1.4), "truth", over_time(drive, |k, _| truth(&samples[k])))
    };
    let forward = chart("forward acceleration [m/s²]", &|s| s.read.acceleration.x, &|s| s.truth.x);
    let left =
        chart("acceleration to the left [m/s²]", &|s| s.read.acceleration.y, &|s| s.truth.y);
    let degrees =
        |of: &dyn Fn(&Sample) -> f64| over_time(drive, |k, _| of(&samples[k]).to_degrees());
    let turn = Chart::new("turn rate [deg/s]")
        .line(Role::Method(1), "reading", degrees(&|s| s.read.angular_velocity.z))
        .line(Role::Truth.dotted(), "truth", degrees(&|s| s.truth.z));
    let figure = Figure::new("What an inertial unit feels on a drive").subtitle(preset);
    figure.x_label("time [s]").panel(forward).panel(left).panel(turn).render()
}

fn drift(drive: &[Step], samples: &[Sample], preset: &str) -> String {
    let chart = |name: &str, label: &str, of: &dyn Fn(&Sample) -> f64| {
        let line = over_time(drive, |k, _| of(&samples[k]));
        Chart::new(name).line(Role::Method(0), label, line).reference(0.0, "")
    };
    let bias = chart("gyroscope's bias [deg/s]", "", &|s| s.biases.1.z.to_degrees());
    let heading = chart("heading error [deg]", "", &|s| s.heading_error.to_degrees());
    let speed = chart("speed error [m/s]", "", &|s| s.speed_error);
    let figure = Figure::new("What bias and noise become when summed up").subtitle(preset);
    figure.x_label("time [s]").panel(bias).panel(heading).panel(speed).render()
}
