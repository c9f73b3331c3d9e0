//! A depth camera: its two images, the point cloud, and the scan that it stands in for.

mod cloud;
mod picture;

use super::station::{mean, rms};
use super::{Place, Sensor, Station, Taken};
use crate::Result;
use loc_core::Pose2;
use loc_maps::ExtrudedGrid;
use loc_plot::{Chart, Figure, Pictures, Role};
use loc_sensors::laser::LaserScan;
use loc_sensors::rgbd::{DepthCamera, DepthCameraSpec, DisparityNoise, Frame, VirtualScan};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;
use serde::{Deserialize, Serialize};

pub(super) const SENSOR: Sensor = Sensor {
    name: "depth-camera",
    about: "an RGB-D camera (B7): depth and colour image, point cloud, virtual scan",
    presets: &[("xtion-pro", "640 x 480 at 30 Hz, 58 x 45 deg, 0.8 to 3.5 m, disparity in 1/8 px")],
    take,
};

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    camera: DepthCamera,
    virtual_scan: VirtualScan,
    /// Height of the walls \[m\].
    wall_height: f64,
}

fn take(station: &Station) -> Result<Taken> {
    let camera = DepthCamera::new(DepthCameraSpec::xtion_pro())?;
    let virtual_scan = VirtualScan::default();
    let settings = station.settings(Settings { camera, virtual_scan, wall_height: 2.5 })?;
    let camera = settings.camera;
    camera.check()?;
    let world = ExtrudedGrid::new(station.place.grid().clone(), settings.wall_height)?;
    let pose = station.pose_or(|place| view(place, &camera))?;
    let frame = camera.capture(&world, pose, &mut station.errors());
    let scan = settings.virtual_scan.of(&frame.depth, &camera)?;
    let perfect = DepthCameraSpec { noise: DisparityNoise::NONE, ..camera.spec };
    let perfect = DepthCamera { spec: perfect, ..camera };
    let truth = perfect.capture(&world, pose, &mut station.errors());

    let mut taken = Taken::new(pose, &settings);
    let pairs = || frame.depth.depths().iter().zip(truth.depth.depths());
    let errors = || pairs().map(|(read, truth)| f64::from(read - truth));
    let valid = frame.depth.depths().iter().filter(|depth| depth.is_finite()).count();
    taken.tell("pixels", frame.depth.depths().len());
    taken.tell("pixels_with_depth", valid);
    taken.tell("depth_mean_m", mean(frame.depth.depths().iter().map(|d| f64::from(*d))));
    taken.tell("depth_error_rms_mm", 1e3 * rms(errors()));
    taken.tell("scan_beams", scan.ranges.len());
    taken.tell("scan_beams_valid", scan.beams().count());
    taken.table(
        "scan.csv",
        ["beam", "angle_rad", "range_m"],
        scan.ranges.iter().enumerate().map(|(k, range)| [k as f64, scan.angle(k), *range]),
    );
    cloud::add_table(&mut taken, &frame, &camera);
    add_pictures(&mut taken, station, &camera, &frame);
    taken.folder.add("cloud.svg", over_map(station, &settings, pose, &frame, &scan));
    taken.folder.add("scan.svg", against_walls(station, &camera, pose, &scan));
    Ok(taken)
}

/// A place and direction with much in reach, at many depths.
fn view(place: &Place, camera: &DepthCamera) -> Result<Pose2> {
    let spec = &camera.spec;
    place.best_view(0.9, |pose| {
        let turn = |k: i32| {
            let heading = pose.theta + f64::from(k) / 24.0 * spec.horizontal_fov;
            Pose2::new(pose.x, pose.y, heading)
        };
        let ranges: Vec<f64> = (-12..=12).map(|k| place.range(turn(k), spec.range_max)).collect();
        let in_reach =
            |range: &&f64| (2.0 * spec.range_min..0.95 * spec.range_max).contains(*range);
        let edges = ranges.windows(2).map(|pair| (pair[1] - pair[0]).abs().min(1.0)).sum::<f64>();
        0.6 * ranges.iter().filter(in_reach).count() as f64 + edges
    })
}

