//! Which topic is what.
//!
//! The first reading of a bag ([`Preview`]) counts its topics, collects the fixed transforms
//! (`/tf_static` may come late) and the names of frames. [`Roles`] then chooses the topics with
//! scans, odometry, true poses and other sensors: what the user names, or else the only one of its
//! type.

use super::{RecordingOptions, RosNames, unsuitable};
use crate::Result;
use crate::bag::{self, Channel, RawMessage, Survey, Topic};
use crate::messages::{
    self, Imu, LaserScan, Message, MultiEchoLaserScan, NavSatFix, Odometry, PointCloud2,
    PoseStamped, PoseWithCovarianceStamped, Stamp, TfMessage,
};
use crate::tf::{Moving, TransformBuffer, plain};
use loc_core::Pose2;
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
        let mut bag = bag::open(path)?;
        let mut observe =
            |channel: &Channel, message: &RawMessage<'_>| preview.observe(channel, message);
        let survey = Survey::of(bag.as_mut(), &mut observe, &mut |_| {})?;
        Ok(Preview { survey, ..preview })
    }

    /// Messages that cannot be read are counted by the second reading.
    fn observe(&mut self, channel: &Channel, message: &RawMessage<'_>) {
        if let Some(moving) = transforms(channel) {
            let Ok(transforms) = TfMessage::from_bytes(message.data, &channel.encoding) else {
                return;
            };
            if moving == Moving::No {
                self.frames.insert_all(&transforms, moving);
                return;
            }
            for transform in transforms.transforms {
                let edge = (
                    plain(&transform.header.frame_id).to_owned(),
                    plain(&transform.child_frame_id).to_owned(),
                );
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

/// What the topics of a bag are used for.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Roles {
    pub(super) scans: String,
    pub(super) odometry: OdometryFrom,
    /// The frame of the robot.
    pub(super) base: String,
    /// Where that frame is in the one that the odometry is about.
    pub(super) base_in_odometry: Pose2,
    pub(super) reference: ReferenceFrom,
    /// The topic of an inertial unit, and of a satellite receiver.
    pub(super) inertial: Option<String>,
    pub(super) satellites: Option<String>,
    /// Topics from which none was chosen, and names
    /// that are not in the bag, as lines for the user.
    pub(super) notes: Vec<String>,
}

/// Where the odometry comes from.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum OdometryFrom {
    /// A topic of type Odometry.
    Topic(String),
    /// The transform of the robot in this frame.
    Transform(String),
}

/// Where true poses come from.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum ReferenceFrom {
    Nothing,
    /// A topic of poses.
    Topic(String),
    /// The transforms from this frame, the map's, to the robot.
    Transform(String),
}

/// Types of scans, and of true poses.
const SCANS: [&str; 3] = [LaserScan::NAME, MultiEchoLaserScan::NAME, PointCloud2::NAME];
const ODOMETRY: [&str; 1] = [Odometry::NAME];
const POSES: [&str; 3] = [Odometry::NAME, PoseStamped::NAME, PoseWithCovarianceStamped::NAME];

