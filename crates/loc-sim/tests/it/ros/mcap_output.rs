//! What a run writes as MCAP.

use super::all;
use loc_core::Pose2;
use loc_ros::McapReader;
use loc_ros::messages::*;
use loc_sim::localizer::Method;
use loc_sim::output::mcap::McapRecorder;
use loc_sim::scenario::Scenario;
use std::collections::BTreeMap;

/// map -> odom -> base_link is the estimate, and the topics are those that viewers look for.
#[test]
fn a_run_becomes_topics_of_ros() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("run.mcap");
    let changes = ["duration=3".to_owned()];
    let scenario = Scenario::named("landmark-drive", &changes)
        .or_else(|_| Scenario::named("landmark-drive", &[]))
        .unwrap();
    let mut recorder = McapRecorder::create(&file).unwrap();
    let run = scenario.run_observed(Some(1), Some(&[Method::Ekf]), &mut recorder).unwrap();
    recorder.finish().unwrap();
    let (messages, notes) = all(&mut McapReader::open(&file).unwrap());
    assert!(notes.is_empty(), "{notes:?}");
    let mut topics: BTreeMap<&str, Vec<_>> = BTreeMap::new();
    for message in &messages {
        topics.entry(&message.0.topic).or_default().push(message);
    }
    for topic in ["/amcl_pose", "/diagnostics", "/ground_truth", "/landmarks", "/odom", "/tf"] {
        assert!(topics.contains_key(topic), "{topic}: {:?}", topics.keys());
    }
    let poses = &topics["/amcl_pose"];
    assert_eq!(poses.len(), run.stamps.len());
    let (channel, _, data) = poses.last().unwrap();
    let pose = PoseWithCovarianceStamped::from_bytes(data, &channel.encoding).unwrap();
    let estimate = run.methods[0].estimates.last().unwrap();
    assert!(pose.pose.pose.planar().unwrap().distance(estimate.pose) < 1e-12);
    assert_eq!(pose.pose.covariance[35], estimate.covariance.unwrap()[(2, 2)]);
    assert_eq!(pose.pose.covariance[5], estimate.covariance.unwrap()[(0, 2)]);
    // The last path holds every true pose.
    let (channel, _, data) = topics["/ground_truth"].last().unwrap();
    let path = Path::from_bytes(data, &channel.encoding).unwrap();
    let last = path.poses.last().unwrap().pose.planar().unwrap();
    assert!(last.distance(run.truth.last().unwrap().value.pose) < 0.05);
    let (channel, _, data) = topics["/landmarks"][0];
    let landmarks = PoseArray::from_bytes(data, &channel.encoding).unwrap();
    assert_eq!(landmarks.poses.len(), run.setup.landmarks.len());
    let at = |parent: &str| {
        let found = topics["/tf"].iter().rev().find_map(|(channel, _, data)| {
            let message = TfMessage::from_bytes(data, &channel.encoding).unwrap();
            let transform = message.transforms[0].clone();
            (transform.header.frame_id == parent).then(|| transform.transform.planar().unwrap())
        });
        found.unwrap()
    };
    assert!((at("map") * at("odom")).is_finite() && at("odom") != Pose2::IDENTITY);
}
