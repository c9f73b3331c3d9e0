//! What a cloud says about the pose: mean, covariance, and the clusters it falls into.
//!
//! A particle filter believes in many poses at once; a robot needs one to act on. While the cloud
//! is a single heap, its mean and covariance ([`moments`]) say all. When the robot may be in any
//! of three rooms that look alike, the mean of all particles lies in none of them: then the
//! clusters ([`Clusterer`]) are the hypotheses, each with its share, and the heaviest is reported.
//!
//! ```
//! use loc_core::{Pose2, gaussian::pose_belief, random::stream};
//! use loc_pf::Particles;
//! use loc_pf::estimate::{ClusterSettings, Clusterer};
//! let belief = pose_belief(Pose2::new(4.0, 2.0, 3.1), [0.1, 0.1, 0.05]);
//! let cloud = Particles::from_gaussian(&belief, 1000, &mut stream(1, "cloud"));
//! let estimate = Clusterer::new(ClusterSettings::default())?.estimate(&cloud);
//! assert_eq!(estimate.clusters.len(), 1);
//! assert!(estimate.belief.pose().distance(Pose2::new(4.0, 2.0, 3.1)) < 0.02);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod clusters;
mod heading;
mod lanes;
mod moments;

pub use clusters::{Cluster, ClusterSettings, Clusterer, PoseSource};
pub use moments::moments;

use crate::Particles;
use loc_core::Gaussian;

/// What a cloud says about the pose.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// The pose to act on, over (x, y, theta) \[m, m, rad\]: mean and covariance of the heaviest
    /// cluster, or of the whole cloud where [`ClusterSettings::pose`] says so.
    pub belief: Gaussian<3>,
    /// All clusters, the heaviest first; none for a cloud without particles.
    pub clusters: Vec<Cluster>,
}

impl Estimate {
    /// Share of the heaviest cluster; 0 for a cloud without particles.
    pub fn share(&self) -> f64 {
        self.clusters.first().map_or(0.0, |cluster| cluster.share)
    }
}

impl Clusterer {
    /// Clusters a cloud and takes the pose from it.
    pub fn estimate(&mut self, particles: &Particles) -> Estimate {
        let clusters = self.clusters(particles);
        let heaviest = clusters.first().map(|cluster| cluster.belief);
        let belief = match self.settings().pose {
            PoseSource::HeaviestCluster => heaviest,
            PoseSource::WholeCloud => None,
        };
        Estimate { belief: belief.unwrap_or_else(|| moments(particles)), clusters }
    }
}
