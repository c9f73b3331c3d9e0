//! Conversion of a log to events, and kidnapped robots.

use super::*;
use loc_sensors::event::{Control, Event, Measurement, Payload};
use loc_sim::source::Source;
use loc_sim::source::laser_log::{Reference, Scans, Start};
use std::path::Path;
use std::sync::Arc;

fn events(mut recording: LaserRecording) -> Vec<Event> {
    std::iter::from_fn(|| recording.next_event().unwrap()).collect()
}

/// Each event as a letter: odometry, scan, truth.
fn letters(events: &[Event]) -> String {
    let letter = |event: &Event| match event.payload {
        Payload::Control(_) => 'o',
        Payload::Measurement(_) => 's',
        Payload::Truth(_) => 't',
    };
    events.iter().map(letter).collect()
}

fn mounting(events: &[Event]) -> Pose2 {
    let scan = events.iter().find_map(|event| match event.payload {
        Payload::Measurement(Measurement::Scan { mounting, .. }) => Some(mounting),
        _ => None,
    });
    scan.unwrap()
}

#[test]
fn the_odometry_of_a_scan_left_out_stays() {
    let log = "ODOM 9 9 9 0 0 0 1 h 1\nFLASER 1 5 1 1 0 7 7 0 2 h 2\nODOM 7.5 7 0 0 0 0 2.5 h 2\n\
               FLASER 1 6 2 1 0 8 7 0 3 h 3\nFLASER 1 7 3 1 0 9 7 0 4 h 4\nNEFF 3\n";
    let with = |scans| open(log, &ReplayOptions { scans, ..Default::default() }).unwrap();
    // What comes before the first scan that is used is passed over.
    let all = events(with(Scans::All));
    assert_eq!(letters(&all), "ostoostost");
    assert_eq!((all[0].stamp, all[9].stamp), (2.0, 4.0));
    assert_eq!(letters(&events(with(Scans::Even))), "ostoo".to_owned() + "ost");
    let odd = with(Scans::Odd);
    assert_eq!(odd.notes(), ["1 messages of other kinds passed over"]);
    assert_eq!((odd.setup().start, odd.setup().end), (3.0, 4.0));
    assert_eq!(odd.setup().start_belief.pose(), Pose2::new(2.0, 1.0, 0.0));
    let odd = events(odd);
    assert_eq!(letters(&odd), "osto");
    assert_eq!(odd[0].payload, Payload::Control(Control::Odometry(Pose2::new(8.0, 7.0, 0.0))));
    assert_eq!(
        refusal("ODOM 9 9 9 0 0 0 1 h 1\n", &ReplayOptions::default()),
        "hall.log: expected laser scans to use, got none among its 0"
    );
    assert_eq!(
        refusal(
            "FLASER 1 6 2 1 0 8 7 0 3 h 3\n",
            &ReplayOptions { scans: Scans::Odd, ..Default::default() }
        ),
        "hall.log: expected laser scans to use, got none among its 1"
    );
}

#[test]
fn stamps_that_do_not_ascend_are_replaced_by_numbers() {
    // As in Belgioioso: one stamp for all, and all odometry before all scans.
    let log = "ODOM 50 50 0 0 0 0 7 h 7\nFLASER 1 5 1 1 0 7 7 0 7 h 7\nFLASER 1 6 2 1 0 8 7 0 7 h 7\n\
               FLASER 1 6 3 1 0 9 7 0 7 h 7\n";
    let recording = open(log, &ReplayOptions::default()).unwrap();
    assert_eq!(recording.notes(), ["its stamps do not ascend: scans are taken as 1 s apart"]);
    assert_eq!(recording.setup().start_belief.pose(), Pose2::new(1.0, 1.0, 0.0));
    let stamps: Vec<f64> = events(recording).iter().map(|event| event.stamp).collect();
    assert_eq!(stamps, [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0]);
    let log =
        "FLASER 1 5 1 1 0 7 7 0 7 h 7\nODOM 5 5 0 0 0 0 6 h 7\nFLASER 1 6 2 1 0 8 7 0 8 h 7\n";
    let recording = open(log, &ReplayOptions::default()).unwrap();
    assert_eq!(recording.notes(), ["1 messages with a stamp before the last one, set to it"]);
    let stamps: Vec<f64> = events(recording).iter().map(|event| event.stamp).collect();
    assert_eq!(stamps, [7.0, 7.0, 7.0, 7.0, 8.0, 8.0, 8.0]);
}

