//! Frames: where one was in another at any time.
//!
//! Every frame but the root has a parent, and a transform that says where it is in it; the chain
//! through the nearest common ancestor joins any two frames of a tree. Between two transforms of
//! the same edge the position is interpolated linearly and the rotation along the shortest turn
//! (slerp), as the tf2 library of ROS does.
//!
//! ```
//! use loc_core::nalgebra::Isometry3;
//! use loc_ros::messages::Stamp;
//! use loc_ros::tf::{Moving, TransformBuffer};
//! let mut frames = TransformBuffer::new(10.0);
//! frames.insert("odom", "base_link", Stamp(0), Isometry3::translation(0.0, 0.0, 0.0), Moving::Yes);
//! frames.insert("odom", "base_link", Stamp(1_000_000_000), Isometry3::translation(2.0, 0.0, 0.0), Moving::Yes);
//! frames.insert("base_link", "laser", Stamp(0), Isometry3::translation(0.1, 0.0, 0.3), Moving::No);
//! let laser = frames.lookup("odom", "laser", Stamp(250_000_000), 0.0)?;
//! assert!((laser.translation.x - 0.6).abs() < 1e-12);
//! let error = frames.lookup("map", "laser", Stamp(0), 0.0).unwrap_err();
//! assert!(error.to_string().contains("known frames: base_link, laser, odom"));
//! # Ok::<(), loc_ros::Error>(())
//! ```

use crate::messages::{Stamp, TfMessage};
use crate::{Error, Result};
use loc_core::nalgebra::Isometry3;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// Whether a frame moves in its parent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Moving {
    /// Its transform holds around its stamp (`/tf`).
    Yes,
    /// Its transform holds at all times (`/tf_static`).
    No,
}

/// Longest chain of frames; a longer one is a ring.
const MAX_CHAIN: usize = 64;

/// The transforms between frames over the last seconds.
#[derive(Debug, Clone)]
pub struct TransformBuffer {
    /// By child.
    edges: BTreeMap<String, Edge>,
    keep: f64,
}

impl TransformBuffer {
    /// A buffer that keeps the transforms of the last `keep` seconds of every frame.
    pub fn new(keep: f64) -> Self {
        TransformBuffer { edges: BTreeMap::new(), keep }
    }

    /// Adds a transform `parent_from_child`. A leading `/` of a name does not count; a frame that
    /// gets another parent forgets what was.
    pub fn insert(
        &mut self,
        parent: &str,
        child: &str,
        stamp: Stamp,
        transform: Isometry3<f64>,
        moving: Moving,
    ) {
        let (parent, child) = (plain(parent), plain(child));
        if parent == child || parent.is_empty() || child.is_empty() {
            return;
        }
        let edge = self.edges.entry(child.to_owned()).or_insert_with(|| Edge::new(parent));
        if edge.parent != parent {
            *edge = Edge::new(parent);
        }
        match moving {
            Moving::Yes => edge.push(stamp, transform, self.keep),
            Moving::No => edge.fix(transform),
        }
    }

    /// Adds all transforms of a message; the answer is how many of them were no rigid motions.
    pub fn insert_all(&mut self, message: &TfMessage, moving: Moving) -> usize {
        let mut refused = 0;
        for transform in &message.transforms {
            let header = &transform.header;
            match transform.transform.isometry() {
                Some(motion) => {
                    let child = &transform.child_frame_id;
                    self.insert(&header.frame_id, child, header.stamp, motion, moving);
                }
                None => refused += 1,
            }
        }
        refused
    }

    /// All frames by name.
    pub fn frames(&self) -> BTreeSet<&str> {
        let both = self.edges.iter().flat_map(|(child, edge)| [child.as_str(), &edge.parent]);
        both.collect()
    }

    /// The parent of a frame.
    pub fn parent(&self, child: &str) -> Option<&str> {
        self.edges.get(plain(child)).map(|edge| edge.parent.as_str())
    }

