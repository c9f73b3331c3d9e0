use approx::assert_relative_eq;
use loc_core::Pose2;
use loc_core::random::stream;
use loc_core::stats::RunningMoments;
use loc_sensors::rgbd::{
    ColorImage, DepthCamera, DepthCameraSpec, DepthImage, DisparityNoise, Frame, VirtualScan,
};
use loc_sensors::world::{Extruded, Room, WallHit, WallWorld};
use nalgebra::Point2;

fn perfect() -> DepthCamera {
    let spec = DepthCameraSpec { noise: DisparityNoise::NONE, ..DepthCameraSpec::xtion_pro() };
    DepthCamera::new(spec).unwrap()
}

fn capture(camera: &DepthCamera, world: &(impl WallWorld + ?Sized)) -> Frame {
    camera.capture(world, Pose2::IDENTITY, &mut stream(1, "camera"))
}

/// Walls x = 2 and x = 3 across the view, the nearer one of the given height.
struct Steps {
    near_height: f64,
}

impl WallWorld for Steps {
    fn visit_walls(
        &self,
        origin: &Point2<f64>,
        direction: f64,
        max_range: f64,
        visit: &mut dyn FnMut(WallHit) -> bool,
    ) {
        for (x, height, color) in [(2.0, self.near_height, [255, 0, 0]), (3.0, 5.0, [0, 0, 255])] {
            let range = (x - origin.x) / direction.cos();
            if range > 0.0 && range <= max_range && !visit(WallHit { range, height, color }) {
                return;
            }
        }
    }

    fn floor_color(&self) -> [u8; 3] {
        [0, 255, 0]
    }
}

#[test]
fn the_preset_has_the_figures_of_its_data_sheet() {
    let spec = DepthCameraSpec::xtion_pro();
    spec.check().unwrap();
    assert_eq!((spec.width, spec.height, spec.rate), (640, 480, 30.0));
    assert_eq!((spec.range_min, spec.range_max), (0.8, 3.5));
    assert_relative_eq!(spec.column_slopes()[0].atan().to_degrees(), 29.0, epsilon = 0.05);
    assert_relative_eq!(spec.row_slopes()[479].atan().to_degrees(), -22.5, epsilon = 0.05);
    // Khoshelham and Elberink: sigma = 1.425e-3 z^2 for the Kinect, focal length 580 px as well.
    assert_relative_eq!(spec.sigma_at(2.0), 1.43e-3 * 4.0, max_relative = 0.02);
}

/// Camera 0.5 m up; a wall 0.2 m high at 2 m, a high one at 3 m.
#[test]
fn a_low_wall_before_a_high_one_by_hand() {
    let frame = capture(&perfect(), &Steps { near_height: 0.2 });
    let slopes = perfect().spec.row_slopes();
    for (row, slope) in slopes.iter().enumerate() {
        let (depth, color) = match slope {
            _ if *slope < -0.5 / 2.0 => (0.5 / -slope, [0, 255, 0]),
            _ if *slope < -0.3 / 2.0 => (2.0, [255, 0, 0]),
            _ => (3.0, [0, 0, 255]),
        };
        for column in [0, 320, 639] {
            assert_relative_eq!(f64::from(frame.depth.at(column, row)), depth, epsilon = 1e-6);
            assert_eq!(frame.color.colors()[row * 640 + column], color);
        }
    }
    // A wall of camera height hides all below the horizon, one above it everything.
    let frame = capture(&perfect(), &Steps { near_height: 0.5 });
    assert_eq!([frame.depth.at(5, 239), frame.depth.at(5, 240)], [3.0, 2.0]);
    let frame = capture(&perfect(), &Steps { near_height: 5.0 });
    assert_eq!([frame.depth.at(5, 0), frame.depth.at(5, 240)], [2.0, 2.0]);
}

