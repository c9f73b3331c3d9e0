//! The correction: each cell's probability times how likely the scan is there.
//!
//! How likely a scan is in a cell is its mean over the poses of the cell: all the free map cells of
//! the square and several headings. Most cells need not be asked. Their bound already says that
//! together they cannot have more than a given share of the result.

use super::bounds::LayerBounds;
use super::levels::Levels;
use super::scan::Scan;
use super::sensor::Sensor;
use super::space::PoseSpace;
use super::stack::Stack;
use super::window::{Place, Window};

/// Cells that are rated first, for an idea of how likely the scan is.
const FIRST: usize = 64;

/// So many times as many cells are rated in each further round.
const GROWTH: usize = 8;

/// What a scan makes of the belief.
#[derive(Debug)]
pub(super) struct Correction {
    /// Logarithms of the weights of the coarse cells that were rated.
    pub(super) cells: Vec<(Place, f64)>,
    /// Logarithms of the likelihood in the fine cells, layer by layer.
    pub(super) fine: Vec<f64>,
    /// Logarithm of the mean likelihood over the belief.
    pub(super) log_evidence: f64,
    /// The most that all cells together that were passed over can have of the result.
    pub(super) passed_over: f64,
}

/// What is known before the scan.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior<'a> {
    pub(super) stack: &'a Stack,
    /// The share of a robot that may be anywhere.
    pub(super) anywhere: f64,
    pub(super) window: Option<&'a Window>,
}

impl Prior<'_> {
    fn of(&self, space: &PoseSpace, (layer, place): Place) -> f64 {
        self.stack.get(layer, place) + self.anywhere * space.share(place)
    }
}

/// A sum of numbers given by their logarithms.
#[derive(Debug, Clone, Copy)]
pub(super) struct LogSum {
    largest: f64,
    sum: f64,
}

impl LogSum {
    pub(super) fn new() -> Self {
        LogSum { largest: f64::NEG_INFINITY, sum: 0.0 }
    }

    pub(super) fn add(&mut self, log: f64) {
        if log > self.largest {
            self.sum = self.sum * (self.largest - log).exp() + 1.0;
            self.largest = log;
        } else if log > f64::NEG_INFINITY {
            self.sum += (log - self.largest).exp();
        }
    }

    pub(super) fn log(&self) -> f64 {
        self.largest + self.sum.ln()
    }
}

impl Correction {
    /// Rates all cells that matter; those passed over have at most the share `negligible`.
    pub(super) fn new(
        sensor: &Sensor,
        space: &PoseSpace,
        scan: &Scan,
        prior: Prior<'_>,
        negligible: f64,
    ) -> Self {
        let fine = prior.window.map(|window| sensor.rate_window(window, scan)).unwrap_or_default();
        let mut total = LogSum::new();
        if let Some(window) = prior.window {
            let layer = window.stack().size().layer();
            for (heading, place, mass) in window.stack().cells() {
                total.add(mass.ln() + fine[heading * layer + place]);
            }
        }
        let keys = keys(sensor, space, scan, prior);
        let mut rating = Rating { sensor, space, scan, prior, keys, cells: Vec::new(), total };
        let passed_over = rating.rate(negligible);
        Correction { log_evidence: rating.total.log(), cells: rating.cells, fine, passed_over }
    }
}

/// For every cell, layer by layer, the logarithm of the highest weight that it can have.
fn keys(sensor: &Sensor, space: &PoseSpace, scan: &Scan, prior: Prior<'_>) -> Vec<f32> {
    let size = space.size();
    let anywhere: Vec<f32> =
        (0..size.layer()).map(|k| (prior.anywhere * space.share(k)).ln() as f32).collect();
    let mut keys = Vec::with_capacity(size.count());
    let mut bounds = LayerBounds::default();
    let (lowest, per_code) = (scan.lowest as f32, scan.per_code as f32);
    for layer in 0..size.headings {
        let sums = sensor.bounds.of_layer(space, scan, layer, &mut bounds);
        let first = keys.len();
        keys.extend(
            sums.iter().zip(&anywhere).map(|(&sum, log)| log + lowest + per_code * sum as f32),
        );
        let extent = prior.stack.extent(layer);
        for row in extent.rows.clone() {
            for column in extent.columns.clone() {
                let place = row * size.columns + column;
                if prior.stack.get(layer, place) > 0.0 {
                    let log = prior.of(space, (layer, place)).ln() as f32;
                    keys[first + place] = log + lowest + per_code * sums[place] as f32;
                }
            }
        }
    }
    keys
}

struct Rating<'a> {
    sensor: &'a Sensor,
    space: &'a PoseSpace,
    scan: &'a Scan,
    prior: Prior<'a>,
    keys: Vec<f32>,
    cells: Vec<(Place, f64)>,
    total: LogSum,
}

impl Rating<'_> {
    /// Rates the cells from the highest key down, until those that are left can have no more than
    /// the share `negligible` together. Returns what they can have at most.
    fn rate(&mut self, negligible: f64) -> f64 {
        if negligible <= 0.0 {
            let all = self.keys.iter().enumerate();
            let all: Vec<usize> = all.filter_map(|(k, key)| key.is_finite().then_some(k)).collect();
            self.take(&all);
            return 0.0;
        }
        let mut highest = self.highest(FIRST);
        highest.sort_unstable();
        self.take(&highest);
        let mut most = FIRST;
        loop {
            let levels = Levels::of(&self.keys, self.total.log(), negligible);
            let (needed, passed_over) = levels.needed(negligible);
            most *= GROWTH;
            // With every cell that is rated the others have less of the whole.
            let level = needed.max(levels.of_about(most));
            let above = |(index, key): (usize, &f32)| levels.is_in(*key, level).then_some(index);
            let next: Vec<usize> = self.keys.iter().enumerate().filter_map(above).collect();
            if next.is_empty() {
                return passed_over;
            }
            self.take(&next);
        }
    }

    /// The cells with the highest keys.
    fn highest(&self, count: usize) -> Vec<usize> {
        let mut best: Vec<(f32, usize)> = Vec::with_capacity(2 * count);
        let mut floor = f32::NEG_INFINITY;
        for (index, &key) in self.keys.iter().enumerate() {
            if key > floor {
                best.push((key, index));
                if best.len() == 2 * count {
                    best.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
                    best.truncate(count);
                    floor = best[count - 1].0;
                }
            }
        }
        best.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        best.truncate(count);
        best.into_iter().map(|(_, index)| index).collect()
    }

    /// Rates cells, given in ascending order, and takes their keys out.
    fn take(&mut self, indices: &[usize]) {
        let layer_length = self.space.size().layer();
        let mut ends: (usize, Vec<Vec<[i32; 2]>>) = (usize::MAX, Vec::new());
        for &index in indices {
            let (layer, place) = (index / layer_length, index % layer_length);
            if ends.0 != layer {
                ends = (layer, self.scan.within_layer(self.space.heading_in_grid(layer)));
            }
            let likelihood = self.sensor.rate_square(self.space, self.scan, place, &ends.1);
            let weight = self.prior.of(self.space, (layer, place)).ln() + likelihood;
            self.total.add(weight);
            self.cells.push(((layer, place), weight));
            self.keys[index] = f32::NEG_INFINITY;
        }
    }
}
