//! Messages to bytes and back.

use loc_ros::messages::*;
use loc_ros::{Decoder, Dialect, Encoding};

/// Encodes in each dialect, decodes, and encodes again: the same bytes, NaN included. Then cuts
/// the bytes anywhere and changes each: never a panic.
fn round_trip<M: Message>(message: &M) {
    for dialect in [Dialect::Ros1, Dialect::Cdr, Dialect::CdrBigEndian] {
        let encoding = if dialect == Dialect::Ros1 { Encoding::Ros1 } else { Encoding::Cdr };
        let bytes = message.to_bytes(dialect);
        let again = M::from_bytes(&bytes, &encoding).unwrap();
        assert_eq!(again.to_bytes(dialect), bytes, "{} {dialect:?}", M::NAME);
        for length in 0..bytes.len() {
            let error = M::from_bytes(&bytes[..length], &encoding).err();
            // Only padding at the very end may be missing.
            assert!(error.is_some() || length + 8 > bytes.len(), "{} {length}", M::NAME);
        }
        for place in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[place] ^= 0xff;
            let _ = M::from_bytes(&changed, &encoding);
        }
    }
}

fn header() -> Header {
    Header::new(Stamp(1_663_967_375_548_411_329), "laser")
}

fn pose(k: f64) -> Pose {
    Pose { position: [k, f64::NAN, f64::NEG_INFINITY], orientation: [0.0, 0.0, 0.6, 0.8] }
}

#[test]
fn every_type_comes_back_bit_by_bit() {
    let (inf, nan) = (f32::INFINITY, f32::NAN);
    let scan = LaserScan {
        header: header(),
        angle_min: -1.5,
        ranges: vec![1.0, inf, -inf, nan, 2.5],
        intensities: vec![3.0],
        ..LaserScan::default()
    };
    round_trip(&scan);
    round_trip(&MultiEchoLaserScan {
        scan: LaserScan { ranges: vec![], intensities: vec![], ..scan },
        ranges: vec![vec![1.0, nan], vec![], vec![inf]],
        intensities: vec![vec![7.0]],
    });
    let mut odometry = Odometry { header: header(), ..Odometry::default() };
    odometry.child_frame_id = "base".into();
    odometry.pose.pose = pose(1.0);
    odometry.twist.covariance[35] = 0.25;
    round_trip(&odometry);
    let transform =
        TransformStamped { header: header(), child_frame_id: "b".into(), transform: pose(2.0) };
    round_trip(&TfMessage { transforms: vec![transform.clone(), transform] });
    round_trip(&Imu { header: header(), orientation_covariance: [-1.0; 9], ..Imu::default() });
    round_trip(&NavSatFix {
        header: header(),
        status: -1,
        service: 3,
        latitude: 52.3,
        ..NavSatFix::default()
    });
    round_trip(&PointCloud2::of(header(), &[[1.0, 2.0, nan], [4.0, inf, 6.0]]));
    round_trip(&PoseStamped { header: header(), pose: pose(3.0) });
    let stamped = PoseStamped { header: header(), pose: pose(4.0) };
    round_trip(&Path { header: header(), poses: vec![stamped.clone(), stamped] });
    round_trip(&PoseArray { header: header(), poses: vec![pose(5.0); 3] });
    round_trip(&PoseWithCovarianceStamped { header: header(), ..Default::default() });
    round_trip(&OccupancyGrid {
        header: header(),
        width: 2,
        height: 1,
        data: vec![-1, 100],
        ..Default::default()
    });
    round_trip(&ParticleCloud { header: header(), particles: vec![(pose(6.0), 0.5)] });
    let status = DiagnosticStatus {
        level: 1,
        name: "mcl".into(),
        values: vec![("a".into(), "b".into())],
        ..Default::default()
    };
    round_trip(&DiagnosticArray { header: header(), status: vec![status.clone(), status] });
}

