//! A satellite receiver along a drive.

use super::drive::{Drive, DriveSettings, Step};
use super::{Sensor, Station, Taken, rms};
use crate::Result;
use loc_plot::{Chart, Figure, Role};
use loc_sensors::gnss::{Geodetic, Gnss, GnssFix, GnssNoise, LocalFrame, Outages};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

pub(super) const SENSOR: Sensor = Sensor {
    name: "gnss",
    about: "satellite positions (B10) along a drive",
    presets: &[
        ("neo-m8", "2.5 m CEP, most of it drifting within minutes, 1 Hz"),
        ("neo-m8-outages", "the same with outages: one a minute, 10 s long on average"),
    ],
    take,
};

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// Where the origin of the map lies on the Earth.
    origin: Geodetic,
    noise: GnssNoise,
    outages: Outages,
    /// Time from one fix to the next \[s\].
    interval: f64,
    drive: DriveSettings,
}

/// A fix with the truth.
struct Fix {
    time: f64,
    error: Vector3<f64>,
    fix: GnssFix,
}

fn take(station: &Station) -> Result<Taken> {
    let outages = match station.preset {
        "neo-m8-outages" => Outages { rate: 1.0 / 60.0, mean_duration: 10.0 },
        _ => Outages::NONE,
    };
    let settings = station.settings(Settings {
        origin: Geodetic::from_degrees(52.2719, 8.0443, 64.0)?,
        noise: GnssNoise::neo_m8(),
        outages,
        interval: 1.0,
        drive: DriveSettings::new(240.0, 0.1),
    })?;
    loc_core::error::positive("interval [s]", settings.interval)?;
    let frame = LocalFrame::new(settings.origin)?;
    let receiver = Gnss::new(frame).with_noise(settings.noise)?.with_outages(settings.outages)?;
    let drive = station.drive(&settings.drive)?;
    let every = (settings.interval / settings.drive.time_step).round().clamp(1.0, 1e6) as usize;
    let steps: Vec<&Step> = drive.steps.iter().skip(every - 1).step_by(every).collect();
    let fixes = fixes(station, &settings, receiver, &frame, &steps);

    let mut taken = Taken::new(drive.start, &settings);
    let error = |of: fn(&Fix) -> f64| rms(fixes.iter().map(of));
    taken.tell("asked", steps.len());
    taken.tell("fixes", fixes.len());
    taken.tell("sigma_m", settings.noise.sigma());
    taken.tell("east_error_rms_m", error(|fix| fix.error.x));
    taken.tell("north_error_rms_m", error(|fix| fix.error.y));
    taken.tell("up_error_rms_m", error(|fix| fix.error.z));
    let mut planar: Vec<f64> = fixes.iter().map(|fix| fix.error.xy().norm()).collect();
    planar.sort_by(f64::total_cmp);
    taken.tell("planar_error_median_m", planar.get(planar.len() / 2).copied());
    taken.table(
        "gnss.csv",
        ["time_s", "latitude_deg", "longitude_deg", "height_m", "east_error_m", "north_error_m"],
        fixes.iter().map(|Fix { time, error, fix }| {
            let Geodetic { latitude, longitude, height } = fix.position;
            [*time, latitude.to_degrees(), longitude.to_degrees(), height, error.x, error.y]
        }),
    );
    taken.folder.add("gnss.svg", over_map(station, &frame, &drive, &fixes));
    taken.folder.add("errors.svg", in_time(&settings, &steps, &fixes, station.preset));
    Ok(taken)
}

fn fixes(
    station: &Station,
    settings: &Settings,
    mut receiver: Gnss,
    frame: &LocalFrame,
    steps: &[&Step],
) -> Vec<Fix> {
    let mut rng = station.errors();
    let one = |step: &&Step| {
        let fix = receiver.measure(step.pose, settings.interval, &mut rng)?;
        let truth = Vector3::new(step.pose.x, step.pose.y, 0.0);
        Some(Fix { time: step.time, error: frame.to_enu(&fix.position) - truth, fix })
    };
    steps.iter().filter_map(one).collect()
}

fn over_map(station: &Station, frame: &LocalFrame, drive: &Drive, fixes: &[Fix]) -> String {
    let note = format!("{} fixes; ellipses show what the receiver claims", fixes.len());
    let place = |fix: &Fix| fix.fix.in_plane(frame);
    let claimed = fixes.iter().step_by(fixes.len().div_ceil(4).max(1));
    let claimed = claimed.map(|fix| place(fix).ellipse(2.0));
    let dots = fixes.iter().map(place).map(|belief| (belief.mean.x, belief.mean.y));
    station
        .scene("Positions by satellite along a drive", &note)
        .ellipses(Role::Method(5).width(1.0), "claimed, 2 sigma", claimed)
        .path(Role::Truth.dotted(), "true path", drive.path())
        .dots(Role::Method(1).width(3.0), "fix", dots)
        .render()
}

fn in_time(settings: &Settings, steps: &[&Step], fixes: &[Fix], preset: &str) -> String {
    // A line breaks where there is no fix.
    let mut next = fixes.iter().peekable();
    let rows: Vec<(f64, Vector3<f64>)> = steps
        .iter()
        .map(|step| {
            let found = next.next_if(|fix| fix.time <= step.time + 1e-9);
            (step.time, found.map_or(Vector3::repeat(f64::NAN), |fix| fix.error))
        })
        .collect();
    let sigma = 2.0 * settings.noise.sigma();
    let chart = |name: &str, axis: usize, factor: f64| {
        let band = rows.iter().map(|(time, _)| (*time, -factor * sigma, factor * sigma));
        Chart::new(name)
            .band(Role::Method(5), "claimed, 2 sigma", band)
            .line(Role::Method(1).width(1.2), "fix", rows.iter().map(|(t, e)| (*t, e[axis])))
            .reference(0.0, "")
    };
    let figure = Figure::new("Errors of the fixes over time").subtitle(preset);
    figure
        .x_label("time [s]")
        .panel(chart("error to the east [m]", 0, 1.0))
        .panel(chart("error to the north [m]", 1, 1.0))
        .panel(chart("error upwards [m]", 2, settings.noise.vertical_factor))
        .render()
}
