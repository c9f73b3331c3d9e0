//! The likelihood field (C5): for every place, how likely it is that a laser beam ends there.
//!
//! Beams end on walls, up to noise: the likelihood is highest on an obstacle and falls off with
//! the distance to the nearest one. Computed once for a map, it turns the rating of a pose into
//! one lookup for each beam, which is what a particle filter does millions of times a second
//! (Thrun, Burgard and Fox, "Probabilistic Robotics", 2005, section 6.4).
//!
//! The field is stored as one byte a cell, a code that is linear in the logarithm of the
//! likelihood: codes of many beams add up as whole numbers, in any order to the same sum, and
//! become a logarithm once at the end. The cells lie in tiles of 8 x 8, one cache line each, since
//! beams of similar poses end close together in both directions; a margin of one tile catches what
//! falls off the map, so that no lookup tests whether it is inside. The memory is, a byte a
//! cell (and six more while the field is built).
//!
//! Loss by quantisation: with the default settings a step of the code is 0.0126 in the logarithm of
//! the likelihood, so a beam is off by 0.0063 at most and 0.0036 on the average (root mean
//! square), as much as 0.8 mm of distance are worth at one standard deviation.
//!
//! Sets of poses are rated together, by the widest vector instructions of the processor
//! (SSE2, AVX2 or AVX-512, chosen at run time), with the same bits on all machines:
//! [`LikelihoodField::log_likelihoods`] is what particle filters call. Positions in the grid and
//! beams are kept in single precision there, good for a millimetre on a map of 10 km. A beam of a
//! tracked pose takes 0.3 to 0.4 ns with AVX-512, 0.6 with AVX2, 1.1 with SSE2 (bench
//! `likelihood_field`; AMD Zen 5 at 2.6 GHz).
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
//! use loc_maps::likelihood_field::{Endpoints, LikelihoodField, LikelihoodFieldSettings};
//! let mut grid = OccupancyGrid::filled(GridFrame::new(100, 100, 0.05, Pose2::IDENTITY)?, 0);
//! (0..100).try_for_each(|row| grid.set(Cell::new(80, row), 100))?;
//! let field = LikelihoodField::new(&grid, &LikelihoodFieldSettings::nav2())?;
//! let scan = Endpoints::from_scan(&[-0.1, 0.0, 0.1], &[2.0, 2.0, 2.0]);
//! let right = field.log_likelihood(Pose2::new(2.0, 2.5, 0.0), &scan);
//! let wrong = field.log_likelihood(Pose2::new(1.5, 2.5, 0.0), &scan);
//! assert!(right > wrong + 3.0);
//! # Ok::<(), loc_maps::Error>(())
//! ```

mod rating;
mod settings;
#[cfg(test)]
mod tests;
mod tiles;

pub use rating::Endpoints;
pub use settings::{LikelihoodFieldSettings, Obstacles, OffMap, UnknownSpace};

use crate::Result;
use crate::grid::{GridFrame, OccupancyGrid};
use loc_core::Pose2;
use nalgebra::Point2;
use rating::{Count, LogLikelihood, Rating, Reading, TableSum};
use settings::off_map;
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};
use tiles::Codes;

/// The likelihood of a beam's end at every place of a map.
#[derive(Debug, Clone)]
pub struct LikelihoodField {
    frame: GridFrame,
    settings: LikelihoodFieldSettings,
    scale: Scale,
    codes: Codes,
}

/// The scale of the codes.
#[derive(Debug, Clone, Copy)]
struct Scale {
    /// Logarithm of the likelihood of code 0.
    lowest: f64,
    /// Increment per code.
    step: f64,
}

/// A function of a beam's likelihood, computed once for a field; see [`LikelihoodField::table`].
#[derive(Debug, Clone, PartialEq)]
pub struct LikelihoodTable([f64; 256]);

impl LikelihoodField {
    /// The field of a map.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for settings that are out of range.
    pub fn new(grid: &OccupancyGrid, settings: &LikelihoodFieldSettings) -> Result<Self> {
        settings::build(grid, settings)
    }

    /// Size, resolution and origin of the grid.
    pub fn frame(&self) -> &GridFrame {
        &self.frame
    }

    /// The settings of the field.
    pub fn settings(&self) -> &LikelihoodFieldSettings {
        &self.settings
    }

    /// Memory of the field \[bytes\].
    pub fn bytes(&self) -> usize {
        self.codes.bytes()
    }

