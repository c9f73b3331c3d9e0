//! Resampling: particles drawn in proportion to their weights (M8, M9, M11).
//!
//! After a measurement some particles are far likelier than others. Resampling draws a new particle
//! set from the old one, likely particles several times, unlikely ones never, and so puts the
//! effort where the robot may be. All schemes draw points in the [`CumulativeWeights`], which have
//! one interval for each particle, as wide as its weight. Each particle gets its share on average.
//! From multinomial (roulette) over stratified to low-variance (systematic) resampling the number
//! of copies varies less about that average; its variance is lost diversity (M11).
//!
//! ```
//! use loc_core::random::stream;
//! use loc_pf::Resampling;
//! let log_weights = [0.1_f64, 0.6, 0.3].map(f64::ln);
//! let mut drawn = Vec::new();
//! Resampling::Systematic.draw(&log_weights, 10, &mut stream(1, "filter"), &mut drawn);
//! assert_eq!(drawn, [0, 1, 1, 1, 1, 1, 1, 2, 2, 2]);
//! ```
//!
//! [`ResamplePolicy`] says when to resample (M11). Resampling costs diversity: every time, some
//! particles are lost. Without measurements that distinguish particles nothing is gained, and a
//! robot that stands still would lose its hypotheses by chance. So one resamples only every N-th
//! update, or only when the weights have become unequal; in between, the weights of the updates
//! multiply up.
//!
//! ```
//! use loc_pf::resample::{ResamplePolicy, ResampleWhen};
//! let policy = ResamplePolicy { every: 2, when: ResampleWhen::EffectiveShareBelow(0.5) };
//! assert!(policy.is_due(2, 300.0, 1000));
//! assert!(!policy.is_due(1, 300.0, 1000), "only one update since the last time");
//! assert!(!policy.is_due(2, 700.0, 1000), "the weights are still much alike");
//! ```

mod cumulative;

pub use cumulative::CumulativeWeights;

use crate::Workers;
use crate::elementary::ROUND;
use crate::workers::PART;
use loc_core::error::{in_range, non_negative};
use pulp::{Arch, Simd, WithSimd};
use rand::{Rng, RngExt};

/// How particles are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Resampling {
    /// Multinomial resampling (the lectures' roulette wheel, M8): every draw is independent and
    /// found by binary search, O(M log M).
    Roulette,
    /// Low-variance (systematic) resampling (the lectures' spoke wheel, M9): one draw shifts M
    /// evenly spaced points, O(M). Equal weights stay as they are.
    #[default]
    Systematic,
    /// One draw in each of M equal parts of the cumulative weights (Kitagawa 1996), O(M).
    Stratified,
    /// Every particle as often as the integer part of its share; multinomial for the rest (Liu and
    /// Chen 1998).
    Residual,
}

impl Resampling {
    /// All schemes.
    pub const ALL: [Resampling; 4] = [
        Resampling::Roulette,
        Resampling::Residual,
        Resampling::Stratified,
        Resampling::Systematic,
    ];

    /// Fills `indices` with `count` particles, drawn in proportion to the weights whose logarithms
    /// are given; they need not add up to 1.
    ///
    /// Weights that are all 0 count as equal; without any weights nothing is drawn. See
    /// [`CumulativeWeights`].
    pub fn draw<R: Rng + ?Sized>(
        self,
        log_weights: &[f64],
        count: usize,
        rng: &mut R,
        indices: &mut Vec<u32>,
    ) {
        let mut cumulative = CumulativeWeights::new();
        cumulative.set(log_weights);
        self.draw_from(&cumulative, count, rng, indices);
    }

    /// The same from cumulative weights, which keep their memory from one resampling to the next.
    pub fn draw_from<R: Rng + ?Sized>(
        self,
        cumulative: &CumulativeWeights,
        count: usize,
        rng: &mut R,
        indices: &mut Vec<u32>,
    ) {
        self.draw_by(&Workers::one(), cumulative, count, rng, indices);
    }

