//! A bag as an MCAP file of ROS 2, message by message.

use super::{Converted, LeftOut};
use crate::Result;
use crate::source::ros::messages::{
    Imu, LaserScan, Message, MultiEchoLaserScan, NavSatFix, OccupancyGrid, Odometry, Path,
    PointCloud2, PoseArray, PoseStamped, PoseWithCovarianceStamped, TfMessage,
};
use crate::source::ros::{Channel, Encoding, McapWriter, MessageReader};

/// Writes a message of a channel under its topic, with its time \[ns\].
type Transcription = fn(&mut McapWriter, &Channel, i64, &[u8]) -> Result<()>;

/// What is known of messages of ROS 1.
const KNOWN: [(&str, Transcription); 13] = [
    (Imu::NAME, anew::<Imu>),
    (LaserScan::NAME, anew::<LaserScan>),
    (MultiEchoLaserScan::NAME, anew::<MultiEchoLaserScan>),
    (NavSatFix::NAME, anew::<NavSatFix>),
    (OccupancyGrid::NAME, anew::<OccupancyGrid>),
    (Odometry::NAME, anew::<Odometry>),
    (Path::NAME, anew::<Path>),
    (PointCloud2::NAME, anew::<PointCloud2>),
    (PoseArray::NAME, anew::<PoseArray>),
    (PoseStamped::NAME, anew::<PoseStamped>),
    (PoseWithCovarianceStamped::NAME, anew::<PoseWithCovarianceStamped>),
    (TfMessage::NAME, anew::<TfMessage>),
    ("tf/msg/tfMessage", anew::<TfMessage>),
];

/// Copies the messages of a bag under their own topics and times. Those of ROS 2 keep their bytes,
/// whatever their type; those of ROS 1 are decoded and written in the serialisation of ROS 2, as
/// far as their types are known here.
///
/// # Errors
/// What the bag reports, [`loc_core::Error::Io`], and [`crate::Error::Recording`] for a topic with
/// messages of two types.
pub fn transcribe(
    bag: &mut dyn MessageReader,
    mut writer: McapWriter,
    progress: &mut dyn FnMut(f64),
) -> Result<Converted> {
    let (mut written, mut left_out) = (0_u64, LeftOut::default());
    let mut data = Vec::new();
    loop {
        progress(bag.progress());
        let Some(message) = bag.next_message()? else { break };
        let (index, time) = (message.channel, message.log_time);
        data.clear();
        data.extend_from_slice(message.data);
        let Some(channel) = bag.channels().get(index) else { continue };
        let type_name = &channel.type_name;
        match (&channel.encoding, known(channel)) {
            (Encoding::Cdr, _) => writer.write_bytes(&channel.topic, type_name, time, &data)?,
            (Encoding::Ros1, Some(transcription)) => {
                match transcription(&mut writer, channel, time, &data) {
                    Err(crate::Error::Malformed { what, expected, found }) => {
                        let why = format!("{what}: expected {expected}, got {found}");
                        left_out.count(format!("messages on {} ({why})", channel.topic));
                        continue;
                    }
                    result => result?,
                }
            }
            (Encoding::Ros1, None) => {
                left_out.count(format!("messages on {} of type {type_name}", channel.topic));
                continue;
            }
            (Encoding::Other(encoding), _) => {
                left_out.count(format!("messages on {} in the encoding {encoding}", channel.topic));
                continue;
            }
        }
        written += 1;
    }
    writer.finish()?;
    let mut left_out = left_out.lines();
    left_out.extend(bag.notes());
    Ok(Converted { written, left_out })
}

fn known(channel: &Channel) -> Option<Transcription> {
    KNOWN.iter().find(|(name, _)| channel.is_of(name)).map(|(_, transcription)| *transcription)
}

fn anew<M: Message>(
    writer: &mut McapWriter,
    channel: &Channel,
    time: i64,
    data: &[u8],
) -> Result<()> {
    writer.write(&channel.topic, time, &M::from_bytes(data, &channel.encoding)?)
}
