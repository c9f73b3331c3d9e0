use approx::assert_relative_eq;
use loc_core::random::stream;
use loc_core::stats::{RunningMoments, chi_square_band, nees};
use loc_core::{Pose2, angle};
use loc_sensors::features::{Line, LineExtractor};
use loc_sensors::laser::{LaserFaults, LaserNoise, LaserScan, LaserScanner, LaserSpec};
use loc_sensors::world::Room;
use nalgebra::{Matrix2, Point2, Vector2};
use rand::RngExt;
use std::f64::consts::{FRAC_PI_2, PI};

/// What the walls of the room are from the scanner: distance and direction of the perpendicular.
fn walls(lower: [f64; 2], upper: [f64; 2], laser: Pose2) -> Vec<(f64, f64)> {
    let seen = |distance: f64, direction: f64| (distance, angle::wrap(direction - laser.theta));
    vec![
        seen(upper[0] - laser.x, 0.0),
        seen(upper[1] - laser.y, FRAC_PI_2),
        seen(laser.x - lower[0], PI),
        seen(laser.y - lower[1], -FRAC_PI_2),
    ]
}

/// Error of a line against the nearest of the walls.
fn error(line: &Line, walls: &[(f64, f64)]) -> Vector2<f64> {
    let off =
        |(r, alpha): &(f64, f64)| Vector2::new(line.r - r, angle::difference(line.alpha, *alpha));
    walls.iter().map(off).min_by(|a, b| a.norm().total_cmp(&b.norm())).unwrap()
}

fn noisy(sigma: f64) -> LaserScanner {
    let noise = LaserNoise { sigma, sigma_per_m: 0.0 };
    LaserScanner::new(LaserSpec { noise, ..LaserSpec::sick_lms100() }).unwrap()
}

fn extractor(sigma: f64) -> LineExtractor {
    let noise = LaserNoise { sigma, sigma_per_m: 0.0 };
    LineExtractor::new(noise).angle_sigma(0.0).roughness(0.0)
}

#[test]
fn perfect_walls_are_found_exactly() {
    let (lower, upper) = ([-3.0, -2.0], [4.0, 2.5]);
    let room = Room::new(lower, upper).unwrap();
    let pose = Pose2::new(0.5, 0.3, 0.7);
    let scan = noisy(0.0).scan(&room, pose, &mut stream(1, "laser"));
    let lines = extractor(0.0).extract(&scan).unwrap();
    assert_eq!(lines.len(), 4, "{lines:?}");
    for line in &lines {
        assert!(error(line, &walls(lower, upper, pose)).norm() < 1e-9);
        for end in [line.start, line.end] {
            assert!(line.distance(&end).abs() < 1e-12);
        }
    }
    // Every beam belongs to a wall, and the wall between two corners ends at them.
    assert_eq!(lines.iter().map(|line| line.points).sum::<usize>(), 1081);
    let corner = lines[1].crossing(&lines[2]).unwrap();
    assert!(nalgebra::distance(&lines[1].end, &corner) < 0.05);
    assert!(nalgebra::distance(&lines[2].start, &corner) < 0.05);
}

/// Lines, and their errors against the walls they belong to, of one scan in a room of its own, for
/// each seed.
fn scans_of_rooms(sigma: f64, seeds: std::ops::Range<u64>) -> Vec<(Line, Vector2<f64>)> {
    let mut all = Vec::new();
    for seed in seeds {
        let mut rng = stream(seed, "rooms");
        let mut draw = |from: f64, to: f64| rng.random_range(from..to);
        let lower = [draw(-4.0, -2.0), draw(-4.0, -2.0)];
        let upper = [draw(2.0, 4.0), draw(2.0, 4.0)];
        let pose = Pose2::new(draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-PI, PI));
        let room = Room::new(lower, upper).unwrap();
        let scan = noisy(sigma).scan(&room, pose, &mut stream(seed, "laser"));
        let lines = extractor(sigma).extract(&scan).unwrap();
        assert!((3..=7).contains(&lines.len()), "seed {seed}: {} lines", lines.len());
        let walls = walls(lower, upper, pose);
        all.extend(lines.into_iter().map(|line| (line, error(&line, &walls))));
    }
    all
}