    /// The same by several threads, which only systematic resampling uses.
    pub(crate) fn draw_by<R: Rng + ?Sized>(
        self,
        workers: &Workers,
        cumulative: &CumulativeWeights,
        count: usize,
        rng: &mut R,
        indices: &mut Vec<u32>,
    ) {
        if self != Resampling::Systematic {
            indices.clear();
        }
        if cumulative.is_empty() || count == 0 {
            return indices.clear();
        }
        match self {
            Resampling::Roulette => roulette(cumulative, count, rng, indices),
            Resampling::Systematic => systematic(cumulative, count, rng, indices, workers),
            Resampling::Stratified => stratified(cumulative, count, rng, indices),
            Resampling::Residual => residual(cumulative, count, rng, indices),
        }
    }
}

/// An even draw from (0, 1) that keeps 2^-33 away from either end, further than rounding reaches.
fn open<R: Rng + ?Sized>(rng: &mut R) -> f64 {
    (f64::from(rng.random::<u32>()) + 0.5) / (1_u64 << 32) as f64
}

/// Indices written at once, whether needed or not: most particles have fewer copies, so that no
/// branch depends on their number.
const AT_ONCE: usize = 4;

/// Low-variance resampling (M9): one random shift of `count` evenly spaced points.
fn systematic<R: Rng + ?Sized>(
    cumulative: &CumulativeWeights,
    count: usize,
    rng: &mut R,
    indices: &mut Vec<u32>,
    workers: &Workers,
) {
    indices.resize(count, 0);
    let per_unit = count as f64 / cumulative.total();
    let points = EvenPoints { per_unit, offset: 0.5 - open(rng), count };
    // The points of a part of the intervals follow those of the part before.
    let (mut rest, mut first) = (&mut indices[..], 0);
    let parts = cumulative.ends().chunks(PART).enumerate().map(|(part, ends)| {
        let last = ends.last().map_or(first, |end| points.before(*end));
        let (indices, others) = std::mem::take(&mut rest).split_at_mut(last - first);
        let part = Part { points, ends, interval: (part * PART) as u32, first, indices };
        (rest, first) = (others, last);
        part
    });
    workers.for_each(parts, |part| Arch::new().dispatch(part));
}

/// Evenly spaced points: point k lies at `k + 0.5 - offset` spacings.
#[derive(Debug, Clone, Copy)]
struct EvenPoints {
    /// Spacings in a unit of the cumulative weights.
    per_unit: f64,
    offset: f64,
    count: usize,
}

// ANCHOR: systematic
impl EvenPoints {
    /// Number of points before `at`.
    #[inline(always)]
    fn before(&self, at: f64) -> usize {
        (self.passed(at) as usize).min(self.count)
    }

    #[inline(always)]
    fn passed(&self, at: f64) -> u32 {
        ((at * self.per_unit + self.offset) + ROUND).to_bits() as u32
    }
}
// ANCHOR_END: systematic

/// Some intervals and the points in them.
struct Part<'a> {
    points: EvenPoints,
    ends: &'a [f64],
    /// The number of the first interval.
    interval: u32,
    /// The number of the first point.
    first: usize,
    /// For each of the points its interval.
    indices: &'a mut [u32],
}

/// Intervals processed together.
const BLOCK: usize = 64;

impl WithSimd for Part<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        let Part { points, ends, mut interval, first, indices } = self;
        let mut written = 0;
        for ends in ends.chunks(BLOCK) {
            let mut passed = [0; BLOCK];
            passed.iter_mut().zip(ends).for_each(|(passed, end)| *passed = points.passed(*end));
            for &passed in &passed[..ends.len()] {
                let passed = (passed as usize).min(points.count) - first;
                match indices.get_mut(written..written + AT_ONCE) {
                    Some(slots) if passed <= written + AT_ONCE => slots.fill(interval),
                    _ => indices[written..passed].fill(interval),
                }
                written = passed;
                interval += 1;
            }
        }
    }
}

/// Stratified resampling: draw k is uniform in part k of `count` equal parts.
fn stratified<R: Rng + ?Sized>(
    cumulative: &CumulativeWeights,
    count: usize,
    rng: &mut R,
    indices: &mut Vec<u32>,
) {
    let part = cumulative.total() / count as f64;
    let last = cumulative.last();
    let ends = cumulative.ends();
    let mut index = 0;
    indices.extend((0..count).map(|k| {
        let at = (k as f64 + open(rng)) * part;
        while index < last && ends[index] <= at {
            index += 1;
        }
        index as u32
    }));
}

