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
mod modes;
mod raster;
mod settings;

pub use settings::{ClusterSettings, PoseSource};

use super::moments::{Center, FirstSums, SecondSums, weighted_moments};
use super::weights::relative_weights;
use crate::{Particles, Poses, Result};
use blocks::{Blocks, NOWHERE};
use loc_core::Gaussian;
use modes::{Cell, Modes, Valley};
use raster::Raster;

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

/// Finds clusters, and keeps its memory from one cloud to the next: 12 bytes a particle, and up to
/// 60 for each occupied cell.
#[derive(Debug)]
pub struct Clusterer {
    settings: ClusterSettings,
    raster: Raster,
    blocks: Blocks,
    modes: Modes,
    weights: Vec<f64>,
    /// For each particle its place, later its cell.
    places: Vec<u32>,
    cells: Vec<Cell>,
    /// For each cell the cluster that it belongs to.
    cluster_of: Vec<u32>,
    sums: Vec<Sums>,
}

/// What is added up for a cluster.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    particles: usize,
    first: FirstSums,
    center: Center,
    second: SecondSums,
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
            raster: Raster::new(settings.cell, settings.heading_cell),
            blocks: Blocks::default(),
            modes: Modes::default(),
            weights: Vec::new(),
            places: Vec::new(),
            cells: Vec::new(),
            cluster_of: Vec::new(),
            sums: Vec::new(),
        })
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
        relative_weights(particles, &mut self.weights);
        self.place(particles.poses());
        let particles_per_weight = self.fill_cells();
        let valley = Valley { depth: self.settings.valley, particles_per_weight };
        self.modes.find(&self.blocks, self.raster.headings, &valley, &mut self.cells);
        self.number_clusters();
        let mut clusters = self.summarize(particles.poses());
        clusters.sort_by(|a, b| {
            b.share.total_cmp(&a.share).then_with(|| b.particles.cmp(&a.particles))
        });
        clusters
    }

    /// Finds the place of every particle among the blocks.
    fn place(&mut self, poses: Poses<'_>) {
        self.blocks.clear();
        self.places.clear();
        let Clusterer { raster, blocks, weights, places, .. } = self;
        let coordinates = poses.x.iter().zip(poses.y).zip(poses.theta).zip(weights.iter());
        places.extend(coordinates.map(|(((&x, &y), &theta), &weight)| {
            let address = raster.address(x, y, theta).filter(|_| weight > 0.0);
            address.map_or(NOWHERE, |address| blocks.occupy(address))
        }));
    }

    /// Adds up the weights of every cell and turns places into cells. Returns how many particles
    /// of equal weight a unit of weight is worth, by the effective sample size.
    fn fill_cells(&mut self) -> f64 {
        let count = self.blocks.number_cells();
        self.cells.clear();
        self.cells.extend((0..count as u32).map(|parent| Cell { weight: 0.0, count: 0, parent }));
        let (mut sum, mut squares) = (0.0, 0.0);
        for (place, &weight) in self.places.iter_mut().zip(&self.weights) {
            if *place != NOWHERE {
                *place = self.blocks.cell(*place);
                let cell = &mut self.cells[*place as usize];
                cell.weight += weight;
                cell.count += 1;
                sum += weight;
                squares += weight * weight;
            }
        }
        if squares > 0.0 { sum / squares } else { 0.0 }
    }

    /// Numbers the clusters in the order of their peaks and counts their particles.
    fn number_clusters(&mut self) {
        let Clusterer { cells, cluster_of, sums, .. } = self;
        cluster_of.clear();
        cluster_of.resize(cells.len(), 0);
        sums.clear();
        for (index, cell) in cells.iter().enumerate() {
            if cell.parent as usize == index {
                cluster_of[index] = sums.len() as u32;
                sums.push(Sums::default());
            }
        }
        for (index, cell) in cells.iter().enumerate() {
            cluster_of[index] = cluster_of[cell.parent as usize];
            sums[cluster_of[index] as usize].particles += cell.count as usize;
        }
    }

    fn summarize(&mut self, poses: Poses<'_>) -> Vec<Cluster> {
        if let [Sums { particles, .. }] = self.sums[..] {
            let belief = weighted_moments(poses, &self.weights);
            return vec![Cluster { share: 1.0, belief, particles }];
        }
        self.for_each(poses, |sums, x, y, theta, weight| sums.first.add(x, y, theta, weight));
        let mut total = 0.0;
        for sums in &mut self.sums {
            sums.center = sums.first.center();
            total += sums.center.weight;
        }
        self.for_each(poses, |sums, x, y, theta, weight| {
            sums.second.add(&sums.center, x, y, theta, weight);
        });
        let summary = |sums: &Sums| Cluster {
            share: sums.center.weight / total,
            belief: sums.second.gaussian(&sums.center),
            particles: sums.particles,
        };
        self.sums.iter().map(summary).collect()
    }

    /// Hands out every particle that is in a cluster, with the sums of that cluster.
    #[inline(always)]
    fn for_each(&mut self, poses: Poses<'_>, mut work: impl FnMut(&mut Sums, f64, f64, f64, f64)) {
        let coordinates = poses.x.iter().zip(poses.y).zip(poses.theta);
        let particles = coordinates.zip(&self.weights).zip(&self.places);
        for ((((&x, &y), &theta), &weight), &cell) in particles {
            if cell != NOWHERE {
                let cluster = self.cluster_of[cell as usize];
                work(&mut self.sums[cluster as usize], x, y, theta, weight);
            }
        }
    }
}