/// Over rooms, places and seeds, the errors normalised by the covariance have unit variance, and
/// are chi-square distributed with 2 degrees of freedom.
#[test]
fn errors_are_those_of_the_covariance() {
    for (sigma, seeds) in [(0.01, 400), (0.03, 4000)] {
        let lines = scans_of_rooms(sigma, 0..seeds);
        let count = lines.len();
        let squares: Vec<f64> =
            lines.iter().map(|(line, error)| nees(error, &line.covariance).unwrap()).collect();
        let mean = squares.iter().sum::<f64>() / count as f64;
        let band = chi_square_band(2, count, 0.999).unwrap();
        assert!(band.contains(&mean), "sigma {sigma}: mean {mean} of {count} outside {band:?}");
        let above = squares.iter().filter(|square| **square > 5.991).count();
        assert_relative_eq!(above as f64 / count as f64, 0.05, epsilon = 0.015);
        let one = chi_square_band(1, count, 0.999).unwrap();
        for axis in 0..2 {
            let normalised =
                lines.iter().map(|(line, e)| e[axis] / line.covariance[(axis, axis)].sqrt());
            let moments = RunningMoments::of(normalised).unwrap();
            let variance = moments.variance().unwrap();
            assert!(one.contains(&variance), "axis {axis}: {variance} outside {one:?}");
            let chance = 3.3 / (count as f64).sqrt();
            assert!(moments.mean().unwrap().abs() < chance, "axis {axis} is biased");
        }
    }
}

/// Whatever stands in a scan, every line is finite and has a covariance.
#[test]
fn any_scan_gives_sound_lines() {
    let mut rng = stream(5, "junk");
    for _ in 0..300 {
        let beams = rng.random_range(1..400);
        let step = rng.random_range(0.001..0.05);
        let spread = 10_f64.powf(rng.random_range(-6.0..1.0));
        let ranges: Vec<f64> = (0..beams)
            .map(|_| match rng.random_range(0..20) {
                0 => f64::INFINITY,
                1 => f64::NAN,
                2 => f64::NEG_INFINITY,
                3 => -1.0,
                _ => 2.0 + spread * rng.random_range(-0.1..0.1),
            })
            .collect();
        let scan = LaserScan {
            angle_min: -3.0,
            angle_max: -3.0 + step * (beams - 1) as f64,
            angle_increment: step,
            time_increment: 0.0,
            scan_time: 0.1,
            range_min: 0.0,
            range_max: 10.0,
            ranges,
            intensities: Vec::new(),
        };
        if scan.check().is_err() {
            continue;
        }
        for sigma in [0.0, 1e-3, 0.1] {
            for line in extractor(sigma).extract(&scan).unwrap() {
                assert!(line.r >= 0.0 && line.r.is_finite() && line.alpha.abs() <= PI, "{line:?}");
                assert!(line.length().is_finite() && line.points >= 10);
                loc_core::gaussian::check_covariance("line", &line.covariance).unwrap();
            }
        }
    }
}

/// The covariance of the fit by hand: n points on a wall straight ahead, seen at right angles.
#[test]
fn covariance_by_hand() {
    // Beams at -t, 0 and t on the wall x = 2, with t so small that the incidence hardly matters.
    let t = 0.01;
    let angles = [-t, 0.0, t];
    let scan = LaserScan {
        angle_min: -t,
        angle_max: t,
        angle_increment: t,
        time_increment: 0.0,
        scan_time: 0.1,
        range_min: 0.1,
        range_max: 10.0,
        ranges: angles.map(|a| 2.0 / f64::cos(a)).to_vec(),
        intensities: Vec::new(),
    };
    let settings = extractor(0.1).min_points(3).min_length(0.0).max_alpha_sigma(9.0);
    let lines = settings.extract(&scan).unwrap();
    assert_eq!((lines.len(), lines[0].points), (1, 3));
    assert_relative_eq!(lines[0].r, 2.0, epsilon = 1e-9);
    assert_relative_eq!(lines[0].covariance.m11, 0.01 / 3.0, max_relative = 1e-3);
    assert_relative_eq!(lines[0].covariance.m12, 0.0, epsilon = 1e-9);
    let lever = 2.0 * (2.0 * t.tan()).powi(2);
    assert_relative_eq!(lines[0].covariance.m22, 0.01 / lever, max_relative = 1e-3);
}