impl Roles {
    pub(super) fn choose(
        path: &Path,
        preview: &Preview,
        options: &RecordingOptions,
    ) -> Result<Self> {
        let chooser = Chooser { path, topics: &preview.survey.topics };
        // A cloud is made a scan of only where there is no laser, or where it is named.
        let lasers = chooser.of(&SCANS[..2]).next().is_some() && options.scan_topic.is_none();
        let kinds = if lasers { &SCANS[..2] } else { &SCANS };
        let names = &options.names;
        let mut notes = Vec::new();
        let given = names.scan_topic.as_deref().filter(|_| options.scan_topic.is_none());
        let found = given.and_then(|name| chooser.named(name, &SCANS));
        let named = options.scan_topic.clone().or(found);
        let scans = chooser.choose("--scan-topic", &named, kinds, "scans")?;
        let scans = scans.ok_or_else(|| {
            chooser.missing("a topic of type LaserScan, MultiEchoLaserScan or PointCloud2")
        })?;
        if let Some(name) = given.filter(|name| plain(name) != plain(&scans)) {
            notes.push(missing_name("scan_topic", name, &scans));
        }
        // Of several topics, that with the frame.
        let of_frame = names.odom_frame.as_deref().and_then(|frame| preview.odometry_in(frame));
        let named = options.odom_topic.clone().or(of_frame);
        let odometry = chooser.choose("--odom-topic", &named, &ODOMETRY, "odometry")?;
        let (odometry, base) = match odometry {
            Some(topic) => {
                let child = preview.odometry_frames.get(&topic).map(|(_, child)| child.as_str());
                let child = child.filter(|child| !child.is_empty()).unwrap_or("base_link");
                (OdometryFrom::Topic(topic), child.to_owned())
            }
            None => {
                let is_named = |frame: &str| Some(frame) == names.odom_frame.as_deref().map(plain);
                let is_odom = |frame: &str| frame.contains("odom");
                let below =
                    preview.moving_below(is_named).or_else(|| preview.moving_below(is_odom));
                let (parent, child) = below.ok_or_else(|| {
                    chooser.missing("a topic of type Odometry, or a transform from a frame odom")
                })?;
                let given = names.base_frame.as_deref().map(plain);
                let child = given.filter(|base| preview.moves(parent, base)).unwrap_or(child);
                (OdometryFrom::Transform(parent.to_owned()), child.to_owned())
            }
        };
        let (base, base_in_odometry) =
            base_frame(names, preview, &odometry, plain(&base), &mut notes);
        check_frames(names, preview, &odometry, &mut notes);
        let reference = reference(&chooser, preview, options)?;
        let mut roles = Roles {
            scans,
            odometry,
            base,
            base_in_odometry,
            reference,
            inertial: None,
            satellites: None,
            notes,
        };
        let left_out = &mut roles.notes;
        roles.inertial =
            chooser.optional_sensor("--imu-topic", &options.imu_topic, Imu::NAME, left_out)?;
        roles.satellites = chooser.optional_sensor(
            "--fix-topic",
            &options.fix_topic,
            NavSatFix::NAME,
            left_out,
        )?;
        Ok(roles)
    }
}

/// The topic or transform with the true poses.
fn reference(
    chooser: &Chooser<'_>,
    preview: &Preview,
    options: &RecordingOptions,
) -> Result<ReferenceFrom> {
    let given = options.names.map_frame.as_deref().map_or("map", plain);
    let map = preview.moving_below(|frame| frame == given);
    let map = map.or_else(|| preview.moving_below(|frame| frame == "map"));
    let map = map.map(|(map, _)| map.to_owned());
    let named = options.reference_topic.as_deref().map(|name| (name, name.trim_start_matches('/')));
    Ok(match named {
        Some((_, "none")) => ReferenceFrom::Nothing,
        Some((_, "tf")) => ReferenceFrom::Transform(map.ok_or_else(|| {
            chooser.missing("a moving transform from the frame map (--reference-topic /tf)")
        })?),
        Some((name, _)) => {
            let name = Some(name.to_owned());
            let topic = chooser.choose("--reference-topic", &name, &POSES, "poses")?;
            topic.map_or(ReferenceFrom::Nothing, ReferenceFrom::Topic)
        }
        None => {
            let mut truths = chooser.of(&POSES).filter(|topic| is_truth(topic));
            match (truths.next(), map) {
                (Some(topic), _) => ReferenceFrom::Topic(topic.channel.topic.clone()),
                (None, Some(map)) => ReferenceFrom::Transform(map),
                (None, None) => ReferenceFrom::Nothing,
            }
        }
    })
}

/// Whether the name says that the poses are true.
fn is_truth(topic: &Topic) -> bool {
    let name = topic.channel.topic.replace('_', "").to_lowercase();
    name.contains("groundtruth")
}

struct Chooser<'a> {
    path: &'a Path,
    topics: &'a [Topic],
}

