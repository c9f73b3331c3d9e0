//! What the particles believe together.

use super::FastSlam;
use crate::Result;
use loc_core::gaussian::check_covariance;
use loc_core::{Gaussian, angle};
use loc_filters::slam::{Identities, MapLandmark};
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Refuses a belief that has lost its positivity, or its numbers.
pub(super) fn check(belief: &Gaussian<3>, step: u64) -> loc_filters::Result<()> {
    let finite = belief.mean.iter().chain(belief.covariance.iter()).all(|v| v.is_finite());
    let what = "covariance of the robot";
    match check_covariance(what, &belief.covariance) {
        Ok(()) if finite => Ok(()),
        _ => {
            let found =
                format!("{:?} at {:?}", belief.covariance.as_slice(), belief.mean.as_slice());
            Err(loc_filters::Error::LostPositivity { what, step, found })
        }
    }
}

impl FastSlam {
    /// What the filter believes about the robot's pose: mean and covariance of all particles, each
    /// with what odometry leaves open since its pose was drawn.
    ///
    /// # Errors
    /// [`loc_filters::Error::LostPositivity`] for a covariance that is none, with the step.
    pub fn pose(&self) -> Result<Gaussian<3>> {
        Ok(self.belief()?)
    }

    pub(super) fn belief(&self) -> loc_filters::Result<Gaussian<3>> {
        let about = self.particles[self.best].belief.mean;
        let off = |mean: &Vector3<f64>| {
            let mut off = mean - about;
            off.z = angle::wrap(off.z);
            off
        };
        let weighted = || self.particles.iter().zip(&self.log_weights).map(|(p, w)| (p, w.exp()));
        let shift: Vector3<f64> = weighted().map(|(p, w)| w * off(&p.belief.mean)).sum();
        let spread = |(p, w): (&super::Particle, f64)| {
            let d = off(&p.belief.mean) - shift;
            w * (p.belief.covariance + d * d.transpose())
        };
        let covariance: Matrix3<f64> = weighted().map(spread).sum();
        let mut belief = Gaussian { mean: about + shift, covariance };
        belief.mean.z = angle::wrap(belief.mean.z);
        check(&belief, self.step)?;
        Ok(belief)
    }

    /// The landmarks. With numbers, mean and covariance over the particles that have each, of
    /// landmarks that most have. Without numbers no particle's landmarks can be told by those of
    /// another: then they are those of the particle with the largest weight, and their covariances
    /// are small, as if the way that it came were the true one.
    ///
    /// # Errors
    /// [`loc_filters::Error::LostPositivity`] where the covariance of one is none.
    pub fn landmarks(&self) -> Result<Vec<MapLandmark>> {
        let mut landmarks = Vec::new();
        if self.settings.identities == Identities::Unknown {
            self.particles[self.best].map.visit(&mut |_, mark| {
                let super::mark::Mark { id, position, observations, confirmed, .. } = *mark;
                landmarks.push(MapLandmark { id, position, observations, confirmed });
            });
        } else {
            landmarks.extend(self.numbers.iter().filter_map(|(&id, &slot)| self.mixed(id, slot)));
        }
        for landmark in &landmarks {
            let what = "covariance of a landmark";
            check_covariance(what, &landmark.position.covariance).map_err(|_| {
                let found = format!("{:?}", landmark.position.covariance.as_slice());
                loc_filters::Error::LostPositivity { what, step: self.step, found }
            })?;
        }
        Ok(landmarks)
    }

    /// A numbered landmark over all particles; `None` where most have none.
    fn mixed(&self, id: u32, slot: usize) -> Option<MapLandmark> {
        let weighted = || {
            let all = self.particles.iter().zip(&self.log_weights);
            all.filter_map(|(p, w)| Some((p.map.get(slot)?, w.exp())))
        };
        let total: f64 = weighted().map(|(_, w)| w).sum();
        if total <= 0.5 {
            return None;
        }
        let mean: Vector2<f64> = weighted().map(|(mark, w)| mark.position.mean * (w / total)).sum();
        let covariance: Matrix2<f64> = weighted()
            .map(|(mark, w)| {
                let d = mark.position.mean - mean;
                (mark.position.covariance + d * d.transpose()) * (w / total)
            })
            .sum();
        let confirmed: f64 = weighted().filter(|(m, _)| m.confirmed).map(|(_, w)| w).sum();
        Some(MapLandmark {
            id,
            position: Gaussian { mean, covariance },
            observations: weighted().map(|(mark, _)| mark.observations).max()?,
            confirmed: confirmed > 0.5 * total,
        })
    }
}