/// Multinomial resampling (M8): `count` independent draws, each found by binary search.
// ANCHOR: roulette
fn roulette<R: Rng + ?Sized>(
    cumulative: &CumulativeWeights,
    count: usize,
    rng: &mut R,
    indices: &mut Vec<u32>,
) {
    indices.extend((0..count).map(|_| cumulative.index_at(open(rng)) as u32));
}
// ANCHOR_END: roulette

/// Residual resampling: particle i comes `floor(count w_i)` times for certain; the rest is drawn in
/// proportion to the remainders.
fn residual<R: Rng + ?Sized>(
    cumulative: &CumulativeWeights,
    count: usize,
    rng: &mut R,
    indices: &mut Vec<u32>,
) {
    let per_unit = count as f64 / cumulative.total();
    let mut remainders = Vec::with_capacity(cumulative.len());
    let (mut before, mut rest) = (0.0, 0.0);
    for (index, &end) in cumulative.ends().iter().enumerate() {
        let share = (end - before) * per_unit;
        // A share that rounding left just below a whole number is that number.
        let copies = (share + 1e-9).floor();
        indices.extend(std::iter::repeat_n(index as u32, copies as usize));
        rest += (share - copies).max(0.0);
        remainders.push(rest);
        before = end;
    }
    indices.truncate(count);
    let last = cumulative.last();
    while indices.len() < count {
        let at = open(rng) * rest;
        let index = remainders.partition_point(|&end| end <= at).min(last);
        indices.push(index as u32);
    }
}

/// When to resample: at every N-th update at the earliest, and then if the weights require it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct ResamplePolicy {
    /// Minimum number of updates from one resampling to the next (`resample_interval`); 0 counts as
    /// 1.
    pub every: usize,
    /// What the weights must be like.
    pub when: ResampleWhen,
}

/// What the weights must be like for resampling.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum ResampleWhen {
    /// Anything.
    Always,
    /// Resampling is switched off.
    Never,
    /// The effective sample size is below this share of the particles, in \[0, 1\].
    EffectiveShareBelow(f64),
    /// The variance of the weights, in units of the mean weight, is above this. It is 0 for
    /// equal weights and M - 1 where one particle has them all; 1 means half of the particles
    /// effective.
    WeightVarianceAbove(f64),
}

impl Default for ResamplePolicy {
    /// At any update that leaves less than half of the particles effective.
    fn default() -> Self {
        ResamplePolicy { every: 1, when: ResampleWhen::EffectiveShareBelow(0.5) }
    }
}

impl ResamplePolicy {
    /// Checks the thresholds.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a share outside \[0, 1\] and a negative variance.
    pub fn check(&self) -> loc_core::Result<()> {
        match self.when {
            ResampleWhen::Always | ResampleWhen::Never => {}
            ResampleWhen::EffectiveShareBelow(share) => {
                let allowed = |share: f64| (0.0..=1.0).contains(&share);
                in_range("effective share of the particles", "a share in [0, 1]", share, allowed)?;
            }
            ResampleWhen::WeightVarianceAbove(variance) => {
                non_negative("variance of the weights [-]", variance)?;
            }
        }
        Ok(())
    }

    /// Whether to resample `updates` updates after the last time, with `particles` particles of
    /// the given effective sample size ([`Particles::effective_sample_size`]).
    ///
    /// [`Particles::effective_sample_size`]: crate::Particles::effective_sample_size
    pub fn is_due(&self, updates: usize, effective_sample_size: f64, particles: usize) -> bool {
        let particles = particles as f64;
        let weights_require = match self.when {
            ResampleWhen::Always => true,
            ResampleWhen::Never => false,
            ResampleWhen::EffectiveShareBelow(share) => effective_sample_size < share * particles,
            ResampleWhen::WeightVarianceAbove(variance) => {
                particles > (1.0 + variance) * effective_sample_size
            }
        };
        updates >= self.every && weights_require
    }
}
