//! The perceptual model learned from a recording (K2): what does this laser measure where this map
//! lets expect a certain range?
//!
//! The log must hold the laser's poses in the frame of the map, as a mapping program or a motion
//! capture system wrote them; raw odometry does not do. From those poses every beam is cast in the
//! map, and of the pairs of expected and measured ranges the histogram and the parameters of the
//! beam model are learned.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_maps::worlds::{self, WorldSettings};
//! use loc_sensors::laser::{LaserScanner, LaserSpec};
//! use loc_sim::perceptual::{LearnSettings, learn};
//! let world = worlds::office(&WorldSettings { width: 200, height: 200, ..Default::default() })?;
//! let (laser, mut rng) = (LaserScanner::new(LaserSpec::sick_lms100())?, stream(1, "laser"));
//! let poses = (0..10).map(|k| Pose2::new(5.0, 5.0, 0.6 * f64::from(k)));
//! let scans: Vec<_> =
//!     poses.map(|pose| (pose, laser.scan(&world.grid, pose, &mut rng))).collect();
//! let learned = learn(&scans, &world.grid, &LearnSettings::default())?;
//! assert!((learned.fit.settings.sigma_hit - 0.012).abs() < 0.002);
//! assert!(learned.within(0.1) > 0.95);
//! # Ok::<(), loc_sim::Error>(())
//! ```

use crate::Result;
use crate::demonstration::{Demonstration, check_count};
use crate::output::Illustration;
use crate::output::figures::FigureFile;
use crate::source::tour::{LaserConfig, TourWorld, WorldConfig};
use loc_core::Pose2;
use loc_core::random::{ChaCha8Rng, stream};
use loc_maps::grid::Occupancy;
use loc_maps::{OccupancyGrid, RayCaster};
use loc_pf::sensor::BeamModelSettings;
use loc_pf::sensor::beam::{BeamModel, RangeModel};
use loc_pf::sensor::perceptual::{
    FitReport, PerceptualHistogram, RangePair, fit_beam_model, range_pairs,
};
use loc_plot::color::{DENSITY, Image};
use loc_plot::{Chart, Figure, HeatMap, HeatMaps, Role, color};
use loc_sensors::laser::LaserFaults;
use loc_sensors::laser::LaserScan;
use rand::RngExt;
use serde::Deserialize;
use serde_json::json;
use std::f64::consts::TAU;

/// How to learn.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LearnSettings {
    /// Where the fit starts; its longest range holds where the scanner's is not shorter.
    pub start: BeamModelSettings,
    /// Width of the histogram's bins \[m\].
    pub bin: f64,
    /// The fit looks at no more than about this many pairs, evenly spread; the histogram at all.
    pub max_fitted: usize,
}

impl Default for LearnSettings {
    fn default() -> Self {
        LearnSettings { start: BeamModelSettings::default(), bin: 0.1, max_fitted: 200_000 }
    }
}

/// What was learned.
#[derive(Debug, Clone)]
pub struct Learned {
    /// Number of scans that were used.
    pub scans: usize,
    /// Number of scans that were left out: their pose is not in the map's free space.
    pub outside: usize,
    /// All pairs.
    pub pairs: Vec<RangePair>,
    /// The pairs, counted.
    pub histogram: PerceptualHistogram,
    /// Where the fit started.
    pub start: BeamModelSettings,
    /// The fitted beam model.
    pub fit: FitReport,
}

impl Learned {
    /// The share of the measured ranges that are at most this far from the expected ones \[m\];
    /// no return counts as right where none is expected.
    pub fn within(&self, distance: f64) -> f64 {
        let fits = |pair: &&RangePair| {
            let none = [pair.expected, pair.measured].map(f64::is_infinite);
            (pair.measured - pair.expected).abs() <= distance || none == [true; 2]
        };
        self.pairs.iter().filter(fits).count() as f64 / self.pairs.len().max(1) as f64
    }

    /// The median of measured less expected range, of those at most `distance` apart \[m\]; `None`
    /// without any. A ray ends where it enters an occupied cell, the wall lies somewhere inside, so
    /// that half a cell is usual.
    pub fn offset(&self, distance: f64) -> Option<f64> {
        let offsets = self.pairs.iter().map(|pair| pair.measured - pair.expected);
        let mut near: Vec<f64> = offsets.filter(|offset| offset.abs() <= distance).collect();
        let middle = near.len() / 2;
        if near.is_empty() {
            return None;
        }
        Some(*near.select_nth_unstable_by(middle, f64::total_cmp).1)
    }
}

