//! Novelty filters: who stands in the way is left out, what the map explains is not.

use crate::beam::{office, scan_at};
use approx::assert_abs_diff_eq;
use loc_core::gaussian::pose_belief;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::sampling::box_muller;
use loc_core::{Gaussian, Pose2};
use loc_maps::likelihood_field::LikelihoodFieldSettings;
use loc_maps::{LikelihoodField, OccupancyGrid, RayCaster};
use loc_pf::initial::FreeSpace;
use loc_pf::mcl::MountedScan;
use loc_pf::novelty::{BeliefSample, DistanceFilter, EntropyFilter, Kept, by_casting, by_field};
use loc_pf::sensor::beam::{BeamLikelihood, BeamModel, BeamModelSettings, informative_beams};
use loc_pf::{Motion, ParticleFilter, Particles, PosesMut, Resampling};
use loc_sensors::laser::LaserScan;
use rand::RngExt;

const BEAMS: usize = 120;
const TRUTH: Pose2 = Pose2 { x: 6.0, y: 6.0, theta: 0.4 };

/// A scan with 2 cm of noise, in which `blocked` of the beams end on people. The beams they end.
fn scan(
    grid: &OccupancyGrid,
    laser: Pose2,
    blocked: f64,
    rng: &mut ChaCha8Rng,
) -> (LaserScan, Vec<usize>) {
    let mut scan = scan_at(grid, laser, BEAMS, 20.0);
    let mut short = Vec::new();
    for (k, range) in scan.ranges.iter_mut().enumerate() {
        *range += 0.02 * box_muller(rng).0;
        if rng.random_bool(blocked) && *range > 1.5 {
            *range = rng.random_range(0.4..*range - 0.8);
            short.push(k);
        }
    }
    (scan, short)
}

fn cloud(about: Pose2, sigmas: [f64; 3], rng: &mut ChaCha8Rng) -> Particles {
    Particles::from_gaussian(&pose_belief(about, sigmas), 2000, rng)
}

fn by_distance(grid: &OccupancyGrid, scan: &LaserScan, cloud: &Particles) -> Kept {
    let caster = RayCaster::new(grid);
    let mounted = MountedScan { scan, mounting: Pose2::IDENTITY };
    let sample = BeliefSample::of(cloud, 64);
    let beams = informative_beams(scan, BEAMS);
    DistanceFilter::default().keep(&caster, &sample, &mounted, &beams).unwrap()
}

#[test]
fn people_are_left_out_and_walls_are_kept() {
    let (grid, mut rng) = (office(), stream(1, "people"));
    let (mut seen, mut dropped, mut clean, mut lost) = (0, 0, 0, 0);
    for _ in 0..20 {
        let (scan, short) = scan(&grid, TRUTH, 0.4, &mut rng);
        let kept = by_distance(&grid, &scan, &cloud(TRUTH, [0.08, 0.08, 0.03], &mut rng));
        let is_kept = |beam: usize| kept.beams.contains(&beam);
        seen += short.len();
        dropped += short.iter().filter(|beam| !is_kept(**beam)).count();
        let others: Vec<usize> = (0..BEAMS).filter(|beam| !short.contains(beam)).collect();
        clean += others.len();
        lost += others.iter().filter(|beam| !is_kept(**beam)).count();
    }
    println!("{dropped} of {seen} on people dropped, {lost} of {clean} others");
    assert!(dropped as f64 > 0.8 * seen as f64 && (lost as f64) < 0.005 * clean as f64);
}

/// Point 7 of what users miss: no cost in a static world.
#[test]
fn a_room_as_mapped_loses_next_to_nothing() {
    let (grid, mut rng) = (office(), stream(2, "static"));
    let mut lost = 0;
    for k in 0..40 {
        // The belief may be off by as much as it is wide.
        let off = if k % 2 == 0 { 0.0 } else { 0.1 };
        let (scan, _) = scan(&grid, TRUTH, 0.0, &mut rng);
        let about = Pose2::new(TRUTH.x + off, TRUTH.y - off, TRUTH.theta);
        lost += by_distance(&grid, &scan, &cloud(about, [0.1, 0.1, 0.05], &mut rng)).novel;
    }
    println!("{lost} of {} beams", 40 * BEAMS);
    assert!((lost as f64) < 0.002 * 40.0 * BEAMS as f64);
}

#[test]
fn a_robot_without_a_clue_keeps_its_beams() {
    let (grid, mut rng) = (office(), stream(3, "lost"));
    let free = FreeSpace::new(&grid).unwrap();
    let anywhere = Particles::from_poses((0..2000).map(|_| free.draw(&mut rng)));
    let (scan, _) = scan(&grid, TRUTH, 0.0, &mut rng);
    let kept = by_distance(&grid, &scan, &anywhere);
    assert!(kept.beams.len() as f64 > 0.95 * BEAMS as f64, "{}", kept.beams.len());

    // Everything nearer than at the place the robot is sure of: the place is wrong.
    let mut near = scan.clone();
    near.ranges.iter_mut().for_each(|range| *range *= 0.15);
    let sure = cloud(TRUTH, [0.05, 0.05, 0.02], &mut rng);
    let kept = by_distance(&grid, &near, &sure);
    assert!(kept.novel as f64 > 0.8 * BEAMS as f64 && kept.beams.len() == BEAMS, "{}", kept.novel);
}