    /// Where `source` was in `target` (`target_from_source`). Up to `hold` seconds before the first
    /// and after the last transform of an edge, these count.
    ///
    /// # Errors
    /// [`Error::NoTransform`] with the frames that are known, the trees that are not joined, or
    /// the times between which there are transforms.
    pub fn lookup(
        &self,
        target: &str,
        source: &str,
        stamp: Stamp,
        hold: f64,
    ) -> Result<Isometry3<f64>> {
        let (target, source) = (plain(target), plain(source));
        let reason = |reason: String| Error::NoTransform {
            target: target.into(),
            source_frame: source.into(),
            stamp: stamp.seconds(),
            reason,
        };
        let frames = self.frames();
        if let Some(unknown) = [target, source].iter().find(|frame| !frames.contains(**frame)) {
            let known = Vec::from_iter(frames).join(", ");
            let known = if known.is_empty() { "none".to_owned() } else { known };
            return Err(reason(format!("there is no frame {unknown}; known frames: {known}")));
        }
        let of_target = self.ancestors(target).map_err(reason)?;
        let of_source = self.ancestors(source).map_err(reason)?;
        let Some(common) = of_source.iter().find(|frame| of_target.contains(frame)) else {
            let root = |chain: &[&str]| chain.last().map_or(String::new(), |r| (*r).to_owned());
            let (a, b) = (root(&of_target), root(&of_source));
            return Err(reason(format!(
                "they are in separate trees, below {a} and {b}; known frames: {}",
                Vec::from_iter(frames).join(", ")
            )));
        };
        let up = |chain: &[&str]| {
            let steps = chain.iter().take_while(|frame| *frame != common);
            let mut sum = Isometry3::identity();
            for frame in steps {
                let edge = self.edges.get(*frame).ok_or_else(|| format!("{frame} is lost"))?;
                sum = edge.at(frame, stamp, hold)? * sum;
            }
            Ok::<_, String>(sum)
        };
        let common_from_target = up(&of_target).map_err(reason)?;
        Ok(common_from_target.inverse() * up(&of_source).map_err(reason)?)
    }

    /// A frame with all above it.
    fn ancestors<'a>(&'a self, frame: &'a str) -> Result<Vec<&'a str>, String> {
        let mut chain = vec![frame];
        let mut last = frame;
        while let Some(edge) = self.edges.get(last) {
            last = &edge.parent;
            chain.push(last);
            if chain.len() > MAX_CHAIN {
                return Err(format!("the frames above {frame} form a ring"));
            }
        }
        Ok(chain)
    }
}

/// Frames of ROS 1 may start with a slash.
pub(crate) fn plain(frame: &str) -> &str {
    frame.trim_start_matches('/')
}

/// At most this many transforms are kept of a frame: 100 a second over 10 minutes.
const MAX_TRANSFORMS: usize = 60_000;

/// The transforms of one frame, in order of time.
#[derive(Debug, Clone)]
struct Edge {
    parent: String,
    fixed: Option<Isometry3<f64>>,
    moving: VecDeque<(Stamp, Isometry3<f64>)>,
}

impl Edge {
    fn new(parent: &str) -> Self {
        Edge { parent: parent.into(), fixed: None, moving: VecDeque::new() }
    }

    fn fix(&mut self, transform: Isometry3<f64>) {
        self.fixed = Some(transform);
    }

    /// Adds a transform and drops those more than `keep` seconds older than the newest.
    fn push(&mut self, stamp: Stamp, transform: Isometry3<f64>, keep: f64) {
        let later = self.moving.iter().rev().take_while(|(known, _)| *known > stamp).count();
        let place = self.moving.len() - later;
        match place.checked_sub(1).and_then(|last| self.moving.get_mut(last)) {
            Some(same) if same.0 == stamp => same.1 = transform,
            _ => self.moving.insert(place, (stamp, transform)),
        }
        while let (Some((first, _)), Some((last, _))) = (self.moving.front(), self.moving.back()) {
            if last.seconds_since(*first) <= keep && self.moving.len() <= MAX_TRANSFORMS {
                break;
            }
            self.moving.pop_front();
        }
    }

    /// The transform at a time.
    fn at(&self, frame: &str, stamp: Stamp, hold: f64) -> Result<Isometry3<f64>, String> {
        if let Some(fixed) = self.fixed {
            return Ok(fixed);
        }
        let after = self.moving.partition_point(|(known, _)| *known < stamp);
        let before = after.checked_sub(1).and_then(|before| self.moving.get(before));
        match (before, self.moving.get(after)) {
            (_, Some((at, transform))) if *at == stamp => Ok(*transform),
            (Some((from, first)), Some((to, second))) => {
                let share = stamp.seconds_since(*from) / to.seconds_since(*from);
                Ok(interpolate(first, second, share))
            }
            (Some((at, transform)), None) | (None, Some((at, transform)))
                if stamp.seconds_since(*at).abs() <= hold =>
            {
                Ok(*transform)
            }
            _ => Err(match (self.moving.front(), self.moving.back()) {
                (Some((first, _)), Some((last, _))) => format!(
                    "{frame} is known in {} from {:.3} s to {:.3} s only",
                    self.parent,
                    first.seconds(),
                    last.seconds()
                ),
                _ => format!("{frame} has no transform yet"),
            }),
        }
    }
}

fn interpolate(a: &Isometry3<f64>, b: &Isometry3<f64>, share: f64) -> Isometry3<f64> {
    // Half a turn has no shortest way; either end is as good.
    a.try_lerp_slerp(b, share, 1e-9).unwrap_or(if share < 0.5 { *a } else { *b })
}
