//! Monte Carlo localization with a user's own models of motion and sensor.

use crate::robot::{Robot, office};
use loc_core::gaussian::pose_belief;
use loc_core::motion::DrivenPath;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, angle};
use loc_filters::RobotSettings;
use loc_pf::mcl::{MotionModel, MotionSettings, MountedScan, ScanModel, ScanView};
use loc_pf::{Mcl, MclSettings, Motion, PosesMut, Transport};
use rand_distr::{Distribution, StandardNormal};

/// The product over the likelihood field, pose by pose.
struct OwnField;

impl ScanModel for OwnField {
    type Likelihood<'a> = Box<dyn Fn(Pose2) -> f64 + Sync + 'a>;

    fn likelihood<'a>(&'a self, scan: &ScanView<'a>) -> loc_pf::Result<Self::Likelihood<'a>> {
        let ScanView { field, endpoints, exponent, .. } = *scan;
        Ok(Box::new(move |pose| exponent * field.log_likelihood(pose, endpoints)))
    }
}

/// Five per cent of the distance in each direction, and of a radian in the heading.
struct OwnMotion;

#[derive(Debug, Clone, Copy)]
struct OwnStep {
    step: Pose2,
    sigma: f64,
}

impl MotionModel for OwnMotion {
    type Step = OwnStep;

    fn step(&self, path: &DrivenPath, _robot: &RobotSettings) -> loc_pf::Result<OwnStep> {
        let sigma = 0.01 + 0.05 * path.length();
        Ok(OwnStep { step: path.step(), sigma })
    }
}

impl Transport for OwnStep {
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2 {
        let [x, y, theta] = [noise[0], noise[1], noise[2]].map(|z| self.sigma * z);
        pose * self.step * Pose2::new(x, y, theta)
    }
}

impl Motion for OwnStep {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        let moved = |pose, rng: &mut ChaCha8Rng| {
            self.moved(pose, std::array::from_fn(|_| StandardNormal.sample(rng)))
        };
        moved.sample(poses, rng);
    }
}

fn update<M: MotionModel, S: ScanModel>(mcl: &mut Mcl<M, S>, robot: &mut Robot) {
    robot.drive();
    let scan = robot.scan();
    mcl.update(robot.odometry, &[MountedScan { scan: &scan, mounting: Pose2::IDENTITY }]).unwrap();
}

/// The same likelihood, written by a user, gives the same drive: same particles, same lost figure.
#[test]
fn an_own_likelihood_field_is_as_good_as_the_built_in_one() {
    let map = office(1);
    // The offset of the ranges is only estimated with the built-in field.
    let fixed = loc_pf::mcl::RangeOffset::Fixed(0.0);
    let settings = MclSettings::default().range_offset(fixed);
    let (mut robot, mut twin) =
        (Robot::new(&map, Robot::laser(), 4), Robot::new(&map, Robot::laser(), 4));
    let mut built_in = Mcl::new(&map, settings.clone(), stream(4, "mcl")).unwrap();
    let mut own =
        Mcl::with_models(&map, settings, MotionSettings::Path, OwnField, stream(4, "mcl")).unwrap();
    let start = pose_belief(robot.truth, [0.2, 0.2, 0.1]);
    built_in.start_at(&start).unwrap();
    own.start_at(&start).unwrap();
    for _ in 0..20 {
        update(&mut built_in, &mut robot);
        update(&mut own, &mut twin);
    }
    let (a, b) = (built_in.pose(), own.pose());
    assert!(a.distance(b) < 0.01 && angle::difference(a.theta, b.theta).abs() < 0.005, "{a} {b}");
    assert!((built_in.lost() - own.lost()).abs() < 0.01);
    assert!(robot.error(a).0 < 0.1);
}

/// Search, suspicion and alternative work with both models of a user.
#[test]
fn a_kidnapped_robot_is_found_again_with_own_models() {
    let mut found = 0;
    for seed in 0..4 {
        let map = office(1);
        let mut robot = Robot::new(&map, Robot::laser(), seed);
        let (settings, rng) = (MclSettings::default(), stream(seed, "mcl"));
        let mut mcl = Mcl::with_models(&map, settings, OwnMotion, OwnField, rng).unwrap();
        mcl.start_at(&pose_belief(robot.truth, [0.2, 0.2, 0.1])).unwrap();
        (0..10).for_each(|_| update(&mut mcl, &mut robot));
        assert!(robot.error(mcl.pose()).0 < 0.1 && mcl.lost() < 0.1);
        robot.carry_off();
        (0..12).for_each(|_| update(&mut mcl, &mut robot));
        found += usize::from(robot.error(mcl.pose()).0 < 0.5);
    }
    assert!(found >= 3, "{found} of 4");
}
