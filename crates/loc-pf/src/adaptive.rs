//! How many particles the particle set needs: KLD-sampling (Fox 2003).
//!
//! A robot that may be anywhere needs many particles, one that is localized to a few centimetres
//! needs few. KLD-sampling measures how spread the belief is by the number of bins (of position and
//! heading) that hold particles, and requires as many particles as keep the particle set, with a
//! given confidence, no further than a given error from the belief (Kullback-Leibler distance).
//!
//! Fox draws the new particles one by one until there are enough. Low-variance resampling needs
//! their number beforehand. [`Kld`] therefore draws the minimum number first, which for a compact
//! particle set is the result. Where their bins require more, it visits further particles of the
//! old set in proportion to their weights, in an order that covers the cumulative weights evenly at
//! every count (multiples of the golden ratio), until there are enough; then the scheme, any
//! [`Resampling`], draws that many anew.
//!
//! ```
//! use loc_core::{Pose2, gaussian::pose_belief, random::stream};
//! use loc_pf::{Kld, KldSettings, Particles, Resampling, resample::CumulativeWeights};
//! let mut rng = stream(1, "filter");
//! let belief = pose_belief(Pose2::IDENTITY, [0.02, 0.02, 0.01]);
//! let particles = Particles::from_gaussian(&belief, 2000, &mut rng);
//! let mut kld = Kld::new(KldSettings::default().min_particles(100))?;
//! let mut cumulative = CumulativeWeights::new();
//! cumulative.set(particles.log_weights());
//! let mut drawn = Vec::new();
//! kld.draw(Resampling::Systematic, &cumulative, particles.poses(), &mut rng, &mut drawn);
//! assert!(drawn.len() < 300, "a particles in a few bins needs few particles");
//! # Ok::<(), loc_pf::Error>(())
//! ```

use crate::elementary::ROUND;
use crate::resample::CumulativeWeights;
use crate::{Poses, Resampling, Result, Workers};
use loc_core::error::{finite, in_range};
use loc_core::{Normal, Pose2};
use rand::Rng;
use std::f64::consts::TAU;

loc_core::settings! {
    /// Settings of KLD-sampling.
    ///
    /// nav2_amcl's numbers, with `pf_z` read as a probability.
    pub struct KldSettings {
        /// Largest Kullback-Leibler distance between the particle set and the belief (`pf_err`,
        /// epsilon).
        pub error: f64 = 0.05 => positive;
        /// The confidence with which it is kept.
        pub certainty: KldCertainty = KldCertainty::Confidence(0.99) => check;
        /// Width of a bin along x and along y \[m\].
        pub bin_position: f64 = 0.5 => positive;
        /// Width of a bin in heading \[rad\]; narrowed a little where it does not divide the full
        /// turn.
        #[serde(with = "loc_core::settings::angle")]
        pub bin_heading: f64 = 10_f64.to_radians() => positive;
        /// Minimum number of particles.
        pub min_particles: usize = 500 => at_least(1);
        /// Maximum number of particles.
        pub max_particles: usize = 2000 => holds(
            "at least min_particles",
            |kld| kld.max_particles >= kld.min_particles
        );
    }
}

/// The confidence with which the error of KLD-sampling is kept.
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

impl KldSettings {
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

    fn quantile(&self) -> Result<f64> {
        Ok(self.certainty.quantile()?)
    }
}

impl KldCertainty {
    /// Checks the number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for what is no confidence and no quantile.
    pub fn check(&self) -> loc_core::Result<()> {
        self.quantile().map(|_| ())
    }

    /// The quantile of the normal distribution.
    fn quantile(&self) -> loc_core::Result<f64> {
        match *self {
            KldCertainty::Quantile(quantile) => finite("quantile of KLD-sampling", quantile),
            KldCertainty::Confidence(probability) => {
                let (what, expected) = ("confidence of KLD-sampling", "a probability in (0, 1)");
                let allowed = |p: f64| p > 0.0 && p < 1.0;
                let probability = in_range(what, expected, probability, allowed)?;
                Normal::new(0.0, 1.0)?.quantile(probability)
            }
        }
    }
}

/// The set of bins that hold particles: a table with open addressing, emptied at constant cost by a
/// new stamp.
#[derive(Debug)]
struct Bins {
    /// Bins per metre, and bins in a full turn over 2 pi.
    per_unit: [f64; 2],
    /// Bins in a full turn.
    headings: i32,
    /// Stamp and key of each slot, a power of two of them; a slot is taken if its stamp is the
    /// present one.
    slots: Vec<(u32, u64)>,
    stamp: u32,
    taken: usize,
}

impl Bins {
    /// No bins yet; `position` and `heading` are the widths of one \[m, rad\].
    fn new(position: f64, heading: f64) -> Self {
        let headings = (TAU / heading - 1e-9).ceil().max(1.0);
        Bins {
            per_unit: [1.0 / position, headings / TAU],
            headings: headings as i32,
            slots: vec![(0, 0); 256],
            stamp: 1,
            taken: 0,
        }
    }

