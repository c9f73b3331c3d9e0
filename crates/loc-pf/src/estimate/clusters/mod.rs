//! Clusters of particles: several hypotheses with their shares.
//!
//! Particles fall into cells over (x, y, theta), and occupied cells that touch, if only at a
//! corner, hold together; headings go round, so a cluster is not cut at +-pi. The cost is linear
//! in the number of particles.
//!
//! Touching alone would join too much: a few stray particles between two rooms, and the mean of the
//! "cluster" lies in the wall. So cells are attached to the highest peak reached by hill climbing,
//! and peaks are joined over the saddles between them, the highest saddle first, unless the lower
//! peak stands out: the saddle is at most a share ([`ClusterSettings::valley`]) of the peak, and
//! the difference is more than the chance of drawing particles explains (3 standard deviations of
//! counts, with the effective sample size as count). This is persistence-based clustering (Chazal,
//! Guibas, Oudot and Skraba, "Persistence-based clustering in Riemannian manifolds", 2013). A
//! threshold on the weight of cells would need another value for every size of the particle set,
//! and would cut the tails off a wide but single mode. Every particle counts: those between two
//! modes belong to the higher one, and the shares add up to 1.
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

use super::{Center, FirstSums, SecondSums, sin_cos, weighted_moments};
use crate::{Particles, Poses, Result, Workers, log_weights};
use blocks::{Cell, Modes, NOWHERE, Valley};
use cells::{Cells, Raster};
use loc_core::Gaussian;
use pulp::{Arch, Simd, WithSimd};
use std::f64::consts::TAU;

/// One hypothesis about the pose.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cluster {
    /// Share of the weight of all particles, in (0, 1].
    pub share: f64,
    /// Mean and covariance over (x, y, theta) \[m, m, rad\], as
    /// [`moments`](crate::estimate::moments) of its particles.
    pub belief: Gaussian<3>,
    /// Number of its particles.
    pub particles: usize,
}

/// Finds clusters, and keeps its memory from one particle set to the next: 20 bytes a particle, and
/// up to 60 for each occupied cell.
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
    /// Those of [`ClusterSettings::check`].
    pub fn new(settings: ClusterSettings) -> Result<Self> {
        settings.check()?;
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

    /// The clusters of a particle set, the heaviest first; of equally heavy ones, the one with more
    /// particles, then the one further down (y) and left (x).
    ///
    /// The order of the particles changes nothing beyond the rounding of sums. Weights need not add
    /// up to 1. Particles that have no weight or are not finite belong to no cluster; a particle
    /// set without any others has none.
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

loc_core::settings! {
    /// Settings of a [`Clusterer`].
    #[derive(Copy)]
    pub struct ClusterSettings {
        /// Side of a cell over x and y \[m\]: modes less than two cells apart are one.
        pub cell: f64 = 0.5 => positive;
        /// Width of a cell over the heading \[rad\], from a 64th of a turn to a third; rounded so
        /// that a whole number of cells fills a turn.
        #[serde(with = "loc_core::settings::angle")]
        pub heading_cell: f64 = TAU / 24.0 => holds(
            "from 1/64 to 1/3 of a turn",
            |c| (TAU / 64.5..=TAU / 2.5).contains(&c.heading_cell)
        );
        /// Two peaks stay separate where the highest path between them falls to this share of the
        /// lower one, in \[0, 1\]. With 0, only gaps part clusters.
        pub valley: f64 = 0.25 => probability;
        /// What the reported pose is taken from.
        pub pose: PoseSource = PoseSource::default() => any;
    }
}

/// What a robot takes as its pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum PoseSource {
    /// Mean and covariance of the heaviest cluster, as in amcl: a pose where the robot may be.
    #[default]
    HeaviestCluster,
    /// Mean and covariance of all particles: minimum squared error, but between two rooms it lies
    /// in the wall.
    WholeCloud,
}

/// What is added up for each cluster, with memory kept from one particle set to the next.
#[derive(Debug, Default)]
struct Summary {
    /// For each cell its cluster.
    cluster_of: Vec<u32>,
    particles: Vec<u32>,
    first: Vec<FirstSums>,
    second: Vec<(Center, SecondSums)>,
    order: Vec<Rank>,
}