    /// The logarithm of the likelihood that a beam ends at a point of the map \[m\].
    pub fn log_likelihood_at(&self, point: &Point2<f64>) -> f64 {
        self.scale.log_likelihood(self.codes.at(&self.frame, point))
    }

    /// The logarithm of the likelihood of beams that end at `endpoints`, seen from the pose whose
    /// frame they are given in: the sum over the beams.
    pub fn log_likelihood(&self, pose: Pose2, endpoints: &Endpoints) -> f64 {
        let mut out = [0.0];
        let Pose2 { x, y, theta } = pose;
        self.log_likelihoods([&[x], &[y], &[theta]], endpoints, &mut out);
        out[0]
    }

    /// The same for many poses (x, y, theta) \[m, m, rad\], given by one coordinate after the
    /// other, into `out`: bit-identical to [`LikelihoodField::log_likelihood`] of each of
    /// them. The shortest slice counts; what is beyond it in `out` stays as it is.
    ///
    /// Poses off the map and NaN are allowed: their beams end off the map.
    ///
    /// ```
    /// use loc_core::Pose2;
    /// use loc_maps::LikelihoodField;
    /// use loc_maps::likelihood_field::{Endpoints, LikelihoodFieldSettings};
    /// use loc_maps::worlds::{self, WorldSettings};
    /// let office = worlds::office(&WorldSettings::default())?.grid;
    /// let field = LikelihoodField::new(&office, &LikelihoodFieldSettings::nav2())?;
    /// let scan = Endpoints::from_scan(&[-0.5, 0.5], &[2.0, 3.0]);
    /// let (x, y, theta) = ([1.0, 2.0, f64::NAN], [1.0, 1.0, 1.0], [0.0, 0.1, 0.2]);
    /// let mut out = [0.0; 3];
    /// field.log_likelihoods([&x, &y, &theta], &scan, &mut out);
    /// assert_eq!(out[1], field.log_likelihood(Pose2::new(2.0, 1.0, 0.1), &scan));
    /// assert!(out[2].is_finite());
    /// # Ok::<(), loc_maps::Error>(())
    /// ```
    pub fn log_likelihoods(&self, poses: [&[f64]; 3], endpoints: &Endpoints, out: &mut [f64]) {
        let Scale { lowest, step } = self.scale;
        let lowest = endpoints.len() as f64 * lowest;
        let length = out.len();
        let reading = LogLikelihood { lowest, step, sum: 0, out: out.iter_mut() };
        self.rate(poses, length, endpoints, reading);
    }

    /// A function of the log-likelihood of a single beam, ready to be summed over beams by
    /// [`LikelihoodField::sums`].
    pub fn table(&self, function: impl Fn(f64) -> f64) -> LikelihoodTable {
        let value = |code: usize| function(self.scale.log_likelihood(code as u8));
        LikelihoodTable(std::array::from_fn(value))
    }

    /// For each of many poses the sum of a function of the beams' likelihoods, into `out`; poses
    /// as in [`LikelihoodField::log_likelihoods`].
    pub fn sums(
        &self,
        table: &LikelihoodTable,
        poses: [&[f64]; 3],
        endpoints: &Endpoints,
        out: &mut [f64],
    ) {
        let length = out.len();
        let LikelihoodTable(table) = table;
        let reading = TableSum { table, sums: Default::default(), out: out.iter_mut() };
        self.rate(poses, length, endpoints, reading);
    }

    /// For each beam, how many of the poses see it end where that is at least as likely as
    /// `distance` \[m\] from the nearest obstacle; poses as in
    /// [`LikelihoodField::log_likelihoods`].
    pub fn hits(&self, distance: f64, poses: [&[f64]; 3], endpoints: &Endpoints) -> Vec<u32> {
        let mut counts = vec![0; endpoints.len()];
        let distance = distance.min(self.settings.max_distance);
        let min_code = self.scale.code(self.settings.likelihood(distance).ln());
        let reading = Count { min_code, counts: &mut counts };
        self.rate(poses, usize::MAX, endpoints, reading);
        counts
    }

    /// Reads the scan from the poses, at most `max` of them.
    fn rate(&self, poses: [&[f64]; 3], max: usize, endpoints: &Endpoints, reading: impl Reading) {
        let count = poses.iter().fold(max, |count, slice| count.min(slice.len()));
        let [x, y, theta] = poses.map(|slice| slice.get(..count).unwrap_or_default());
        let LikelihoodField { frame, codes, .. } = self;
        Rating { frame, codes, x, y, theta, endpoints, reading }.run();
    }

