//! The first reading of a bag.

use crate::Result;
use crate::source::ros::bag::{Channel, RawMessage};
use crate::source::ros::messages::{Message, Odometry, Stamp, TfMessage};
use crate::source::ros::survey::Survey;
use crate::source::ros::tf::{Moving, TransformBuffer};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// Transforms of the last seconds are kept \[s\].
const KEEP: f64 = 30.0;

/// What is known of a bag before it is replayed.
#[derive(Debug, Clone)]
pub(super) struct Preview {
    pub(super) survey: Survey,
    /// The fixed transforms.
    pub(super) frames: TransformBuffer,
    /// Parents and children of the moving transforms.
    pub(super) moving: BTreeSet<(String, String)>,
    /// Frame and child frame of the odometry on each topic.
    pub(super) odometry_frames: BTreeMap<String, (String, String)>,
    /// The last stamp of an odometry.
    pub(super) last_stamp: Option<Stamp>,
}

/// Whether a channel carries transforms, and whether these move.
pub(super) fn transforms(channel: &Channel) -> Option<Moving> {
    let is_tf = channel.is_of(TfMessage::NAME) || channel.type_name == "tf/tfMessage";
    let is_static = channel.topic.ends_with("tf_static");
    is_tf.then_some(if is_static { Moving::No } else { Moving::Yes })
}

impl Preview {
    pub(super) fn of(path: &Path) -> Result<Self> {
        let mut preview = Preview {
            survey: Survey::default(),
            frames: TransformBuffer::new(KEEP),
            moving: BTreeSet::new(),
            odometry_frames: BTreeMap::new(),
            last_stamp: None,
        };
        let mut bag = super::super::open(path)?;
        let mut look = |channel: &Channel, message: &RawMessage<'_>| preview.look(channel, message);
        let survey = Survey::of(bag.as_mut(), &mut look, &mut |_| {})?;
        Ok(Preview { survey, ..preview })
    }

    /// Messages that cannot be read are counted by the second reading.
    fn look(&mut self, channel: &Channel, message: &RawMessage<'_>) {
        if let Some(moving) = transforms(channel) {
            let Ok(transforms) = TfMessage::from_bytes(message.data, &channel.encoding) else {
                return;
            };
            if moving == Moving::No {
                self.frames.insert_all(&transforms, moving);
                return;
            }
            for transform in transforms.transforms {
                let plain = |frame: &str| frame.trim_start_matches('/').to_owned();
                let edge = (plain(&transform.header.frame_id), plain(&transform.child_frame_id));
                self.last_stamp = self.last_stamp.max(Some(transform.header.stamp));
                if self.moving.len() < 10_000 {
                    self.moving.insert(edge);
                }
            }
        } else if channel.is_of(Odometry::NAME) {
            let Ok(odometry) = Odometry::from_bytes(message.data, &channel.encoding) else {
                return;
            };
            self.last_stamp = self.last_stamp.max(Some(odometry.header.stamp));
            let frames = (odometry.header.frame_id, odometry.child_frame_id);
            self.odometry_frames.entry(channel.topic.clone()).or_insert(frames);
        }
    }

    /// Whether one frame moves in another.
    pub(super) fn moves(&self, parent: &str, child: &str) -> bool {
        self.moving.contains(&(parent.to_owned(), child.to_owned()))
    }

    /// The only topic of odometry in a frame.
    pub(super) fn odometry_in(&self, frame: &str) -> Option<String> {
        let plain = |frame: &str| frame.trim_start_matches('/').to_owned();
        let fits = |(_, (of, _)): &(&String, &(String, String))| plain(of) == plain(frame);
        let mut topics = self.odometry_frames.iter().filter(fits);
        let (first, _) = topics.next()?;
        topics.next().is_none().then(|| first.clone())
    }

    /// The child of the first moving transform whose parent has a name that fits.
    pub(super) fn moving_below(&self, fits: impl Fn(&str) -> bool) -> Option<(&str, &str)> {
        let edge = self.moving.iter().find(|(parent, _)| fits(parent));
        edge.map(|(parent, child)| (parent.as_str(), child.as_str()))
    }
}
