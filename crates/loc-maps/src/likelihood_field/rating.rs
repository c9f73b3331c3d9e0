//! Many poses rated in one go, by the widest vector instructions that the machine has.
//!
//! The loops here are plain Rust without a word about instructions. `pulp` compiles them several
//! times, for SSE2, AVX2 and AVX-512, and asks the processor once a call which to run. They add
//! and multiply the same numbers in the same order, so all of them come to the same bits.

use super::codes::{Codes, place_in_rows};
use super::endpoints::{BLOCK, Endpoints};
use super::tiles::Tiles;
use super::view::View;
use crate::grid::GridFrame;
use loc_core::Pose2;
use nalgebra::Point2;

/// Poses that are turned into views together.
const GROUP: usize = 64;

/// Blocks of beams that are placed before their codes are read. The places pass through memory,
/// the fastest one: taking them out of vector registers one by one would cost more.
const BLOCKS: usize = 32;

/// Places of that many beams.
type Places = [[u32; BLOCK]; BLOCKS];

/// What is made of the codes at the ends of a scan's beams.
pub(super) trait Reading {
    /// Takes in some beams, the first of which is number `first` of the scan.
    fn beams(&mut self, codes: &[u8], places: &[u32], first: usize);

    /// All beams of a pose were taken in.
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

/// The task as an object, which is how the instructions are handed to it.
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