/// Learns from scans taken from known poses of the laser in the map.
///
/// # Errors
/// [`loc_pf::Error`] for settings out of range, and where fewer than 100 beams taken in free space
/// end within reach where the map lets expect it.
pub fn learn(
    scans: &[(Pose2, LaserScan)],
    map: &OccupancyGrid,
    settings: &LearnSettings,
) -> Result<Learned> {
    settings.start.check()?;
    let reach = scans.iter().map(|(_, scan)| scan.range_max).fold(0.0, f64::max);
    let max_range = if reach > 0.0 { settings.start.max_range.min(reach) } else { 1.0 };
    let start = settings.start.max_range(max_range);
    let mut histogram = PerceptualHistogram::new(max_range, settings.bin)?;
    let caster = RayCaster::new(map);
    let is_free = |pose: &Pose2| map.occupancy_at(&pose.position()) == Occupancy::Free;
    let mut pairs = Vec::new();
    let mut used = 0;
    for (pose, scan) in scans.iter().filter(|(pose, _)| is_free(pose)) {
        pairs.extend(range_pairs(&caster, *pose, scan, max_range));
        used += 1;
    }
    pairs.iter().for_each(|pair| histogram.add(*pair));
    let step = pairs.len().div_ceil(settings.max_fitted.max(1)).max(1);
    // A step that does not divide the number of beams, so that all directions have their turn.
    let step = if step > 1 { step | 1 } else { 1 };
    let fitted: Vec<RangePair> = pairs.iter().step_by(step).copied().collect();
    let fit = fit_beam_model(&fitted, &start)?;
    Ok(Learned { scans: used, outside: scans.len() - used, pairs, histogram, start, fit })
}

/// Pixels along the side of a surface.
const PIXELS: usize = 270;

/// The densities that the colours and the cuts show, as powers of ten \[1/m\].
const LOWEST: f64 = -4.0;
const HIGHEST: f64 = 1.0;

/// Expected ranges of the cuts \[m\].
const CUTS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// Fewer pairs make no curve.
const FEWEST: u64 = 500;

/// The surface `p(measured | expected)` as counted beside the fitted one, as heat maps over the
/// same axes; the strip above is the probability of no return.
///
/// # Errors
/// [`loc_pf::Error`] where the fitted parameters make no model.
pub fn surfaces(learned: &Learned, title: &str) -> Result<String> {
    let counted = learned.histogram.model();
    let fitted = BeamModel::new(&learned.fit.settings)?;
    let reach = reach(learned);
    let width = learned.histogram.width();
    let map = |caption: &str, model: &dyn Fn(f64, f64) -> f64| {
        let at = |k: usize| (k as f64 + 0.5) * reach / PIXELS as f64;
        let rows = (0..PIXELS).rev();
        let pixels = rows.flat_map(|row| (0..PIXELS).map(move |column| (column, row)));
        let density =
            pixels.map(|(column, row)| density_color(model(at(column), at(row)) / 10_f64.ln()));
        // A probability is drawn as if spread over one bin.
        let none = |column| model(at(column), f64::INFINITY) - width.ln();
        let strip = (0..PIXELS).map(|column| density_color(none(column) / 10_f64.ln()));
        HeatMap {
            caption: caption.into(),
            data_uri: Image { width: PIXELS, pixels: density.collect() }.data_uri(),
            strip: Some(Image { width: PIXELS, pixels: strip.collect() }.data_uri()),
        }
    };
    let figure = HeatMaps {
        title: title.into(),
        subtitle: format!("{} beams of {} scans", learned.pairs.len(), learned.scans),
        x_label: "expected range [m]".into(),
        y_label: "measured range [m]".into(),
        x_range: (0.0, reach),
        y_range: (0.0, reach),
        strip_label: "none".into(),
        maps: vec![
            map("measured", &|expected, measured| counted.log_density(expected, measured)),
            map("fitted beam model", &|expected, measured| fitted.log_density(expected, measured)),
        ],
        bar: Some(color::bar(&DENSITY, LOWEST, HIGHEST, "log10 of p [1/m]")),
    };
    Ok(figure.render())
}

/// Cuts through both surfaces at a few expected ranges.
///
/// # Errors
/// [`loc_pf::Error`] where the fitted parameters make no model.
pub fn cuts(learned: &Learned, title: &str) -> Result<String> {
    let counted = learned.histogram.model();
    let fitted = BeamModel::new(&learned.fit.settings)?;
    let (reach, width) = (reach(learned), learned.histogram.width());
    let mut figure = Figure::new(title)
        .subtitle("Densities of the measured range where the map lets expect a certain one")
        .x_label("measured range [m]");
    for expected in CUTS.into_iter().filter(|range| *range < reach) {
        let row = learned.histogram.bin(expected).map(|bin| learned.histogram.row(bin));
        let pairs: u64 = row.unwrap_or_default().iter().map(|count| u64::from(*count)).sum();
        if pairs < FEWEST {
            continue;
        }
        // In the middle of a bin there is nothing to interpolate.
        let middle = (expected / width).floor() * width + 0.5 * width;
        let curve = |model: &dyn RangeModel, step: f64| -> Vec<(f64, f64)> {
            let count = (reach / step) as usize;
            let at = |k: usize| (k as f64 + 0.5) * step;
            (0..count).map(|k| (at(k), model.log_density(middle, at(k)).exp())).collect()
        };
        let chart = Chart::new(format!("p [1/m], expected {middle:.2} m ({pairs} beams)"))
            .line(Role::Measurement, "measured", curve(&counted, width))
            .line(Role::Method(0), "fitted beam model", curve(&fitted, 0.2 * width))
            .log_y()
            .y_range(10_f64.powf(LOWEST), 2.0 * 10_f64.powf(HIGHEST));
        figure = figure.panel(chart);
    }
    Ok(figure.render())
}

