//! Which topic is what.

use super::names;
use super::{Preview, RosOptions, unsuitable};
use crate::Result;
use crate::source::ros::messages::{
    Imu, LaserScan, Message, MultiEchoLaserScan, NavSatFix, Odometry, PointCloud2, PoseStamped,
    PoseWithCovarianceStamped,
};
use crate::source::ros::survey::Topic;
use loc_core::Pose2;
use std::path::Path;

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
    /// Topics that nobody has chosen from, and names that were asked for and are not there, as lines for the user.
    pub(super) not_chosen: Vec<String>,
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
    pub(super) fn choose(path: &Path, preview: &Preview, options: &RosOptions) -> Result<Self> {
        let chooser = Chooser { path, topics: &preview.survey.topics };
        // A cloud is made a scan of only where there is no laser, or where it is named.
        let lasers = chooser.of(&SCANS[..2]).next().is_some() && options.scan_topic.is_none();
        let kinds = if lasers { &SCANS[..2] } else { &SCANS };
        let names = &options.names;
        let mut notes = Vec::new();
        let asked = names.scan_topic.as_deref().filter(|_| options.scan_topic.is_none());
        let found = asked.and_then(|name| chooser.named(name, &SCANS));
        let named = options.scan_topic.clone().or(found);
        let scans = chooser.choose("--scan-topic", &named, kinds, "scans")?;
        let scans = scans.ok_or_else(|| {
            chooser.missing("a topic of type LaserScan, MultiEchoLaserScan or PointCloud2")
        })?;
        if let Some(name) = asked.filter(|name| plain(name) != plain(&scans)) {
            notes.push(names::missing("scan_topic", name, &scans));
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
                let asked = names.base_frame.as_deref().map(plain);
                let child = asked.filter(|base| preview.moves(parent, base)).unwrap_or(child);
                (OdometryFrom::Transform(parent.to_owned()), child.to_owned())
            }
        };
        let (base, base_in_odometry) =
            names::base(names, preview, &odometry, plain(&base), &mut notes);
        names::check(names, preview, &odometry, &mut notes);
        let reference = reference(&chooser, preview, options)?;
        let mut roles = Roles {
            scans,
            odometry,
            base,
            base_in_odometry,
            reference,
            inertial: None,
            satellites: None,
            not_chosen: notes,
        };
        let several = &mut roles.not_chosen;
        roles.inertial = chooser.beside("--imu-topic", &options.imu_topic, Imu::NAME, several)?;
        roles.satellites =
            chooser.beside("--fix-topic", &options.fix_topic, NavSatFix::NAME, several)?;
        Ok(roles)
    }
}

/// The topic or transform with the true poses.
fn reference(
    chooser: &Chooser<'_>,
    preview: &Preview,
    options: &RosOptions,
) -> Result<ReferenceFrom> {
    let asked = options.names.map_frame.as_deref().map_or("map", plain);
    let map = preview.moving_below(|frame| frame == asked);
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

/// Names of ROS 1 may start with a slash.
pub(super) fn plain(name: &str) -> &str {
    name.trim_start_matches('/')
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

    /// The topic of a sensor that nobody has to have: the one named, where it is not `none`, or
    /// the only one. Several are left out, and a line for the user goes into `several`.
    fn beside(
        &self,
        option: &str,
        named: &Option<String>,
        kind: &str,
        several: &mut Vec<String>,
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
            several.push(format!("{topics} are left out: {option} chooses one of them"));
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
