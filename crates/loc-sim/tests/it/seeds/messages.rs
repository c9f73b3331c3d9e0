//! A message of every type, in every way of writing it.

use super::Corpus;
use loc_ros::messages::*;
use loc_ros::{Dialect, Encoding};

/// Writes a message behind the number of its type among the fuzz targets'.
fn put<M: Message>(kind: u8, message: &M) {
    for (target, dialect) in
        [("cdr", Dialect::Cdr), ("cdr", Dialect::CdrBigEndian), ("ros1", Dialect::Ros1)]
    {
        let bytes = message.to_bytes(dialect);
        let encoding = if dialect == Dialect::Ros1 { Encoding::Ros1 } else { Encoding::Cdr };
        assert_eq!(M::from_bytes(&bytes, &encoding).unwrap().to_bytes(dialect), bytes);
        let corpus = Corpus::of(target);
        corpus.put(&format!("{kind}-{dialect:?}"), &[&[kind], bytes.as_slice()].concat());
    }
}

#[test]
fn of_every_type() {
    let header = || Header::new(Stamp(1_500_000_000), "map");
    let scan = LaserScan {
        header: header(),
        ranges: vec![1.0, f32::INFINITY, f32::NAN],
        intensities: vec![3.0],
        ..LaserScan::default()
    };
    put(0, &scan);
    let bare = LaserScan { ranges: vec![], intensities: vec![], ..scan };
    let echoes = vec![vec![1.0, 2.0], vec![], vec![3.0]];
    put(1, &MultiEchoLaserScan { scan: bare, ranges: echoes.clone(), intensities: echoes });
    put(2, &Odometry { header: header(), child_frame_id: "b".into(), ..Odometry::default() });
    let transform = TransformStamped { header: header(), ..TransformStamped::default() };
    put(3, &TfMessage { transforms: vec![transform.clone(), transform] });
    put(4, &Imu { header: header(), ..Imu::default() });
    put(5, &NavSatFix { header: header(), latitude: 52.0, ..NavSatFix::default() });
    put(6, &PointCloud2::of(header(), &[[1.0, 2.0, 0.0], [4.0, 5.0, f32::NAN]]));
    let pose = PoseStamped { header: header(), ..PoseStamped::default() };
    put(7, &PoseWithCovarianceStamped { header: header(), ..Default::default() });
    put(
        8,
        &OccupancyGrid {
            header: header(),
            width: 2,
            height: 1,
            data: vec![-1, 100],
            ..Default::default()
        },
    );
    put(9, &Path { header: header(), poses: vec![pose.clone(), pose.clone()] });
    put(10, &PoseArray { header: header(), poses: vec![Pose::default(); 3] });
    put(11, &pose);
    put(12, &ParticleCloud { header: header(), particles: vec![(Pose::default(), 0.5); 2] });
    let values = vec![("key".into(), "value".into())];
    let status = DiagnosticStatus { name: "mcl".into(), values, ..Default::default() };
    put(13, &DiagnosticArray { header: header(), status: vec![status.clone(), status] });
}
