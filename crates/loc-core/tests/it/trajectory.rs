use approx::assert_abs_diff_eq;
use loc_core::{Error, Pose2, Trajectory, angle};
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI};

fn path(poses: &[(f64, Pose2)]) -> Trajectory {
    let mut path = Trajectory::new();
    for &(stamp, pose) in poses {
        path.push(stamp, pose).unwrap();
    }
    path
}

/// Reads a text as a TUM file.
fn read(text: &str) -> Result<Trajectory, Error> {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("path.tum");
    std::fs::write(&file, text).unwrap();
    Trajectory::read_tum(&file)
}

/// Line, column and message of the error that a TUM text must cause.
fn refused(text: &str) -> (usize, String, String) {
    let error = read(text).unwrap_err();
    let message = error.to_string();
    match error {
        Error::Parse { line, field, .. } => (line, field, message),
        other => panic!("{other}"),
    }
}

#[test]
fn interpolation_takes_the_shorter_turn() {
    let seam =
        path(&[(0.0, Pose2::new(0.0, 0.0, PI - 0.1)), (2.0, Pose2::new(4.0, -2.0, -PI + 0.3))]);
    let at = |stamp| seam.interpolate(stamp, 10.0).unwrap();
    assert_abs_diff_eq!(at(1.0).theta, -PI + 0.1, epsilon = 1e-12);
    assert_abs_diff_eq!(at(0.25).theta, PI - 0.05, epsilon = 1e-12);
    assert_abs_diff_eq!(at(0.5).x, 1.0, epsilon = 1e-12);
    assert_abs_diff_eq!(at(0.5).y, -0.5, epsilon = 1e-12);
    assert_eq!(at(0.0), Pose2::new(0.0, 0.0, PI - 0.1));
    assert_eq!(at(2.0), Pose2::new(4.0, -2.0, -PI + 0.3));
}

#[test]
fn interpolation_stops_at_gaps_and_ends() {
    let at = |stamp: f64| Pose2::new(stamp, 0.0, 0.0);
    let path = path(&[(1.0, at(1.0)), (2.0, at(2.0)), (12.0, at(12.0))]);
    assert_eq!(path.interpolate(0.999, 5.0), None);
    assert_eq!(path.interpolate(12.001, 5.0), None);
    assert_eq!(path.interpolate(1.5, 5.0), Some(at(1.5)));
    assert_eq!(path.interpolate(7.0, 5.0), None, "inside the gap");
    assert_eq!(path.interpolate(7.0, 10.0), Some(at(7.0)));
    assert_eq!(path.interpolate(2.0, 5.0), Some(at(2.0)));
    assert_eq!(path.interpolate(12.0, 5.0), Some(at(12.0)), "the far end of the gap");
    assert_eq!(path.interpolate(f64::NAN, 5.0), None);
    assert_eq!(Trajectory::new().interpolate(0.0, 1.0), None);
}

#[test]
fn two_poses_may_share_a_stamp() {
    let (a, b) = (Pose2::new(0.0, 0.0, 0.0), Pose2::new(2.0, 0.0, 0.0));
    let jump = path(&[(0.0, a), (1.0, a), (1.0, b), (2.0, b)]);
    assert_eq!(jump.interpolate(1.0, 9.0), Some(a));
    assert_eq!(jump.interpolate(0.75, 9.0), Some(a));
    assert_eq!(jump.interpolate(1.25, 9.0), Some(b));
}

#[test]
fn length_and_duration() {
    let square = path(&[
        (5.0, Pose2::new(0.0, 0.0, 0.0)),
        (6.0, Pose2::new(3.0, 4.0, 0.0)),
        (9.0, Pose2::new(3.0, 5.0, 0.0)),
    ]);
    assert_eq!((square.len(), square.duration(), square.path_length()), (3, 4.0, 6.0));
    assert_eq!((square.first().unwrap().stamp, square.last().unwrap().stamp), (5.0, 9.0));
    assert_eq!(square.iter().count(), (&square).into_iter().count());
    let empty = Trajectory::new();
    assert!(empty.is_empty() && empty.first().is_none() && empty.last().is_none());
    assert_eq!((empty.duration(), empty.path_length()), (0.0, 0.0));
}

