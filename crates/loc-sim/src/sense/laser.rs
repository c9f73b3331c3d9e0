//! A laser scan over the map with its errors beam by beam, and a scan out of a recording with the
//! lines that are found in it.

use super::{Place, Reading, Sensor, Station, Taken, check_twist, csv, mean, rms, xy};
use crate::output::{Folder, backdrop};
use crate::source::carmen::CarmenLog;
use crate::{Error, Result};
use loc_core::{Pose2, Twist2};
use loc_maps::grid::io;
use loc_plot::{Chart, Figure, Role, Scene};
use loc_sensors::features::{Line, LineExtractor};
use loc_sensors::laser::{LaserFaults, LaserNoise, LaserScan, LaserScanner, LaserSpec};
use loc_sensors::world::{Glazed, Pane, Surface};
use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::path::Path;

pub(super) const SENSOR: Sensor = Sensor {
    name: "laser",
    about: "a laser scan (B8): ranges in a plane",
    presets: &[
        ("hokuyo-ust-10lx", "270 deg in 0.25 deg, 40 Hz, 0.06 to 10 m, sigma 30 mm"),
        ("sick-lms100", "270 deg in 0.25 deg, 25 Hz, 0.5 to 18 m, sigma 12 mm"),
        ("sick-lms100-50hz", "270 deg in 0.5 deg, 50 Hz, 0.5 to 18 m, sigma 12 mm"),
    ],
    take,
};

/// How many beams are drawn.
const RAYS: usize = 90;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    mounting: Pose2,
    spec: LaserSpec,
    faults: LaserFaults,
    /// Velocity of the robot during the sweep.
    velocity: Twist2,
    panes: Vec<Pane>,
}

fn take(station: &Station) -> Result<Taken> {
    let spec = match station.preset {
        "sick-lms100" => LaserSpec::sick_lms100(),
        "sick-lms100-50hz" => LaserSpec::sick_lms100_50_hz(),
        _ => LaserSpec::hokuyo_ust_10lx(),
    };
    let settings = station.settings(Settings {
        mounting: Pose2::IDENTITY,
        spec,
        faults: LaserFaults::NONE,
        velocity: Twist2::ZERO,
        panes: Vec::new(),
    })?;
    let Settings { mounting, spec, faults, velocity, .. } = settings;
    let scanner = LaserScanner { mounting, spec, faults };
    scanner.check()?;
    check_twist(velocity)?;
    let walls = station.place.walls();
    let world = Glazed::new(walls, settings.panes.iter().copied())?;
    let pose = station.pose_or(|place| view(place, &spec))?;
    let scan = scanner.scan_moving(&world, pose, velocity, &mut station.errors());
    let perfect = LaserScanner {
        faults: LaserFaults::NONE,
        spec: LaserSpec { noise: LaserNoise::NONE, ..spec },
        ..scanner
    };
    let truth = perfect.scan_moving(walls, pose, velocity, &mut station.errors());

    let mut taken = Taken::new(pose, &settings);
    let error: Vec<f64> = errors(&scan, &truth);
    let count = |is: fn(f64) -> bool| scan.ranges.iter().filter(|range| is(**range)).count();
    taken.tell("beams", scan.ranges.len());
    taken.tell("valid", scan.beams().count());
    taken.tell("no_return", count(|range| range == f64::INFINITY));
    taken.tell("too_close", count(|range| range == f64::NEG_INFINITY));
    taken.tell("erroneous", count(f64::is_nan));
    let lines = LineExtractor::new(spec.noise).extract(&scan).unwrap_or_default();
    taken.tell("lines", lines.len());
    taken.tell("range_mean_m", mean(scan.beams().map(|beam| beam.range)));
    taken.tell("error_mean_mm", 1e3 * mean(error.iter().copied()));
    taken.tell("error_rms_mm", 1e3 * rms(error.iter().copied()));
    taken.table(
        "scan.csv",
        ["beam", "angle_rad", "range_m", "map_range_m"],
        (0..scan.ranges.len()).map(|k| [k as f64, scan.angle(k), scan.ranges[k], truth.ranges[k]]),
    );
    taken.folder.add("scan.svg", over_map(station, &settings, pose, &scan, &lines));
    taken.folder.add("ranges.svg", over_angle(&scan, &truth, &error, station.preset));
    Ok(taken)
}

