//! The correction: the probability of each cell times the likelihood of the scan there.
//!
//! How likely a scan is in a cell is its mean over the poses of the cell: all the free map cells of
//! the square and several headings. Most cells need not be rated: by their bounds they cannot have
//! more than a given share of the result together.

use super::field::{BoundMaps, LayerBounds, PaddedCodes};
use super::settings::GridSettings;
use super::space::PoseSpace;
use super::stack::Stack;
use super::window::{Place, Window};
use crate::Result;
use loc_core::Pose2;
use loc_maps::likelihood_field::Endpoints;
use loc_maps::{LikelihoodField, OccupancyGrid};
use loc_sensors::laser::LaserScan;

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
    /// Upper bound of the probability of all cells that were passed over.
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

/// Height of a level \[nat\].
const HEIGHT: f32 = 0.25;

/// How many levels there are: 64 nat.
const COUNT: usize = 256;

/// How far below the share that may be passed over the lowest level begins \[nat\].
const BELOW: f64 = 24.0;

/// Cells counted by the logarithm of the share that they can have at most.
#[derive(Debug, Clone)]
pub(super) struct Levels {
    /// Key at which the lowest level begins.
    lowest: f32,
    /// The same as a share of the whole.
    lowest_share: f64,
    below: usize,
    counts: Vec<usize>,
}

impl Levels {
    /// Counts the keys that are above minus infinity, given the logarithm of the whole and the share
    /// of it that may be passed over, above 0.
    pub(super) fn of(keys: &[f32], log_total: f64, negligible: f64) -> Self {
        let lowest_share = (negligible.ln() - BELOW).exp();
        let lowest = (log_total + lowest_share.ln()) as f32;
        let mut levels = Levels { lowest, lowest_share, below: 0, counts: vec![0; COUNT] };
        for &key in keys.iter().filter(|key| **key > f32::NEG_INFINITY) {
            match levels.level(key) {
                Some(level) => levels.counts[level] += 1,
                None => levels.below += 1,
            }
        }
        levels
    }

    fn level(&self, key: f32) -> Option<usize> {
        let level = (key - self.lowest) / HEIGHT;
        // The highest level has no end.
        (level >= 0.0).then_some((level as usize).min(COUNT - 1))
    }

    /// Whether a key is in this level or a higher one.
    pub(super) fn is_in(&self, key: f32, level: usize) -> bool {
        key > f32::NEG_INFINITY && self.level(key).is_some_and(|of_key| of_key >= level)
    }

    /// The lowest level that is needed if all below may have the share `negligible` together, and
    /// the share that they can have at most.
    pub(super) fn needed(&self, negligible: f64) -> (usize, f64) {
        let mut passed_over = self.below as f64 * self.lowest_share;
        for (level, &count) in self.counts.iter().enumerate() {
            let upper = self.lowest_share * f64::from((level + 1) as f32 * HEIGHT).exp();
            let share = passed_over + count as f64 * upper;
            if share > negligible && count > 0 {
                return (level, passed_over);
            }
            passed_over = share;
        }
        (COUNT, passed_over)
    }

    /// The level from which on there are about so many cells, at least one if there are any.
    pub(super) fn of_about(&self, most: usize) -> usize {
        let mut above = 0;
        for (level, &count) in self.counts.iter().enumerate().rev() {
            above += count;
            if above > most {
                // A level alone may hold more.
                let alone = above == count;
                return if alone { level } else { level + 1 };
            }
        }
        0
    }
}

/// The likelihood field of a map, made ready for grids.
#[derive(Debug, Clone)]
pub(super) struct Sensor {
    pub(super) field: LikelihoodField,
    codes: PaddedCodes,
    pub(super) bounds: BoundMaps,
}

impl Sensor {
    pub(super) fn new(
        map: &OccupancyGrid,
        space: &PoseSpace,
        settings: &GridSettings,
    ) -> Result<Self> {
        // A field cannot be sharper than the map.
        let sigma_hit = settings.field.sigma_hit.max(map.resolution());
        let field = settings.field.sigma_hit(sigma_hit);
        let field = LikelihoodField::new(map, &field)?;
        let codes = PaddedCodes::new(&field, space.side());
        let bounds = BoundMaps::new(&field, space.side());
        Ok(Sensor { field, codes, bounds })
    }

    /// Logarithm of the mean likelihood of a scan over the poses of a square and a sector; `ends`
    /// are those of the sector's headings.
    pub(super) fn rate_square(
        &self,
        space: &PoseSpace,
        scan: &Scan,
        place: usize,
        ends: &[Vec<[i32; 2]>],
    ) -> f64 {
        let side = space.side();
        let corner = space.corner_of(place);
        let free: Vec<bool> = (0..side * side)
            .map(|k| space.is_free(corner[0] + k % side, corner[1] + k / side))
            .collect();
        let mut sums = vec![0; side * side * ends.len()];
        for (ends, sums) in ends.iter().zip(sums.chunks_exact_mut(side * side)) {
            self.codes.sums(corner, ends, sums);
        }
        let rated = || sums.iter().zip(free.iter().cycle()).filter(|(_, free)| **free);
        let highest = rated().map(|(sum, _)| *sum).max().unwrap_or(0);
        let relative = |sum: u32| (-scan.per_code * f64::from(highest - sum)).exp();
        let (count, total) = rated()
            .fold((0.0, 0.0), |(count, total), (sum, _)| (count + 1.0, total + relative(*sum)));
        scan.lowest + scan.per_code * f64::from(highest) + (total / count).ln()
    }

