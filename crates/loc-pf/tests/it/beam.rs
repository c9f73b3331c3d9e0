//! The beam model: densities by hand, and scans against a brute-force computation.

use approx::assert_abs_diff_eq;
use loc_core::Pose2;
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_filters::RobotSettings;
use loc_maps::RayCaster;
use loc_maps::grid::{GridFrame, OccupancyGrid};
use loc_maps::worlds::{self, WorldSettings};
use loc_pf::mcl::{MountedScan, SensorSettings};
use loc_pf::sensor::Likelihood;
use loc_pf::sensor::beam::{
    BeamForm, BeamLikelihood, BeamModel, BeamModelSettings, RangeModel, informative_beams,
};
use loc_pf::{Error, Mcl, MclSettings, Particles};
use loc_sensors::laser::LaserScan;
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;
use rand::RngExt;

const NOTHING: f64 = f64::INFINITY;

fn model(settings: BeamModelSettings) -> BeamModel {
    BeamModel::new(&settings).unwrap()
}

fn twelve_metres() -> BeamModelSettings {
    BeamModelSettings::default().max_range(12.0)
}

pub(crate) fn office() -> OccupancyGrid {
    let settings = WorldSettings { width: 240, height: 240, resolution: 0.05, seed: 4 };
    worlds::office(&settings).unwrap().grid
}

/// A noise-free scan at a pose of the laser.
pub(crate) fn scan_at(
    world: &impl RangeWorld,
    laser: Pose2,
    beams: usize,
    reach: f64,
) -> LaserScan {
    let step = std::f64::consts::TAU / beams as f64;
    let mut ranges = vec![0.0; beams];
    world.cast_fan(&laser.position(), laser.theta - 3.0, step, reach, &mut ranges);
    LaserScan {
        angle_min: -3.0,
        angle_max: -3.0 + step * (beams - 1) as f64,
        angle_increment: step,
        time_increment: 0.0,
        scan_time: 0.1,
        range_min: 0.1,
        range_max: reach,
        ranges,
        intensities: Vec::new(),
    }
}

/// Every beam of a scan by itself, cast by the exact traversal.
fn brute_force(grid: &OccupancyGrid, model: &BeamModel, scan: &LaserScan, laser: Pose2) -> f64 {
    let beam = |k: usize| {
        let reach = model.max_range();
        let direction = laser.theta + scan.angle(k);
        let expected = grid.cast(&laser.position(), direction, reach).unwrap_or(NOTHING);
        model.log_density(expected, scan.ranges[k])
    };
    informative_beams(scan, usize::MAX).into_iter().map(beam).sum()
}

#[test]
fn densities_are_those_computed_by_hand() {
    let model = model(twelve_metres());
    for (expected, measured, parts, logarithm) in [
        (5.0, 4.5, [0.039837046576, 0.007366037155, 0.0, 0.037878787879], -2.464141290649),
        (5.0, 5.3, [0.294358171968, 0.0, 0.0, 0.037878787879], -1.101906830175),
        (0.1, 0.05, [1.270916678445, 0.454543560612, 0.0, 0.037878787879], 0.567209186083),
        (11.9, 11.5, [0.177459730568, 0.002068557098, 0.0, 0.037878787879], -1.525983758623),
        (5.0, NOTHING, [0.0, 0.0, 1.0 / 22.0, 0.0], -3.091042453358),
        (NOTHING, NOTHING, [10.0 / 22.0, 0.0, 1.0 / 22.0, 0.0], -std::f64::consts::LN_2),
    ] {
        for (part, by_hand) in model.parts(expected, measured).into_iter().zip(parts) {
            assert_abs_diff_eq!(part, by_hand, epsilon = 1e-11);
        }
        assert_abs_diff_eq!(model.log_density(expected, measured), logarithm, epsilon = 1e-11);
    }
}

#[test]
fn densities_and_the_chance_of_no_return_add_up_to_one() {
    let model = model(twelve_metres().lambda_short(0.7).z_short(0.4));
    for expected in [0.03, 0.4, 5.0, 11.9, 12.0, NOTHING] {
        let step = 1e-4;
        let at = |k: usize| model.parts(expected, (k as f64 + 0.5) * step).iter().sum::<f64>();
        let finite = step * (0..120_000).map(at).sum::<f64>();
        let none: f64 = model.parts(expected, NOTHING).iter().sum();
        assert_abs_diff_eq!(finite + none, 1.0, epsilon = 1e-4);
    }
}

