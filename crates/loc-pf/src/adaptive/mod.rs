//! How many particles the cloud needs: KLD-sampling (Fox 2003).
//!
//! A robot that has no idea where it is needs many particles, one that knows it to a few
//! centimetres needs few. KLD-sampling measures how spread the belief is by the number of bins (of
//! position and heading) that hold particles, and asks for as many particles as make the cloud, with
//! a given confidence, no further than a given error from the belief (Kullback-Leibler distance).
//!
//! Fox draws the new particles one by one until there are enough, which the spoke wheel cannot do:
//! it must know how many before it turns. [`Kld`] therefore draws the fewest first, which for a tight
//! cloud are the result. Where their bins ask for more, it looks at further particles of the old
//! cloud in proportion to their weights, in an order that covers the wheel of weights evenly at
//! every count (multiples of the golden ratio), until there are enough; then the scheme, any
//! [`Resampling`], draws that many anew.
//!
//! ```
//! use loc_core::{Pose2, gaussian::pose_belief, random::stream};
//! use loc_pf::{Kld, KldSettings, Particles, Resampling, resample::Wheel};
//! let mut rng = stream(1, "filter");
//! let belief = pose_belief(Pose2::IDENTITY, [0.02, 0.02, 0.01]);
//! let cloud = Particles::from_gaussian(&belief, 2000, &mut rng);
//! let mut kld = Kld::new(KldSettings { min_particles: 100, ..Default::default() })?;
//! let mut wheel = Wheel::new();
//! wheel.set(cloud.log_weights());
//! let mut drawn = Vec::new();
//! kld.draw(Resampling::Systematic, &wheel, cloud.poses(), &mut rng, &mut drawn);
//! assert!(drawn.len() < 300, "a cloud in a few bins needs few particles");
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod bins;
mod kld;

pub use kld::Kld;

#[cfg(doc)]
use crate::Resampling;
use crate::Result;
use loc_core::Normal;
use loc_core::error::{finite, in_range, positive};

/// Settings of KLD-sampling.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct KldSettings {
    /// Largest Kullback-Leibler distance between the cloud and the belief (`pf_err`, epsilon).
    pub error: f64,
    /// How surely it is kept.
    pub certainty: KldCertainty,
    /// Width of a bin along x and along y \[m\].
    pub bin_position: f64,
    /// Width of a bin in heading \[rad\]; narrowed a little where it does not divide the full turn.
    pub bin_heading: f64,
    /// Fewest particles.
    pub min_particles: usize,
    /// Most particles.
    pub max_particles: usize,
}

/// How surely the error of KLD-sampling is kept.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum KldCertainty {
    /// With this probability (1 - delta); what nav2_amcl's `pf_z` is meant to be.
    Confidence(f64),
    /// As the quantile of the normal distribution that belongs to the probability: 2.33 for 0.99.
    /// nav2_amcl takes its `pf_z` for that, so that its 0.99 is a confidence of 0.84.
    Quantile(f64),
}

impl Default for KldSettings {
    /// nav2_amcl's numbers, with `pf_z` read as a probability.
    fn default() -> Self {
        KldSettings {
            error: 0.05,
            certainty: KldCertainty::Confidence(0.99),
            bin_position: 0.5,
            bin_heading: 10_f64.to_radians(),
            min_particles: 500,
            max_particles: 2000,
        }
    }
}

impl KldSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] and [`loc_core::Error::Length`] naming the first that is not
    /// allowed.
    pub fn validate(&self) -> Result<()> {
        positive("error of KLD-sampling", self.error)?;
        self.quantile()?;
        positive("bin_position [m]", self.bin_position)?;
        positive("bin_heading [rad]", self.bin_heading)?;
        let (what, found) = ("min_particles", self.min_particles);
        if found == 0 {
            return Err(loc_core::Error::Length { what, expected: "at least 1", found }.into());
        }
        let (what, found) = ("max_particles", self.max_particles);
        if found < self.min_particles {
            let expected = "at least min_particles";
            return Err(loc_core::Error::Length { what, expected, found }.into());
        }
        Ok(())
    }

    /// How many particles a belief over `bins` bins needs: the quantile of chi-square with
    /// `bins - 1` degrees of freedom over twice the error, by the approximation of Wilson and
    /// Hilferty; between `min_particles` and `max_particles`.
    ///
    /// # Errors
    /// A certainty that is none.
    pub fn particles_for(&self, bins: usize) -> Result<usize> {
        Ok(self.bound(self.quantile()?, bins))
    }

    /// The same with the quantile known.
    fn bound(&self, quantile: f64, bins: usize) -> usize {
        if bins <= 1 {
            return self.min_particles;
        }
        let freedom = (bins - 1) as f64;
        let ninth = 2.0 / (9.0 * freedom);
        let root = (1.0 - ninth + ninth.sqrt() * quantile).max(0.0);
        let count = (freedom / (2.0 * self.error) * root.powi(3)).ceil();
        // The cast saturates.
        (count as usize).max(self.min_particles).min(self.max_particles)
    }

    /// The quantile of the normal distribution.
    fn quantile(&self) -> Result<f64> {
        match self.certainty {
            KldCertainty::Quantile(quantile) => Ok(finite("quantile of KLD-sampling", quantile)?),
            KldCertainty::Confidence(probability) => {
                let (what, expected) = ("confidence of KLD-sampling", "a probability in (0, 1)");
                let allowed = |p: f64| p > 0.0 && p < 1.0;
                let probability = in_range(what, expected, probability, allowed)?;
                Ok(Normal::new(0.0, 1.0)?.quantile(probability)?)
            }
        }
    }
}
