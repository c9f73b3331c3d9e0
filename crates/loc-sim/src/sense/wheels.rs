//! Wheel odometry along a drive, and encoders of a car-like robot: counts of a wheel, and of the
//! steering.

use super::drive::{Drive, DriveSettings, Step, dotted_truth};
use super::{Sensor, Station, Taken, rms};
use crate::Result;
use loc_core::kinematics::Ackermann;
use loc_core::motion::{Integration, VelocityNoise};
use loc_core::{Pose2, Twist2, angle};
use loc_plot::{Chart, Figure, Role};
use loc_sensors::encoder::{SteeringCount, SteeringEncoder, SteeringNoise};
use loc_sensors::encoder::{WheelEncoder, WheelTicks};
use loc_sensors::wheel::{WheelFaults, WheelOdometry};
use serde::{Deserialize, Serialize};

pub(super) const SENSOR: Sensor = Sensor {
    name: "wheels",
    about: "wheel odometry (B1): forward speed and turn rate along a drive",
    presets: &[
        ("lectures", "5 cm per m, 5 deg per turn, 2 deg per m (E7)"),
        ("worn-tyre", "the same, and the left wheel is 3 % too small"),
    ],
    take: take_odometry,
};

pub(super) const ENCODER: Sensor = Sensor {
    name: "encoder",
    about: "rotary encoders (B2, B1): counts of a steering and of a wheel along a drive",
    presets: &[
        ("fine", "4096 counts a turn of the steering, 2048 a turn of the wheel"),
        ("coarse", "360 and 64 counts a turn, 1 deg of play, 0.5 deg off straight ahead"),
    ],
    take: take_counts,
};

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OdometrySettings {
    /// Distance between the wheels \[m\].
    track: f64,
    noise: VelocityNoise,
    faults: WheelFaults,
    drive: DriveSettings,
}

fn take_odometry(station: &Station) -> Result<Taken> {
    let left_radius = if station.preset == "worn-tyre" { 0.97 } else { 1.0 };
    let settings = station.settings(OdometrySettings {
        track: 0.4,
        noise: VelocityNoise::default(),
        faults: WheelFaults { left_radius, ..WheelFaults::NONE },
        drive: DriveSettings::new(40.0, 0.1),
    })?;
    settings.noise.check()?;
    let odometry = WheelOdometry::new(settings.track)?.with_noise(settings.noise);
    let odometry = odometry.with_faults(settings.faults)?;
    let drive = station.drive(&settings.drive)?;
    let (dt, mut rng) = (settings.drive.time_step, station.errors());
    let steps = || drive.steps.iter();
    let read: Vec<Twist2> = steps().map(|s| odometry.measure(s.twist, dt, &mut rng)).collect();
    let summed: Vec<Pose2> = read
        .iter()
        .scan(drive.start, |pose, twist| {
            *pose = Integration::ExactArc.step(*pose, *twist, dt);
            Some(*pose)
        })
        .collect();

    let mut taken = Taken::new(drive.start, &settings);
    let pairs = || read.iter().zip(steps());
    let (end, last) = (summed.last().copied().unwrap_or(drive.start), drive.end());
    taken.tell("readings", read.len());
    taken.tell("distance_m", steps().map(|step| step.twist.vx.abs() * dt).sum::<f64>());
    taken.tell("speed_error_rms_m_s", rms(pairs().map(|(read, step)| read.vx - step.twist.vx)));
    let turn = rms(pairs().map(|(read, step)| read.omega - step.twist.omega));
    taken.tell("turn_rate_error_rms_deg_s", turn.to_degrees());
    taken.tell("end_error_m", end.distance(last));
    taken.tell("end_heading_error_deg", angle::difference(end.theta, last.theta).to_degrees());
    taken.table(
        "wheels.csv",
        ["time_s", "v_m_s", "omega_rad_s", "true_v_m_s", "true_omega_rad_s"],
        pairs().map(|(r, s)| [s.time, r.vx, r.omega, s.twist.vx, s.twist.omega]),
    );
    let scene = station
        .scene("Where the wheels lead when their readings are summed up", "")
        .path(Role::Method(1), "summed up", summed.iter().map(|pose| (pose.x, pose.y)))
        .path(Role::Truth.dotted(), "true path", drive.path())
        .poses(Role::Truth, "start", [drive.start]);
    taken.folder.add("drive.svg", scene.render());

    let styles = [Role::Method(1).width(1.0), Role::Truth.into()];
    let speed = drive.compared(
        "speed [m/s]",
        "reading",
        styles,
        |k, _| read[k].vx,
        |_, step| step.twist.vx,
    );
    let turn = drive.compared(
        "turn rate [deg/s]",
        "reading",
        styles,
        |k, _| read[k].omega.to_degrees(),
        |_, step| step.twist.omega.to_degrees(),
    );
    let error = drive.over_time(|k, step| summed[k].distance(step.pose));
    let error = Chart::new("position error [m]").line(Role::Method(0), "of the sum", error);
    let figure = Figure::new("Wheel odometry along a drive").subtitle(station.preset);
    let figure = figure.x_label("time [s]").panel(speed).panel(turn).panel(error);
    taken.folder.add("wheels.svg", figure.render());
    Ok(taken)
}