#[test]
fn the_plain_gaussian_is_the_product_of_the_lecture() {
    let settings =
        BeamModelSettings::default().form(BeamForm::Gaussian).sigma_hit(0.5).max_range(12.0);
    let model = model(settings);
    // -0.5 (1 / 0.5)^2 - ln(0.5 sqrt(2 pi))
    assert_abs_diff_eq!(model.log_density(4.0, 5.0), -2.0 - 0.225791352644, epsilon = 1e-9);
    assert_abs_diff_eq!(model.log_density(NOTHING, 11.0), -2.0 - 0.225791352644, epsilon = 1e-9);
    let grid = office();
    let caster = RayCaster::new(&grid);
    let truth = Pose2::new(6.0, 6.0, 0.4);
    let scan = scan_at(&grid, truth, 40, 12.0);
    let beams = informative_beams(&scan, 40);
    let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
    let rated = BeamLikelihood::new(&caster, &settings, &mounted, &beams, 1.0).unwrap();
    for pose in [truth, Pose2::new(6.1, 5.9, 0.45), Pose2::new(3.0, 8.0, 2.0)] {
        let brute = brute_force(&grid, &model, &scan, pose);
        assert_abs_diff_eq!(rated.log_likelihood(pose), brute, epsilon = 0.002 * 40.0);
    }
}

#[test]
fn a_scan_is_rated_as_by_brute_force() {
    let grid = office();
    // The same walls in a map whose origin is turned.
    let frame = GridFrame::new(240, 240, 0.05, Pose2::new(3.0, -2.0, 0.7)).unwrap();
    let turned = OccupancyGrid::new(frame, grid.values().to_vec()).unwrap();
    for (grid, to_map) in [(grid, Pose2::IDENTITY), (turned, Pose2::new(3.0, -2.0, 0.7))] {
        let caster = RayCaster::new(&grid);
        for sigma_hit in [0.02, 0.2] {
            let settings = BeamModelSettings::default().sigma_hit(sigma_hit).max_range(8.0);
            let truth = to_map * Pose2::new(6.0, 6.0, 0.4);
            let scan = scan_at(&grid, truth, 180, 10.0);
            let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
            let beams = informative_beams(&scan, 180);
            let rated = BeamLikelihood::new(&caster, &settings, &mounted, &beams, 1.0).unwrap();
            let (model, mut rng) = (model(settings), stream(1, "poses"));
            let (mut worst, mut sum) = (0.0_f64, 0.0);
            for k in 0..300 {
                let spread = if k % 2 == 0 { 0.1 } else { 5.0 };
                let mut off = || rng.random_range(-spread..spread);
                let pose = Pose2::new(truth.x + off(), truth.y + off(), truth.theta + off());
                let brute = brute_force(&grid, &model, &scan, pose);
                let loss = (rated.log_likelihood(pose) - brute).abs() / 180.0;
                (worst, sum) = (worst.max(loss), sum + loss / 300.0);
            }
            println!(
                "sigma_hit {sigma_hit}: loss a beam {sum:.5} on the average, {worst:.5} at most"
            );
            assert!(worst < 0.01 && sum < 0.001, "{worst} {sum}");
        }
    }
}

#[test]
fn beams_start_at_the_laser_not_at_the_base() {
    let grid = office();
    let caster = RayCaster::new(&grid);
    let mounting = Pose2::new(0.4, -0.15, 1.2);
    let base = Pose2::new(6.0, 6.0, 0.4);
    let scan = scan_at(&grid, base * mounting, 90, 20.0);
    let beams = informative_beams(&scan, 90);
    let rate = |mounting: Pose2, pose: Pose2| {
        let mounted = MountedScan { scan: &scan, mounting };
        let settings = BeamModelSettings::default();
        BeamLikelihood::new(&caster, &settings, &mounted, &beams, 1.0).unwrap().log_likelihood(pose)
    };
    let right = rate(mounting, base);
    assert_abs_diff_eq!(right, rate(Pose2::IDENTITY, base * mounting), epsilon = 1e-9);
    assert!(right > rate(Pose2::IDENTITY, base) + 20.0);
    assert!(right > rate(mounting, Pose2::new(6.0, 6.0, 0.3)) + 10.0);
}

