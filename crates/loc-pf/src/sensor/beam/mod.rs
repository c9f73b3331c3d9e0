//! The beam model: the likelihood of the ranges of a scan, given those expected by the map (M6).
//!
//! For a pose every beam is cast in the map, and the expected range compared with the measured one.
//! A range may be the expected one with a little noise (hit), shorter because a person blocks the
//! beam (short), missing (max), or anything (random); [`BeamModel`] is the mixture of these four.
//! Beams without a return are evidence too: that there is no wall near. The likelihood field, which
//! casts no rays and is faster for it, ignores them.
//!
//! [`BeamLikelihood`] rates a scan in a map, from the mounting pose of the *laser* on the robot.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::worlds::{self, WorldSettings};
//! use loc_maps::RayCaster;
//! use loc_pf::mcl::MountedScan;
//! use loc_pf::sensor::beam::{BeamLikelihood, BeamModelSettings, informative_beams};
//! use loc_sensors::laser::LaserScan;
//! use loc_sensors::world::RangeWorld;
//! let world = worlds::office(&WorldSettings { width: 200, height: 200, ..Default::default() })?;
//! let caster = RayCaster::new(&world.grid);
//! let truth = Pose2::new(5.0, 5.0, 0.3);
//! let mut scan = LaserScan {
//!     angle_min: -1.5, angle_max: 1.45, angle_increment: 0.05,
//!     time_increment: 0.0, scan_time: 0.1, range_min: 0.1, range_max: 20.0,
//!     ranges: vec![0.0; 60], intensities: Vec::new(),
//! };
//! caster.cast_fan(&truth.position(), 0.3 - 1.5, 0.05, 20.0, &mut scan.ranges);
//! let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
//! let beams = informative_beams(&scan, 30);
//! let settings = BeamModelSettings::default();
//! let likelihood = BeamLikelihood::new(&caster, &settings, &mounted, &beams, 1.0)?;
//! let right = likelihood.log_likelihood(truth);
//! let wrong = likelihood.log_likelihood(Pose2::new(5.0, 5.0, 0.6));
//! assert!(right > wrong + 3.0);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod likelihood;

pub use likelihood::{BeamLikelihood, informative_beams};
pub(crate) use likelihood::{informative_beams_from, reading, thinned};

use crate::Result;
use loc_core::Normal;
use std::f64::consts::TAU;

loc_core::settings! {
    /// Parameters of a [`BeamModel`]; the defaults are those of nav2_amcl.
    #[derive(Copy)]
    pub struct BeamModelSettings {
        /// Mixture or plain Gaussian.
        pub form: BeamForm = BeamForm::Mixture => any;
        /// Share of the beams that measure the obstacle of the map (`z_hit`).
        pub z_hit: f64 = 0.5 => non_negative;
        /// Share of those that something stops before it, such as people (`z_short`).
        pub z_short: f64 = 0.05 => non_negative;
        /// Share of those that nothing returns (`z_max`).
        pub z_max: f64 = 0.05 => non_negative;
        /// Share of those that measure anything (`z_rand`).
        pub z_rand: f64 = 0.5 => holds(
            "shares >= 0 of which one is above 0",
            |b| b.z_rand >= 0.0 && (b.z_hit + b.z_short + b.z_max + b.z_rand) > 0.0
        );
        /// Standard deviation of what measures the obstacle \[m\] (`sigma_hit`).
        pub sigma_hit: f64 = 0.2 => positive;
        /// Rate of the exponential distribution of short ranges \[1/m\] (`lambda_short`).
        pub lambda_short: f64 = 0.1 => positive;
        /// Longest range \[m\] (`laser_max_range`); a scanner with a shorter one decides itself.
        pub max_range: f64 = 100.0 => within(0.01, 1e5);
    }
}

/// The form of the density of a range.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum BeamForm {
    /// Hit, short, max and random together.
    #[default]
    Mixture,
    /// `N(measured; expected, sigma_hit^2)` alone (M6). Where nothing returns, and where nothing is
    /// expected to, the range counts as `max_range`. A single person before the laser can exclude
    /// the true pose: for simulations and comparisons.
    Gaussian,
}