/// A place from which much is seen at many different ranges.
fn view(place: &Place, spec: &LaserSpec) -> Result<Pose2> {
    place.best_view(0.8, |pose| {
        let rays = 24;
        let step = (spec.angle_max() - spec.angle_min) / f64::from(rays - 1);
        let heading = |k| pose.theta + spec.angle_min + f64::from(k) * step;
        let reach = 0.9 * spec.range_max;
        let ranges = (0..rays).map(|k| place.range(Pose2::new(pose.x, pose.y, heading(k)), reach));
        let seen = ranges.filter(|range| *range < reach);
        seen.map(f64::sqrt).sum::<f64>() + 0.1 * place.range(pose, reach)
    })
}

fn errors(scan: &LaserScan, truth: &LaserScan) -> Vec<f64> {
    let error = |(range, true_range): (&f64, &f64)| {
        let both = scan.is_valid(*range) && scan.is_valid(*true_range);
        if both { range - true_range } else { f64::NAN }
    };
    scan.ranges.iter().zip(&truth.ranges).map(error).collect()
}

fn over_map(
    station: &Station,
    settings: &Settings,
    pose: Pose2,
    scan: &LaserScan,
    lines: &[Line],
) -> String {
    let Settings { mounting, velocity, .. } = *settings;
    let (beams, valid) = (scan.ranges.len(), scan.beams().count());
    let every = beams.div_ceil(RAYS);
    let note = format!("{valid} of {beams} beams returned; every {every}th is drawn");
    let in_map = |point: Point2<f64>| xy(pose.transform(&point));
    let laser = pose * mounting;
    let mut scene = station.scene("A laser scan over the map", &note);
    let rays = scan.beams().filter(|beam| beam.index.is_multiple_of(every));
    let rays = rays.map(|beam| ((laser.x, laser.y), xy(laser.transform(&beam.point()))));
    scene = scene.segments(Role::Method(5).width(0.7), "beam", rays);
    for pane in &settings.panes {
        let (role, label) = match pane.surface {
            Surface::Glass { .. } => (Role::Method(2), "glass"),
            Surface::Mirror => (Role::Method(3), "mirror"),
        };
        let ends = (pane.from.into(), pane.to.into());
        scene = scene.segments(role.width(2.5), label, [ends]);
    }
    let ends = scan.points(mounting).map(in_map);
    if velocity == Twist2::ZERO {
        scene = scene.dots(Role::Method(1), "where a beam ended", ends);
        scene = lines_over(scene, laser, lines);
    } else {
        scene = scene.dots(Role::Method(3), "taken from the first beam's pose", ends);
        let ends = scan.points_of_moving(mounting, velocity).map(in_map);
        scene = scene.dots(Role::Method(1), "with the robot's motion", ends);
    }
    scene.poses(Role::Truth, "scanner", [laser]).render()
}

