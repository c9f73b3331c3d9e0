//! The number of particles from a cloud and its weights.

use super::KldSettings;
use super::bins::Bins;
use crate::resample::Wheel;
use crate::{Poses, Result};
use loc_core::Pose2;
use rand::Rng;

/// KLD-sampling with its memory, which is kept from one resampling to the next.
#[derive(Debug)]
pub struct Kld {
    settings: KldSettings,
    quantile: f64,
    bins: Bins,
}

/// The golden ratio less 1, in units of 2^-64 of the wheel: its multiples divide the wheel more
/// evenly, at every count, than those of any other number.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

impl Kld {
    /// KLD-sampling with the given settings.
    ///
    /// # Errors
    /// Settings out of range ([`KldSettings::validate`]).
    pub fn new(settings: KldSettings) -> Result<Self> {
        settings.validate()?;
        let bins = Bins::new(settings.bin_position, settings.bin_heading);
        Ok(Kld { quantile: settings.quantile()?, settings, bins })
    }

    /// The settings.
    pub fn settings(&self) -> &KldSettings {
        &self.settings
    }

    /// How many particles to draw from the wheel of a cloud: draws until there are as many as the
    /// bins that they fell into ask for; between `min_particles` and `max_particles`.
    ///
    /// The wheel must be that of these particles; of more or fewer, those that both have count.
    pub fn count<R: Rng + ?Sized>(
        &mut self,
        wheel: &Wheel,
        poses: Poses<'_>,
        rng: &mut R,
    ) -> usize {
        self.bins.clear();
        let mut needed = self.settings.min_particles;
        let mut place = rng.next_u64();
        let (mut drawn, mut last) = (0, usize::MAX);
        let particles = wheel.len().min(poses.len());
        while particles > 0 && drawn < needed && needed < self.settings.max_particles {
            // The upper 53 bits as a share of the wheel.
            let share = (place >> 11) as f64 / (1_u64 << 53) as f64;
            let index = wheel.index_at(share).min(particles - 1);
            let [x, y, theta] = [poses.x[index], poses.y[index], poses.theta[index]];
            if index != last && self.bins.insert(Pose2 { x, y, theta }) {
                needed = self.settings.bound(self.quantile, self.bins.len());
            }
            last = index;
            drawn += 1;
            place = place.wrapping_add(GOLDEN);
        }
        needed
    }

    /// In how many bins the draws of the last [`count`](Kld::count) fell: all bins of the belief,
    /// up to those that ask for `max_particles`.
    pub fn bins(&self) -> usize {
        self.bins.len()
    }
}
