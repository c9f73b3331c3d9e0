//! Rating of many poses at once, by the widest vector instructions of the processor.
//!
//! The loops are plain Rust without intrinsics. `pulp` compiles them several times, for SSE2, AVX2
//! and AVX-512, and selects the version once a call. All versions add and multiply the same numbers
//! in the same order, so their results are bit-identical.

use super::View;
use super::tiles::{Codes, Tiles, place_in_rows};
use crate::grid::GridFrame;
use loc_core::Pose2;
use nalgebra::Point2;
use std::slice::IterMut;

/// Poses that are turned into views together.
const GROUP: usize = 64;

/// Blocks of beams whose places are computed before their codes are read. The places pass through
/// the first-level cache: extracting them from vector registers one by one would cost more.
const BLOCKS: usize = 32;

/// Places of that many beams.
type Places = [[u32; BLOCK]; BLOCKS];

/// A reduction of the codes at the ends of a scan's beams.
pub(super) trait Reading {
    /// Adds some beams, the first of which is number `first` of the scan.
    fn beams(&mut self, codes: &[u8], places: &[u32], first: usize);

    /// Called after all beams of a pose.
    fn finish_pose(&mut self);
}

/// A reading of a scan from many poses, given by one coordinate after the other \[m, m, rad\].
pub(super) struct Rating<'a, R> {
    pub(super) frame: &'a GridFrame,
    pub(super) codes: &'a Codes,
    pub(super) x: &'a [f64],
    pub(super) y: &'a [f64],
    pub(super) theta: &'a [f64],
    pub(super) endpoints: &'a Endpoints,
    pub(super) reading: R,
}

impl<R: Reading> Rating<'_, R> {
    /// Reads the scan from all poses in order.
    pub(super) fn run(self) {
        match self.codes {
            Codes::Tiles(tiles) => pulp::Arch::new().dispatch(InTiles { tiles, rating: self }),
            Codes::Rows(codes) => self.run_in_rows(codes),
        }
    }

    /// The plain form, in double precision.
    fn run_in_rows(mut self, codes: &[u8]) {
        for ((&x, &y), &theta) in self.x.iter().zip(self.y).zip(self.theta) {
            let pose = Pose2 { x, y, theta };
            let ends = self.endpoints.xs().iter().zip(self.endpoints.ys());
            for (beam, (&x, &y)) in ends.enumerate() {
                let end = pose.transform(&Point2::new(f64::from(x), f64::from(y)));
                // A grid has at most 2^28 cells.
                let place = place_in_rows(self.frame, &end) as u32;
                self.reading.beams(codes, &[place], beam);
            }
            self.reading.finish_pose();
        }
    }
}

/// The task as an object, as `pulp` dispatches it.
pub(super) struct InTiles<'a, R> {
    pub(super) tiles: &'a Tiles,
    pub(super) rating: Rating<'a, R>,
}

impl<R: Reading> pulp::WithSimd for InTiles<'_, R> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) {
        let InTiles { tiles, rating: Rating { frame, x, y, theta, endpoints, mut reading, .. } } =
            self;
        let mut views = [View::default(); GROUP];
        let mut places = [[0; BLOCK]; BLOCKS];
        let groups = x.chunks(GROUP).zip(y.chunks(GROUP)).zip(theta.chunks(GROUP));
        for ((x, y), theta) in groups {
            let count = x.len().min(y.len()).min(theta.len());
            for (view, ((&x, &y), &theta)) in views.iter_mut().zip(x.iter().zip(y).zip(theta)) {
                *view = View::new(frame, x, y, theta);
            }
            for view in views.iter().take(count) {
                read(tiles, *view, endpoints, &mut places, &mut reading);
            }
        }
    }
}

/// Reads the scan from one pose.
#[inline(always)]
fn read(
    tiles: &Tiles,
    view: View,
    endpoints: &Endpoints,
    places: &mut Places,
    reading: &mut impl Reading,
) {
    let (xs, ys) = endpoints.blocks();
    let mut first = 0;
    for (xs, ys) in xs.chunks(BLOCKS).zip(ys.chunks(BLOCKS)) {
        for (places, block) in places.iter_mut().zip(xs.iter().zip(ys)) {
            *places = tiles.places(view, block);
        }
        let count = (endpoints.len() - first).min(BLOCKS * BLOCK);
        reading.beams(tiles.codes(), &places.as_flattened()[..count], first);
        first += count;
    }
    reading.finish_pose();
}

/// How many beams are placed together: as many as the widest vector instructions take at once.
pub(super) const BLOCK: usize = 16;

/// Ends of beams in the frame of the sensor or the robot, x and y apart, in single precision.
#[derive(Debug, Clone, Default)]
pub struct Endpoints {
    /// Coordinates, filled up to whole blocks with NaN, which lies off every map.
    xs: Vec<f32>,
    ys: Vec<f32>,
    len: usize,
}

impl Endpoints {
    /// The ends of a scan's beams, from their angles \[rad\] and ranges \[m\]; beams whose range
    /// is not a finite number >= 0 (no return, too close, an error) are left out.
    pub fn from_scan(angles: &[f64], ranges: &[f64]) -> Self {
        let beams = angles.iter().zip(ranges);
        let valid = beams.filter(|&(_, range)| range.is_finite() && *range >= 0.0);
        valid.map(|(angle, range)| [range * angle.cos(), range * angle.sin()]).collect()
    }