/// Peers lose everything, or yield NaN, at 720 beams.
#[test]
fn nothing_underflows_at_720_beams() {
    let grid = office();
    let caster = RayCaster::new(&grid);
    let truth = Pose2::new(6.0, 6.0, 0.4);
    let scan = scan_at(&grid, truth, 720, 20.0);
    let beams = informative_beams(&scan, 720);
    for form in [BeamForm::Mixture, BeamForm::Gaussian] {
        let settings = BeamModelSettings::default()
            .form(form)
            .sigma_hit(0.02)
            .z_rand(1e-6)
            .z_max(0.0)
            .z_short(0.0);
        let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
        let rated = BeamLikelihood::new(&caster, &settings, &mounted, &beams, 1.0).unwrap();
        let poses = [3.0, 0.5, 0.1, 0.02].map(|off| Pose2::new(6.0 + off, 6.0, 0.4));
        let mut cloud = Particles::from_poses(poses);
        let (poses, weights) = cloud.poses_and_log_weights();
        rated.rate(poses, weights);
        assert!(weights.iter().all(|weight| weight.is_finite()), "{weights:?}");
        assert!(weights.is_sorted() && weights[0] < -2000.0 && weights[1] < weights[2] - 50.0);
        cloud.normalize();
        assert_abs_diff_eq!(cloud.weights().sum::<f64>(), 1.0, epsilon = 1e-12);
    }
}

#[test]
fn beams_that_see_nothing_tell_where_no_wall_is() {
    let frame = GridFrame::new(400, 400, 0.05, Pose2::IDENTITY).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    for row in 0..400 {
        grid.set(loc_maps::grid::Cell::new(300, row), 100).unwrap();
    }
    let caster = RayCaster::new(&grid);
    let mut scan = scan_at(&grid, Pose2::new(5.0, 10.0, 0.0), 60, 6.0);
    assert!(scan.ranges.iter().all(|range| *range == NOTHING));
    let rate = |scan: &LaserScan, pose: Pose2| {
        let mounted = MountedScan { scan, mounting: Pose2::IDENTITY };
        let beams = informative_beams(scan, 60);
        let settings = BeamModelSettings::default();
        BeamLikelihood::new(&caster, &settings, &mounted, &beams, 1.0).unwrap().log_likelihood(pose)
    };
    let (open, at_wall) = (Pose2::new(5.0, 10.0, 0.0), Pose2::new(13.0, 10.0, 0.0));
    assert!(rate(&scan, open) > rate(&scan, at_wall) + 30.0);
    // A scanner that reports its longest range, or more, instead of +inf.
    scan.ranges.fill(6.5);
    assert!(rate(&scan, open) > rate(&scan, at_wall) + 30.0);
}

#[test]
fn failed_beams_are_dropped_before_thinning() {
    let grid = office();
    let mut scan = scan_at(&grid, Pose2::new(6.0, 6.0, 0.4), 100, 20.0);
    for (k, range) in scan.ranges.iter_mut().enumerate() {
        match k {
            10..30 => *range = f64::NAN,
            30..40 => *range = f64::NEG_INFINITY,
            40..60 => *range = 0.05,
            60..65 => *range = NOTHING,
            _ => {}
        }
    }
    let all = informative_beams(&scan, 1000);
    assert_eq!(all, (0..10).chain(60..100).collect::<Vec<_>>());
    let some = informative_beams(&scan, 25);
    assert!(some.len() == 25 && some[0] == 0 && some[24] == 99);
    assert!(some.iter().all(|beam| all.contains(beam)) && some.is_sorted());
    assert_eq!((informative_beams(&scan, 0), informative_beams(&scan, 1)), (vec![], vec![75]));

    let caster = RayCaster::new(&grid);
    let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
    let every: Vec<usize> = (0..300).collect();
    let settings = BeamModelSettings::default();
    let rated = BeamLikelihood::new(&caster, &settings, &mounted, &every, 1.0).unwrap();
    assert_eq!(rated.beams(), 50);
}

#[test]
fn a_rating_depends_on_its_pose_alone_and_the_exponent_scales_it() {
    let grid = office();
    let caster = RayCaster::new(&grid);
    let scan = scan_at(&grid, Pose2::new(6.0, 6.0, 0.4), 150, 20.0);
    let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
    let beams = informative_beams(&scan, 150);
    let rated = |exponent| {
        let settings = BeamModelSettings::default();
        BeamLikelihood::new(&caster, &settings, &mounted, &beams, exponent).unwrap()
    };
    let nan = Pose2 { x: f64::NAN, y: 0.0, theta: 0.0 };
    let poses = [Pose2::new(6.0, 6.0, 0.4), nan, Pose2::new(-300.0, 1e9, 1.0), Pose2::IDENTITY];
    let mut cloud = Particles::from_poses(poses);
    let (poses, weights) = cloud.poses_and_log_weights();
    weights.fill(0.0);
    rated(1.0).rate(poses, weights);
    for (pose, weight) in poses.iter().zip(&*weights) {
        assert_eq!(rated(1.0).log_likelihood(pose), *weight);
        if pose.x.is_nan() {
            assert_eq!(*weight, f64::NEG_INFINITY);
        } else {
            assert_abs_diff_eq!(rated(0.25).log_likelihood(pose), 0.25 * weight);
            assert!(weight.is_finite());
        }
    }
}

