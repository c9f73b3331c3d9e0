//! Robots that are carried away.

use super::*;
use loc_sensors::event::{Control, Payload};
use loc_sim::source::Source;

fn kidnapped(after: f64) -> ReplayOptions {
    ReplayOptions { kidnap: Some(after), ..Default::default() }
}

#[test]
fn odometry_and_time_go_on_as_if_nothing_had_happened() {
    let mut recording = open(&corrected(), &kidnapped(5.0)).unwrap();
    assert_eq!(recording.setup().kidnapped_at, Some(55.0));
    let (mut odometry, mut truth) = (Vec::new(), Vec::new());
    while let Some(event) = recording.next_event().unwrap() {
        match event.payload {
            Payload::Control(Control::Odometry(pose)) => odometry.push((event.stamp, pose)),
            Payload::Truth(of) => truth.push((event.stamp, of.pose)),
            _ => {}
        }
    }
    // Nothing jumps but the truth, and that once.
    for pair in odometry.windows(2) {
        let (dt, way) = (pair[1].0 - pair[0].0, pair[0].1.distance(pair[1].1));
        assert!((dt - 0.25).abs() < 1e-9 && way < 0.2, "{pair:?}");
        assert!((pair[1].1.theta - pair[0].1.theta).abs() < 0.1, "{pair:?}");
    }
    let jumps: Vec<_> =
        truth.windows(2).filter(|pair| pair[0].1.distance(pair[1].1) > 1.0).collect();
    assert_eq!(jumps.len(), 1);
    assert_eq!((jumps[0][0].0, jumps[0][1].0), (54.5, 55.0));
    let at_the_cut = drive()[10];
    let way = at_the_cut.distance(jumps[0][1].1);
    assert!((5.0..5.3).contains(&way), "{way}");
    // After it the robot drives as it did: each step of the odometry is that of the recording.
    let steps = super::odometry(&drive());
    let last = odometry[odometry.len() - 3].1.between(odometry[odometry.len() - 1].1);
    assert!(last.distance(steps[62].between(steps[63])) < 1e-9);
    assert_eq!(recording.setup().end, truth.last().unwrap().0);
}

#[test]
fn without_a_reference_the_odometry_says_how_far() {
    let start = loc_sim::source::laser_log::Start::Anywhere;
    let options = ReplayOptions { start, ..kidnapped(5.0) };
    let recording = open(&uncorrected(), &options).unwrap();
    assert_eq!(recording.setup().kidnapped_at, Some(55.0));
    let (cut_out, all) = (recording.setup().end, 81.5);
    assert!((9.0..11.0).contains(&(all - cut_out)), "{cut_out}");
}

#[test]
fn times_without_room_are_refused() {
    let error = |after: f64| refusal(&corrected(), &kidnapped(after));
    assert_eq!(
        error(40.0),
        "hall.log: expected a time of kidnapping above 0 s and up to 31.500 s, its end, got 40 s"
    );
    assert!(error(0.0).ends_with("its end, got 0 s"));
    assert_eq!(
        error(28.0),
        "hall.log: expected a scan at least 5 m from where the robot is at 28 s, got none in the \
         rest of the recording"
    );
    assert!(error(-1.0).contains("kidnapping [s]") && error(f64::NAN).contains("kidnapping [s]"));
}
