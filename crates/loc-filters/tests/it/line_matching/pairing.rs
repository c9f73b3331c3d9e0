//! Which line is which.

use super::{ROOM, all_around, map, scanner, seen, settings};
use loc_core::Pose2;
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_filters::association::Rule;
use loc_filters::line_matching::{LineEkf, LinePairing, LineUpdate};
use loc_sensors::features::Line;

const PAIRINGS: [LinePairing; 4] = [
    LinePairing::MostLikelySet,
    LinePairing::Rule(Rule::NearestNeighbor),
    LinePairing::Rule(Rule::MaximumLikelihood),
    LinePairing::Rule(Rule::JointCompatibility),
];

fn partners(update: &LineUpdate) -> Vec<Option<usize>> {
    let line = |pair: &loc_filters::line_matching::LinePair| {
        pair.innovation.accepted.then_some(update.predicted[pair.predicted].line)
    };
    update.pairs.iter().map(|pair| pair.as_ref().and_then(line)).collect()
}

/// Piers at equal distances on one side of a room, its other walls far away: a robot that is off by
/// half a distance takes each for the next, unless it looks at all of them together.
#[test]
fn sets_of_pairs_see_what_single_pairs_do_not() {
    let piers: String = (0..6).map(|k| format!("{0},0,{0},2\n", 1.5 * f64::from(k))).collect();
    let map = map(&(piers + "9.4,-6,9.4,6\n"));
    let truth = Pose2::new(3.2, 4.0, 0.0);
    let believed = Pose2::new(4.1, 4.0, 0.0);
    let lines: Vec<Line> = (0..6)
        .map(|k| 1.5 * f64::from(k))
        .map(|x| seen(truth, [x, 0.2], [x, 1.8], [0.02, 0.01]))
        .chain([seen(truth, [9.4, -5.0], [9.4, 5.0], [0.02, 0.005])])
        .collect();
    for pairing in PAIRINGS {
        let with = settings().pairing(pairing);
        let mut ekf =
            LineEkf::new(map.clone(), with, pose_belief(believed, [0.6, 0.1, 0.05])).unwrap();
        let update = ekf.lines(lines.clone(), all_around(), Pose2::IDENTITY).unwrap();
        // The piers are what misleads; joint compatibility may leave the far wall unpaired.
        let piers = |found: &[Option<usize>]| found.iter().copied().eq((0..6).map(Some));
        let right = piers(&partners(&update)[..6]);
        let jointly =
            !matches!(pairing, LinePairing::Rule(rule) if rule != Rule::JointCompatibility);
        assert_eq!(right, jointly, "{pairing:?}: {:?}", partners(&update));
    }
}

/// A wall behind a pillar is seen in two pieces, which are both of it.
#[test]
fn pieces_of_one_wall_are_all_matched() {
    let map = map("5,-4,5,4\n-3,-4,5,-4\n");
    let truth = Pose2::new(0.1, 0.0, 0.02);
    let pieces = [([5.0, -4.0], [5.0, -0.5]), ([5.0, 0.5], [5.0, 4.0])];
    let lines: Vec<Line> = pieces.map(|(a, b)| seen(truth, a, b, [0.01, 0.005])).to_vec();
    let mut ekf =
        LineEkf::new(map, settings(), pose_belief(Pose2::IDENTITY, [0.1, 0.1, 0.05])).unwrap();
    let update = ekf.lines(lines, all_around(), Pose2::IDENTITY).unwrap();
    assert_eq!(partners(&update), [Some(0), Some(0)]);
    // Both count, so that what is left is better known than each alone.
    assert!(update.after.covariance.m11.sqrt() < 0.0075);
}

/// Furniture that is not in the map, and walls out of sight, have no partners.
#[test]
fn lines_without_a_partner_are_left_alone() {
    let truth = Pose2::new(1.2, 1.4, 0.2);
    let mut ekf = LineEkf::new(map(ROOM), settings(), pose_belief(truth, [0.02; 3])).unwrap();
    let wall = seen(truth, [6.0, 0.5], [6.0, 3.5], [0.005, 0.002]);
    let desk = seen(truth, [2.0, 2.0], [2.9, 2.2], [0.005, 0.005]);
    let beyond = seen(truth, [6.0, 8.0], [6.0, 9.5], [0.005, 0.005]);
    let update = ekf.lines(vec![wall, desk, beyond], all_around(), Pose2::IDENTITY).unwrap();
    assert_eq!(partners(&update), [Some(1), None, None]);
    let share = 3.0 / (3.0 + 0.9_f64.hypot(0.2) + 1.5);
    assert!((update.matched_share().unwrap() - share).abs() < 1e-12);
}

/// Believed to be behind the table, from where the near side of it is hidden, and the wall too.
#[test]
fn what_is_seen_from_where_the_robot_may_be_is_predicted() {
    let world = map("0,0,6,0\n6,0,6,4\n6,4,0,4\n0,4,0,0\n2.5,0,2.5,2\n2.5,2,2.7,2\n2.7,2,2.7,0\n");
    let (truth, believed) = (Pose2::new(2.3, 1.0, 3.0), Pose2::new(2.85, 1.1, 3.1));
    let scanner = scanner();
    let scan = scanner.scan(&world, truth, &mut stream(6, "hidden"));
    let start = pose_belief(believed, [0.3, 0.3, 0.05]);
    let mut ekf = LineEkf::new(world, settings(), start).unwrap();
    let update = ekf.scan(&scan, scanner.mounting).unwrap();
    assert!(ekf.belief().pose().distance(truth) < 0.01, "{:?}", partners(&update));
}

/// A wall so close that noise puts the scanner on its other side.
#[test]
fn a_wall_that_passes_through_the_scanner_is_matched() {
    let map = map("-5,0,5,0\n");
    let truth = Pose2::new(0.0, 0.004, 0.3);
    for off in [-0.01, 0.01] {
        let believed = Pose2::new(0.0, 0.004 + off, 0.31);
        let mut ekf =
            LineEkf::new(map.clone(), settings(), pose_belief(believed, [0.02; 3])).unwrap();
        let lines = vec![seen(truth, [-5.0, 0.0], [5.0, 0.0], [0.002, 0.001])];
        let update = ekf.lines(lines, all_around(), Pose2::IDENTITY).unwrap();
        assert_eq!(partners(&update), [Some(0)]);
        let residual = update.pairs[0].unwrap().innovation.residual;
        assert!(residual.amax() < 0.05, "{residual}");
        assert!((ekf.belief().mean.y - 0.004).abs() < 0.001);
    }
}
