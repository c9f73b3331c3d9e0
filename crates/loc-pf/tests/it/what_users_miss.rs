//! What users of other localizers miss, point by point; what one of those gets wrong must not go
//! wrong here.

use crate::robot::{Robot, office};
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_core::{Pose2, angle};
use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
use loc_maps::likelihood_field::Endpoints;
use loc_maps::{DistanceMap, LikelihoodField};
use loc_pf::adaptive::KldSettings;
use loc_pf::estimate::{ClusterSettings, Clusterer};
use loc_pf::mcl::{
    FieldSettings, MountedScan, NoveltyFilter, RecoverySettings, SensorSettings, Update,
};
use loc_pf::novelty::DistanceFilter;
use loc_pf::recovery::AugmentedSettings;
use loc_pf::sensor::BeamModelSettings;
use loc_pf::{Mcl, MclSettings, ParticleFilter, Particles, Resampling};
use loc_sensors::laser::LaserScan;
use std::f64::consts::PI;

fn mounted(scan: &LaserScan) -> [MountedScan<'_>; 1] {
    [MountedScan { scan, mounting: Pose2::IDENTITY }]
}

/// A filter that starts near the true pose.
fn tracking(map: &OccupancyGrid, robot: &Robot, settings: MclSettings, seed: u64) -> Mcl {
    let mut mcl = Mcl::new(map, settings, stream(seed, "mcl")).unwrap();
    mcl.start_at(&pose_belief(robot.truth, [0.2, 0.2, 0.1])).unwrap();
    mcl
}

fn step(mcl: &mut Mcl, robot: &mut Robot) -> Update {
    let scan = robot.scan();
    mcl.update(robot.odometry, &mounted(&scan)).unwrap()
}

fn drive(mcl: &mut Mcl, robot: &mut Robot, steps: usize) {
    for _ in 0..steps {
        robot.drive();
        step(mcl, robot);
    }
}

#[test]
fn point_01_recovery_after_a_kidnapping_fires() {
    let mut recovered = 0;
    for seed in 0..6 {
        let map = office(1);
        let mut robot = Robot::new(&map, Robot::laser(), seed);
        let mut mcl = tracking(&map, &robot, MclSettings::default(), seed);
        drive(&mut mcl, &mut robot, 10);
        robot.carry_off();
        drive(&mut mcl, &mut robot, 10);
        recovered += usize::from(robot.error(mcl.pose()).0 < 0.5);
    }
    assert!(recovered >= 5, "{recovered} of 6");
}

#[test]
fn point_01_random_particles_are_injected_by_the_averages_too() {
    let map = office(1);
    let mut robot = Robot::new(&map, Robot::laser(), 3);
    let augmented = AugmentedSettings::default().alpha_slow(0.05).alpha_fast(0.5);
    let recovery =
        RecoverySettings::default().search(false).suspicion(None).augmented(Some(augmented));
    let settings = MclSettings::default().recovery(recovery);
    let mut mcl = tracking(&map, &robot, settings, 3);
    drive(&mut mcl, &mut robot, 10);
    let spread = |mcl: &Mcl| {
        let far = mcl.particles().poses().iter().filter(|p| p.distance(mcl.pose()) > 3.0);
        far.count()
    };
    assert_eq!(spread(&mcl), 0);
    robot.carry_off();
    step(&mut mcl, &mut robot);
    drive(&mut mcl, &mut robot, 3);
    assert!(spread(&mcl) > 50, "{}", spread(&mcl));
}

#[test]
fn point_02_it_says_when_it_is_lost() {
    let map = office(1);
    let mut robot = Robot::new(&map, Robot::laser(), 5);
    let recovery = RecoverySettings::default().search(false);
    let settings = MclSettings::default().recovery(recovery);
    let mut mcl = tracking(&map, &robot, settings, 5);
    drive(&mut mcl, &mut robot, 20);
    assert!(mcl.lost() < 0.05, "{}", mcl.lost());
    robot.carry_off();
    drive(&mut mcl, &mut robot, 4);
    assert!(mcl.lost() > 0.9, "{}", mcl.lost());
}

