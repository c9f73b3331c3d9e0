//! A few of the many clouds of a run, for figures.

use crate::localizer::Cloud;
use loc_core::Stamped;

/// Clouds of one method, at most [`Snapshots::MOST`]: the first ones all, since that is when a
/// method finds the robot, the others at even distances over the rest of the run.
///
/// ```
/// use loc_core::{Pose2, Stamped};
/// use loc_sim::localizer::Cloud;
/// use loc_sim::record::Snapshots;
/// let mut snapshots = Snapshots::default();
/// for k in 0..1000 {
///     let pose = Pose2::new(f64::from(k), 0.0, 0.0);
///     let cloud = Cloud { particles: vec![(pose, 1.0)], weighed: None };
///     snapshots.offer(f64::from(k), cloud);
/// }
/// assert!(snapshots.len() <= Snapshots::MOST);
/// let stamps: Vec<f64> = snapshots.iter().map(|snapshot| snapshot.stamp).collect();
/// assert_eq!(stamps[..3], [0.0, 1.0, 2.0]);
/// assert!(stamps.last() > Some(&950.0));
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Snapshots {
    clouds: Vec<Stamped<Cloud>>,
    /// The last cloud that was offered, to tell new ones from old ones.
    last: Option<Cloud>,
    /// How many different ones were offered.
    offered: usize,
    /// Of the later ones every 2^k-th is kept.
    doublings: u32,
}

impl Snapshots {
    /// The most clouds that are kept.
    pub const MOST: usize = 64;
    /// How many of the first ones are kept whatever comes after them.
    pub const FIRST: usize = 16;

    /// Offers the cloud at a time \[s\]; one that is the same as the last one is passed over.
    pub fn offer(&mut self, stamp: f64, cloud: Cloud) {
        if self.last.as_ref() == Some(&cloud) {
            return;
        }
        let number = self.offered;
        self.offered += 1;
        if number < Self::FIRST || number.is_multiple_of(1 << self.doublings) {
            self.clouds.push(Stamped { stamp, value: cloud.clone() });
        }
        self.last = Some(cloud);
        if self.clouds.len() > Self::MOST {
            self.doublings += 1;
            self.thin();
        }
    }

    /// Leaves out every second one of the later ones.
    fn thin(&mut self) {
        let mut later = 0;
        let mut kept = 0;
        self.clouds.retain(|_| {
            kept += 1;
            if kept <= Self::FIRST {
                return true;
            }
            later += 1;
            later % 2 == 1
        });
    }

    /// How many clouds there are.
    pub fn len(&self) -> usize {
        self.clouds.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.clouds.is_empty()
    }

    /// The clouds in order of time.
    pub fn iter(&self) -> std::slice::Iter<'_, Stamped<Cloud>> {
        self.clouds.iter()
    }
}