/// Camera 0.6 m up: over the edge of a wall 0.1 m high the floor goes on to the foot of the next.
#[test]
fn floor_shows_between_walls_seen_from_above() {
    let camera = DepthCamera { height: 0.6, ..perfect() };
    let frame = capture(&camera, &Steps { near_height: 0.1 });
    let (red, green, blue) = ([255, 0, 0], [0, 255, 0], [0, 0, 255]);
    for (row, slope) in camera.spec.row_slopes().into_iter().enumerate() {
        let (depth, color) = match slope {
            _ if slope < -0.6 / 2.0 => (0.6 / -slope, green),
            _ if slope < -0.5 / 2.0 => (2.0, red),
            _ if slope < -0.6 / 3.0 => (0.6 / -slope, green),
            _ => (3.0, blue),
        };
        assert_relative_eq!(f64::from(frame.depth.at(100, row)), depth, epsilon = 1e-6);
        assert_eq!(frame.color.colors()[row * 640 + 100], color);
    }
}

#[test]
fn out_of_reach_is_nan() {
    let room = |x| Extruded::new(Room::new([-1.0, -9.0], [x, 9.0]).unwrap(), 3.0).unwrap();
    for (x, seen) in [(0.79, false), (0.81, true), (3.49, true), (3.51, false)] {
        let depth = capture(&perfect(), &room(x)).depth.at(320, 200);
        assert_eq!(depth.is_finite(), seen, "wall at {x}: {depth}");
    }
}

#[test]
fn noise_is_quantised_and_has_its_variance() {
    let camera = DepthCamera::default();
    for depth in [1.0, 2.2, 3.0] {
        let world = Extruded::new(Room::new([-1.0, -9.0], [depth, 9.0]).unwrap(), 9.0).unwrap();
        let frame = capture(&camera, &world);
        let depths: Vec<f64> = (0..200)
            .flat_map(|row| (0..640).map(move |column| (column, row)))
            .map(|(column, row)| f64::from(frame.depth.at(column, row)))
            .collect();
        let shift = camera.spec.disparity_depth();
        let disparities = RunningMoments::of(depths.iter().map(|z| shift / z)).unwrap();
        let sigma = disparities.standard_deviation().unwrap();
        // Errors of less than half a step do not quite blur the steps: a few percent remain.
        assert_relative_eq!(sigma, 0.0625, max_relative = 0.08);
        assert_relative_eq!(disparities.mean().unwrap(), shift / depth, epsilon = 0.005);
        let sigma =
            RunningMoments::of(depths.iter().copied()).unwrap().standard_deviation().unwrap();
        assert_relative_eq!(sigma, camera.spec.sigma_at(depth), max_relative = 0.08);
        for z in depths.iter().take(100) {
            let steps = shift / z / 0.125;
            assert!((steps - steps.round()).abs() < 1e-3);
        }
    }
}

#[test]
fn dropouts_come_at_their_rate() {
    let noise = DisparityNoise { dropout: 0.2, ..DepthCameraSpec::xtion_pro().noise };
    let spec = DepthCameraSpec { noise, ..DepthCameraSpec::xtion_pro() };
    let frame = capture(&DepthCamera::new(spec).unwrap(), &Steps { near_height: 5.0 });
    let lost = frame.depth.depths().iter().take(640 * 240).filter(|z| z.is_nan()).count();
    assert_relative_eq!(lost as f64 / (640.0 * 240.0), 0.2, epsilon = 0.01);
}

#[test]
fn the_cloud_lies_on_the_walls() {
    let pose = Pose2::new(0.3, -0.2, 0.4);
    let room = Room::new([-1.0, -1.5], [2.0, 1.4]).unwrap();
    let world = Extruded::new(&room, 2.5).unwrap().with_stripes([[255, 0, 0], [0, 0, 255]]);
    let camera = DepthCamera { mounting: Pose2::new(0.2, 0.0, 0.1), ..perfect() };
    let frame = camera.capture(&world, pose, &mut stream(1, "camera"));
    let (mut floor, mut wall) = (0, 0);
    for point in frame.cloud(&camera.spec) {
        let planar = Point2::new(point.position.x, point.position.y);
        let place = (pose * camera.mounting).transform(&planar);
        if point.color == world.floor_color() {
            floor += 1;
            assert_relative_eq!(point.position.z, -0.5, epsilon = 1e-6);
        } else {
            wall += 1;
            let off = (place.x - 2.0).abs().min((place.y - 1.4).abs()).min((place.y + 1.5).abs());
            assert!(off < 1e-5, "{place}");
        }
    }
    assert!(floor > 30_000 && wall > 150_000, "{floor} {wall}");
}