#[test]
fn point_03_global_localization_ends() {
    let mut found = 0;
    for seed in 0..6 {
        let map = office(2);
        let mut robot = Robot::new(&map, Robot::laser(), seed);
        let mut mcl = Mcl::new(&map, MclSettings::default(), stream(seed, "mcl")).unwrap();
        step(&mut mcl, &mut robot);
        drive(&mut mcl, &mut robot, 5);
        found += usize::from(robot.error(mcl.pose()).0 < 0.5);
    }
    assert!(found >= 5, "{found} of 6");
}

#[test]
fn point_04_hypotheses_hold_together_across_pi_and_have_shares() {
    let mut rng = stream(1, "cloud");
    let mut cloud = Particles::new();
    for (at, count) in [(Pose2::new(1.0, 1.0, PI), 700), (Pose2::new(6.0, 1.0, 0.3), 300)] {
        let drawn = Particles::from_gaussian(&pose_belief(at, [0.1, 0.1, 0.1]), count, &mut rng);
        drawn.poses().iter().for_each(|pose| cloud.push(pose, 0.0));
    }
    cloud.normalize();
    let clusters = Clusterer::new(ClusterSettings::default()).unwrap().clusters(&cloud);
    assert_eq!(clusters.len(), 2);
    assert!((clusters[0].share - 0.7).abs() < 1e-9);
    assert!(angle::difference(clusters[0].belief.pose().theta, PI).abs() < 0.02);
}

/// A room of 6 m x 4 m with one pillar, turned and moved as a whole.
fn room(origin: Pose2) -> OccupancyGrid {
    let mut map = OccupancyGrid::filled(GridFrame::new(120, 80, 0.05, origin).unwrap(), 0);
    for column in 0..120 {
        for row in 0..80 {
            let edge = column == 0 || row == 0 || column == 119 || row == 79;
            let pillar = (30..36).contains(&column) && (50..54).contains(&row);
            let wall = row == 20 && column > 80;
            if edge || pillar || wall {
                map.set(Cell::new(column, row), 100).unwrap();
            }
        }
    }
    map
}

/// Mean error over some updates of a robot that stands at `truth`.
fn bias(map: &OccupancyGrid, truth: Pose2, mounting: Pose2, settings: &MclSettings) -> [f64; 2] {
    let mut laser = Robot::laser();
    laser.mounting = mounting;
    let mut sum = [0.0; 2];
    for seed in 0..5 {
        let mut robot = Robot::new(map, laser, seed);
        (robot.truth, robot.odometry) = (truth, Pose2::IDENTITY);
        let mut mcl = tracking(map, &robot, settings.clone(), seed);
        for _ in 0..4 {
            let scan = robot.scan();
            mcl.update_standing(robot.odometry, &[MountedScan { scan: &scan, mounting }]).unwrap();
        }
        let off = truth.between(mcl.pose());
        (sum[0], sum[1]) = (sum[0] + off.x / 5.0, sum[1] + off.y / 5.0);
    }
    sum
}

#[test]
fn point_05_the_yaw_of_the_map_counts_and_no_half_cell_is_lost() {
    let in_room = Pose2::new(2.6, 1.3, 0.7);
    for yaw in [0.0, 1.0, PI] {
        let origin = Pose2::new(-3.0, 12.0, yaw);
        let settings = MclSettings::default();
        let off = bias(&room(origin), origin * in_room, Pose2::IDENTITY, &settings);
        // Half a cell is 0.025 m.
        assert!(off.iter().all(|off| off.abs() < 0.012), "yaw {yaw}: {off:?}");
    }
}

