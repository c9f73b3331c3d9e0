//! A bag as an MCAP file of ROS 2, message by message.

use crate::bag::{Channel, Encoding, MessageReader};
use crate::mcap::McapWriter;
use crate::messages::{
    Imu, LaserScan, Message, MultiEchoLaserScan, NavSatFix, OccupancyGrid, Odometry, Path,
    PointCloud2, PoseArray, PoseStamped, PoseWithCovarianceStamped, TfMessage,
};
use crate::{Error, Result};
use std::collections::BTreeMap;

/// What [`transcribe`] did.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Transcribed {
    /// Number of messages written.
    pub written: u64,
    /// What could not be written, as counted lines for the user, and the notes of the bag.
    pub left_out: Vec<String>,
}

/// Writes a message of a channel under its topic, with its time \[ns\].
type Transcription = fn(&mut McapWriter, &Channel, i64, &[u8]) -> Result<()>;

/// What is known of messages of ROS 1.
const KNOWN: [(&str, Transcription); 13] = [
    (Imu::NAME, reencode::<Imu>),
    (LaserScan::NAME, reencode::<LaserScan>),
    (MultiEchoLaserScan::NAME, reencode::<MultiEchoLaserScan>),
    (NavSatFix::NAME, reencode::<NavSatFix>),
    (OccupancyGrid::NAME, reencode::<OccupancyGrid>),
    (Odometry::NAME, reencode::<Odometry>),
    (Path::NAME, reencode::<Path>),
    (PointCloud2::NAME, reencode::<PointCloud2>),
    (PoseArray::NAME, reencode::<PoseArray>),
    (PoseStamped::NAME, reencode::<PoseStamped>),
    (PoseWithCovarianceStamped::NAME, reencode::<PoseWithCovarianceStamped>),
    (TfMessage::NAME, reencode::<TfMessage>),
    ("tf/msg/tfMessage", reencode::<TfMessage>),
];

/// Copies the messages of a bag under their own topics and times. Those of ROS 2 keep their bytes,
/// whatever their type; those of ROS 1 are decoded and written in the serialisation of ROS 2, as
/// far as their types are known here.
///
/// # Errors
/// What the bag reports, [`loc_core::Error::Io`], and [`Error::Recording`] for a topic with
/// messages of two types.
pub fn transcribe(
    bag: &mut dyn MessageReader,
    mut writer: McapWriter,
    progress: &mut dyn FnMut(f64),
) -> Result<Transcribed> {
    let (mut written, mut left_out) = (0_u64, BTreeMap::<String, u64>::new());
    let mut leave_out = |what: String| *left_out.entry(what).or_default() += 1;
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
                    Err(Error::Malformed { what, expected, found }) => {
                        let why = format!("{what}: expected {expected}, got {found}");
                        leave_out(format!("messages on {} ({why})", channel.topic));
                        continue;
                    }
                    result => result?,
                }
            }
            (Encoding::Ros1, None) => {
                leave_out(format!("messages on {} of type {type_name}", channel.topic));
                continue;
            }
            (Encoding::Other(encoding), _) => {
                leave_out(format!("messages on {} in the encoding {encoding}", channel.topic));
                continue;
            }
        }
        written += 1;
    }
    writer.finish()?;
    let counted = left_out.into_iter().map(|(what, count)| format!("{count} {what}"));
    let mut left_out: Vec<String> = counted.collect();
    left_out.extend(bag.notes());
    Ok(Transcribed { written, left_out })
}

fn known(channel: &Channel) -> Option<Transcription> {
    KNOWN.iter().find(|(name, _)| channel.is_of(name)).map(|(_, transcription)| *transcription)
}

fn reencode<M: Message>(
    writer: &mut McapWriter,
    channel: &Channel,
    time: i64,
    data: &[u8],
) -> Result<()> {
    writer.write(&channel.topic, time, &M::from_bytes(data, &channel.encoding)?)
}
