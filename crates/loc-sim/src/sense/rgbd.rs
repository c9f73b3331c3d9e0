//! A depth camera: its two images, the point cloud, and the scan that it stands in for.

use super::{Place, Sensor, Station, Taken, mean, rms, xy};
use crate::Result;
use loc_core::Pose2;
use loc_maps::ExtrudedGrid;
use loc_plot::color::{self, DEPTH, Image};
use loc_plot::{Chart, Figure, Perspective, Picture, Pictures, Role};
use loc_sensors::laser::LaserScan;
use loc_sensors::rgbd::{CloudPoint, DepthCamera, DepthCameraSpec, DisparityNoise};
use loc_sensors::rgbd::{DepthImage, Frame, VirtualScan};
use loc_sensors::world::{RangeWorld, Rgb};
use nalgebra::Point3;
use serde::{Deserialize, Serialize};

pub(super) const SENSOR: Sensor = Sensor {
    name: "depth-camera",
    about: "an RGB-D camera (B7): depth and colour image, point cloud, virtual scan",
    presets: &[("xtion-pro", "640 x 480 at 30 Hz, 58 x 45 deg, 0.8 to 3.5 m, disparity in 1/8 px")],
    take,
};

/// Of the cloud's points one in this many is written, in each direction of the image.
const THIN: usize = 4;
/// What has no depth.
const NO_DEPTH: Rgb = [198, 200, 204];
/// Background, lines and size of the picture of the cloud.
const PAPER: Rgb = [247, 248, 250];
const INK: Rgb = [31, 35, 40];
const SIZE: (usize, usize) = (1200, 680);

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
    add_cloud(&mut taken, &frame, &camera);
    add_pictures(&mut taken, station, &camera, &frame);
    taken.folder.add("cloud.svg", over_map(station, &settings, pose, &frame, &scan));
    taken.folder.add("scan.svg", against_walls(station, &camera, pose, &scan));
    Ok(taken)
}

/// A place and direction with much in reach, at many depths.
fn view(place: &Place, camera: &DepthCamera) -> Result<Pose2> {
    let spec = &camera.spec;
    place.best_view(0.9, |pose| {
        let ranges = place.fan(pose, spec.horizontal_fov, spec.range_max);
        let in_reach =
            |range: &&f64| (2.0 * spec.range_min..0.95 * spec.range_max).contains(*range);
        let edges = ranges.windows(2).map(|pair| (pair[1] - pair[0]).abs().min(1.0)).sum::<f64>();
        0.6 * ranges.iter().filter(in_reach).count() as f64 + edges
    })
}

/// Adds every fourth point of every fourth row, in the camera's frame.
fn add_cloud(taken: &mut Taken, frame: &Frame, camera: &DepthCamera) {
    let (depths, colors) = (&frame.depth, frame.color.colors());
    let points = depths.points(&camera.spec);
    let kept = points.filter(|(column, row, _)| column % THIN == 0 && row % THIN == 0);
    let rows = kept.map(|(column, row, point)| {
        let color = colors.get(row * depths.width() + column).copied().unwrap_or_default();
        let [r, g, b] = color.map(f64::from);
        let [x, y, z] = [point.x, point.y, point.z].map(|value| (1e3 * value).round() / 1e3);
        [x, y, z, r, g, b]
    });
    taken.table("cloud.csv", ["x_m", "y_m", "z_m", "red", "green", "blue"], rows);
}

fn add_pictures(taken: &mut Taken, station: &Station, camera: &DepthCamera, frame: &Frame) {
    let (near, far) = (camera.spec.range_min, camera.spec.range_max);
    let color_of = |depth: &f32| {
        let share = (f64::from(*depth) - near) / (far - near);
        if share.is_finite() { color::along(&DEPTH, share) } else { NO_DEPTH }
    };
    let depths = frame.depth.depths().iter().map(color_of).collect();
    let depth = Image { width: frame.depth.width(), pixels: depths };
    let color = Image { width: frame.color.width(), pixels: frame.color.colors().to_vec() };
    let view = seen_from_behind(frame, camera);
    let place = station.place.name();
    let subtitle =
        format!("{} in {place}: grey has no depth, it is too near or too far", station.preset);
    let bar = color::bar(&DEPTH, near, far, "depth [m]");
    let depth_picture = Picture { bar: Some(bar), ..picture("depth image", &depth) };
    let figure = Pictures::new("What a depth camera sees")
        .subtitle(subtitle)
        .row([depth_picture, picture("colour image", &color)])
        .row([picture("point cloud, from behind the camera", &view)]);
    taken.folder.add("camera.svg", figure.render());
    for (name, image) in [("depth.png", &depth), ("color.png", &color), ("cloud.png", &view)] {
        taken.folder.add_bytes(name, image.png());
    }
    taken.folder.add_bytes("depth_mm.png", millimetres(&frame.depth));
}

