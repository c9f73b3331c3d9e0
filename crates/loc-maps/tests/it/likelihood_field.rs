use loc_core::Pose2;
use loc_core::random::stream;
use loc_maps::grid::{Cell, GridFrame, Occupancy, OccupancyGrid};
use loc_maps::likelihood_field::{
    Endpoints, LikelihoodField, LikelihoodFieldSettings, UnknownSpace,
};
use loc_maps::{DistanceMap, likelihood_field};
use nalgebra::Point2;
use rand::RngExt;

fn grid(yaw: f64) -> OccupancyGrid {
    let mut rng = stream(3, "field");
    let frame = GridFrame::new(61, 43, 0.05, Pose2::new(4.0, -2.0, yaw)).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    for _ in 0..40 {
        let cell = Cell::new(rng.random_range(0..61), rng.random_range(0..43));
        grid.set(cell, if rng.random() { 100 } else { -1 }).unwrap();
    }
    grid
}

/// The worst loss by rounding to a byte that the settings allow.
fn half_step(settings: &LikelihoodFieldSettings) -> f64 {
    let far = settings.likelihood(settings.max_distance);
    0.5 * (settings.likelihood(0.0) / far).ln() / 255.0
}

#[test]
fn the_byte_loses_half_a_step_at_most() {
    let settings = LikelihoodFieldSettings::default();
    let grid = grid(0.4);
    let field = LikelihoodField::new(&grid, &settings).unwrap();
    let distances = DistanceMap::new(&grid, settings.max_distance).unwrap();
    let (mut worst, mut squares) = (0.0_f64, 0.0);
    for cell in grid.frame().cells() {
        let exact = settings.likelihood(distances.distance(cell).unwrap()).ln();
        let loss = field.log_likelihood_at(&grid.frame().center(cell)) - exact;
        worst = worst.max(loss.abs());
        squares += loss * loss;
    }
    let rms = (squares / grid.frame().cell_count() as f64).sqrt();
    println!("loss: {worst:.5} at most, {rms:.5} root mean square");
    assert!(worst <= half_step(&settings) * 1.000_001 && rms < 0.7 * worst);
    assert!((half_step(&settings) - 0.0063).abs() < 0.0001, "{}", half_step(&settings));
}

#[test]
fn a_scan_is_the_sum_of_its_beams_on_the_map_and_off_it() {
    let settings = LikelihoodFieldSettings::default();
    let grid = grid(-1.1);
    let field = LikelihoodField::new(&grid, &settings).unwrap();
    let mut rng = stream(5, "field");
    for beams in [0, 1, 31, 32, 33, 200] {
        let points: Vec<[f64; 2]> = (0..beams)
            .map(|_| [rng.random_range(-3.0..3.0), rng.random_range(-3.0..3.0)])
            .collect();
        let endpoints: Endpoints = points.iter().copied().collect();
        let pose = Pose2::new(5.0, -1.0, rng.random_range(-3.0..3.0));
        let at = |p: &[f64; 2]| field.log_likelihood_at(&pose.transform(&Point2::from(*p)));
        let sum: f64 = points.iter().map(at).sum();
        let found = field.log_likelihood(pose, &endpoints);
        // Single precision may put a beam that ends on the edge of a cell into the next one.
        assert!((found - sum).abs() <= 1e-9 + 0.002 * f64::from(beams), "{found} {sum}");
    }
}

#[test]
fn off_the_map_is_far_from_everything() {
    let settings = LikelihoodFieldSettings::default();
    let field = LikelihoodField::new(&grid(0.0), &settings).unwrap();
    let far = settings.likelihood(2.0).ln();
    for (x, y) in [(0.0, 0.0), (1e30, -1e30), (f64::INFINITY, 0.0), (3.99, -1.99), (f64::NAN, 0.0)]
    {
        let found = field.log_likelihood_at(&Point2::new(x, y));
        assert!((found - far).abs() < 1e-9, "{x} {y}: {found} {far}");
    }
    let nothing = Endpoints::from_scan(&[0.0, 0.1], &[f64::INFINITY, f64::NAN]);
    assert!(nothing.is_empty() && field.log_likelihood(Pose2::IDENTITY, &nothing) == 0.0);
}

#[test]
fn unknown_space_has_a_likelihood_of_its_own() {
    let unknown_space = UnknownSpace::Likelihood(1.0 / 12.0);
    let settings = LikelihoodFieldSettings { unknown_space, ..Default::default() };
    let grid = grid(0.0);
    let field = LikelihoodField::new(&grid, &settings).unwrap();
    for center in grid.centers_of(Occupancy::Unknown) {
        let loss = field.log_likelihood_at(&center) - (1.0_f64 / 12.0).ln();
        assert!(loss.abs() <= half_step(&settings) * 1.01);
    }
}

#[test]
fn bad_settings_are_refused() {
    let good = LikelihoodFieldSettings::default();
    let bad = [
        LikelihoodFieldSettings { sigma_hit: 0.0, ..good },
        LikelihoodFieldSettings { z_hit: -0.1, ..good },
        LikelihoodFieldSettings { z_rand: 0.0, ..good },
        LikelihoodFieldSettings { max_range: f64::INFINITY, ..good },
        LikelihoodFieldSettings { max_distance: f64::NAN, ..good },
        LikelihoodFieldSettings { unknown_space: UnknownSpace::Likelihood(0.0), ..good },
    ];
    for settings in bad {
        assert!(likelihood_field::LikelihoodField::new(&grid(0.0), &settings).is_err());
    }
}
