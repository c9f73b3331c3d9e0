//! Ranges that are short of the map's walls, or long.

use crate::robot::{Robot, office};
use loc_core::Pose2;
use loc_core::gaussian::pose_belief;
use loc_core::random::stream;
use loc_pf::mcl::{MountedScan, RangeOffset};
use loc_pf::{Mcl, MclSettings};

/// A drive of a robot whose laser measures `short` \[m\] too little; the filter, and its mean
/// distance from the truth over the second half.
fn drive(seed: u64, short: f64, range_offset: RangeOffset) -> (Mcl, f64) {
    let map = office(seed);
    let mut robot = Robot::new(&map, Robot::laser(), seed);
    let settings = MclSettings::default().range_offset(range_offset);
    let mut mcl = Mcl::new(&map, settings, stream(seed, "mcl")).unwrap();
    mcl.start_at(&pose_belief(robot.truth, [0.1, 0.1, 0.05])).unwrap();
    let (mut sum, mut count) = (0.0, 0.0);
    for step in 0..60 {
        robot.drive();
        let mut scan = robot.scan();
        scan.ranges.iter_mut().for_each(|range| *range = (*range - short).max(0.0));
        let scan = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
        mcl.update(robot.odometry, &[scan]).unwrap();
        if step >= 30 {
            sum += robot.error(mcl.pose()).0;
            count += 1.0;
        }
    }
    (mcl, sum / count)
}

#[test]
fn an_offset_put_in_is_found_and_none_where_there_is_none() {
    let (mut with, mut without) = (0.0, 0.0);
    for seed in 1..=2 {
        let (mcl, error) = drive(seed, 0.0, RangeOffset::Estimated);
        let estimate = *mcl.range_offset_estimate();
        println!("{seed}: {:?} {:?} {error}", estimate.offset(), estimate.sigma());
        // Beams end on the faces of walls, the field has its peak half a cell behind them.
        assert!((0.0..0.045).contains(&estimate.offset().unwrap()), "{estimate:?}");
        assert_eq!(mcl.range_offset(), 0.0);
        for short in [0.08, -0.11] {
            let (mcl, error) = drive(seed, short, RangeOffset::Estimated);
            let estimate = mcl.range_offset_estimate();
            println!("{seed} {short}: {:?} {:?} {error}", estimate.offset(), estimate.sigma());
            assert!((mcl.range_offset() - short - 0.03).abs() < 0.02, "{estimate:?}");
            with += error;
            let plain = drive(seed, short, RangeOffset::Fixed(0.0)).1;
            println!("    plain {plain}");
            without += plain;
        }
    }
    println!("mean error with {with} and without {without}");
    assert!(with < without, "{with} {without}");
}

#[test]
fn a_fixed_offset_is_used_as_it_is_and_checked() {
    let (mcl, _) = drive(1, 0.05, RangeOffset::Fixed(0.05));
    assert_eq!((mcl.range_offset(), mcl.range_offset_estimate().scans()), (0.05, 0));
    for wrong in [f64::NAN, 0.2, f64::NEG_INFINITY] {
        let settings = MclSettings::default().range_offset(RangeOffset::Fixed(wrong));
        let error = Mcl::new(&office(1), settings, stream(1, "mcl")).unwrap_err().to_string();
        assert!(error.contains("range_offset [m]"), "{error}");
    }
}

#[cfg(feature = "serde")]
#[test]
fn settings_and_state_know_it() {
    let read = |text: &str| serde_json::from_str::<MclSettings>(text).unwrap().range_offset;
    assert_eq!(read("{}"), RangeOffset::Estimated);
    assert_eq!(read(r#"{"range_offset": "estimated"}"#), RangeOffset::Estimated);
    assert_eq!(read(r#"{"range_offset": {"fixed": -0.02}}"#), RangeOffset::Fixed(-0.02));
    let (mcl, _) = drive(2, 0.08, RangeOffset::Estimated);
    let mut again = Mcl::new(&office(2), MclSettings::default(), stream(9, "mcl")).unwrap();
    again.restore(mcl.state()).unwrap();
    assert_eq!(again.range_offset(), mcl.range_offset());
}
