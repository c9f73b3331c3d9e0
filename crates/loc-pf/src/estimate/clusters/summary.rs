//! Shares, means and covariances of clusters, from the particles of each.

use super::super::heading::sin_cos;
use super::super::moments::{Center, FirstSums, SecondSums};
use super::Cluster;
use super::blocks::NOWHERE;
use super::modes::Cell;
use crate::Poses;
use pulp::{Arch, Simd, WithSimd};

/// What is added up for each cluster, with memory kept from one cloud to the next.
#[derive(Debug, Default)]
pub(super) struct Summary {
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
    /// Numbers the clusters in the order of their peaks and counts their particles; cells hang on
    /// peaks directly.
    pub(super) fn number_clusters(&mut self, cells: &[Cell]) {
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
    pub(super) fn only(&self) -> Option<usize> {
        if let [particles] = self.particles[..] { Some(particles as usize) } else { None }
    }

    /// The clusters, the heaviest first; `of_particles` are cells, and become clusters.
    pub(super) fn clusters(
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

/// Particles whose directions are worked out together.
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