/// What decides on the order of clusters.
#[derive(Debug, Clone, Copy)]
struct Rank {
    weight: f64,
    particles: u32,
    cluster: u32,
}

impl Summary {
    /// Numbers the clusters in the order of their peaks and counts their particles; cells are
    /// attached to peaks directly.
    fn number_clusters(&mut self, cells: &[Cell]) {
        let Summary { cluster_of, particles, .. } = self;
        cluster_of.clear();
        cluster_of.resize(cells.len(), 0);
        particles.clear();
        for (index, cell) in cells.iter().enumerate() {
            if cell.parent as usize == index {
                cluster_of[index] = particles.len() as u32;
                particles.push(0);
            }
        }
        for (index, cell) in cells.iter().enumerate() {
            cluster_of[index] = cluster_of[cell.parent as usize];
            particles[cluster_of[index] as usize] += cell.count;
        }
    }

    /// How many particles there are in the only cluster; `None` if there are several, or none.
    fn only(&self) -> Option<usize> {
        if let [particles] = self.particles[..] { Some(particles as usize) } else { None }
    }

    /// The clusters, the heaviest first; `of_particles` are cells, and become clusters.
    fn clusters(
        &mut self,
        poses: Poses<'_>,
        weights: &[f64],
        of_particles: &mut [u32],
    ) -> Vec<Cluster> {
        self.add_up(poses, weights, of_particles);
        self.rank();
        let total: f64 = self.second.iter().map(|(center, _)| center.weight).sum();
        let cluster = |rank: &Rank| {
            let (center, second) = &self.second[rank.cluster as usize];
            let belief = second.gaussian(center);
            Cluster { share: rank.weight / total, belief, particles: rank.particles as usize }
        };
        self.order.iter().map(cluster).collect()
    }

    fn add_up(&mut self, poses: Poses<'_>, weights: &[f64], of_particles: &mut [u32]) {
        self.first.clear();
        self.first.resize(self.particles.len(), FirstSums::default());
        let parts = poses.chunks(BLOCK).zip(weights.chunks(BLOCK));
        for ((poses, weights), of_particles) in parts.zip(of_particles.chunks_mut(BLOCK)) {
            let directions = Arch::new().dispatch(Directions(poses.theta));
            for (k, place) in of_particles.iter_mut().enumerate().filter(|(_, k)| **k != NOWHERE) {
                *place = self.cluster_of[*place as usize];
                let sums = &mut self.first[*place as usize];
                sums.add(poses.x[k], poses.y[k], directions[k], weights[k]);
            }
        }
        self.second.clear();
        let centers = self.first.iter().map(|sums| (sums.center(), SecondSums::default()));
        self.second.extend(centers);
        let coordinates = poses.x.iter().zip(poses.y).zip(poses.theta).zip(weights);
        for ((((&x, &y), &theta), &weight), &cluster) in coordinates.zip(&*of_particles) {
            if cluster != NOWHERE {
                let (center, sums) = &mut self.second[cluster as usize];
                sums.add(center, x, y, theta, weight);
            }
        }
    }

    fn rank(&mut self) {
        let ranks = self.second.iter().zip(&self.particles).enumerate();
        self.order.clear();
        self.order.extend(ranks.map(|(cluster, ((center, _), &particles))| Rank {
            weight: center.weight,
            particles,
            cluster: cluster as u32,
        }));
        self.order.sort_unstable_by(|a, b| {
            let heavier = b.weight.total_cmp(&a.weight).then(b.particles.cmp(&a.particles));
            heavier.then(a.cluster.cmp(&b.cluster))
        });
    }
}

/// Particles whose directions are computed together.
const BLOCK: usize = 64;

/// Sines and cosines of some headings.
struct Directions<'a>(&'a [f64]);

impl WithSimd for Directions<'_> {
    type Output = [(f64, f64); BLOCK];

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Self::Output {
        let mut directions = [(0.0, 0.0); BLOCK];
        for (direction, &heading) in directions.iter_mut().zip(self.0) {
            *direction = sin_cos(heading);
        }
        directions
    }
}