#[test]
fn point_06_no_underflow_with_720_beams() {
    let map = office(1);
    let mut laser = Robot::laser();
    laser.spec.beams = 720;
    laser.spec.angle_increment = std::f64::consts::TAU / 720.0;
    laser.spec.angle_min = -PI;
    for sensor in [
        SensorSettings::LikelihoodField(FieldSettings::default()),
        SensorSettings::Beam(BeamModelSettings::default()),
    ] {
        let mut robot = Robot::new(&map, laser, 2);
        let settings = MclSettings::default().beams(720).independent_beams(720.0).sensor(sensor);
        let mut mcl = tracking(&map, &robot, settings, 2);
        drive(&mut mcl, &mut robot, 6);
        assert!(mcl.particles().log_weights().iter().all(|weight| !weight.is_nan()));
        assert!(mcl.pose().is_finite() && robot.error(mcl.pose()).0 < 0.2);
    }
}

#[test]
fn point_07_people_are_filtered_at_no_cost_in_an_empty_building() {
    let filter = Some(NoveltyFilter::Distance(DistanceFilter::default()));
    let with_people = |blocked: bool, novelty: Option<NoveltyFilter>| {
        let map = office(1);
        let mut robot = Robot::new(&map, Robot::laser(), 4);
        let mut mcl = tracking(&map, &robot, MclSettings::default().novelty(novelty), 4);
        let mut sum = 0.0;
        for k in 0..40 {
            robot.drive();
            let mut scan = robot.scan();
            if blocked {
                let around = (0..scan.ranges.len()).filter(|beam| (beam + k) % 100 < 40);
                around.for_each(|beam| scan.ranges[beam] = scan.ranges[beam].min(0.8));
            }
            mcl.update(robot.odometry, &mounted(&scan)).unwrap();
            sum += robot.error(mcl.pose()).0 / 40.0;
        }
        sum
    };
    let (crowded, empty, plain) =
        (with_people(true, filter), with_people(false, filter), with_people(false, None));
    assert!(crowded < 0.3, "{crowded}");
    assert!(empty < 1.2 * plain + 0.002, "{empty} against {plain}");
}

#[test]
fn point_08_walls_unknown_space_and_the_edge_of_the_map_are_settings() {
    use loc_maps::likelihood_field::{LikelihoodFieldSettings, Obstacles, OffMap, UnknownSpace};
    let mut map = room(Pose2::IDENTITY);
    map.set(Cell::new(60, 40), -1).unwrap();
    let at = |settings: LikelihoodFieldSettings, x: f64, y: f64| {
        let field = LikelihoodField::new(&map, &settings).unwrap();
        field.log_likelihood_at(&nalgebra::Point2::new(x, y)).exp()
    };
    let plain = LikelihoodFieldSettings::nav2();
    let unknown = plain.unknown_space(UnknownSpace::Likelihood(0.5));
    let off = plain.off_map(OffMap::Likelihood(0.5));
    let surfaces = plain.obstacles(Obstacles::Surfaces);
    assert!((at(unknown, 3.02, 2.02) - 0.5).abs() < 0.01 && at(plain, 3.02, 2.02) < 0.1);
    assert!((at(off, -1.0, 2.0) - 0.5).abs() < 0.01 && at(plain, -3.0, 2.0) < 0.1);
    // The middle of the pillar is no surface.
    assert!(at(surfaces, 1.65, 2.6) < at(plain, 1.65, 2.6));
}

#[test]
fn point_09_beams_are_thinned_after_the_invalid_ones_are_dropped() {
    let map = office(1);
    let mut robot = Robot::new(&map, Robot::laser(), 6);
    let settings = MclSettings::default().beams(60);
    let mut mcl = tracking(&map, &robot, settings, 6);
    let mut scan = robot.scan();
    // Two of three beams failed; the 90 others are enough for 60.
    for (beam, range) in scan.ranges.iter_mut().enumerate() {
        *range = if beam % 3 == 0 { *range } else { f64::NAN };
    }
    mcl.update(robot.odometry, &mounted(&scan)).unwrap();
    assert!(robot.error(mcl.pose()).0 < 0.15);
    assert_eq!(scan.thinned(60).len(), 60);
}

