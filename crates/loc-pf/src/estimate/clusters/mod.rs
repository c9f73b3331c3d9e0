//! Several hypotheses with their shares: where the particles crowd.
//!
//! Particles fall into cells over (x, y, theta), and occupied cells that touch, if only at a
//! corner, hold together; headings go round, so a cluster is not cut at +-pi. The cost is linear
//! in the number of particles.
//!
//! Touching alone would join too much: a few stray particles between two rooms, and the mean of
//! the "cluster" lies in the wall. So cells hang on the highest peak that is reached by climbing,
//! and peaks are joined over the saddles between them, the highest saddle first, unless the lower
//! peak stands out: the saddle is at most a share ([`ClusterSettings::valley`]) of the peak, and
//! the difference is more than the chance of drawing particles explains (3 standard deviations of
//! counts, with the effective sample size as count). This is persistence-based clustering (Chazal,
//! Guibas, Oudot and Skraba, "Persistence-based clustering in Riemannian manifolds", 2013). A
//! threshold on the weight of cells would need another value for every size of the cloud, and
//! would cut the tails off a wide but single mode. Nothing is lost: strays between two modes go
//! with the peak above them, and the shares add up to 1.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_pf::Particles;
//! use loc_pf::estimate::{ClusterSettings, Clusterer};
//! let here = (0..30).map(|k| Pose2::new(1.0 + 0.01 * f64::from(k), 2.0, 3.1));
//! let there = (0..10).map(|k| Pose2::new(7.0, 2.0 + 0.01 * f64::from(k), 0.0));
//! let mut clusterer = Clusterer::new(ClusterSettings::default())?;
//! let clusters = clusterer.clusters(&Particles::from_poses(here.chain(there)));
//! assert_eq!(clusters.len(), 2);
//! assert!((clusters[0].share - 0.75).abs() < 1e-12 && clusters[1].particles == 10);
//! assert!((clusters[0].belief.mean.x - 1.145).abs() < 1e-9);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod blocks;
mod cells;
mod modes;
mod raster;
mod settings;
mod summary;

pub use settings::{ClusterSettings, PoseSource};

use super::moments::weighted_moments;
use crate::{Particles, Result, Workers, log_weights};
use cells::Cells;
use loc_core::Gaussian;
use modes::{Modes, Valley};
use raster::Raster;
use summary::Summary;

/// One hypothesis about the pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cluster {
    /// Share of the weight of all particles, in (0, 1].
    pub share: f64,
    /// Mean and covariance over (x, y, theta) \[m, m, rad\], as
    /// [`moments`](super::moments) of its particles.
    pub belief: Gaussian<3>,
    /// Number of its particles.
    pub particles: usize,
}

/// Finds clusters, and keeps its memory from one cloud to the next: 20 bytes a particle, and up to
/// 60 for each occupied cell.
#[derive(Debug)]
pub struct Clusterer {
    settings: ClusterSettings,
    workers: Workers,
    weights: Vec<f64>,
    cells: Cells,
    modes: Modes,
    summary: Summary,
}

impl Clusterer {
    /// A clusterer with the given settings.
    ///
    /// # Errors
    /// Those of [`ClusterSettings::validate`].
    pub fn new(settings: ClusterSettings) -> Result<Self> {
        settings.validate()?;
        Ok(Clusterer {
            settings,
            workers: Workers::one(),
            weights: Vec::new(),
            cells: Cells::new(Raster::new(settings.cell, settings.heading_cell)),
            modes: Modes::default(),
            summary: Summary::default(),
        })
    }

    /// The same with other threads; the results stay the same.
    #[must_use]
    pub fn with_workers(mut self, workers: Workers) -> Self {
        self.workers = workers;
        self
    }

    /// The settings.
    pub fn settings(&self) -> &ClusterSettings {
        &self.settings
    }

    /// The clusters of a cloud, the heaviest first; of equally heavy ones, the one with more
    /// particles, then the one further down (y) and left (x).
    ///
    /// The order of the particles changes nothing beyond the rounding of sums. Weights need not
    /// add up to 1. Particles that have no weight or are not finite belong to no cluster; a cloud
    /// without any others has none.
    pub fn clusters(&mut self, particles: &Particles) -> Vec<Cluster> {
        let Clusterer { settings, workers, weights, cells, modes, summary } = self;
        log_weights::relative(workers, particles.log_weights(), weights);
        let particles_per_weight = cells.find(workers, particles.poses(), weights);
        let valley = Valley { depth: settings.valley, particles_per_weight };
        modes.find(&cells.blocks, cells.raster.headings, &valley, &mut cells.all);
        summary.number_clusters(&cells.all);
        if let Some(count) = summary.only() {
            let belief = weighted_moments(workers, particles.poses(), weights);
            return vec![Cluster { share: 1.0, belief, particles: count }];
        }
        summary.clusters(particles.poses(), weights, cells.of_particles())
    }
}