#[test]
fn beams_that_end_nowhere_or_beyond_are_no_news() {
    let (grid, mut rng) = (office(), stream(4, "far"));
    let (mut scan, _) = scan(&grid, TRUTH, 0.0, &mut rng);
    scan.ranges.iter_mut().step_by(2).for_each(|range| *range = f64::INFINITY);
    scan.ranges.iter_mut().skip(1).step_by(2).for_each(|range| *range += 3.0);
    let sure = cloud(TRUTH, [0.05, 0.05, 0.02], &mut rng);
    assert_eq!(by_distance(&grid, &scan, &sure).novel, 0);
    // Without a belief, and where all beams failed, there is nothing to drop.
    scan.ranges.fill(0.2);
    assert_eq!(by_distance(&grid, &scan, &Particles::new()).novel, 0);
    scan.ranges.fill(f64::NAN);
    assert_eq!(by_distance(&grid, &scan, &sure), Kept { beams: vec![], novel: 0 });
}

#[test]
fn a_sample_represents_its_particles() {
    let poses = (0..1000).map(|k| Pose2::new(k as f64, 0.0, 0.0));
    let mut cloud = Particles::from_poses(poses);
    let sample = BeliefSample::of(&cloud, 50);
    assert_eq!(sample.poses().len(), 50);
    assert_eq!((sample.poses()[0].x, sample.poses()[49].x), (9.0, 989.0));
    assert!(sample.weights().iter().all(|weight| (weight - 0.02).abs() < 1e-12));
    // One particle holds 0.9 of the weight.
    for (k, weight) in cloud.log_weights_mut().iter_mut().enumerate() {
        *weight = if k == 300 { 0.9_f64 } else { 0.1 / 999.0 }.ln();
    }
    let sample = BeliefSample::of(&cloud, 50);
    let heavy = sample.poses().iter().position(|pose| pose.x == 300.0).unwrap();
    assert_abs_diff_eq!(sample.weights()[heavy], 0.9, epsilon = 0.021);
    assert_abs_diff_eq!(sample.weights().iter().sum::<f64>(), 1.0, epsilon = 1e-12);
    for (count, cloud) in [(0, &cloud), (10, &Particles::new())] {
        assert!(BeliefSample::of(cloud, count).poses().is_empty());
    }
}

/// What the filter makes of a single measurement, given as a likelihood of the pose.
fn raises_entropy(cloud: &Particles, tolerance: f64, rating: impl Fn(Pose2) -> f64) -> bool {
    let scan = scan_at(&office(), TRUTH, 1, 20.0);
    let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
    let sample = BeliefSample::of(cloud, 500);
    let filter = EntropyFilter::default().tolerance(tolerance).max_dropped(1.0);
    let pose = |at: nalgebra::Point2<f64>| Pose2::new(at.x, at.y, 0.0);
    filter.keep(|laser, _, _| rating(pose(laser)), &sample, &mounted, &[0]).unwrap().novel == 1
}

#[test]
fn entropy_falls_with_agreement_and_rises_with_contradiction() {
    let sigmas = [0.2, 0.2, 0.1];
    let cloud = cloud(Pose2::IDENTITY, sigmas, &mut stream(5, "belief"));
    let square = |x: f64, sigma: f64| -0.5 * (x / sigma).powi(2);
    assert!(!raises_entropy(&cloud, 0.0, |pose| square(pose.x, 0.1)));
    assert!(!raises_entropy(&cloud, 1e-9, |_| -7.0), "what says nothing is let through");
    // A weak pull away from the belief widens it, towards either side.
    let edge = |pose: Pose2| (1.0 - 0.95 * square(pose.x, 0.2).exp()).ln();
    assert!(raises_entropy(&cloud, 0.0, edge));
    // Two places, one all but ruled out: being sent there makes both possible.
    let other = Gaussian { mean: [5.0, 0.0, 0.0].into(), ..pose_belief(Pose2::IDENTITY, sigmas) };
    let mut two = cloud.clone();
    let mut rng = stream(6, "other");
    for _ in 0..100 {
        let [x, y, theta] = other.sample(&mut rng).into();
        two.push(Pose2::new(x, y, theta), -(2000_f64).ln());
    }
    two.normalize();
    let there = |pose: Pose2| if pose.x > 2.5 { 0.0 } else { -3.0 };
    let here = |pose: Pose2| if pose.x > 2.5 { -3.0 } else { 0.0 };
    assert!(raises_entropy(&two, 0.3, there) && !raises_entropy(&two, 0.0, here));
}

