//! The likelihood of many poses at once, in single precision.
//!
//! Particles are taken in blocks whose coordinates stay in the first-level cache; for each
//! observation a loop without branches runs over the block. No direction is computed for a
//! particle, only the angle between where the landmark is and where it was seen. With outliers the
//! factors of a few observations are multiplied up before one logarithm is taken.

use super::{LandmarkLikelihood, ObservationModel, Placed};
use crate::Poses;
use loc_core::Pose2;
use loc_sensors::landmark_camera::Observed;
use nalgebra::Point2;

/// Particles of one block: a multiple of every vector's length.
const BLOCK: usize = 64;

/// Minimum product of factors that stays a normal number, with a margin.
const SMALLEST_PRODUCT: f64 = 1e-34;

/// An observation in single precision.
#[derive(Debug, Clone, Copy)]
pub(super) struct Seen {
    kind: Kind,
    /// The landmark, from the origin \[m\].
    landmark: [f32; 2],
    /// Measured distance \[m\].
    range: f32,
    /// Measured direction in the robot's frame, as a unit vector.
    direction: [f32; 2],
    /// Sigma of the distance at the camera, and its growth per metre.
    range_sigma: f32,
    range_sigma_per_m: f32,
    /// 1 / sigma of the distance at the measured one, and of the direction.
    per_range_sigma: f32,
    per_bearing_sigma: f32,
    /// Density of a wrong observation over the largest of a right one.
    outlier: f32,
    /// Logarithm of the largest density of a right observation, times their share.
    log_peak: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    RangeBearing,
    Range,
    Bearing,
}

impl Seen {
    pub(super) fn new(placed: &Placed, origin: Point2<f64>, model: &ObservationModel) -> Self {
        let (noise, observed) = (&model.noise, placed.observation.observed);
        let way = placed.landmark - origin;
        let range = observed.range().unwrap_or(0.0);
        let (sin, cos) = (observed.bearing().unwrap_or(0.0) + model.mounting.theta).sin_cos();
        let log_peak = super::peak(Some(range), placed, model);
        let outlier = (super::wrong(placed, model) - log_peak).exp();
        Seen {
            kind: match observed {
                Observed::RangeBearing { .. } => Kind::RangeBearing,
                Observed::Range { .. } => Kind::Range,
                Observed::Bearing { .. } => Kind::Bearing,
            },
            landmark: [way.x as f32, way.y as f32],
            range: range as f32,
            direction: [cos as f32, sin as f32],
            range_sigma: noise.range_sigma as f32,
            range_sigma_per_m: noise.range_sigma_per_m as f32,
            per_range_sigma: noise.range_sigma_at(range).recip() as f32,
            per_bearing_sigma: noise.bearing_sigma.recip() as f32,
            // Rarer observations are impossible in single precision.
            outlier: if model.outlier_share > 0.0 { outlier.max(SMALLEST_PRODUCT) } else { 0.0 }
                as f32,
            log_peak,
        }
    }
}

/// Coordinates and ratings of a block of cameras.
struct Block {
    x: [f32; BLOCK],
    y: [f32; BLOCK],
    sin: [f32; BLOCK],
    cos: [f32; BLOCK],
    /// Sum of logarithms.
    score: [f32; BLOCK],
    /// Product of factors whose logarithm is still to be taken.
    product: [f32; BLOCK],
}

pub(super) fn rate(likelihood: &LandmarkLikelihood, poses: Poses<'_>, log_weights: &mut [f64]) {
    if !likelihood.is_empty() {
        // Compiled for several generations of processors; selected at run time.
        pulp::Arch::new().dispatch(Rating { likelihood, poses, log_weights });
    }
}

/// The work on particles, for one generation of processors.
struct Rating<'a> {
    likelihood: &'a LandmarkLikelihood,
    poses: Poses<'a>,
    log_weights: &'a mut [f64],
}

impl pulp::WithSimd for Rating<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _simd: S) {
        let Rating { likelihood, poses, log_weights } = self;
        let zeros = [0.0; BLOCK];
        let mut block =
            Block { x: zeros, y: zeros, sin: zeros, cos: zeros, score: zeros, product: zeros };
        let log_peak: f64 = likelihood.seen.iter().map(|seen| seen.log_peak).sum();
        let blocks = poses.x.chunks(BLOCK).zip(poses.y.chunks(BLOCK));
        let blocks = blocks.zip(poses.theta.chunks(BLOCK));
        for (((x, y), theta), weights) in blocks.zip(log_weights.chunks_mut(BLOCK)) {
            block.place([x, y, theta], likelihood.origin, &likelihood.model.mounting);
            block.rate(&likelihood.seen);
            for (weight, score) in weights.iter_mut().zip(&block.score) {
                // A pose that is not finite has no score; it is excluded.
                let score = if *score > f32::MIN { f64::from(*score) } else { f64::NEG_INFINITY };
                *weight += log_peak + score;
            }
        }
    }
}