/// The steering stops there \[rad\].
const LOCK: f64 = 0.7;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct EncoderSettings {
    /// Distance between the axles \[m\].
    wheelbase: f64,
    steering_counts: u32,
    steering: SteeringNoise,
    wheel_counts: u32,
    wheel_radius: f64,
    drive: DriveSettings,
}

/// One reading with the truth: steering angles \[rad\], distances of a step \[m\].
struct Counted {
    steering: f64,
    count: SteeringCount,
    steering_read: f64,
    ticks: WheelTicks,
    distance: f64,
    distance_read: f64,
}

fn take_counts(station: &Station) -> Result<Taken> {
    let (steering_counts, wheel_counts, steering) = match station.preset {
        "coarse" => {
            let (backlash, zero_offset) = (1_f64.to_radians(), 0.5_f64.to_radians());
            (360, 64, SteeringNoise { backlash, zero_offset, ..SteeringNoise::NONE })
        }
        _ => (4096, 2048, SteeringNoise::NONE),
    };
    let (drive, wheelbase, wheel_radius) = (DriveSettings::new(20.0, 0.05), 0.5, 0.1);
    let settings =
        EncoderSettings { wheelbase, steering_counts, steering, wheel_counts, wheel_radius, drive };
    let settings = station.settings(settings)?;
    let car = Ackermann::new(settings.wheelbase)?;
    let steering = SteeringEncoder::new(settings.steering_counts)?;
    let mut steering = steering.with_noise(settings.steering)?;
    let mut wheel = WheelEncoder::new(settings.wheel_counts, settings.wheel_radius)?;
    let drive = station.drive(&settings.drive)?;
    let (mut rng, mut angle) = (station.errors(), 0.0_f64);
    let read = drive.steps.iter().map(|step| {
        // What cannot be driven by a car (turning on the spot) leaves the steering at its lock.
        angle = match car.wheels(step.twist) {
            Ok((speed, _)) if speed.abs() < 0.1 => angle,
            Ok((_, angle)) => angle.clamp(-LOCK, LOCK),
            Err(_) => LOCK.copysign(step.twist.omega),
        };
        let count = steering.measure(angle, &mut rng);
        let distance = step.twist.vx * settings.drive.time_step;
        let ticks = wheel.roll(distance);
        let (steering_read, distance_read) = (steering.angle(count), wheel.distance(ticks));
        Counted { steering: angle, count, steering_read, ticks, distance, distance_read }
    });
    let read: Vec<Counted> = read.collect();

    let mut taken = Taken::new(drive.start, &settings);
    let total = |of: fn(&Counted) -> f64| read.iter().map(of).sum::<f64>();
    let rms = |of: fn(&Counted) -> f64| rms(read.iter().map(of));
    let steering_error = |read: &Counted| read.steering_read - read.steering;
    taken.tell("readings", read.len());
    taken.tell("steering_resolution_deg", steering.resolution().to_degrees());
    taken.tell("steering_error_rms_deg", rms(steering_error).to_degrees());
    taken.tell("wheel_resolution_mm", 1e3 * wheel.resolution());
    taken.tell("way_error_rms_mm", rms(|read| 1e3 * (read.distance_read - read.distance)));
    taken.tell("distance_m", total(|read| read.distance));
    let error = total(|read| read.distance_read) - total(|read| read.distance);
    taken.tell("distance_error_mm", 1e3 * error);
    taken.table(
        "encoder.csv",
        ["time_s", "steering_count", "wheel_ticks", "true_steering_rad", "true_way_m"],
        drive.steps.iter().zip(&read).map(|(step, read)| {
            let (count, ticks) = (f64::from(read.count.0), read.ticks.0 as f64);
            [step.time, count, ticks, read.steering, read.distance]
        }),
    );
    taken.folder.add("drive.svg", drive.draw(station, "The drive that the encoders counted"));
    taken.folder.add("encoder.svg", draw_counts(&drive, &read, station.preset));
    Ok(taken)
}

fn draw_counts(drive: &Drive, read: &[Counted], preset: &str) -> String {
    let compared = |name: &str, of: fn(&Counted) -> f64, truth: fn(&Counted) -> f64| {
        let (of, truth) = (|k: usize, _: &Step| of(&read[k]), |k: usize, _: &Step| truth(&read[k]));
        drive.compared(name, "of the counts", dotted_truth(), of, truth)
    };
    let steering = compared(
        "steering angle [deg]",
        |read| read.steering_read.to_degrees(),
        |read| read.steering.to_degrees(),
    );
    let error = drive.over_time(|k, _| (read[k].steering_read - read[k].steering).to_degrees());
    let error = Chart::new("steering error [deg]")
        .line(Role::Method(1).width(1.0), "of the counts", error)
        .reference(0.0, "");
    let per_step = compared("way in a step [mm]", |r| 1e3 * r.distance_read, |r| 1e3 * r.distance);
    let figure = Figure::new("Counts of steering and wheel along a drive").subtitle(preset);
    figure.x_label("time [s]").panel(steering).panel(error).panel(per_step).render()
}