impl BeamModelSettings {
    /// The same with shares that add up to 1.
    ///
    /// # Errors
    /// Those of [`check`](Self::check).
    pub fn normalized(&self) -> Result<Self> {
        self.check()?;
        let total = self.z_hit + self.z_short + self.z_max + self.z_rand;
        Ok(BeamModelSettings {
            z_hit: self.z_hit / total,
            z_short: self.z_short / total,
            z_max: self.z_max / total,
            z_rand: self.z_rand / total,
            ..*self
        })
    }
}

/// Minimum density of a range \[1/m\], so that a share of 0 excludes no pose for good.
const MIN: f64 = 1e-12;

/// Parts of `sigma_hit` between which the logarithm is interpolated.
const STEPS_PER_SIGMA: f64 = 8.0;

/// Maximum number of steps from 0 to the longest range.
const MAX_STEPS: f64 = 16384.0;

/// Maximum distance of a hit from the expected range \[sigma_hit\].
const REACH: f64 = 8.0;

/// The beam model of a range finder (M6; Thrun, Burgard and Fox, Probabilistic Robotics, 6.3.1):
/// `p(d | d*) = z_hit p_hit + z_short p_short + z_max p_max + z_rand p_rand`.
///
/// * `p_hit` is `N(d; d*, sigma_hit^2)`, normalised on `[0, max_range]`;
/// * `p_short` is `lambda exp(-lambda d)`, normalised on `[0, d*]`;
/// * `p_max` is the probability of no return;
/// * `p_rand` is `1 / max_range`.
///
/// Where nothing is expected (`d* = +inf`), no return counts as a hit: its probability is
/// `z_hit + z_max`. The book has half a Gaussian there, which makes a correct missing return an
/// outlier. For every `d*` above 0 the densities and the probability of no return add
/// up to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BeamModel {
    settings: BeamModelSettings,
}

impl BeamModel {
    /// A model; the shares need not add up to 1.
    ///
    /// # Errors
    /// Those of [`BeamModelSettings::check`].
    pub fn new(settings: &BeamModelSettings) -> Result<Self> {
        Ok(BeamModel { settings: settings.normalized()? })
    }

    /// The parameters, with shares that add up to 1.
    pub fn settings(&self) -> &BeamModelSettings {
        &self.settings
    }

    /// The parts of `p(measured | expected)` in the order hit, short, max, random, each with its
    /// share: densities \[1/m\] for a finite `measured`, probabilities for +inf.
    // ANCHOR: parts
    pub fn parts(&self, expected: f64, measured: f64) -> [f64; 4] {
        let BeamModelSettings { z_hit, z_short, z_max, z_rand, max_range, .. } = self.settings;
        let expects = expected < max_range;
        if measured >= max_range {
            return [if expects { 0.0 } else { z_hit }, 0.0, z_max, 0.0];
        }
        let hit = if expects { z_hit * self.hit(expected, measured) } else { 0.0 };
        let expected = expected.min(max_range);
        let before = measured <= expected && expected > 0.0;
        let short = if before { z_short * self.short(expected, measured) } else { 0.0 };
        [hit, short, 0.0, z_rand / max_range]
    }
    // ANCHOR_END: parts

    fn hit(&self, expected: f64, measured: f64) -> f64 {
        let sigma = self.settings.sigma_hit;
        let deviation = (measured - expected) / sigma;
        (-0.5 * deviation * deviation).exp() / (sigma * TAU.sqrt() * self.inside(expected))
    }

    /// The share of the bell about `expected` that lies within `[0, max_range]`.
    fn inside(&self, expected: f64) -> f64 {
        let BeamModelSettings { sigma_hit, max_range, .. } = self.settings;
        let (low, high) = (-expected / sigma_hit, (max_range - expected) / sigma_hit);
        if low < -REACH && high > REACH { 1.0 } else { Normal::STANDARD.probability(low, high) }
    }

    fn short(&self, expected: f64, measured: f64) -> f64 {
        let lambda = self.settings.lambda_short;
        lambda * (-lambda * measured).exp() / -(-lambda * expected).exp_m1()
    }

    fn log_gaussian(&self, expected: f64, measured: f64) -> f64 {
        let BeamModelSettings { sigma_hit, max_range, .. } = self.settings;
        let deviation = (measured.min(max_range) - expected.min(max_range)) / sigma_hit;
        -0.5 * (deviation * deviation + TAU.ln()) - sigma_hit.ln()
    }
}