#[test]
fn point_10_several_lasers_anywhere_on_the_robot_in_every_model() {
    let origin = Pose2::IDENTITY;
    let (map, truth) = (room(origin), Pose2::new(2.6, 1.3, 0.7));
    let behind = Pose2::new(-0.3, 0.1, PI);
    for sensor in [
        SensorSettings::LikelihoodField(FieldSettings::default()),
        SensorSettings::Beam(BeamModelSettings::default().sigma_hit(0.1)),
    ] {
        let settings = MclSettings::default().sensor(sensor);
        let off = bias(&map, truth, behind, &settings);
        assert!(off.iter().all(|off| off.abs() < 0.04), "{sensor:?}: {off:?}");
        // Both lasers at once.
        let mut robot = Robot::new(&map, Robot::laser(), 1);
        robot.truth = truth;
        let front = robot.scan();
        robot.truth = truth * behind;
        let back = robot.scan();
        robot.truth = truth;
        let mut mcl = tracking(&map, &robot, settings, 1);
        let both = [
            MountedScan { scan: &front, mounting: Pose2::IDENTITY },
            MountedScan { scan: &back, mounting: behind },
        ];
        mcl.update(Pose2::IDENTITY, &both).unwrap();
        assert!(robot.error(mcl.pose()).0 < 0.1, "{sensor:?}");
    }
}

#[test]
fn point_11_a_compact_particle_set_needs_the_minimum_number() {
    let map = office(1);
    let mut robot = Robot::new(&map, Robot::laser(), 7);
    let particles = KldSettings::default().min_particles(120).max_particles(20_000);
    let mut mcl = tracking(&map, &robot, MclSettings::default().particles(particles), 7);
    assert_eq!(mcl.particles().len(), 20_000);
    drive(&mut mcl, &mut robot, 5);
    assert!(mcl.particles().len() < 400, "{}", mcl.particles().len());
}

#[test]
fn point_12_low_variance_and_selective_resampling_with_an_adaptive_size() {
    let map = office(1);
    for resampling in Resampling::ALL {
        let mut robot = Robot::new(&map, Robot::laser(), 8);
        let settings = MclSettings::default().tempering(None).resampling(resampling);
        let mut mcl = tracking(&map, &robot, settings, 8);
        drive(&mut mcl, &mut robot, 8);
        assert!(robot.error(mcl.pose()).0 < 0.3, "{resampling:?}");
        assert!(mcl.particles().len() < 2000, "{resampling:?}");
    }
}

#[test]
fn point_13_a_saved_state_goes_on_to_the_bit() {
    let map = office(1);
    let mut robot = Robot::new(&map, Robot::laser(), 9);
    let mut mcl = tracking(&map, &robot, MclSettings::default(), 9);
    drive(&mut mcl, &mut robot, 4);
    let saved = serde_json::to_string(&mcl.state()).unwrap();
    let mut other = Mcl::new(&map, MclSettings::default(), stream(1, "other")).unwrap();
    other.restore(serde_json::from_str(&saved).unwrap()).unwrap();
    for _ in 0..3 {
        robot.drive();
        let scan = robot.scan();
        for mcl in [&mut mcl, &mut other] {
            mcl.update(robot.odometry, &mounted(&scan)).unwrap();
        }
        assert_eq!(mcl.particles(), other.particles());
    }
}

#[test]
fn point_14_the_same_seed_gives_the_same_result_for_any_number_of_threads() {
    let run = |threads: usize| {
        let map = office(1);
        let mut robot = Robot::new(&map, Robot::laser(), 10);
        let particles = KldSettings::default().min_particles(3000).max_particles(5000);
        let settings = MclSettings::default().threads(threads).particles(particles);
        let mut mcl = Mcl::new(&map, settings, stream(10, "mcl")).unwrap();
        step(&mut mcl, &mut robot);
        drive(&mut mcl, &mut robot, 3);
        mcl.particles().clone()
    };
    let alone = run(1);
    assert!(alone == run(2) && alone == run(3));
}