#[test]
fn stray_beams_and_pillars_leave_the_walls_alone() {
    let (lower, upper) = ([-3.0, -2.0], [4.0, 2.5]);
    let room = Room::new(lower, upper).unwrap().with_pillar([2.0, 1.0], 0.15).unwrap();
    let faults = LaserFaults { dropout: 0.05, erroneous: 0.02, short: 0.02 };
    let scanner = LaserScanner { faults, ..noisy(0.012) };
    let (mut found, mut worst) = (0, 0.0_f64);
    for seed in 0..50 {
        let pose = Pose2::new(0.5, 0.3, 0.02 * seed as f64);
        let scan = scanner.scan(&room, pose, &mut stream(seed, "laser"));
        for line in LineExtractor::new(scanner.spec.noise).extract(&scan).unwrap() {
            let square = nees(&error(&line, &walls(lower, upper, pose)), &line.covariance).unwrap();
            if line.length() > 1.0 {
                (found, worst) = (found + 1, worst.max(square));
            }
        }
    }
    assert!(found >= 150, "{found} walls");
    assert!(worst < 30.0, "{worst}");
}

#[test]
fn a_line_in_another_frame() {
    let line = Line {
        r: 2.0,
        alpha: 0.3,
        covariance: Matrix2::new(4e-4, 1e-4, 1e-4, 9e-4),
        start: Point2::new(2.0, 0.0),
        end: Point2::new(1.0, 2.0),
        points: 40,
    };
    for pose in [Pose2::new(1.0, -2.0, 2.0), Pose2::new(-5.0, 1.0, 0.4)] {
        let moved = line.transformed(pose);
        assert!(moved.r >= 0.0);
        let on_line = Point2::from(line.normal() * line.r);
        assert!(moved.distance(&pose.transform(&on_line)).abs() < 1e-12);
        // The Jacobian against differences of the line itself.
        let h = 1e-6;
        let by = |r: f64, alpha: f64| {
            let there = Line { r: line.r + r, alpha: line.alpha + alpha, ..line }.transformed(pose);
            Vector2::new(there.r - moved.r, angle::difference(there.alpha, moved.alpha)) / h
        };
        let jacobian = Matrix2::from_columns(&[by(h, 0.0), by(0.0, h)]);
        let expected = jacobian * line.covariance * jacobian.transpose();
        assert_relative_eq!(moved.covariance, expected, epsilon = 1e-7);
    }
    assert_eq!(line.transformed(Pose2::IDENTITY), line);
}

#[test]
fn bad_input_is_refused() {
    let good = noisy(0.0).scan(
        &Room::new([-1.0; 2], [1.0; 2]).unwrap(),
        Pose2::IDENTITY,
        &mut stream(1, "l"),
    );
    for bad in [
        LaserScan { ranges: Vec::new(), ..good.clone() },
        LaserScan { angle_increment: 0.0, ..good.clone() },
        LaserScan { ranges: vec![f64::NAN; 1081], ..good.clone() },
    ] {
        assert!(extractor(0.01).extract(&bad).is_err());
    }
    for bad in [
        extractor(0.01).min_points(2),
        extractor(0.01).gate_sigmas(0.0),
        extractor(0.01).grazing_angle(2.0),
        extractor(0.01).roughness(f64::NAN),
    ] {
        assert!(bad.extract(&good).is_err(), "{bad:?}");
    }
    let nothing = LaserScan { ranges: vec![f64::INFINITY; 1081], ..good };
    assert!(extractor(0.01).extract(&nothing).unwrap().is_empty());
}
