//! Encoders of a car-like robot along a drive: counts of a wheel, and of the steering.

use super::drive::{DriveSettings, Step, over_time, path};
use super::station::rms;
use super::{Place, Sensor, Station, Taken};
use crate::Result;
use loc_core::kinematics::Ackermann;
use loc_plot::{Chart, Figure, Role};
use loc_sensors::encoder::{
    SteeringCount, SteeringEncoder, SteeringNoise, WheelEncoder, WheelTicks,
};
use serde::{Deserialize, Serialize};

pub(super) const SENSOR: Sensor = Sensor {
    name: "encoder",
    about: "rotary encoders (B2, B1): counts of a steering and of a wheel along a drive",
    presets: &[
        ("fine", "4096 counts a turn of the steering, 2048 a turn of the wheel"),
        ("coarse", "360 and 64 counts a turn, 1 deg of play, 0.5 deg off straight ahead"),
    ],
    take,
};

/// The steering stops there \[rad\].
const LOCK: f64 = 0.7;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Distance between the axles \[m\].
    wheelbase: f64,
    steering_counts: u32,
    steering: SteeringNoise,
    wheel_counts: u32,
    wheel_radius: f64,
    drive: DriveSettings,
}

/// One reading with the truth.
struct Read {
    steering: f64,
    count: SteeringCount,
    steering_read: f64,
    ticks: WheelTicks,
    way: f64,
    way_read: f64,
}

fn take(station: &Station) -> Result<Taken> {
    let (steering_counts, wheel_counts, steering) = match station.preset {
        "coarse" => {
            let (backlash, zero_offset) = (1_f64.to_radians(), 0.5_f64.to_radians());
            (360, 64, SteeringNoise { backlash, zero_offset, ..SteeringNoise::NONE })
        }
        _ => (4096, 2048, SteeringNoise::NONE),
    };
    let drive = DriveSettings::new(20.0, 0.05);
    let (wheelbase, wheel_radius) = (0.5, 0.1);
    let settings = station.settings(Settings {
        wheelbase,
        steering_counts,
        steering,
        wheel_counts,
        wheel_radius,
        drive,
    })?;
    let car = Ackermann::new(settings.wheelbase)?;
    let mut steering =
        SteeringEncoder::new(settings.steering_counts)?.with_noise(settings.steering)?;
    let mut wheel = WheelEncoder::new(settings.wheel_counts, settings.wheel_radius)?;
    let start = station.pose_or(Place::middle)?;
    let drive = settings.drive.drive(station.place, start)?;
    let mut rng = station.errors();
    let mut angle = 0.0_f64;
    let read: Vec<Read> = drive
        .iter()
        .map(|step| {
            // What cannot be driven by a car (turning on the spot) leaves the steering at its lock.
            angle = match car.wheels(step.twist) {
                Ok((speed, _)) if speed.abs() < 0.1 => angle,
                Ok((_, angle)) => angle.clamp(-LOCK, LOCK),
                Err(_) => LOCK.copysign(step.twist.omega),
            };
            let count = steering.measure(angle, &mut rng);
            let way = step.twist.vx * settings.drive.time_step;
            let ticks = wheel.roll(way);
            let (steering_read, way_read) = (steering.angle(count), wheel.distance(ticks));
            Read { steering: angle, count, steering_read, ticks, way, way_read }
        })
        .collect();

    let mut taken = Taken::new(start, &settings);
    let total = |of: fn(&Read) -> f64| read.iter().map(of).sum::<f64>();
    let off = rms(read.iter().map(|read| read.steering_read - read.steering));
    taken.tell("readings", read.len());
    taken.tell("steering_resolution_deg", steering.resolution().to_degrees());
    taken.tell("steering_error_rms_deg", off.to_degrees());
    taken.tell("wheel_resolution_mm", 1e3 * wheel.resolution());
    let way = rms(read.iter().map(|read| 1e3 * (read.way_read - read.way)));
    taken.tell("way_error_rms_mm", way);
    taken.tell("distance_m", total(|read| read.way));
    taken.tell("distance_error_mm", 1e3 * (total(|read| read.way_read) - total(|read| read.way)));
    taken.table(
        "encoder.csv",
        ["time_s", "steering_count", "wheel_ticks", "true_steering_rad", "true_way_m"],
        drive.iter().zip(&read).map(|(step, read)| {
            let count = f64::from(read.count.0);
            [step.time, count, read.ticks.0 as f64, read.steering, read.way]
        }),
    );
    let subtitle = format!("{} in {}", station.preset, station.place.name());
    let scene = station.scene("The drive that the encoders counted", &subtitle);
    let scene = scene.path(Role::Method(0), "true path", path(&drive));
    taken.folder.add("drive.svg", scene.poses(Role::Truth, "start", [start]).render());
    taken.folder.add("encoder.svg", in_time(&drive, &read, station.preset));
    Ok(taken)
}

fn in_time(drive: &[Step], read: &[Read], preset: &str) -> String {
    let steps = |of: &dyn Fn(&Read) -> f64| over_time(drive, |k, _| of(&read[k]));
    let steering = Chart::new("steering angle [deg]")
        .line(Role::Method(1), "of the counts", steps(&|r| r.steering_read.to_degrees()))
        .line(Role::Truth.dotted(), "truth", steps(&|r| r.steering.to_degrees()));
    let error = steps(&|r| (r.steering_read - r.steering).to_degrees());
    let error = Chart::new("steering error [deg]")
        .line(Role::Method(1).width(1.0), "of the counts", error)
        .reference(0.0, "");
    let per_step = Chart::new("way in a step [mm]")
        .line(Role::Method(1), "of the counts", steps(&|r| 1e3 * r.way_read))
        .line(Role::Truth.dotted(), "truth", steps(&|r| 1e3 * r.way));
    let figure = Figure::new("Counts of steering and wheel along a drive").subtitle(preset);
    figure.x_label("time [s]").panel(steering).panel(error).panel(per_step).render()
}