#[test]
fn point_16_no_update_while_standing_still_unless_asked() {
    let map = office(1);
    let mut robot = Robot::new(&map, Robot::laser(), 11);
    let mut mcl = tracking(&map, &robot, MclSettings::default(), 11);
    assert!(matches!(step(&mut mcl, &mut robot), Update::Done(_)));
    let before = mcl.particles().clone();
    for _ in 0..5 {
        assert_eq!(step(&mut mcl, &mut robot), Update::StoodStill);
    }
    assert_eq!(&before, mcl.particles());
    let scan = robot.scan();
    let asked = mcl.update_standing(robot.odometry, &mounted(&scan)).unwrap();
    assert!(matches!(asked, Update::Done(_)));
    assert!(robot.error(mcl.pose()).0 < 0.1);
}

#[test]
fn point_16_no_wobble_when_turning_on_the_spot() {
    let map = office(1);
    let mut robot = Robot::new(&map, Robot::laser(), 12);
    let mut mcl = tracking(&map, &robot, MclSettings::default(), 12);
    let place = robot.truth;
    for _ in 0..30 {
        robot.truth.theta = angle::wrap(robot.truth.theta + 0.2);
        robot.odometry.theta = angle::wrap(robot.odometry.theta + 0.2);
        step(&mut mcl, &mut robot);
        assert!(mcl.pose().distance(place) < 0.1, "{}", mcl.pose().distance(place));
    }
}

#[test]
fn point_17_distances_are_exact() {
    let map = office(3);
    let distances = DistanceMap::new(&map, 3.0).unwrap();
    let frame = map.frame();
    let obstacles: Vec<Cell> = frame.cells().filter(|cell| map.value(*cell) == Some(100)).collect();
    for cell in frame.cells().step_by(7919) {
        let squared = |other: &Cell| {
            let dx = cell.column.abs_diff(other.column);
            let dy = cell.row.abs_diff(other.row);
            dx * dx + dy * dy
        };
        let nearest = obstacles.iter().map(squared).min().unwrap() as f64;
        let expected = (nearest.sqrt() * frame.resolution()).min(3.0);
        assert!((distances.distance(cell).unwrap() - expected).abs() < 1e-9);
    }
}

#[test]
fn point_15_fewer_beams_than_asked_for_another_map_and_starts_outside_are_no_crash() {
    let map = office(1);
    let mut robot = Robot::new(&map, Robot::laser(), 13);
    let settings = MclSettings::default().beams(200);
    let mut mcl = tracking(&map, &robot, settings.clone(), 13);
    let mut scan = robot.scan();
    scan.ranges.truncate(3);
    scan.angle_max = scan.angle_min + 2.0 * scan.angle_increment;
    mcl.update(robot.odometry, &mounted(&scan)).unwrap();
    assert!(mcl.pose().is_finite());
    // The map is switched while the robot runs: what is known is carried over, on it or off it.
    for other in [office(2), room(Pose2::new(100.0, 100.0, 1.0))] {
        let mut switched = Mcl::new(&other, settings.clone(), stream(13, "mcl")).unwrap();
        let off = pose_belief(Pose2::new(-1000.0, 0.0, 0.0), [0.1, 0.1, 0.1]);
        assert!(switched.start_at(&off).is_err());
        switched.restore(mcl.state()).unwrap();
        drive(&mut switched, &mut robot, 3);
        assert!(switched.pose().is_finite());
        assert!(switched.particles().log_weights().iter().all(|weight| !weight.is_nan()));
    }
}

/// Used by the tests of single rooms as well: a filter without particles does nothing.
#[test]
fn point_15_an_empty_particle_set_is_no_crash() {
    let mut filter = ParticleFilter::new(Particles::new(), stream(1, "empty"));
    let _ = filter.normalize();
    filter.resample(Resampling::Systematic, 10);
    assert!(filter.particles().is_empty());
    assert!(Endpoints::default().is_empty());
}