impl Chooser<'_> {
    /// The topics with messages of one of several types.
    fn of<'t>(&'t self, types: &'t [&str]) -> impl Iterator<Item = &'t Topic> {
        let fits = |topic: &&Topic| types.iter().any(|name| topic.channel.is_of(name));
        self.topics.iter().filter(|topic| topic.count > 0).filter(fits)
    }

    /// The topic with messages of one of several types that has a name.
    fn named(&self, name: &str, types: &[&str]) -> Option<String> {
        let topic = self.of(types).find(|topic| plain(&topic.channel.topic) == plain(name));
        topic.map(|topic| topic.channel.topic.clone())
    }

    /// The topic that is named, or the only one of its types.
    fn choose(
        &self,
        option: &str,
        named: &Option<String>,
        types: &[&str],
        what: &str,
    ) -> Result<Option<String>> {
        if let Some(named) = named {
            let found = self
                .topics
                .iter()
                .filter(|t| t.count > 0)
                .find(|topic| plain(&topic.channel.topic) == plain(named));
            let Some(topic) = found else {
                return Err(self.missing(&format!("messages on {named} ({option})")));
            };
            if !types.iter().any(|name| topic.channel.is_of(name)) {
                let expected = format!("{option} of type {}", types.join(", "));
                return Err(unsuitable(self.path, expected, &topic.channel.type_name));
            }
            return Ok(Some(topic.channel.topic.clone()));
        }
        let found: Vec<&str> = self
            .of(types)
            .filter(|topic| what != "odometry" || !is_truth(topic))
            .map(|topic| topic.channel.topic.as_str())
            .collect();
        match found.as_slice() {
            [] => Ok(None),
            [only] => Ok(Some((*only).to_owned())),
            several => {
                let expected = format!("one topic of {what}, or {option} to choose one");
                Err(unsuitable(self.path, expected, several.join(", ")))
            }
        }
    }

    /// The topic of a sensor that is optional: the one named, where it is not `none`, or
    /// the only one. Several are left out, and a line for the user goes into `left_out`.
    fn optional_sensor(
        &self,
        option: &str,
        named: &Option<String>,
        kind: &str,
        left_out: &mut Vec<String>,
    ) -> Result<Option<String>> {
        match named.as_deref() {
            Some("none") => return Ok(None),
            Some(_) => return self.choose(option, named, &[kind], "a sensor"),
            None => {}
        }
        let kinds = [kind];
        let topics: Vec<&str> = self.of(&kinds).map(|topic| topic.channel.topic.as_str()).collect();
        if topics.len() > 1 {
            let topics = topics.join(", ");
            left_out.push(format!("{topics} are left out: {option} chooses one of them"));
            return Ok(None);
        }
        Ok(topics.first().map(|topic| (*topic).to_owned()))
    }

    fn missing(&self, expected: &str) -> crate::Error {
        let topics: Vec<String> = self
            .topics
            .iter()
            .map(|topic| format!("{} ({})", topic.channel.topic, topic.channel.type_name))
            .collect();
        let found = match topics.is_empty() {
            true => "a bag without messages".to_owned(),
            false => topics.join(", "),
        };
        unsuitable(self.path, expected, found)
    }
}

/// The frame of the robot, and where it is in the one that the odometry is about: the frame that
/// is given, where fixed transforms join the two.
fn base_frame(
    names: &RosNames,
    preview: &Preview,
    odometry: &OdometryFrom,
    child: &str,
    notes: &mut Vec<String>,
) -> (String, Pose2) {
    let same = (child.to_owned(), Pose2::IDENTITY);
    let Some(given) = names.base_frame.as_deref().map(plain).filter(|name| *name != child) else {
        return same;
    };
    // A transform is the odometry of its own child.
    let is_topic = matches!(odometry, OdometryFrom::Topic(_));
    match preview.frames.lookup(child, given, Stamp(0), 0.0) {
        Ok(place) if is_topic => (given.to_owned(), messages::planar(&place)),
        _ => {
            notes.push(missing_name("base_frame_id", given, child));
            same
        }
    }
}

/// Notes the other names of frames that are not in the bag.
fn check_frames(
    names: &RosNames,
    preview: &Preview,
    odometry: &OdometryFrom,
    notes: &mut Vec<String>,
) {
    let odom = match odometry {
        OdometryFrom::Transform(frame) => Some(frame.as_str()),
        OdometryFrom::Topic(topic) => preview.odometry_frames.get(topic).map(|of| of.0.as_str()),
    };
    let given = names.odom_frame.as_deref().map(plain);
    if let Some((given, odom)) = given.zip(odom).filter(|(given, odom)| *given != plain(odom)) {
        notes.push(missing_name("odom_frame_id", given, plain(odom)));
    }
    let has = |name: &str| preview.moving_below(|frame| frame == name).is_some();
    let given = names.map_frame.as_deref().map(plain);
    if let Some(given) = given.filter(|given| has("map") && !has(given)) {
        notes.push(missing_name("global_frame_id", given, "map"));
    }
}

/// A line for the user.
fn missing_name(key: &str, name: &str, taken: &str) -> String {
    format!("{key} {name}: not in the bag, {taken} taken")
}