impl Block {
    /// Loads poses of the robot, as positions of its camera from the origin. The rest of a block
    /// that is not full keeps what it has.
    #[inline(always)]
    fn place(&mut self, [x, y, theta]: [&[f64]; 3], origin: Point2<f64>, on_robot: &Pose2) {
        let (forward, left) = (on_robot.x as f32, on_robot.y as f32);
        for (to, from) in self.x.iter_mut().zip(x) {
            *to = (from - origin.x) as f32;
        }
        for (to, from) in self.y.iter_mut().zip(y) {
            *to = (from - origin.y) as f32;
        }
        for ((sin, cos), theta) in self.sin.iter_mut().zip(&mut self.cos).zip(theta) {
            (*sin, *cos) = single::sin_cos(*theta as f32);
        }
        for k in 0..BLOCK {
            self.x[k] += self.cos[k] * forward - self.sin[k] * left;
            self.y[k] += self.sin[k] * forward + self.cos[k] * left;
        }
        self.score = [0.0; BLOCK];
        self.product = [1.0; BLOCK];
    }

    /// Rates the block by all observations.
    #[inline(always)]
    fn rate(&mut self, observations: &[Seen]) {
        let mut smallest = 1.0;
        for seen in observations {
            if seen.outlier > 0.0 && smallest * f64::from(seen.outlier) < SMALLEST_PRODUCT {
                self.take_logarithms();
                smallest = 1.0;
            }
            smallest *= f64::from(seen.outlier);
            match (seen.kind, seen.range_sigma_per_m > 0.0) {
                (Kind::RangeBearing, false) => self.add::<true, true, false>(seen),
                (Kind::RangeBearing, true) => self.add::<true, true, true>(seen),
                (Kind::Range, false) => self.add::<true, false, false>(seen),
                (Kind::Range, true) => self.add::<true, false, true>(seen),
                (Kind::Bearing, _) => self.add::<false, true, false>(seen),
            }
        }
        self.take_logarithms();
    }

    #[inline(always)]
    fn take_logarithms(&mut self) {
        for (score, product) in self.score.iter_mut().zip(&mut self.product) {
            *score += single::ln(*product);
            *product = 1.0;
        }
    }

    /// Rates the block by one observation; `GROWS` where the sigma of its distance does.
    #[inline(always)]
    fn add<const RANGE: bool, const BEARING: bool, const GROWS: bool>(&mut self, seen: &Seen) {
        if seen.outlier > 0.0 {
            for k in 0..BLOCK {
                let (exponent, gain) = self.error::<RANGE, BEARING, GROWS>(k, seen);
                self.product[k] *= single::exp(exponent) * gain + seen.outlier;
            }
        } else {
            for k in 0..BLOCK {
                let (exponent, gain) = self.error::<RANGE, BEARING, GROWS>(k, seen);
                self.score[k] += if GROWS { exponent + single::ln(gain) } else { exponent };
            }
        }
    }

    /// Exponent of the normal densities at one particle, and how much larger their peak is there
    /// than at the measured distance.
    #[inline(always)]
    fn error<const RANGE: bool, const BEARING: bool, const GROWS: bool>(
        &self,
        k: usize,
        seen: &Seen,
    ) -> (f32, f32) {
        let (dx, dy) = (seen.landmark[0] - self.x[k], seen.landmark[1] - self.y[k]);
        let (mut sum, mut gain) = (0.0, 1.0);
        if RANGE {
            let expected = (dx * dx + dy * dy).sqrt();
            let mut per_sigma = seen.per_range_sigma;
            if GROWS {
                per_sigma = 1.0 / (seen.range_sigma + seen.range_sigma_per_m * expected);
                gain = per_sigma / seen.per_range_sigma;
            }
            let error = (seen.range - expected) * per_sigma;
            sum += error * error;
        }
        if BEARING {
            let (forward, left) =
                (self.cos[k] * dx + self.sin[k] * dy, self.cos[k] * dy - self.sin[k] * dx);
            let [cos, sin] = seen.direction;
            let along = cos * forward + sin * left;
            let across = cos * left - sin * forward;
            let error = single::angle(along, across) * seen.per_bearing_sigma;
            sum += error * error;
        }
        (-0.5 * sum, gain)
    }
}