/// An image in a figure.
fn picture(caption: &str, image: &Image) -> Picture {
    let aspect = image.width as f64 / image.height().max(1) as f64;
    Picture { caption: caption.into(), data_uri: image.data_uri(), aspect, bar: None }
}

/// Depths in whole millimetres as a PNG of 16 bits, 0 for none: the form of REP-118.
fn millimetres(depths: &DepthImage) -> Vec<u8> {
    // The cast saturates, and turns NaN into 0.
    let numbers = depths.depths().iter().map(|depth| (1e3 * depth).round() as u16);
    color::grey16_png(&numbers.collect::<Vec<_>>(), depths.width())
}

/// The cloud from a place behind, above and to the right of the camera, which is drawn as the
/// pyramid of its view.
fn seen_from_behind(frame: &Frame, camera: &DepthCamera) -> Image {
    let reach = camera.spec.range_max;
    let eye = Point3::new(-0.52 * reach, -0.52 * reach, 0.66 * reach);
    let target = Point3::new(0.50 * reach, 0.0, 0.75 - camera.height);
    let mut view = Perspective::new(eye, target, SIZE, 0.98 * SIZE.0 as f64, PAPER);
    for CloudPoint { position, color } in frame.cloud(&camera.spec) {
        view.dot(&position, color, 2);
    }
    let (left, up) = (camera.spec.horizontal_fov, camera.spec.vertical_fov);
    let corner = |(x, y): (f64, f64)| {
        let depth = 0.25 * reach;
        Point3::new(depth, x * depth * (0.5 * left).tan(), y * depth * (0.5 * up).tan())
    };
    let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)].map(corner);
    for (k, from) in corners.iter().enumerate() {
        view.line(from, &corners[(k + 1) % corners.len()], INK);
        view.line(&Point3::origin(), from, INK);
    }
    view.into_image()
}

fn over_map(
    station: &Station,
    settings: &Settings,
    pose: Pose2,
    frame: &Frame,
    scan: &LaserScan,
) -> String {
    let (camera, spec) = (&settings.camera, &settings.camera.spec);
    let eye = pose * camera.mounting;
    let VirtualScan { lower, upper, .. } = settings.virtual_scan;
    let note = format!("points {lower:.1} to {upper:.1} m above the floor make the scan");
    let points = |low: f64, high: f64| {
        let heights = low - camera.height..high - camera.height;
        let points = frame.depth.points(&camera.spec);
        let inside = points.filter(move |(_, _, point)| heights.contains(&point.z)).step_by(23);
        inside.map(move |(_, _, point)| xy(eye.transform(&point.xy()))).collect::<Vec<_>>()
    };
    let scanned = scan.points(camera.mounting).map(|point| xy(pose.transform(&point)));
    let scene = station.scene("The point cloud from above, and the scan made of it", &note);
    station
        .field_of_view(scene, eye, spec.horizontal_fov, spec.range_max)
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
    let wall = beams.clone().map(|k| (degrees(k), walls[k]));
    let scanned = beams.clone().map(|k| (degrees(k), scan.ranges[k]));
    let range = Chart::new("range [m]")
        .line(Role::Truth.width(1.2), "the map's wall", wall)
        .points(Role::Method(1).width(2.5), "virtual scan", scanned);
    let off = |error: f64| if error.abs() < 0.3 { 1e3 * error } else { f64::NAN };
    let errors = beams.map(|k| (degrees(k), off(scan.ranges[k] - walls[k])));
    let error = Chart::new("error [mm]")
        .points(Role::Method(1).width(2.5), "virtual scan", errors)
        .reference(0.0, "");
    let figure = Figure::new("The virtual scan beside the walls").subtitle(station.preset);
    figure.x_label("angle, counter-clockwise [deg]").panel(range).panel(error).render()
}