#[test]
fn bad_input_is_refused_by_name() {
    let wrong = |change: fn(&mut BeamModelSettings)| {
        let mut settings = BeamModelSettings::default();
        change(&mut settings);
        BeamModel::new(&settings).unwrap_err().to_string()
    };
    for (message, what) in [
        (wrong(|s| s.sigma_hit = 0.0), "BeamModelSettings.sigma_hit: "),
        (wrong(|s| s.sigma_hit = f64::NAN), "BeamModelSettings.sigma_hit: "),
        (wrong(|s| s.z_hit = -0.1), "BeamModelSettings.z_hit: "),
        (wrong(|s| s.lambda_short = 0.0), "BeamModelSettings.lambda_short: "),
        (wrong(|s| s.max_range = f64::INFINITY), "BeamModelSettings.max_range: "),
        (
            wrong(|s| (s.z_hit, s.z_short, s.z_max, s.z_rand) = (0.0, 0.0, 0.0, 0.0)),
            "BeamModelSettings.z_rand: expected shares",
        ),
    ] {
        assert!(message.starts_with(what), "{message}");
    }
    let grid = office();
    let caster = RayCaster::new(&grid);
    let settings = BeamModelSettings::default();
    let mut scan = scan_at(&grid, Pose2::new(6.0, 6.0, 0.4), 10, 20.0);
    let new = |scan: &LaserScan, mounting: Pose2, exponent: f64| {
        let mounted = MountedScan { scan, mounting };
        BeamLikelihood::new(&caster, &settings, &mounted, &[0, 1, 99], exponent).map(|l| l.beams())
    };
    assert_eq!(new(&scan, Pose2::IDENTITY, 1.0).unwrap(), 2);
    let nowhere = Pose2 { x: 0.0, y: f64::NAN, theta: 0.0 };
    assert!(matches!(new(&scan, nowhere, 1.0), Err(Error::Core(_))));
    assert!(matches!(new(&scan, Pose2::IDENTITY, 0.0), Err(Error::Core(_))));
    scan.ranges.fill(f64::NAN);
    assert!(matches!(new(&scan, Pose2::IDENTITY, 1.0), Err(Error::Core(_))));
}

/// What is nearer than the settings' `min_range` says as little as a beam that failed.
#[test]
fn beams_below_the_least_range_of_the_settings_are_not_used() {
    let grid = office();
    let frame = grid.frame();
    let middle = Point2::new(frame.width() as f64 / 2.0, frame.height() as f64 / 2.0);
    let place = frame.to_map(middle.x, middle.y);
    let pose = Pose2::new(place.x, place.y, 0.3);
    let clean = scan_at(&RayCaster::new(&grid), pose, 120, 12.0);
    let changed = |range: f64| {
        let mut scan = clean.clone();
        scan.ranges.iter_mut().step_by(3).for_each(|beam| *beam = range);
        scan
    };
    let estimate = |scan: &LaserScan, min_range: f64| {
        let sensor = SensorSettings::Beam(twelve_metres());
        let settings = MclSettings::default()
            .robot(RobotSettings::default().laser_min_range(min_range))
            .sensor(sensor);
        let mut mcl = Mcl::new(&grid, settings, stream(3, "mcl")).unwrap();
        mcl.start_at(&pose_belief(pose, [0.2, 0.2, 0.1])).unwrap();
        let mounted = MountedScan { scan, mounting: Pose2::IDENTITY };
        mcl.update(Pose2::IDENTITY, &[mounted]).unwrap();
        mcl.last_estimate().belief
    };
    let (bumper, failed) = (changed(0.2), changed(f64::NAN));
    assert_eq!(estimate(&bumper, 0.5), estimate(&failed, 0.0));
    assert_ne!(estimate(&bumper, 0.0), estimate(&failed, 0.0));
}
