//! What a particle filter believes, few enough particles of it to be drawn.

use loc_core::Pose2;
use loc_pf::Particles;

/// Some of the particles of a filter, evenly taken.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Cloud {
    /// Poses in the map, each with its weight; those of all particles add up to 1.
    pub particles: Vec<(Pose2, f64)>,
    /// The particles as they were weighed, before the last resampling, from a method that keeps
    /// them.
    pub weighed: Option<Vec<(Pose2, f64)>>,
}

impl Cloud {
    /// The most particles that are kept.
    pub const MAX: usize = 500;

    /// Every k-th particle of a filter's cloud, at most [`Cloud::MAX`].
    pub fn of(particles: &Particles) -> Self {
        Cloud { particles: thinned(particles), weighed: None }
    }

    /// The same with the cloud before resampling.
    #[must_use]
    pub fn with_weighed(self, weighed: &Particles) -> Self {
        Cloud { weighed: Some(thinned(weighed)), ..self }
    }
}

fn thinned(particles: &Particles) -> Vec<(Pose2, f64)> {
    let step = particles.len().div_ceil(Cloud::MAX).max(1);
    particles.poses().iter().zip(particles.weights()).step_by(step).collect()
}