/// By hand: 4 bytes of representation, sec, nsec, length 2 and "m\0", 2 to align, then doubles
/// aligned to 8 behind the representation.
#[test]
fn cdr_is_aligned_behind_its_head() {
    let message = PoseStamped {
        header: Header::new(Stamp(-1), "m"),
        pose: Pose { position: [1.0, 0.0, 0.0], ..Pose::default() },
    };
    let bytes = message.to_bytes(Dialect::Cdr);
    let head = [0, 1, 0, 0, 0xff, 0xff, 0xff, 0xff, 0xff, 0xc9, 0x9a, 0x3b, 2, 0, 0, 0, b'm', 0];
    assert_eq!(bytes[..18], head);
    assert_eq!(bytes[4 + 16..4 + 24], 1.0_f64.to_le_bytes());
    assert_eq!(bytes.len(), 4 + 16 + 56);
    let big = message.to_bytes(Dialect::CdrBigEndian);
    assert_eq!(big[..8], [0, 0, 0, 0, 0xff, 0xff, 0xff, 0xff]);
    assert_eq!(big[4 + 16..4 + 24], 1.0_f64.to_be_bytes());
    // ROS 1: a number in front, nothing aligned, no zero byte.
    let old = message.to_bytes(Dialect::Ros1);
    assert_eq!(old[12..17], [1, 0, 0, 0, b'm']);
    assert_eq!(old.len(), 17 + 56);
}

#[test]
fn lengths_beyond_the_message_are_errors() {
    let mut bytes = PoseStamped::default().to_bytes(Dialect::Cdr);
    bytes[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    let error = PoseStamped::from_bytes(&bytes, &Encoding::Cdr).unwrap_err().to_string();
    assert!(error.contains("frame_id") && error.contains("4294967295"), "{error}");
    let error = Decoder::new(&[0, 7, 0, 0], &Encoding::Cdr).unwrap_err().to_string();
    assert!(error.contains("plain CDR"), "{error}");
    let other = Encoding::Other("protobuf".into());
    assert!(Decoder::new(&[], &other).unwrap_err().to_string().contains("protobuf"));
}

#[test]
fn seconds_keep_their_nanoseconds_apart() {
    let stamp = Stamp(1_663_967_375_548_411_329);
    assert!((stamp.seconds() - 1_663_967_375.548_411_3).abs() < 3e-7);
    assert_eq!(Stamp::from_seconds(1.25), Stamp(1_250_000_000));
    assert_eq!(Stamp::from_seconds(-0.25), Stamp(-250_000_000));
    assert_eq!(Stamp::from_seconds(f64::NAN), Stamp(0));
}

/// Points at 0, 90 and 180 degrees; one too high, one behind another.
#[test]
fn a_slice_of_a_cloud_is_a_scan() {
    let points =
        [[2.0, 0.0, 0.05], [0.0, 3.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.5], [5.0, 0.0, 0.0]];
    let cloud = PointCloud2::of(header(), &points);
    let scan = cloud.slice(&Slice { beams: 4, ..Slice::default() }).unwrap();
    assert_eq!(scan.ranges, [1.0, f32::INFINITY, 2.0, 3.0]);
    assert!((scan.angle_min + std::f32::consts::PI).abs() < 1e-6);
    let mut lies = cloud.clone();
    lies.width = 1000;
    assert!(
        lies.slice(&Slice::default()).unwrap_err().to_string().contains("60 bytes, rows of 60")
    );
    // Millions of rows that are one and the same, or of no points.
    let mut rows = cloud.clone();
    (rows.height, rows.row_step) = (u32::MAX, 0);
    assert!(rows.points().unwrap_err().to_string().contains("rows of 0"));
    (rows.width, rows.row_step) = (0, 12);
    assert!(rows.points().unwrap().is_empty());
    lies.fields.clear();
    assert!(lies.points().unwrap_err().to_string().contains("field x"));
}
