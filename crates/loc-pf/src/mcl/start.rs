//! Where the robot may be at the start.

use super::Mcl;
use crate::confidence::LostMonitor;
use crate::recovery::{AugmentedMcl, Suspicion};
use crate::{Error, Particles, Result};
use loc_core::Gaussian;
use loc_core::gaussian::check_covariance;

impl Mcl {
    /// Starts from no idea of the pose (A2). With the search of
    /// [`RecoverySettings`](super::RecoverySettings) the first scan says where the robot may be,
    /// without it particles are spread evenly over the free space.
    pub fn start_anywhere(&mut self) {
        let count = self.settings.particles.max_particles;
        let (free_space, rng) = (&self.surroundings.free_space, self.belief.filter.rng_mut());
        let cloud = Particles::from_poses((0..count).map(|_| free_space.draw(rng)));
        self.restart(cloud, None);
    }

    /// Starts from a belief about the pose (A1), with the most particles that the settings allow.
    ///
    /// # Errors
    /// [`loc_core::Error::NotACovariance`], and [`Error::OffMap`] for a mean that is not on the map
    /// (walls and unknown space are: a map may be wrong there). The cloud stays as it was then.
    pub fn start_at(&mut self, belief: &Gaussian<3>) -> Result<()> {
        let pose = belief.pose();
        check_covariance("covariance of the start pose", &belief.covariance)?;
        if !pose.is_finite() || !self.surroundings.free_space.is_on_map(pose) {
            return Err(Error::OffMap { x: pose.x, y: pose.y });
        }
        let count = self.settings.particles.max_particles;
        let cloud = Particles::from_gaussian(belief, count, self.belief.filter.rng_mut());
        self.restart(cloud, Some(*belief));
        Ok(())
    }

    fn restart(&mut self, cloud: Particles, start: Option<Gaussian<3>>) {
        let belief = &mut self.belief;
        *belief.filter.particles_mut() = cloud;
        (self.path, self.start, self.challenger) = (None, start, None);
        (belief.has_seen, belief.is_anywhere) = (false, start.is_none());
        belief.updates_since_resampling = 0;
        belief.suspicion.iter_mut().for_each(Suspicion::clear);
        belief.augmented.iter_mut().for_each(AugmentedMcl::reset);
        self.monitor = LostMonitor::new(self.settings.lost).unwrap_or(self.monitor);
        self.estimate = self.clusterer.estimate(belief.filter.particles());
    }
}
