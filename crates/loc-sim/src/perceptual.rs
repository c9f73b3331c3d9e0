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
use loc_core::Pose2;
use loc_maps::grid::Occupancy;
use loc_maps::{OccupancyGrid, RayCaster};
use loc_pf::sensor::BeamModelSettings;
use loc_pf::sensor::perceptual::{
    FitReport, PerceptualHistogram, RangePair, fit_beam_model, range_pairs,
};
use loc_sensors::laser::LaserScan;

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
    settings.start.validate()?;
    let reach = scans.iter().map(|(_, scan)| scan.range_max).fold(0.0, f64::max);
    let max_range = if reach > 0.0 { settings.start.max_range.min(reach) } else { 1.0 };
    let start = BeamModelSettings { max_range, ..settings.start };
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