    /// The codes of all cells, row by row from the bottom: whole numbers, linear in the logarithm
    /// of the likelihood (see [`LikelihoodField::log_likelihood_of`]).
    pub fn cell_codes(&self) -> Vec<u8> {
        match &self.codes {
            Codes::Tiles(tiles) => {
                self.frame.cells().map(|cell| tiles.get(cell.column, cell.row)).collect()
            }
            Codes::Rows(codes) => codes.iter().copied().take(self.frame.cell_count()).collect(),
        }
    }

    /// The code of every place off the map.
    pub fn code_off_map(&self) -> u8 {
        self.scale.code(off_map(&self.settings))
    }

    /// Increment of the logarithm of the likelihood per code.
    pub fn code_step(&self) -> f64 {
        self.scale.step
    }

    /// The logarithm of the likelihood of `beams` beams whose codes add up to `sum`.
    pub fn log_likelihood_of(&self, sum: u64, beams: usize) -> f64 {
        beams as f64 * self.scale.lowest + self.scale.step * sum as f64
    }
}

impl Scale {
    fn log_likelihood(self, code: u8) -> f64 {
        self.lowest + self.step * f64::from(code)
    }

    /// The nearest code; those beyond the scale become its end.
    fn code(self, log_likelihood: f64) -> u8 {
        ((log_likelihood - self.lowest) / self.step).round() as u8
    }
}

/// A pose in the grid's frame, in single precision, as the lookups use it.
#[derive(Debug, Clone, Copy, Default)]
struct View {
    /// Column and row \[cells\].
    u: f32,
    v: f32,
    /// Cosine and sine of the heading \[cells/m\].
    cos: f32,
    sin: f32,
}

impl View {
    /// The view from a pose of the map \[m, m, rad\].
    #[inline(always)]
    fn new(frame: &GridFrame, x: f64, y: f64, theta: f64) -> Self {
        let at = frame.to_cells(&Point2::new(x, y));
        let scale = (1.0 / frame.resolution()) as f32;
        let (sin, cos) = sin_cos(theta - frame.origin().theta);
        View { u: at.x as f32, v: at.y as f32, cos: cos * scale, sin: sin * scale }
    }

    /// The end of a beam \[m\] in the grid's frame \[cells\].
    #[inline(always)]
    fn end(self, x: f32, y: f32) -> (f32, f32) {
        let View { u, v, cos, sin } = self;
        (u + cos * x - sin * y, v + sin * x + cos * y)
    }
}

/// Added to a number below 2^51, it leaves the nearest whole number in the lowest bits.
const ROUND: f64 = 6_755_399_441_055_744.0;

/// Sine and cosine in single precision, off by 1e-7 at most, which turns a beam of 30 m by 3 um.
/// Without branches and calls, so that several angles go through it side by side; and the same on
/// every machine, which the functions of the system's library are not.
///
/// The angle \[rad\], which may have many turns (up to 1e9), is reduced to +-pi/4 in double
/// precision; polynomials of the Cephes library (S. L. Moshier) do the rest. Angles that are not
/// finite yield NaN.
#[inline(always)]
fn sin_cos(angle: f64) -> (f32, f32) {
    let quarters = angle * FRAC_2_PI + ROUND;
    let quarter = quarters.to_bits() as u32;
    let rest = (angle - (quarters - ROUND) * FRAC_PI_2) as f32;
    let square = rest * rest;
    let sin = ((-1.951_529_6e-4 * square + 8.332_161e-3) * square - 1.666_665_5e-1) * square;
    let sin = sin * rest + rest;
    let cos = (2.443_315_7e-5 * square - 1.388_731_6e-3) * square + 4.166_664_6e-2;
    let cos = cos * square * square - 0.5 * square + 1.0;
    let (sin, cos) = if quarter & 1 == 0 { (sin, cos) } else { (cos, sin) };
    // The second bit of the quarter, moved to where a number keeps its sign.
    let flip = |value: f32, bits: u32| f32::from_bits(value.to_bits() ^ ((bits & 2) << 30));
    (flip(sin, quarter), flip(cos, quarter.wrapping_add(1)))
}