#[test]
fn the_entropy_filter_keeps_walls_and_leaves_out_who_pulls() {
    let (grid, mut rng) = (office(), stream(7, "entropy"));
    let field = LikelihoodField::new(&grid, &LikelihoodFieldSettings::nav2()).unwrap();
    let caster = RayCaster::new(&grid);
    let model = BeamModel::new(&BeamModelSettings::default().max_range(20.0)).unwrap();
    let (scan, short) = scan(&grid, TRUTH, 0.4, &mut rng);
    let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
    let cloud = cloud(TRUTH, [0.1, 0.1, 0.05], &mut rng);
    let sample = BeliefSample::of(&cloud, 64);
    let beams = informative_beams(&scan, BEAMS);
    let filter = EntropyFilter::default();
    let by_field = filter.keep(by_field(&field), &sample, &mounted, &beams).unwrap();
    let by_casting = filter.keep(by_casting(&caster, &model), &sample, &mounted, &beams).unwrap();
    for kept in [by_field, by_casting] {
        let share = |clean: bool| {
            let of = beams.iter().filter(|beam| short.contains(beam) != clean);
            let kept = of.clone().filter(|beam| kept.beams.contains(beam)).count();
            kept as f64 / of.count() as f64
        };
        println!("kept: {:.2} of the walls, {:.2} of the people", share(true), share(false));
        assert!(share(true) > 0.85 && share(true) > share(false));
    }
}

/// A step known but for noise.
struct Step(Pose2);

impl Motion for Step {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        for ((x, y), theta) in poses.x.iter_mut().zip(poses.y).zip(poses.theta) {
            let noise = [0.03, 0.03, 0.02].map(|sigma| sigma * box_muller(rng).0);
            let step =
                Pose2::new(self.0.x + noise[0], self.0.y + noise[1], self.0.theta + noise[2]);
            let moved = Pose2 { x: *x, y: *y, theta: *theta } * step;
            (*x, *y, *theta) = (moved.x, moved.y, moved.theta);
        }
    }
}

/// Mean error of a robot that turns on a circle among people, tracked with or without the filter.
fn tracked(grid: &OccupancyGrid, blocked: f64, filtered: bool, seed: u64) -> f64 {
    let caster = RayCaster::new(grid);
    let mut rng = stream(seed, "world");
    let step = Pose2::new(0.1, 0.0, 0.3);
    let mut truth = TRUTH;
    let start = Particles::from_gaussian(&pose_belief(truth, [0.1, 0.1, 0.05]), 400, &mut rng);
    let mut filter = ParticleFilter::new(start, stream(seed, "filter"));
    // No short part: the model of a robot that knows of no people.
    let settings = BeamModelSettings::default().z_short(0.0).z_rand(0.05).z_hit(0.9);
    let mut errors = 0.0;
    for _ in 0..20 {
        truth = truth * step;
        filter.predict(&Step(step));
        // People walk along on one side of the robot, and look like a wall there.
        let (mut scan, _) = scan(grid, truth, 0.0, &mut rng);
        let behind = (blocked * BEAMS as f64) as usize;
        let far = scan.ranges[..behind].iter_mut().filter(|range| **range > 1.2);
        far.for_each(|range| *range -= 0.7);
        let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
        let mut beams = informative_beams(&scan, 60);
        if filtered {
            let sample = BeliefSample::of(filter.particles(), 64);
            beams =
                DistanceFilter::default().keep(&caster, &sample, &mounted, &beams).unwrap().beams;
        }
        filter.weigh(&BeamLikelihood::new(&caster, &settings, &mounted, &beams, 0.3).unwrap());
        filter.normalize();
        let mean = loc_pf::estimate::moments(filter.particles()).pose();
        errors += f64::hypot(mean.x - truth.x, mean.y - truth.y) / 20.0;
        filter.resample(Resampling::Systematic, 400);
    }
    errors
}

#[test]
fn tracking_among_people_is_better_and_alone_no_worse() {
    let grid = office();
    let mean = |blocked, filtered| {
        (0..4).map(|seed| tracked(&grid, blocked, filtered, seed)).sum::<f64>() / 4.0
    };
    let (crowd, crowd_filtered) = (mean(0.4, false), mean(0.4, true));
    let (alone, alone_filtered) = (mean(0.0, false), mean(0.0, true));
    println!(
        "crowd {crowd:.3} -> {crowd_filtered:.3} m, alone {alone:.3} -> {alone_filtered:.3} m"
    );
    assert!(crowd_filtered < 0.08 && crowd_filtered < 0.7 * crowd);
    assert!(alone_filtered < alone + 0.003);
}

#[test]
fn settings_out_of_range_are_refused() {
    let (grid, mut rng) = (office(), stream(8, "bad"));
    let (scan, _) = scan(&grid, TRUTH, 0.0, &mut rng);
    let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
    let (caster, sample) = (RayCaster::new(&grid), BeliefSample::default());
    for filter in [
        DistanceFilter::default().threshold(1.5),
        DistanceFilter::default().sigma_hit(0.0),
        DistanceFilter::default().max_dropped(f64::NAN),
    ] {
        assert!(filter.keep(&caster, &sample, &mounted, &[0]).is_err());
    }
    let filter = EntropyFilter::default().tolerance(-1.0);
    assert!(filter.keep(|_, _, _| 0.0, &sample, &mounted, &[0]).is_err());
}
