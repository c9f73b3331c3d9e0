use loc_core::Pose2;
use loc_core::random::stream;
use loc_core::sampling::box_muller;
use loc_maps::grid::Occupancy;
use loc_maps::likelihood_field::{Endpoints, LikelihoodField, LikelihoodFieldSettings};
use loc_maps::worlds::{self, WorldSettings};
use loc_maps::{DistanceMap, OccupancyGrid, RayCaster};
use loc_pf::sensor::{BeamSkip, FieldLikelihood, Likelihood, SumOfCubes};
use loc_pf::{Particles, Workers};
use loc_sensors::world::RangeWorld;
use nalgebra::Point2;

fn office() -> OccupancyGrid {
    let settings = WorldSettings { width: 300, height: 300, resolution: 0.05, seed: 4 };
    worlds::office(&settings).unwrap().grid
}

/// The place with the most room about it.
fn truth(grid: &OccupancyGrid) -> Pose2 {
    let distances = DistanceMap::new(grid, 5.0).unwrap();
    let room = |place: &Point2<f64>| distances.distance_at(place).unwrap();
    let free = grid.centers_of(Occupancy::Free);
    let best = free.max_by(|a, b| room(a).total_cmp(&room(b))).unwrap();
    assert!(room(&best) > 1.0, "{}", room(&best));
    Pose2::new(best.x, best.y, 0.3)
}

/// A scan of 120 beams; the first `blocked` of them end 0.8 m before the wall.
fn scan(grid: &OccupancyGrid, pose: Pose2, blocked: usize) -> Endpoints {
    let caster = RayCaster::new(grid);
    let beam = |k: usize| {
        let angle = k as f64 * std::f64::consts::TAU / 120.0;
        let range = caster.cast(&pose.position(), pose.theta + angle, 30.0);
        let range = range.unwrap_or(f64::INFINITY) - if k < blocked { 0.8 } else { 0.0 };
        [range * angle.cos(), range * angle.sin()]
    };
    (0..120).map(beam).collect()
}

fn cloud(count: usize, about: Pose2, sigma: f64) -> Particles {
    let mut rng = stream(1, "cloud");
    let mut normal = |mean: f64, sigma: f64| mean + sigma * box_muller(&mut rng).0;
    Particles::from_poses((0..count).map(|_| {
        let (x, y) = (normal(about.x, sigma), normal(about.y, sigma));
        Pose2::new(x, y, normal(about.theta, 0.03))
    }))
}

/// The weighted mean of a cloud after a scan.
fn mean(cloud: &Particles, measurement: &impl Likelihood) -> Point2<f64> {
    let mut cloud = cloud.clone();
    Workers::one().rate(&mut cloud, measurement);
    cloud.normalize();
    let poses = cloud.poses();
    let weighted = poses.iter().zip(cloud.weights());
    let sum = weighted.map(|(pose, weight)| weight * pose.position().coords);
    Point2::from(sum.sum::<nalgebra::Vector2<f64>>())
}

#[test]
fn the_product_is_that_of_the_field_raised_to_the_exponent() {
    let grid = office();
    let field = LikelihoodField::new(&grid, &LikelihoodFieldSettings::nav2()).unwrap();
    let scan = scan(&grid, truth(&grid), 0);
    let mut cloud = cloud(1300, truth(&grid), 0.1);
    cloud.log_weights_mut().fill(-2.0);
    let likelihood = FieldLikelihood { field: &field, endpoints: &scan, exponent: 0.25 };
    let (poses, weights) = cloud.poses_and_log_weights();
    likelihood.rate(poses, weights);
    for (pose, weight) in poses.iter().zip(weights) {
        let expected = -2.0 + 0.25 * field.log_likelihood(pose, &scan);
        assert!((*weight - expected).abs() < 1e-9);
    }
}

/// 720 beams underflow no weight, and the number of threads changes nothing.
#[test]
fn threads_change_nothing_and_720_beams_lose_nothing() {
    let grid = office();
    let field = LikelihoodField::new(&grid, &LikelihoodFieldSettings::nav2()).unwrap();
    let once = scan(&grid, truth(&grid), 0);
    let ends = || once.xs().iter().zip(once.ys()).map(|(&x, &y)| (x, y));
    let scan: Endpoints = (0..6).flat_map(|_| ends()).collect();
    let endpoints = &scan;
    let (start, mut rated) = (cloud(2500, truth(&grid), 3.0), Vec::new());
    for threads in [1, 2, 3] {
        let mut cloud = start.clone();
        let workers = Workers::new(threads).unwrap();
        workers.rate(&mut cloud, &FieldLikelihood { field: &field, endpoints, exponent: 1.0 });
        workers.rate(&mut cloud, &SumOfCubes::new(&field, endpoints));
        assert!(cloud.log_weights().iter().all(|weight| weight.is_finite()));
        rated.push(cloud);
    }
    assert_eq!(rated[0], rated[1]);
    assert_eq!(rated[0], rated[2]);
    assert!(rated[0].log_weights().iter().any(|weight| *weight < -800.0));
}

