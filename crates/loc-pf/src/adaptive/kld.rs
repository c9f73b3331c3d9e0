//! The number of particles from a cloud and its weights, and the draw of that many.

use super::KldSettings;
use super::bins::Bins;
use crate::resample::{Resampling, Wheel};
use crate::{Poses, Result, Workers};
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

    /// Fills `indices` with as many particles as the bins that they fall into ask for, drawn by
    /// `scheme` from the wheel of the cloud; between `min_particles` and `max_particles`, none from
    /// a cloud without any.
    ///
    /// # Panics
    /// Where the wheel has more sectors than there are poses.
    pub fn draw<R: Rng + ?Sized>(
        &mut self,
        scheme: Resampling,
        wheel: &Wheel,
        poses: Poses<'_>,
        rng: &mut R,
        indices: &mut Vec<u32>,
    ) {
        self.draw_by(&Workers::one(), scheme, wheel, poses, rng, indices);
    }

    /// The same by several threads.
    // ANCHOR: draw
    pub(crate) fn draw_by<R: Rng + ?Sized>(
        &mut self,
        workers: &Workers,
        scheme: Resampling,
        wheel: &Wheel,
        poses: Poses<'_>,
        rng: &mut R,
        indices: &mut Vec<u32>,
    ) {
        let fewest = self.settings.min_particles;
        scheme.spin_by(workers, wheel, fewest, rng, indices);
        self.bins.clear();
        if indices.is_empty() {
            return;
        }
        // The fewest are drawn in any case; if they are enough, they are the result.
        for &index in &*indices {
            self.bins.insert(poses.at(index as usize));
        }
        let mut needed = self.settings.bound(self.quantile, self.bins.len());
        if needed <= fewest {
            return;
        }
        let mut place = rng.next_u64();
        let mut drawn = fewest;
        while drawn < needed && needed < self.settings.max_particles {
            // The upper 53 bits as a share of the wheel.
            let share = (place >> 11) as f64 / (1_u64 << 53) as f64;
            if self.bins.insert(poses.at(wheel.index_at(share))) {
                needed = self.settings.bound(self.quantile, self.bins.len());
            }
            drawn += 1;
            place = place.wrapping_add(GOLDEN);
        }
        scheme.spin_by(workers, wheel, needed, rng, indices);
    }
    // ANCHOR_END: draw

    /// In how many bins the particles of the last [`draw`](Kld::draw) were found: all bins of the belief,
    /// up to those that ask for `max_particles`.
    pub fn bins(&self) -> usize {
        self.bins.len()
    }
}
