//! The scan turned to every heading of the search, in whole cells.

use super::sums::Ends;
use loc_maps::grid::GridFrame;
use loc_maps::likelihood_field::Endpoints;
use std::f64::consts::TAU;

/// The ends of all beams at all headings, in cells from the robot's.
#[derive(Debug)]
pub(super) struct Turned {
    beams: usize,
    headings: usize,
    xs: Vec<i32>,
    ys: Vec<i32>,
}

/// No beam reaches farther \[cells\]; added to a cell of a map, it fits into 32 bits.
const FARTHEST: f64 = (1 << 29) as f64;

/// Heading `index` of `count` in the map \[rad\], in (-pi, pi].
pub(super) fn heading(index: u32, count: usize) -> f64 {
    loc_core::angle::wrap(f64::from(index) * TAU / count as f64)
}

impl Turned {
    pub(super) fn new(endpoints: &Endpoints, frame: &GridFrame, headings: usize) -> Self {
        let beams = endpoints.len();
        let [mut xs, mut ys] = [(); 2].map(|()| Vec::with_capacity(beams * headings));
        // The robot stands in the middle of its cell.
        let cell = |length: f64| (length / frame.resolution() + 0.5).floor();
        let cell = |length: f64| cell(length).clamp(-FARTHEST, FARTHEST) as i32;
        for index in 0..headings as u32 {
            let (sin, cos) = (heading(index, headings) - frame.origin().theta).sin_cos();
            for (&x, &y) in endpoints.xs().iter().zip(endpoints.ys()) {
                let (x, y) = (f64::from(x), f64::from(y));
                xs.push(cell(cos * x - sin * y));
                ys.push(cell(sin * x + cos * y));
            }
        }
        Turned { beams, headings, xs, ys }
    }

    pub(super) fn beams(&self) -> usize {
        self.beams
    }

    pub(super) fn headings(&self) -> usize {
        self.headings
    }

    /// The ends at one heading.
    pub(super) fn at(&self, heading: usize) -> Ends<'_> {
        let range = heading * self.beams..(heading + 1) * self.beams;
        [&self.xs, &self.ys].map(|ends| ends.get(range.clone()).unwrap_or_default())
    }
}