#[test]
fn worlds_on_top_of_each_other() {
    let (low, high) = (Steps { near_height: 0.2 }, Steps { near_height: 0.4 });
    let both: [&dyn WallWorld; 2] = [&low, &high];
    assert_eq!(capture(&perfect(), &both[..]).depth, capture(&perfect(), &high).depth);
}

#[test]
fn the_virtual_scan_is_the_wall() {
    let camera = DepthCamera::default();
    let world = Extruded::new(Room::new([-1.0, -9.0], [2.5, 9.0]).unwrap(), 3.0).unwrap();
    let frame = capture(&camera, &world);
    let median = VirtualScan::default().of(&frame.depth, &camera).unwrap();
    median.check().unwrap();
    let depths = |scan: &loc_sensors::laser::LaserScan| {
        RunningMoments::of(scan.beams().map(|beam| beam.range * beam.angle.cos())).unwrap()
    };
    assert!(median.beams().count() > 225);
    assert_relative_eq!(depths(&median).mean().unwrap(), 2.5, epsilon = 0.01);
    let nearest = VirtualScan { quantile: 0.0, ..VirtualScan::default() };
    let nearest = nearest.of(&frame.depth, &camera).unwrap();
    assert!(depths(&nearest).mean().unwrap() < 2.5 - camera.spec.sigma_at(2.5));
    // The low wall counts, the floor does not, and what is not seen is NaN.
    let frame = capture(&perfect(), &Steps { near_height: 0.3 });
    let low = VirtualScan { lower: 0.05, upper: 0.25, ..VirtualScan::default() };
    let scan = low.of(&frame.depth, &perfect()).unwrap();
    assert_relative_eq!(depths(&scan).max().unwrap(), 2.0, epsilon = 0.01);
    let high = VirtualScan { lower: 8.0, upper: 9.0, ..VirtualScan::default() };
    assert!(high.of(&frame.depth, &perfect()).unwrap().ranges.iter().all(|r| r.is_nan()));
}

#[test]
fn bad_settings_and_images_are_refused() {
    let spec = DepthCameraSpec::xtion_pro();
    for bad in [
        DepthCameraSpec { width: 0, ..spec },
        DepthCameraSpec { height: 1_000_000, ..spec },
        DepthCameraSpec { horizontal_fov: 3.2, ..spec },
        DepthCameraSpec { range_max: 0.5, ..spec },
        DepthCameraSpec { base: 0.0, ..spec },
        DepthCameraSpec { noise: DisparityNoise { sigma: -1.0, ..spec.noise }, ..spec },
        DepthCameraSpec { noise: DisparityNoise { step: f64::NAN, ..spec.noise }, ..spec },
    ] {
        assert!(DepthCamera::new(bad).is_err(), "{bad:?}");
    }
    assert!(DepthCamera { height: 0.0, ..perfect() }.check().is_err());
    assert!(DepthImage::new(0, vec![1.0]).is_err() && DepthImage::new(3, vec![1.0; 4]).is_err());
    assert!(ColorImage::new(2, Vec::new()).is_err());
    let image = DepthImage::new(2, vec![1.0; 4]).unwrap();
    assert!(image.at(2, 0).is_nan() && image.at(0, 2).is_nan() && image.at(1, 1) == 1.0);
    // An image that is not of this camera is read as far as it goes.
    VirtualScan::default().of(&image, &perfect()).unwrap();
    assert!(
        VirtualScan { angle_increment: 0.0, ..VirtualScan::default() }
            .of(&image, &perfect())
            .is_err()
    );
    assert!(VirtualScan { upper: 0.0, ..VirtualScan::default() }.check().is_err());
}