    /// Number of beams.
    pub fn len(&self) -> usize {
        self.len
    }

    /// The points, in the frame of the robot \[m\].
    pub fn points(&self) -> impl Iterator<Item = Point2<f64>> {
        let pairs = self.xs().iter().zip(self.ys());
        pairs.map(|(x, y)| Point2::new(f64::from(*x), f64::from(*y)))
    }

    /// Whether there are no beams.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The x coordinates \[m\].
    pub fn xs(&self) -> &[f32] {
        self.xs.get(..self.len).unwrap_or_default()
    }

    /// The y coordinates \[m\].
    pub fn ys(&self) -> &[f32] {
        self.ys.get(..self.len).unwrap_or_default()
    }

    /// The beams for which `keep` is true, in order; beams beyond its length are left out.
    #[must_use]
    pub fn selected(&self, keep: &[bool]) -> Self {
        let beams = self.xs().iter().zip(self.ys()).zip(keep);
        beams.filter(|&(_, keep)| *keep).map(|((&x, &y), _)| (x, y)).collect()
    }

    /// The coordinates in blocks, the last one filled up.
    #[inline(always)]
    pub(super) fn blocks(&self) -> (&[[f32; BLOCK]], &[[f32; BLOCK]]) {
        (self.xs.as_chunks().0, self.ys.as_chunks().0)
    }
}

impl PartialEq for Endpoints {
    fn eq(&self, other: &Self) -> bool {
        self.xs() == other.xs() && self.ys() == other.ys()
    }
}

impl FromIterator<[f64; 2]> for Endpoints {
    /// Points (x, y) \[m\]; those that are not finite are left out.
    fn from_iter<I: IntoIterator<Item = [f64; 2]>>(points: I) -> Self {
        points.into_iter().map(|[x, y]| (x as f32, y as f32)).collect()
    }
}

impl FromIterator<(f32, f32)> for Endpoints {
    /// Points (x, y) \[m\]; those that are not finite are left out.
    fn from_iter<I: IntoIterator<Item = (f32, f32)>>(points: I) -> Self {
        let finite = points.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite());
        let (mut xs, mut ys): (Vec<f32>, Vec<f32>) = finite.unzip();
        let len = xs.len();
        xs.resize(len.next_multiple_of(BLOCK), f32::NAN);
        ys.resize(len.next_multiple_of(BLOCK), f32::NAN);
        Endpoints { xs, ys, len }
    }
}

/// How many beams are looked up in a row: their sums are independent.
const AT_ONCE: usize = 8;

/// The code at a place, which lies in the map as the coordinates that it came from are clamped.
#[inline(always)]
fn code(codes: &[u8], place: u32) -> u8 {
    codes[place as usize]
}

/// The log-likelihood of the whole scan.
pub(super) struct LogLikelihood<'a> {
    /// Logarithm of the likelihood of a scan whose codes are all 0.
    pub(super) lowest: f64,
    /// Increment per code.
    pub(super) step: f64,
    pub(super) sum: u64,
    /// One for each pose.
    pub(super) out: IterMut<'a, f64>,
}

impl Reading for LogLikelihood<'_> {
    #[inline(always)]
    fn beams(&mut self, codes: &[u8], places: &[u32], _: usize) {
        let (rows, rest) = places.as_chunks::<AT_ONCE>();
        let mut sum = 0;
        for row in rows {
            let mut of_row = 0;
            for &place in row {
                of_row += u64::from(code(codes, place));
            }
            sum += of_row;
        }
        for &place in rest {
            sum += u64::from(code(codes, place));
        }
        self.sum += sum;
    }

    #[inline(always)]
    fn finish_pose(&mut self) {
        if let Some(out) = self.out.next() {
            *out = self.lowest + self.step * self.sum as f64;
        }
        self.sum = 0;
    }
}

/// The sum of the table's values of the codes.
pub(super) struct TableSum<'a> {
    pub(super) table: &'a [f64; 256],
    /// The sum of every `AT_ONCE`-th beam.
    pub(super) sums: [f64; AT_ONCE],
    /// One for each pose.
    pub(super) out: IterMut<'a, f64>,
}

impl Reading for TableSum<'_> {
    #[inline(always)]
    fn beams(&mut self, codes: &[u8], places: &[u32], _: usize) {
        for places in places.chunks(AT_ONCE) {
            for (sum, &place) in self.sums.iter_mut().zip(places) {
                *sum += self.table[usize::from(code(codes, place))];
            }
        }
    }

    #[inline(always)]
    fn finish_pose(&mut self) {
        if let Some(out) = self.out.next() {
            *out = self.sums.iter().sum();
        }
        self.sums = [0.0; AT_ONCE];
    }
}

/// For each beam, from how many poses its code is at least `min_code`.
pub(super) struct Count<'a> {
    pub(super) min_code: u8,
    /// One for each beam.
    pub(super) counts: &'a mut [u32],
}

impl Reading for Count<'_> {
    #[inline(always)]
    fn beams(&mut self, codes: &[u8], places: &[u32], first: usize) {
        let counts = self.counts.get_mut(first..).unwrap_or_default();
        for (count, &place) in counts.iter_mut().zip(places) {
            *count += u32::from(code(codes, place) >= self.min_code);
        }
    }

    #[inline(always)]
    fn finish_pose(&mut self) {}
}