    /// Logarithm of the likelihood of a scan in each cell of a window, layer by layer.
    pub(super) fn rate_window(&self, window: &Window, scan: &Scan) -> Vec<f64> {
        let size = window.stack().size();
        let poses = || (0..size.layer()).map(|place| window.pose(0, place));
        let x: Vec<f64> = poses().map(|pose| pose.x).collect();
        let y: Vec<f64> = poses().map(|pose| pose.y).collect();
        let mut rated = vec![0.0; size.count()];
        for (layer, rated) in rated.chunks_exact_mut(size.layer()).enumerate() {
            let theta = vec![window.pose(layer, 0).theta; size.layer()];
            self.field.log_likelihoods([&x, &y, &theta], &scan.endpoints, rated);
            rated.iter_mut().for_each(|log_likelihood| *log_likelihood *= scan.exponent);
        }
        rated
    }
}

/// Maximum number of headings rated within a sector.
const MAX_TURNS: f64 = 64.0;

/// Where the beams of a scan end, and what the codes there mean.
#[derive(Debug, Clone)]
pub(super) struct Scan {
    /// In the robot's frame \[m\].
    pub(super) endpoints: Endpoints,
    /// The same \[map cells\].
    ends: Vec<[f64; 2]>,
    /// Logarithm of the likelihood of a scan whose codes are all 0.
    pub(super) lowest: f64,
    /// What one code adds to it.
    pub(super) per_code: f64,
    /// Power to which the likelihood is raised.
    pub(super) exponent: f64,
    /// Headings within a layer at which the scan is rated, from its middle \[rad\]: from one to the
    /// next, beams of the usual length end two standard deviations further on.
    pub(super) turns: Vec<f64>,
}

impl Scan {
    /// The beams that the settings let pass; `None` where there are none.
    pub(super) fn new(
        scan: &LaserScan,
        mounting: Pose2,
        field: &LikelihoodField,
        space: &PoseSpace,
        settings: &GridSettings,
    ) -> Option<Self> {
        let limited = LaserScan {
            range_min: scan.range_min.max(settings.robot.laser_min_range),
            range_max: scan.range_max.min(settings.robot.laser_max_range),
            ..scan.clone()
        };
        let beams = limited.thinned(settings.beams).into_iter();
        let points = beams.map(|beam| mounting.transform(&beam.point()));
        let endpoints: Endpoints = points.map(|end| [end.x, end.y]).collect();
        if endpoints.is_empty() {
            return None;
        }
        let resolution = field.frame().resolution();
        let pairs = endpoints.xs().iter().zip(endpoints.ys());
        let ends = pairs.map(|(x, y)| [x, y].map(|c| f64::from(*c) / resolution)).collect();
        let exponent = (settings.independent_beams / endpoints.len() as f64).min(1.0);
        let step = space.heading_step();
        let sharpness = 2.0 * settings.field.sigma_hit.max(resolution) / rms_range(&endpoints);
        let count = (step / sharpness - 1e-6).ceil().clamp(1.0, MAX_TURNS) as usize;
        let turn = |k: usize| ((k as f64 + 0.5) / count as f64 - 0.5) * step;
        Some(Scan {
            lowest: exponent * field.log_likelihood_of(0, endpoints.len()),
            per_code: exponent * field.code_step(),
            exponent,
            turns: (0..count).map(turn).collect(),
            endpoints,
            ends,
        })
    }

    /// The ends for a robot with the heading `heading` \[rad\] in the grid, in cells from the
    /// robot.
    pub(super) fn turned(&self, heading: f64) -> Vec<[f64; 2]> {
        let (sin, cos) = heading.sin_cos();
        self.ends.iter().map(|[x, y]| [cos * x - sin * y, sin * x + cos * y]).collect()
    }

    /// For each heading within a layer, the ends as whole cells from the cell in whose middle the
    /// robot stands.
    pub(super) fn within_layer(&self, heading: f64) -> Vec<Vec<[i32; 2]>> {
        let whole = |end: [f64; 2]| end.map(|c| (c + 0.5).floor() as i32);
        let turned = |turn: &f64| self.turned(heading + turn).into_iter().map(whole).collect();
        self.turns.iter().map(turned).collect()
    }

    /// How far headings within a layer are from its middle at most \[rad\].
    pub(super) fn widest_turn(&self) -> f64 {
        self.turns.iter().fold(0.0, |widest, turn| turn.abs().max(widest))
    }
}

/// Root mean square of how far beams end from the robot \[m\].
fn rms_range(ends: &Endpoints) -> f64 {
    let squared = ends.xs().iter().zip(ends.ys()).map(|(x, y)| f64::from(x * x + y * y));
    (squared.sum::<f64>() / ends.len() as f64).sqrt()
}
