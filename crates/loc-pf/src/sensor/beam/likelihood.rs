//! Scans rated by casting every beam in the map.

use super::select::reading;
use super::{BeamModel, BeamModelSettings, RangeModel};
use crate::mcl::MountedScan;
use crate::sensor::Likelihood;
use crate::{Poses, Result};
use loc_core::Pose2;
use loc_core::error::{finite, positive};
use loc_maps::RayCaster;

/// Poses that are worked on together: one beam is cast for all of them before the next one, so
/// that rays which follow each other are alike and the processor guesses their way right.
const BATCH: usize = 256;

/// A scan before a map, ready to rate poses by the beam model.
///
/// Every beam has a table of `ln p(measured | expected)` over the expected range, so that rating a
/// pose is a ray and an interpolated lookup for each beam. The interpolation is off by less than
/// 0.005 a beam where the table's steps are an eighth of `sigma_hit` (down to a `sigma_hit` of
/// 1/2048 of the longest range), single precision by 1e-6 of the logarithm.
#[derive(Debug, Clone)]
pub struct BeamLikelihood<'a> {
    caster: &'a RayCaster,
    mounting: Pose2,
    /// Directions of the beams in the laser's frame, unit vectors.
    directions: Vec<[f64; 2]>,
    /// A table for each beam: expected ranges `0, step, ..` up to the longest one, and nothing
    /// (twice, so that there is always a next entry).
    tables: Vec<f32>,
    entries: usize,
    /// Steps a cell.
    scale: f64,
    /// Longest range \[cells\].
    max_length: f64,
    exponent: f64,
}

impl<'a> BeamLikelihood<'a> {
    /// A scan before the obstacles of a map. Of its beams those numbered `beams` are used (see
    /// [`telling_beams`](super::telling_beams)); of these, the ones that say nothing are not. The
    /// likelihood is raised to the power `exponent` in (0, 1], as the beams of a scan are not
    /// independent of each other.
    ///
    /// The longest range is the shorter one of the scan's and the settings'.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for settings out of range, an exponent that is not above 0
    /// and a mounting that is not finite; those of
    /// [`LaserScan::check`](loc_sensors::laser::LaserScan::check).
    pub fn new(
        caster: &'a RayCaster,
        settings: &BeamModelSettings,
        mounted: &MountedScan<'_>,
        beams: &[usize],
        exponent: f64,
    ) -> Result<Self> {
        mounted.scan.check()?;
        let max_range = settings.max_range.min(mounted.scan.range_max);
        let model = BeamModel::new(&BeamModelSettings { max_range, ..*settings })?;
        BeamLikelihood::with_model(caster, &model, mounted, beams, exponent)
    }

    /// The same with any model of ranges, such as one that was learned.
    ///
    /// # Errors
    /// As for [`new`](Self::new).
    pub fn with_model(
        caster: &'a RayCaster,
        model: &impl RangeModel,
        mounted: &MountedScan<'_>,
        beams: &[usize],
        exponent: f64,
    ) -> Result<Self> {
        let MountedScan { scan, mounting } = *mounted;
        scan.check()?;
        for value in [mounting.x, mounting.y, mounting.theta] {
            finite("mounting of a laser", value)?;
        }
        positive("exponent of a scan", exponent)?;
        let max_range = model.max_range();
        let steps = (max_range / model.step()).ceil().max(1.0);
        let entries = steps as usize + 3;
        let (mut directions, mut tables) = (Vec::new(), Vec::new());
        for &beam in beams {
            let Some(measured) = reading(scan, beam, max_range) else { continue };
            let (sin, cos) = scan.angle(beam).sin_cos();
            directions.push([cos, sin]);
            let start = tables.len();
            tables.resize(start + entries, 0.0);
            let table = &mut tables[start..];
            model.tabulate(measured, max_range / steps, &mut table[..entries - 1]);
            table[entries - 1] = table[entries - 2];
        }
        let resolution = caster.frame().resolution();
        let (scale, max_length) = (resolution * steps / max_range, max_range / resolution);
        Ok(BeamLikelihood {
            caster,
            mounting,
            directions,
            tables,
            entries,
            scale,
            max_length,
            exponent,
        })
    }

    /// Number of beams that are used.
    pub fn beams(&self) -> usize {
        self.directions.len()
    }

    /// Memory of the tables \[bytes\].
    pub fn bytes(&self) -> usize {
        self.tables.len() * size_of::<f32>()
    }

    /// `ln p(scan | pose)` for one pose of the robot.
    pub fn log_likelihood(&self, pose: Pose2) -> f64 {
        let mut weight = [0.0];
        self.rate(Poses { x: &[pose.x], y: &[pose.y], theta: &[pose.theta] }, &mut weight);
        weight[0]
    }

    /// The logarithm for one beam, from its table.
    #[inline(always)]
    fn look_up(&self, table: &[f32], length: Option<f64>) -> f64 {
        let last = self.entries - 2;
        let place = length.map_or(last as f64, |length| length * self.scale);
        let below = (place as usize).min(last);
        let share = place - below as f64;
        let (low, high) = (f64::from(table[below]), f64::from(table[below + 1]));
        low + share * (high - low)
    }
}

/// A pose of the laser in the grid's frame \[cells\].
#[derive(Clone, Copy, Default)]
struct Laser {
    start: [f64; 2],
    /// Cosine and sine of its heading.
    heading: [f64; 2],
}

impl Likelihood for BeamLikelihood<'_> {
    fn rate(&self, poses: Poses<'_>, log_weights: &mut [f64]) {
        let frame = self.caster.frame();
        let mut poses = poses.iter();
        let mut lasers = [Laser::default(); BATCH];
        for weights in log_weights.chunks_mut(BATCH) {
            let lasers = &mut lasers[..weights.len()];
            for (laser, pose) in lasers.iter_mut().zip(&mut poses) {
                let at = pose * self.mounting;
                let start = frame.to_cells(&at.position());
                let (sin, cos) = at.theta.sin_cos();
                *laser =
                    Laser { start: [start.x, start.y], heading: frame.turn_to_grid([cos, sin]) };
            }
            self.rate_batch(lasers, weights);
        }
    }
}

impl BeamLikelihood<'_> {
    fn rate_batch(&self, lasers: &[Laser], weights: &mut [f64]) {
        let mut sums = [0.0; BATCH];
        let tables = self.tables.chunks_exact(self.entries);
        for (&[x, y], table) in self.directions.iter().zip(tables) {
            for (laser, sum) in lasers.iter().zip(&mut sums) {
                let [cos, sin] = laser.heading;
                let along = [cos * x - sin * y, sin * x + cos * y];
                let length = self.caster.cast_in_cells(laser.start, along, self.max_length);
                *sum += self.look_up(table, length);
            }
        }
        for ((weight, sum), laser) in weights.iter_mut().zip(sums).zip(lasers) {
            let [u, v] = laser.start;
            let finite = u.is_finite() && v.is_finite() && laser.heading[0].is_finite();
            *weight += if finite { self.exponent * sum } else { f64::NEG_INFINITY };
        }
    }
}
