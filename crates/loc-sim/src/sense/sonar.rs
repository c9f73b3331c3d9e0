//! A ring of ultrasonic rangers: the echo in each cone, and the walls that give none.

use super::{Place, Sensor, Station, Taken, check_count, rms, xy};
use crate::Result;
use loc_core::{Pose2, angle};
use loc_plot::{Chart, Figure, Role};
use loc_sensors::sonar::{Sonar, SonarNoise, SonarRange, SonarSpec};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

pub(super) const SENSOR: Sensor = Sensor {
    name: "sonar",
    about: "a ring of sonars (B11): one range in each cone",
    presets: &[
        ("polaroid-6500", "0.15 to 10.7 m, 1 %, cone of 30 deg, a ring of 16"),
        ("hc-sr04", "0.02 to 4 m, sigma 3 mm, cone of 30 deg, a ring of 8"),
    ],
    take,
};

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    /// How many sonars stand around the robot.
    count: usize,
    /// Radius of the ring \[m\].
    ring_radius: f64,
    spec: SonarSpec,
}

/// One of the ring: its direction on the robot, its place in the map, what it read, what it would
/// have read without errors, and the nearest wall in its cone.
struct Echo {
    direction: f64,
    sonar: Pose2,
    read: SonarRange,
    perfect: f64,
    nearest: f64,
}

fn take(station: &Station) -> Result<Taken> {
    let (spec, count) = match station.preset {
        "hc-sr04" => (SonarSpec::hc_sr04(), 8),
        _ => (SonarSpec::polaroid_6500(), 16),
    };
    let settings = station.settings(Settings { count, ring_radius: 0.2, spec })?;
    settings.spec.check()?;
    loc_core::error::non_negative("ring_radius [m]", settings.ring_radius)?;
    check_count("count", "1 to 1000 sonars", 1..=1000, settings.count)?;
    let pose = station.pose_or(view)?;
    let echoes = measure_all(station, &settings, pose);

    let mut taken = Taken::new(pose, &settings);
    let valid = || echoes.iter().filter(|echo| echo.read.is_valid());
    let error = |echo: &Echo| echo.read.range - echo.perfect;
    let missed = echoes.iter().filter(|e| e.perfect > e.nearest + 0.05 || e.perfect.is_infinite());
    taken.tell("sonars", echoes.len());
    taken.tell("heard", valid().count());
    taken.tell("no_echo", echoes.iter().filter(|e| e.read.range == f64::INFINITY).count());
    taken.tell("nearest_wall_missed", missed.filter(|e| e.nearest.is_finite()).count());
    taken.tell("error_rms_mm", 1e3 * rms(valid().map(error)));
    taken.tell("past_nearest_wall_rms_m", rms(valid().map(|e| e.perfect - e.nearest)));
    taken.table(
        "sonar.csv",
        ["direction_rad", "range_m", "noise_free_m", "nearest_wall_m"],
        echoes.iter().map(|e| [e.direction, e.read.range, e.perfect, e.nearest]),
    );
    taken.folder.add("sonar.svg", over_map(station, &echoes, pose));
    taken.folder.add("ranges.svg", over_angle(&echoes, station.preset));
    Ok(taken)
}

fn view(place: &Place) -> Result<Pose2> {
    place.best_view(0.8, |pose| {
        let turn = |k| Pose2::new(pose.x, pose.y, pose.theta + f64::from(k) * TAU / 16.0);
        (0..16).map(|k| place.range(turn(k), 5.0)).map(|range| -(range - 2.0).abs()).sum()
    })
}

fn measure_all(station: &Station, settings: &Settings, pose: Pose2) -> Vec<Echo> {
    let walls = station.place.walls();
    let mut rng = station.errors();
    let step = TAU / settings.count as f64;
    let one = |k: usize| {
        let direction = angle::wrap(k as f64 * step);
        let (sin, cos) = direction.sin_cos();
        let mounting =
            Pose2::new(settings.ring_radius * cos, settings.ring_radius * sin, direction);
        let sonar = Sonar { mounting, spec: settings.spec };
        let perfect = SonarSpec { noise: SonarNoise::NONE, ..settings.spec };
        let at = pose * mounting;
        let mut fan = vec![f64::INFINITY; 61];
        let (first, turn) = (at.theta - 0.5 * settings.spec.cone, settings.spec.cone / 60.0);
        walls.cast_fan(&at.position(), first, turn, settings.spec.range_max, &mut fan);
        Echo {
            direction,
            sonar: at,
            read: sonar.measure(walls, pose, &mut rng),
            perfect: Sonar { mounting, spec: perfect }.measure(walls, pose, &mut rng).range,
            nearest: fan.into_iter().fold(f64::INFINITY, f64::min),
        }
    };
    (0..settings.count).map(one).collect()
}

/// The outline of a cone up to a range.
fn cone(echo: &Echo, range: f64) -> Vec<(f64, f64)> {
    let tip = [(echo.sonar.x, echo.sonar.y)];
    [&tip[..], &arc(echo, range), &tip].concat()
}

fn arc(echo: &Echo, range: f64) -> Vec<(f64, f64)> {
    let point = |k: i32| {
        let (sin, cos) = (f64::from(k) / 24.0 * echo.read.cone).sin_cos();
        xy(echo.sonar.transform(&Point2::new(range * cos, range * sin)))
    };
    (-12..=12).map(point).collect()
}

fn over_map(station: &Station, echoes: &[Echo], pose: Pose2) -> String {
    let valid = || echoes.iter().filter(|echo| echo.read.is_valid());
    let silent = echoes.iter().filter(|echo| !echo.read.is_valid());
    let note = "an echo came from somewhere on each arc; walls met at a slant give none";
    let mut scene = station.scene("What a ring of sonars hears", note);
    for echo in valid() {
        scene = scene.path(Role::Method(5).width(0.7), "cone", cone(echo, echo.read.range));
    }
    for echo in valid() {
        scene = scene.path(Role::Method(1).width(3.0), "echo", arc(echo, echo.read.range));
    }
    for echo in silent {
        let stub = cone(echo, 0.6_f64.min(echo.read.range_max));
        scene = scene.path(Role::Method(3).dashed().width(1.2), "no echo", stub);
    }
    scene.poses(Role::Truth, "robot", [pose]).render()
}

fn over_angle(echoes: &[Echo], preset: &str) -> String {
    let mut sorted: Vec<&Echo> = echoes.iter().collect();
    sorted.sort_by(|a, b| a.direction.total_cmp(&b.direction));
    let at = |of: fn(&Echo) -> f64| sorted.iter().map(move |e| (e.direction.to_degrees(), of(e)));
    let chart = Chart::new("range [m]")
        .line(Role::Truth.dotted(), "nearest wall in the cone", at(|e| e.nearest))
        .points(Role::Method(5).width(9.0), "echo without errors", at(|e| e.perfect))
        .points(Role::Method(1).width(5.0), "reading", at(|e| e.read.range));
    let figure = Figure::new("Readings of a ring of sonars").subtitle(preset);
    figure.x_label("direction of the sonar [deg]").panel(chart).render()
}