/// Elementary functions in single precision, without branches and calls, so that a loop over many
/// particles becomes vector instructions.
///
/// No fused multiply-add is used: the results are the same on every processor.
mod single {
    use std::f32::consts::{FRAC_2_PI, FRAC_PI_2, LN_2, LOG2_E, PI, SQRT_2};

    /// Adding and subtracting 1.5 * 2^23 rounds to the nearest whole number, which then also stands
    /// in the lowest bits.
    const ROUND: f32 = 12_582_912.0;

    /// Sine and cosine of an angle of at most a few turns \[rad\], to 2e-7.
    #[inline(always)]
    pub(super) fn sin_cos(angle: f32) -> (f32, f32) {
        let shifted = angle * FRAC_2_PI + ROUND;
        let (quarter, turns) = (shifted.to_bits(), shifted - ROUND);
        // pi / 2 in two parts, the first of few digits, so that the product is exact.
        let r = (angle - turns * 1.570_312_5) - turns * 4.838_268e-4;
        let r2 = r * r;
        let sin = r + r * r2 * (-0.166_666_55 + r2 * (8.332_161e-3 - r2 * 1.951_529_6e-4));
        let cos = 1.0 - 0.5 * r2
            + r2 * r2 * (4.166_664_6e-2 + r2 * (-1.388_731_6e-3 + r2 * 2.443_315_7e-5));
        let odd = quarter & 1 != 0;
        let (s, c) = if odd { (cos, sin) } else { (sin, cos) };
        let signed = |value: f32, sign: u32| f32::from_bits(value.to_bits() ^ ((sign & 2) << 30));
        (signed(s, quarter), signed(c, quarter.wrapping_add(1)))
    }

    /// The unsigned angle between a direction and another whose components along and across it are
    /// given, in \[0, pi\] \[rad\], to 4e-6 and, near the direction, a relative 5e-6; 0 where both
    /// vanish.
    #[inline(always)]
    pub(super) fn angle(along: f32, across: f32) -> f32 {
        let (a, b) = (along.abs(), across.abs());
        let (small, large) = if a < b { (a, b) } else { (b, a) };
        let t = small / if large > f32::MIN_POSITIVE { large } else { f32::MIN_POSITIVE };
        let t2 = t * t;
        let upper = -0.121_239_066 + t2 * (0.057_477_307 - t2 * 0.013_480_466);
        let tail = 0.999_995_65 + t2 * (-0.332_994_6 + t2 * (0.195_635_92 + t2 * upper));
        let eighth = t * tail;
        let quarter = if a < b { FRAC_PI_2 - eighth } else { eighth };
        if along < 0.0 { PI - quarter } else { quarter }
    }

    /// Below this the exponential counts as that of it, 1.6e-38.
    const LOWEST: f32 = -87.0;

    /// The exponential of a number of at most 0, to a relative 3e-6.
    #[inline(always)]
    pub(super) fn exp(x: f32) -> f32 {
        let x = if x > LOWEST { x } else { LOWEST };
        let shifted = x * LOG2_E + ROUND;
        let (bits, twos) = (shifted.to_bits(), shifted - ROUND);
        // ln 2 in two parts, as above.
        let r = (x - twos * 0.693_359_4) + twos * 2.121_944_4e-4;
        let upper = 0.500_043_6 + r * (0.167_909_07 + r * 0.041_458_607);
        let series = 0.999_999_3 + r * (0.999_963_4 + r * upper);
        let power = f32::from_bits(bits.wrapping_sub(ROUND.to_bits()).wrapping_add(127) << 23);
        series * power
    }

    /// The natural logarithm of a positive number that is not subnormal, to 2e-7 and a relative
    /// 2e-7.
    #[inline(always)]
    pub(super) fn ln(x: f32) -> f32 {
        // The mantissa in [sqrt(1/2), sqrt(2)), by shifting where the exponent steps.
        let offset = x.to_bits().wrapping_sub((0.5 * SQRT_2).to_bits());
        let exponent = (offset as i32) >> 23;
        let mantissa = f32::from_bits(x.to_bits().wrapping_sub((exponent as u32) << 23));
        let (e, m) = (exponent as f32, mantissa - 1.0);
        let m2 = m * m;
        let upper = -0.124_201_41 + m * (0.116_769_99 + m * (-0.115_146_1 + m * 0.070_376_836));
        let middle = -0.166_680_58 + m * (0.142_493_23 + m * upper);
        let tail = 0.333_333_3 + m * (-0.249_999_94 + m * (0.200_007_15 + m * middle));
        m - 0.5 * m2 + m * m2 * tail + e * LN_2
    }
}