fn over_angle(scan: &LaserScan, truth: &LaserScan, error: &[f64], preset: &str) -> String {
    let degrees = |k: usize| scan.angle(k).to_degrees();
    let valid = |range: f64| if scan.is_valid(range) { range } else { f64::NAN };
    let beams = 0..scan.ranges.len();
    let map = beams.clone().map(|k| (degrees(k), valid(truth.ranges[k])));
    let read = beams.clone().map(|k| (degrees(k), valid(scan.ranges[k])));
    let lost = beams.clone().filter(|k| !scan.is_valid(scan.ranges[*k]));
    let lost: Vec<_> = lost.map(|k| (degrees(k), 0.0)).collect();
    let range = Chart::new("range [m]")
        .line(Role::Truth.width(1.2), "the map's wall", map)
        .points(Role::Method(1).width(2.0), "reading", read)
        .points(Role::Method(3).width(3.0), if lost.is_empty() { "" } else { "no reading" }, lost);
    // What faults and panes do is far beyond noise, and would hide it.
    let noise = |e: f64| if e.abs() < 0.3 { 1e3 * e } else { f64::NAN };
    let errors = beams.map(|k| (degrees(k), noise(error[k])));
    let error = Chart::new("error [mm]")
        .points(Role::Method(1).width(2.0), "reading", errors)
        .reference(0.0, "");
    let figure = Figure::new("Ranges and their errors, beam by beam").subtitle(preset);
    figure.x_label("angle, counter-clockwise [deg]").panel(range).panel(error).render()
}

/// Draws scan `index` (counted from 0) of a CARMEN log and the lines in it: over a map at the pose
/// that the log gives, or else around the scanner.
///
/// # Errors
/// What is wrong with the log or the map, and [`Error::Recording`] for a scan that it has not.
pub fn recorded_scan(log: &Path, index: usize, map: Option<&Path>) -> Result<Reading> {
    let lasers = CarmenLog::open(log)?.lasers()?;
    let Some(laser) = lasers.get(index) else {
        return Err(Error::Recording {
            path: log.to_owned(),
            expected: format!("one of its {} scans, counted from 0", lasers.len()),
            found: format!("scan {index}"),
        });
    };
    let pose = if map.is_some() { laser.laser } else { Pose2::IDENTITY };
    let lines = LineExtractor::default().extract(&laser.scan)?;
    let name = log.file_name().unwrap_or_default().to_string_lossy();
    let title = format!("scan {index} of {name}");
    let mut scene = Scene::new("Lines in a recorded scan").subtitle(title.clone());
    if let Some(map) = map {
        scene = backdrop(&io::load(map)?).map_or(scene.clone(), |image| scene.backdrop(image));
    }
    let mut folder = Folder::default();
    let ends = laser.scan.beams().map(|beam| xy(pose.transform(&beam.point())));
    let scene = scene.dots(Role::Method(1), "where a beam ended", ends);
    let scene = lines_over(scene, pose, &lines).poses(Role::Truth, "scanner", [pose]);
    folder.add("scan.svg", scene.render());
    folder.add("lines.csv", table(&lines));
    let covered: usize = lines.iter().map(|line| line.points).sum();
    let results = vec![
        ("beams", json!(laser.scan.ranges.len())),
        ("valid", json!(laser.scan.beams().count())),
        ("lines", json!(lines.len())),
        ("beams_on_lines", json!(covered)),
    ];
    let figures: serde_json::Map<_, _> =
        results.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
    let summary = json!({"log": name, "scan": index, "stamp": laser.stamp, "results": figures});
    folder.add("summary.json", format!("{summary:#}\n"));
    Ok(Reading { title, results, summary, folder })
}

/// The segments of lines in the frame of a scanner at `laser`.
fn lines_over(scene: Scene, laser: Pose2, lines: &[Line]) -> Scene {
    let end = |point| xy(laser.transform(point));
    let segments = lines.iter().map(|line| (end(&line.start), end(&line.end)));
    scene.segments(Role::Method(2).width(2.5), "line found", segments)
}

fn table(lines: &[Line]) -> String {
    let columns = [
        "r_m",
        "alpha_rad",
        "sigma_r_m",
        "sigma_alpha_rad",
        "points",
        "x1_m",
        "y1_m",
        "x2_m",
        "y2_m",
    ];
    let row = |l: &Line| {
        let [sigma_r, sigma_alpha] = [l.covariance.m11, l.covariance.m22].map(f64::sqrt);
        let (start, end) = (l.start, l.end);
        [l.r, l.alpha, sigma_r, sigma_alpha, l.points as f64, start.x, start.y, end.x, end.y]
    };
    csv(columns, lines.iter().map(row))
}