impl RangeModel for BeamModel {
    fn max_range(&self) -> f64 {
        self.settings.max_range
    }

    fn step(&self) -> f64 {
        let BeamModelSettings { sigma_hit, max_range, .. } = self.settings;
        (sigma_hit / STEPS_PER_SIGMA).clamp(max_range / MAX_STEPS, max_range / 2.0)
    }

    fn log_density(&self, expected: f64, measured: f64) -> f64 {
        match self.settings.form {
            BeamForm::Gaussian => self.log_gaussian(expected, measured),
            BeamForm::Mixture => {
                let parts: f64 = self.parts(expected, measured).iter().sum();
                parts.max(MIN).ln()
            }
        }
    }

    /// The same numbers as by single calls, without what is the same for many pairs of ranges.
    fn tabulate(&self, measured: &[f64], step: f64, tables: &mut [f32]) {
        let BeamModelSettings { z_short, z_rand, max_range, sigma_hit, lambda_short, .. } =
            self.settings;
        let mixture = self.settings.form == BeamForm::Mixture;
        let entries = tables.len().checked_div(measured.len()).unwrap_or(0);
        // What the densities of short ranges are divided by.
        let before = |k: usize| -(-lambda_short * k as f64 * step).exp_m1();
        let stopped: Vec<f64> = (0..entries).map(|k| z_short * lambda_short / before(k)).collect();
        let random = (z_rand / max_range).max(MIN);
        for (&measured, table) in measured.iter().zip(rows(tables, measured.len())) {
            let Some((finite, nothing)) = table.split_last_chunk_mut::<2>() else { return };
            nothing.fill(self.log_density(f64::INFINITY, measured) as f32);
            if mixture && measured >= max_range {
                finite.fill(self.log_density(0.0, measured) as f32);
                continue;
            }
            let decay = (-lambda_short * measured).exp();
            let far = random.ln() as f32;
            for (k, logarithm) in finite.iter_mut().enumerate() {
                // The longest range itself would be no return already.
                let expected = (k as f64 * step).min(max_range.next_down());
                let near = (expected - measured).abs() < REACH * sigma_hit;
                *logarithm = if near || !mixture {
                    self.log_density(expected, measured) as f32
                } else if expected < measured {
                    far
                } else {
                    (stopped[k] * decay + random).ln() as f32
                };
            }
        }
    }
}

/// The likelihood of a measured range given the expected one: `p(measured | expected)` (K2).
///
/// Ranges are in metres; +inf stands for no return, where nothing was in reach or nothing is
/// expected to be.
pub trait RangeModel {
    /// Ranges from here on count as no return \[m\]; finite and above 0.
    fn max_range(&self) -> f64;

    /// Distance of two expected ranges between which the logarithm may be interpolated \[m\].
    fn step(&self) -> f64;

    /// `ln p(measured | expected)`, a density \[1/m\] for a finite `measured` and a probability for
    /// +inf. Finite for every pair of ranges that are not NaN.
    fn log_density(&self, expected: f64, measured: f64) -> f64;

    /// Tables of the logarithm, one for each of the `measured` ranges and all of the same length:
    /// for the expected ranges `0, step, 2 step, ..`, and +inf in the last two entries, so that
    /// there is always a next one to interpolate to.
    ///
    /// # Panics
    /// Never: tables too short for that, or none, are left as they are.
    fn tabulate(&self, measured: &[f64], step: f64, tables: &mut [f32]) {
        for (&measured, table) in measured.iter().zip(rows(tables, measured.len())) {
            let Some((finite, nothing)) = table.split_last_chunk_mut::<2>() else { return };
            for (k, logarithm) in finite.iter_mut().enumerate() {
                // The longest range itself would be no return already.
                let expected = (k as f64 * step).min(self.max_range().next_down());
                *logarithm = self.log_density(expected, measured) as f32;
            }
            nothing.fill(self.log_density(f64::INFINITY, measured) as f32);
        }
    }
}

/// The tables of `count` beams.
fn rows(tables: &mut [f32], count: usize) -> impl Iterator<Item = &mut [f32]> {
    let entries = tables.len().checked_div(count).unwrap_or(0).max(1);
    tables.chunks_exact_mut(entries)
}