/// A round range that nearly all pairs lie within \[m\].
fn reach(learned: &Learned) -> f64 {
    let pairs = learned.pairs.iter().map(|pair| pair.expected.min(pair.measured));
    let mut ranges: Vec<f64> = pairs.filter(|range| range.is_finite()).collect();
    let place = (0.99 * ranges.len() as f64) as usize;
    if place >= ranges.len() {
        return learned.histogram.max_range();
    }
    let (_, range, _) = ranges.select_nth_unstable_by(place, f64::total_cmp);
    range.ceil().clamp(1.0, learned.histogram.max_range().max(1.0))
}

/// The colour of a density's power of ten.
fn density_color(power: f64) -> [u8; 3] {
    color::along(&DENSITY, (power - LOWEST) / (HIGHEST - LOWEST))
}

/// From the robot to the nearest wall \[m\].
const CLEARANCE: f64 = 0.3;

/// After so many tries any place will do; [`learn`] leaves out those that are not free.
const MAX_TRIES: usize = 10_000;

/// The demonstration `perceptual-model` (K2): a laser scans at many places of a world, and the model is
/// learned from its scans and true poses.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerceptualModelConfig {
    /// The world.
    pub world: WorldConfig,
    /// The laser; `every` has no meaning here.
    pub laser: LaserConfig,
    /// Number of places at which it scans.
    pub places: usize,
}

impl Demonstration for PerceptualModelConfig {
    fn check(&self) -> Result<()> {
        self.world.settings()?;
        self.laser.scanner()?;
        check_count("demonstration.places", self.places, 100_000)
    }

    /// Scans, learns and draws. Some beams are stopped by what the map does not know (people), some
    /// do not come back (glass); the shares that were put in are compared with the fitted ones.
    fn run(&self, title: &str, seed: u64) -> Result<Illustration> {
        self.check()?;
        let learned = scan_and_learn(self, seed)?;
        let fitted = &learned.fit.settings;
        let LaserFaults { dropout, short, .. } = self.laser.faults;
        let rows = [
            ("z_hit", 1.0 - short - dropout, fitted.z_hit),
            ("z_short", short, fitted.z_short),
            ("z_max", dropout, fitted.z_max),
            ("z_rand", 0.0, fitted.z_rand),
            ("sigma_hit [m]", self.laser.scanner()?.spec.noise.sigma, fitted.sigma_hit),
        ];
        let mut lines = vec![
            format!("{} beams of {} scans", learned.pairs.len(), learned.scans),
            format!("{:<20}{:>10}{:>10}", "", "put in", "fitted"),
        ];
        lines
            .extend(rows.map(|(name, put, fitted)| format!("{name:<20}{put:>10.4}{fitted:>10.4}")));
        let put_in = json!({"short": short, "none": dropout});
        let summary = json!({"beams": learned.pairs.len(), "fitted": fitted, "put_in": put_in});
        let surfaces = FigureFile::new(
            "surfaces.svg",
            "p(measured | expected) as counted, beside the fitted beam model",
            surfaces(&learned, title)?,
        );
        let cuts = FigureFile::new(
            "cuts.svg",
            "Cuts through both surfaces at a few expected ranges",
            cuts(&learned, title)?,
        );
        Ok(Illustration::new(lines, summary, vec![surfaces, cuts]))
    }
}

fn scan_and_learn(config: &PerceptualModelConfig, seed: u64) -> Result<Learned> {
    let world = TourWorld::open(Some(&config.world), None)?;
    let (scanner, map) = (config.laser.scanner()?, world.grid());
    let (mut places, mut errors) = (stream(seed, "places"), stream(seed, "laser"));
    let scans: Vec<(Pose2, LaserScan)> = (0..config.places)
        .map(|_| {
            let pose = free_pose(&world, &mut places);
            let scan = scanner.scan(&world.walls, pose, &mut errors);
            (pose * scanner.mounting, scan)
        })
        .collect();
    let start = BeamModelSettings::default().max_range(scanner.spec.range_max);
    learn(&scans, map, &LearnSettings { start, ..LearnSettings::default() })
}

/// A pose in free space, at least [`CLEARANCE`] from every wall.
fn free_pose(world: &TourWorld, rng: &mut ChaCha8Rng) -> Pose2 {
    let frame = world.grid().frame();
    let mut pose = Pose2::IDENTITY;
    for _ in 0..MAX_TRIES {
        let (u, v, turn): (f64, f64, f64) = (rng.random(), rng.random(), rng.random());
        let place = frame.to_map(u * frame.width() as f64, v * frame.height() as f64);
        pose = Pose2::new(place.x, place.y, TAU * turn);
        if world.clearance(&place) >= CLEARANCE {
            break;
        }
    }
    pose
}
