//! Reads a bag of ROS 1 or ROS 2: its topics, and the first messages.
//!
//! `cargo run -p loc-ros --example 01_read_a_bag -- my_bag` takes a folder of ROS 2, or a file
//! `.bag`, `.db3` or `.mcap`. Without a path it writes a small bag first and reads that.

use loc_core::Pose2;
use loc_ros::bag::Survey;
use loc_ros::messages::{Header, LaserScan, Message, Odometry, Stamp};
use loc_ros::{McapWriter, Result};
use std::path::{Path, PathBuf};

/// Messages that are printed.
const FIRST: usize = 5;

fn main() -> Result<()> {
    let path = match std::env::args_os().nth(1) {
        Some(path) => PathBuf::from(path),
        None => small_bag()?,
    };

    // What is in it: every message is looked at once.
    let mut bag = loc_ros::open(&path)?;
    let survey = Survey::of(bag.as_mut(), &mut |_, _| {}, &mut |_| {})?;
    println!("{}: {} messages", path.display(), survey.count());
    for topic in &survey.topics {
        let rate = topic.rate().map_or("-".into(), |rate| format!("{rate:.1} Hz"));
        println!("{} ({}): {}, {rate}", topic.channel.topic, topic.channel.type_name, topic.count);
    }
    // Where it breaks off, and what was passed over.
    survey.notes.iter().for_each(|note| println!("note: {note}"));

    // The messages themselves, one after the other.
    let mut bag = loc_ros::open(&path)?;
    for _ in 0..FIRST {
        let Some(message) = bag.next_message()? else { break };
        let (index, time, data) = (message.channel, message.log_time, message.data.to_vec());
        let Some(channel) = bag.channels().get(index) else { continue };
        let what = if channel.is_of(Odometry::NAME) {
            let odometry = Odometry::from_bytes(&data, &channel.encoding)?;
            format!("at {:?} m", odometry.pose.pose.position)
        } else if channel.is_of(LaserScan::NAME) {
            let scan = LaserScan::from_bytes(&data, &channel.encoding)?;
            format!("{} beams, the first {:.2?} m", scan.ranges.len(), scan.ranges.first())
        } else {
            format!("{} bytes", data.len())
        };
        println!("{:.3} s, {}: {what}", Stamp(time).seconds(), channel.topic);
    }
    Ok(())
}

/// A robot that drives 1 m/s along x, with odometry at 20 Hz and scans at 10 Hz.
fn small_bag() -> Result<PathBuf> {
    let path: &Path = &std::env::temp_dir().join("loc_ros_example.mcap");
    let mut writer = McapWriter::create(path)?;
    for k in 0..40_u32 {
        let stamp = Stamp::from_seconds(0.05 * f64::from(k));
        let mut odometry = Odometry { header: Header::new(stamp, "odom"), ..Odometry::default() };
        odometry.child_frame_id = "base_link".into();
        odometry.pose.pose = Pose2::new(stamp.seconds(), 0.0, 0.0).into();
        writer.write("/odom", stamp.0, &odometry)?;
        if k % 2 == 0 {
            let header = Header::new(stamp, "laser");
            let scan = LaserScan { header, ranges: vec![2.5; 180], ..LaserScan::default() };
            writer.write("/scan", stamp.0, &scan)?;
        }
    }
    writer.finish()?;
    Ok(path.to_owned())
}