fn add_pictures(taken: &mut Taken, station: &Station, camera: &DepthCamera, frame: &Frame) {
    let spec = &camera.spec;
    let depth = picture::of_depths(&frame.depth, (spec.range_min, spec.range_max));
    let color = picture::of_colors(&frame.color);
    let view = cloud::seen_from_behind(frame, camera);
    let subtitle = format!(
        "{} in {}: grey has no depth, it is too near or too far",
        station.preset,
        station.place.name()
    );
    let figure = Pictures::new("What a depth camera sees").subtitle(subtitle);
    let (low, high) = (spec.range_min, spec.range_max);
    let figure = figure
        .row([
            picture::shown("depth image", &depth).with_bar(low, high),
            picture::shown("colour image", &color).plain(),
        ])
        .row([picture::shown("point cloud, from behind the camera", &view).plain()]);
    taken.folder.add("camera.svg", figure.render());
    for (name, image) in [("depth.png", &depth), ("color.png", &color), ("cloud.png", &view)] {
        taken.folder.add_bytes(name, image.png());
    }
    taken.folder.add_bytes("depth_mm.png", picture::millimetres(&frame.depth));
}

fn over_map(
    station: &Station,
    settings: &Settings,
    pose: Pose2,
    frame: &Frame,
    scan: &LaserScan,
) -> String {
    let camera = &settings.camera;
    let eye = pose * camera.mounting;
    let subtitle = format!(
        "{} in {}: points {:.1} to {:.1} m above the floor make the scan",
        station.preset,
        station.place.name(),
        settings.virtual_scan.lower,
        settings.virtual_scan.upper
    );
    let edge = |side: f64| {
        let turn = Pose2::new(eye.x, eye.y, eye.theta + 0.5 * side * camera.spec.horizontal_fov);
        let range = station.place.range(turn, camera.spec.range_max);
        let end = turn.transform(&Point2::new(range, 0.0));
        ((eye.x, eye.y), (end.x, end.y))
    };
    let points = |low: f64, high: f64| {
        let heights = low - camera.height..high - camera.height;
        let points = frame.depth.points(&camera.spec);
        let inside = points.filter(move |(_, _, point)| heights.contains(&point.z)).step_by(23);
        let place = move |(_, _, point): (_, _, nalgebra::Point3<f64>)| {
            let place = eye.transform(&point.xy());
            (place.x, place.y)
        };
        inside.map(place).collect::<Vec<_>>()
    };
    let scanned = scan.points(camera.mounting).map(|point| {
        let place = pose.transform(&point);
        (place.x, place.y)
    });
    let VirtualScan { lower, upper, .. } = settings.virtual_scan;
    station
        .scene("The point cloud from above, and the scan made of it", &subtitle)
        .segments(Role::Reference.dashed().width(1.0), "field of view", [edge(-1.0), edge(1.0)])
        .dots(Role::Method(2).width(1.6), "floor", points(-1.0, lower))
        .dots(Role::Method(3).width(3.8), "above the scan", points(upper, 100.0))
        .dots(Role::Method(0).width(2.8), "in the scan's heights", points(lower, upper))
        .dots(Role::Method(1).width(1.8), "virtual scan", scanned)
        .poses(Role::Truth, "camera", [eye])
        .render()
}

/// The virtual scan beside the ranges to the walls of the map.
fn against_walls(station: &Station, camera: &DepthCamera, pose: Pose2, scan: &LaserScan) -> String {
    let eye = pose * camera.mounting;
    let degrees = |k: usize| scan.angle(k).to_degrees();
    let beams = 0..scan.ranges.len();
    let wall = |k: usize| {
        let direction = eye.theta + scan.angle(k);
        let range = station.place.walls().cast(&eye.position(), direction, scan.range_max);
        range.unwrap_or(f64::NAN)
    };
    let walls: Vec<f64> = beams.clone().map(wall).collect();
    let range = Chart::new("range [m]")
        .line(
            Role::Truth.width(1.2),
            "the map's wall",
            beams.clone().map(|k| (degrees(k), walls[k])),
        )
        .points(
            Role::Method(1).width(2.5),
            "virtual scan",
            beams.clone().map(|k| (degrees(k), scan.ranges[k])),
        );
    let off = |error: f64| if error.abs() < 0.3 { 1e3 * error } else { f64::NAN };
    let errors = beams.map(|k| (degrees(k), off(scan.ranges[k] - walls[k])));
    let error = Chart::new("error [mm]")
        .points(Role::Method(1).width(2.5), "virtual scan", errors)
        .reference(0.0, "");
    let figure = Figure::new("The virtual scan beside the walls").subtitle(station.preset);
    figure.x_label("angle, counter-clockwise [deg]").panel(range).panel(error).render()
}