/// Two beams by hand: one on the wall, one far from it, with nav2_amcl's parameters.
#[test]
fn the_sum_of_cubes_is_that_of_nav2() {
    use loc_maps::grid::{Cell, GridFrame};
    let frame = GridFrame::new(100, 100, 0.05, Pose2::IDENTITY).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    (0..100).for_each(|row| grid.set(Cell::new(80, row), 100).unwrap());
    let settings = LikelihoodFieldSettings::nav2().max_range(100.0);
    let field = LikelihoodField::new(&grid, &settings.unnormalised()).unwrap();
    let scan: Endpoints = [[2.0, 0.0], [0.0, 0.0]].into_iter().collect();
    let mut weights = [0.0, 0.0];
    let mut cloud =
        Particles::from_poses([Pose2::new(2.025, 2.525, 0.0), Pose2::new(1.825, 2.525, 0.0)]);
    let poses = cloud.poses_and_log_weights().0;
    SumOfCubes::new(&field, &scan).rate(poses, &mut weights);
    let far = 0.005_f64;
    let hit = 0.505_f64;
    let sigma = 0.5 * (-0.5_f64).exp() + far;
    for (weight, pz) in weights.into_iter().zip([hit, sigma]) {
        let expected = (pz.powi(3) + far.powi(3)).ln_1p();
        assert!((weight - expected).abs() < 0.025 * expected, "{weight} {expected}");
    }
}

/// People stand along a third of the walls, and the field is a wide one, as for a rough map: the
/// estimate stays with beam skip, and is pulled to them without.
#[test]
fn beams_on_people_are_skipped() {
    let grid = office();
    let truth = truth(&grid);
    let settings = LikelihoodFieldSettings::nav2().sigma_hit(0.4);
    let field = LikelihoodField::new(&grid, &settings).unwrap();
    let blocked = scan(&grid, truth, 40);
    let cloud = cloud(3000, truth, 0.1);
    let keep = BeamSkip::default().keep(&field, cloud.poses(), &blocked);
    let skipped = keep.iter().take(40).filter(|keep| !**keep).count();
    let kept = keep.iter().skip(40).filter(|keep| **keep).count();
    println!("skipped {skipped} of 40 blocked beams, kept {kept} of {}", keep.len() - 40);
    assert!(skipped >= 30 && kept >= 78, "{skipped} {kept}");
    let skipping = BeamSkip::default().apply(&field, cloud.poses(), &blocked);
    let off = |endpoints: &Endpoints| {
        let found = mean(&cloud, &FieldLikelihood { field: &field, endpoints, exponent: 0.5 });
        (found - truth.position()).norm()
    };
    println!("off by {} m, without beam skip {} m", off(&skipping), off(&blocked));
    // The rays end on the faces of cells, the field counts from their centres.
    assert!(off(&skipping) < 0.05 && off(&blocked) > 0.1);
}

/// In a static world nothing is lost, and where the cloud is wrong or wide nothing is skipped.
#[test]
fn beam_skip_costs_nothing_without_people() {
    let grid = office();
    let truth = truth(&grid);
    let field = LikelihoodField::new(&grid, &LikelihoodFieldSettings::nav2()).unwrap();
    let (scan, skip) = (scan(&grid, truth, 0), BeamSkip::default());
    let kept = |cloud: &Particles, scan: &Endpoints| skip.apply(&field, cloud.poses(), scan).len();
    assert_eq!(kept(&cloud(2000, truth, 0.1), &scan), scan.len());
    assert_eq!(kept(&cloud(2000, truth, 2.0), &scan), scan.len());
    assert_eq!(kept(&Particles::new(), &scan), scan.len());
    let nothing = Endpoints::default();
    assert_eq!(kept(&cloud(10, truth, 0.1), &nothing), 0);
    // All beams end in mid-air: more than the error threshold would be skipped.
    let lost: Endpoints = (0..30).map(|k| [0.01 * f64::from(k), 0.0]).collect();
    assert_eq!(kept(&cloud(2000, truth, 0.05), &lost), 30);
}

#[test]
fn bad_beam_skips_are_refused() {
    let good = BeamSkip::default();
    assert!(good.check().is_ok());
    let bad = [good.distance(0.0), good.threshold(1.1), good.error_threshold(f64::NAN)];
    assert!(bad.iter().all(|skip| skip.check().is_err()));
}