#[test]
fn a_laser_that_keeps_its_place_is_mounted_there() {
    let place = Pose2::new(0.3, 0.1, 0.2);
    let odometry = odometry(&drive());
    let start = Start::At(Pose2::IDENTITY);
    let mounted =
        open(&carmen(|k, _| odometry[k] * place), &ReplayOptions { start, ..Default::default() });
    let mounted = mounted.unwrap();
    assert!(!mounted.has_truth());
    let found = mounting(&events(mounted));
    assert!(found.distance(place) < 1e-9 && (found.theta - place.theta).abs() < 1e-9);
    // A laser that is corrected sits where the log's PARAM says.
    let log = format!(
        "PARAM robot_frontlaser_offset 0.3 h 0\n{}",
        carmen(|_, t| t * Pose2::new(0.3, 0.0, 0.0))
    );
    let corrected = open(&log, &ReplayOptions::default()).unwrap();
    assert!(corrected.has_truth());
    assert!(corrected.setup().start_belief.pose().distance(drive()[0]) < 1e-9);
    assert_eq!(mounting(&events(corrected)), Pose2::new(0.3, 0.0, 0.0));
}

#[test]
fn true_poses_of_a_simulated_robot_go_first() {
    let log = "TRUEPOS 10 5 0 0 0 0 1 h 1\nFLASER 1 5 3 3 3 7 7 0 1.1 h 2\n\
               FLASER 1 5 4 3 3 8 7 0 2 h 2\nTRUEPOS 11 5 0 0 0 0 2 h 2\n";
    let recording = open(log, &ReplayOptions::default()).unwrap();
    assert_eq!(recording.setup().start_belief.pose(), Pose2::new(10.0, 5.0, 0.0));
    assert_eq!(letters(&events(recording)), "osost");
}

#[test]
fn a_reference_from_elsewhere_takes_the_place_of_the_logs_own() {
    let text = "time_s,x_m,y_m,theta_rad\n1,0,0,0\n51.0004,7,8,0.1\n60,9,9,0\n900,0,0,0\n";
    let reference = Reference::parse(Path::new("r.csv"), text).unwrap();
    let options = ReplayOptions { reference: Some(reference), ..Default::default() };
    let recording = open(&corrected(), &options).unwrap();
    // The reference of 51 s, moved back by the odometry of a second.
    let odometry = odometry(&drive());
    let expected = Pose2::new(7.0, 8.0, 0.1) * odometry[2].between(odometry[0]);
    assert!(recording.setup().start_belief.pose().distance(expected) < 1e-9);
    let events = events(recording);
    let truths = events.iter().filter(|event| matches!(event.payload, Payload::Truth(_)));
    assert_eq!(truths.map(|event| event.stamp).collect::<Vec<_>>(), [51.0004, 60.0]);
    // Rounded stamps: the scan of 51 s comes before its pose, that of 51.5 s after it.
    let before = letters(&events).find('t').unwrap();
    assert_eq!(letters(&events[..before]).matches('s').count(), 3);
    let far = Reference::parse(Path::new("r.csv"), "time_s,x_m,y_m,theta_rad\n1,0,0,0\n").unwrap();
    let options = ReplayOptions { reference: Some(far), ..Default::default() };
    let error = refusal(&corrected(), &options);
    assert_eq!(
        error,
        "hall.log: expected a reference between 50 s and 81.5 s, got none of its poses there"
    );
}

#[test]
fn the_start_pose_is_known_or_asked_for() {
    let map = Some(Arc::new(hall()));
    let options = |start| ReplayOptions { map: map.clone(), start, ..Default::default() };
    let error = refusal(&uncorrected(), &options(Start::Reference));
    assert!(error.contains("expected a reference to start from, a start pose"), "{error}");
    let anywhere = open(&uncorrected(), &options(Start::Anywhere)).unwrap();
    assert!(!anywhere.start_is_known());
    assert_eq!(anywhere.notes(), ["no reference to judge by: errors are left out"]);
    assert!(open(&corrected(), &options(Start::Anywhere)).unwrap().start_is_known());
    let outside = options(Start::At(Pose2::new(-1.5, 0.0, 0.0)));
    let error = refusal(&corrected(), &outside);
    assert_eq!(
        error,
        "hall.log: expected a start pose inside the map, got (-1.500 m, 0.000 m, 0.00 deg)"
    );
    let wall = open(&corrected(), &options(Start::At(Pose2::new(-0.95, 0.0, 0.0)))).unwrap();
    let note = "the start pose (-0.950 m, 0.000 m, 0.00 deg) lies in an occupied cell of the map";
    assert_eq!(wall.notes(), [note]);
    let nowhere = options(Start::At(Pose2 { x: f64::NAN, y: 0.0, theta: 0.0 }));
    assert!(refusal(&corrected(), &nowhere).contains("expected a finite start pose"));
    let sigmas = ReplayOptions { start_sigmas: [0.1, -0.1, 0.0], ..Default::default() };
    assert!(refusal(&corrected(), &sigmas).contains("sigma of the start [m]"));
}

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
fn without_a_reference_the_odometry_gives_the_distance() {
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