#[test]
fn bad_poses_are_not_taken() {
    let mut path = path(&[(1.0, Pose2::IDENTITY)]);
    let error = path.push(0.5, Pose2::IDENTITY).unwrap_err();
    assert!(matches!(error, Error::TimeBackwards { before: 1.0, after: 0.5, .. }));
    for bad in [f64::NAN, f64::INFINITY] {
        for pose in [(bad, 0.0, 0.0), (0.0, bad, 0.0), (0.0, 0.0, bad)] {
            let pose = Pose2 { x: pose.0, y: pose.1, theta: pose.2 };
            assert!(matches!(path.push(2.0, pose), Err(Error::OutOfRange { .. })));
        }
        assert!(matches!(path.push(bad, Pose2::IDENTITY), Err(Error::OutOfRange { .. })));
    }
    assert_eq!(path.len(), 1);
}

#[test]
fn tum_files_of_others() {
    let text = "# timestamp tx ty tz qx qy qz qw\n\
                1305031098.6659 1.5 -2.0 0.7 0 0 0.7071 0.7071\n\
                1305031099.0 0 0 0 0 0 -1 0\r\n\
                1305031099.5, 0, 0, 0, 0, 0, -0.4794255386, -0.8775825619\n";
    let path = read(text).unwrap();
    let poses: Vec<_> = path.iter().collect();
    assert_eq!(poses[0].stamp, 1305031098.6659);
    assert_eq!((poses[0].value.x, poses[0].value.y), (1.5, -2.0));
    assert_abs_diff_eq!(poses[0].value.theta, FRAC_PI_2, epsilon = 1e-12);
    assert_abs_diff_eq!(poses[1].value.theta, PI, epsilon = 1e-12);
    assert_abs_diff_eq!(poses[2].value.theta, 1.0, epsilon = 1e-9);
}

#[test]
fn broken_tum_files_name_line_and_column() {
    let good = "0 0 0 0 0 0 0 1\n";
    let quaternion = |q: &str| refused(&format!("{good}1 0 0 0 {q}\n"));
    for q in ["0 0 0 0", "0 0 0 2", "0 0 0 0.9", "1 0 0 0", "0 0.1 0 0.995", "0 0 1e200 1e200"] {
        let (line, field, message) = quaternion(q);
        assert_eq!((line, field.as_str()), (2, "qx"), "{message}");
        assert!(message.contains("unit quaternion"), "{message}");
    }
    assert_eq!(quaternion("0 0 nan 1").1, "qz");
    let (line, field, message) = refused("5 0 0 0 0 0 0 1\n4.5 0 0 0 0 0 0 1\n");
    assert_eq!((line, field.as_str()), (2, "timestamp"));
    assert!(message.contains("not before the last one") && message.contains("`4.5`"), "{message}");
    let (line, field, _) = refused(&format!("{good}{good}1 0 0 0 0 0 0"));
    assert_eq!((line, field.as_str()), (3, "qw"));
    assert_eq!(refused("0 0 0 0 0 0 0 1 0\n").1, "line");
    assert_eq!(refused("x 0 0 0 0 0 0 1\n").1, "timestamp");
    assert_eq!(refused("0 0 inf 0 0 0 0 1\n").1, "ty");
    assert_eq!(refused("0 0 0 high 0 0 0 1\n").1, "tz");
    assert!(read(&good.repeat(2)).is_ok(), "equal stamps are no step back");
}

#[test]
fn empty_and_missing_tum_files() {
    for text in ["", "# timestamp tx ty tz qx qy qz qw\n", "\n\n"] {
        assert!(matches!(read(text), Err(Error::Empty { .. })), "{text:?}");
    }
    assert!(matches!(Trajectory::read_tum("no/such/file.tum"), Err(Error::Io { .. })));
}

proptest! {
    #[test]
    fn tum_round_trip(
        poses in prop::collection::vec((0.0..1e10_f64, -1e6..1e6_f64, -1e-6..1e-6_f64, -PI..=PI), 1..20),
    ) {
        let mut poses = poses;
        poses.sort_by(|a, b| a.0.total_cmp(&b.0));
        let poses: Vec<_> = poses.iter().map(|p| (p.0, Pose2::new(p.1, p.2, p.3))).collect();
        let written = path(&poses);
        let read = read(&written.to_tum()).unwrap();
        prop_assert_eq!(read.len(), written.len());
        for (a, b) in written.iter().zip(&read) {
            prop_assert_eq!(a.stamp.to_bits(), b.stamp.to_bits());
            prop_assert_eq!(a.value.x.to_bits(), b.value.x.to_bits());
            prop_assert_eq!(a.value.y.to_bits(), b.value.y.to_bits());
            // The heading passes through the sine and cosine of its half.
            prop_assert!(angle::difference(a.value.theta, b.value.theta).abs() <= 9e-16);
        }
    }
}