    /// Empties the set.
    fn clear(&mut self) {
        self.taken = 0;
        self.stamp = self.stamp.wrapping_add(1);
        if self.stamp == 0 {
            self.slots.fill((0, 0));
            self.stamp = 1;
        }
    }

    /// Number of bins in the set.
    fn len(&self) -> usize {
        self.taken
    }

    /// Adds the bin of a pose; whether it was not there yet.
    fn insert(&mut self, pose: Pose2) -> bool {
        let key = self.key(pose);
        let new = put(&mut self.slots, self.stamp, key);
        self.taken += usize::from(new);
        if 2 * self.taken > self.slots.len() {
            self.grow();
        }
        new
    }

    /// Bins are centred on multiples of their widths, one of them on the heading pi. Those further
    /// apart than 2^24 bins in x or y share a key: 8000 km at 0.5 m.
    fn key(&self, pose: Pose2) -> u64 {
        let [position, heading] = self.per_unit;
        // The low bits of the sum are the nearest whole number.
        let bits = |value: f64| (value + ROUND).to_bits();
        let (column, row) = (bits(pose.x * position), bits(pose.y * position));
        let heading = bits(pose.theta * heading) as u32 as i32;
        let heading = if heading < 0 { heading + self.headings } else { heading };
        (column & 0xff_ffff) << 40 | (row & 0xff_ffff) << 16 | (heading as u64 & 0xffff)
    }

    fn grow(&mut self) {
        let mut slots = vec![(0, 0); 2 * self.slots.len()];
        for &(_, key) in self.slots.iter().filter(|(stamp, _)| *stamp == self.stamp) {
            put(&mut slots, self.stamp, key);
        }
        self.slots = slots;
    }
}

/// Puts a key into the first free slot after its own; at least one is free.
fn put(slots: &mut [(u32, u64)], stamp: u32, key: u64) -> bool {
    let mask = slots.len() - 1;
    // Fibonacci hashing: the upper half of the product depends on every bit of the key.
    let mut slot = (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize & mask;
    while slots[slot].0 == stamp {
        if slots[slot].1 == key {
            return false;
        }
        slot = (slot + 1) & mask;
    }
    slots[slot] = (stamp, key);
    true
}

/// KLD-sampling with its memory, which is kept from one resampling to the next.
#[derive(Debug)]
pub struct Kld {
    settings: KldSettings,
    quantile: f64,
    bins: Bins,
}

/// The golden ratio less 1, in units of 2^-64 of the total weight: its multiples divide it more
/// evenly, at every count, than those of any other number.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

impl Kld {
    /// KLD-sampling with the given settings.
    ///
    /// # Errors
    /// Settings out of range ([`KldSettings::check`]).
    pub fn new(settings: KldSettings) -> Result<Self> {
        settings.check()?;
        let bins = Bins::new(settings.bin_position, settings.bin_heading);
        Ok(Kld { quantile: settings.quantile()?, settings, bins })
    }

    /// The settings.
    pub fn settings(&self) -> &KldSettings {
        &self.settings
    }

    /// Fills `indices` with as many particles as the number of occupied bins requires, drawn by
    /// `scheme` from the cumulative weights of the particle set; between `min_particles` and
    /// `max_particles`, none from a particle set without any.
    ///
    /// # Panics
    /// Where the cumulative weights have more intervals than there are poses.
    pub fn draw<R: Rng + ?Sized>(
        &mut self,
        scheme: Resampling,
        cumulative: &CumulativeWeights,
        poses: Poses<'_>,
        rng: &mut R,
        indices: &mut Vec<u32>,
    ) {
        self.draw_by(&Workers::one(), scheme, cumulative, poses, rng, indices);
    }

    /// The same by several threads.
    // ANCHOR: draw
    pub(crate) fn draw_by<R: Rng + ?Sized>(
        &mut self,
        workers: &Workers,
        scheme: Resampling,
        cumulative: &CumulativeWeights,
        poses: Poses<'_>,
        rng: &mut R,
        indices: &mut Vec<u32>,
    ) {
        let min = self.settings.min_particles;
        scheme.draw_by(workers, cumulative, min, rng, indices);
        self.bins.clear();
        if indices.is_empty() {
            return;
        }
        // The min are drawn in any case; if they are enough, they are the result.
        for &index in &*indices {
            self.bins.insert(poses.at(index as usize));
        }
        let mut needed = self.settings.bound(self.quantile, self.bins.len());
        if needed <= min {
            return;
        }
        let mut position = rng.next_u64();
        let mut drawn = min;
        while drawn < needed && needed < self.settings.max_particles {
            // The upper 53 bits as a share of the total weight.
            let share = (position >> 11) as f64 / (1_u64 << 53) as f64;
            if self.bins.insert(poses.at(cumulative.index_at(share))) {
                needed = self.settings.bound(self.quantile, self.bins.len());
            }
            drawn += 1;
            position = position.wrapping_add(GOLDEN);
        }
        scheme.draw_by(workers, cumulative, needed, rng, indices);
    }
    // ANCHOR_END: draw

    /// Number of bins of the last [`draw`](Kld::draw): all bins of the belief, up to those that
    /// require `max_particles`.
    pub fn bins(&self) -> usize {
        self.bins.len()
    }
}
