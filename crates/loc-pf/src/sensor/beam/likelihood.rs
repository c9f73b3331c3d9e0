//! Scans rated by casting every beam in the map.

use super::{BeamModel, BeamModelSettings, RangeModel};
use crate::mcl::MountedScan;
use crate::sensor::Likelihood;
use crate::{Poses, Result};
use loc_core::Pose2;
use loc_core::error::{finite, positive};
use loc_maps::RayCaster;
use loc_sensors::laser::LaserScan;

/// Beams of a pose that are cast before their tables are read.
const BATCH: usize = 64;

/// A scan in a map, prepared to rate poses by the beam model.
///
/// Every beam has a table of `ln p(measured | expected)` over the expected range, so that rating a
/// pose is a ray and an interpolated lookup for each beam. The steps of the table are an eighth of
/// `sigma_hit` (down to a `sigma_hit` of 1/2048 of the longest range). Interpolation is off by less
/// than 0.005 a beam, and by up to 0.05 within the one step where the mixture jumps, at
/// `measured = expected`; on the average over poses by 0.001, in either direction.
#[derive(Debug, Clone)]
pub struct BeamLikelihood<'a> {
    caster: &'a RayCaster,
    mounting: Pose2,
    /// Directions of the beams in the laser's frame, unit vectors.
    directions: Vec<[f64; 2]>,
    /// A table for each beam, see [`RangeModel::tabulate`].
    tables: Vec<f32>,
    entries: usize,
    /// Steps a cell.
    scale: f64,
    /// Longest range \[cells\].
    max_length: f64,
    exponent: f64,
}

impl<'a> BeamLikelihood<'a> {
    /// A scan among the obstacles of a map. Of its beams those numbered `beams` are used (see
    /// [`informative_beams`](super::informative_beams)); of these, the ones without information are not. The
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
        let (mut directions, mut readings) = (Vec::new(), Vec::new());
        for &beam in beams {
            let Some(measured) = reading(scan, beam, max_range) else { continue };
            let (sin, cos) = scan.angle(beam).sin_cos();
            directions.push([cos, sin]);
            readings.push(measured);
        }
        let mut tables = vec![0.0; entries * readings.len()];
        model.tabulate(&readings, max_range / steps, &mut tables);
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

    /// `ln p(scan | pose)` of a laser at `start` \[cells\] with the cosine and sine of its heading,
    /// both in the grid's frame.
    #[inline(always)]
    fn rate_laser(&self, start: [f64; 2], [cos, sin]: [f64; 2]) -> f64 {
        let nothing = self.entries - 2;
        let mut places = [0.0; BATCH];
        let mut sum = 0.0;
        let tables = self.tables.chunks(BATCH * self.entries);
        for (directions, tables) in self.directions.chunks(BATCH).zip(tables) {
            for (&[x, y], place) in directions.iter().zip(&mut places) {
                let along = [cos * x - sin * y, sin * x + cos * y];
                let length = self.caster.cast_in_cells(start, along, self.max_length);
                *place = length.map_or(nothing as f64, |length| length * self.scale);
            }
            for (&place, table) in places.iter().zip(tables.chunks_exact(self.entries)) {
                let below = (place as usize).min(nothing);
                let (low, high) = (f64::from(table[below]), f64::from(table[below + 1]));
                sum += low + (place - below as f64) * (high - low);
            }
        }
        self.exponent * sum
    }
}

impl Likelihood for BeamLikelihood<'_> {
    fn rate(&self, poses: Poses<'_>, log_weights: &mut [f64]) {
        let frame = self.caster.frame();
        for (pose, weight) in poses.iter().zip(log_weights) {
            let laser = pose * self.mounting;
            let start = frame.to_cells(&laser.position());
            let (sin, cos) = laser.theta.sin_cos();
            let finite = start.x.is_finite() && start.y.is_finite() && sin.is_finite();
            *weight += if finite {
                self.rate_laser([start.x, start.y], frame.turn_to_grid([cos, sin]))
            } else {
                f64::NEG_INFINITY
            };
        }
    }
}

/// Numbers of at most `count` beams of a scan, evenly spread over the informative ones: the
/// measured ranges, and those where nothing returned (longer than the longest range, +inf). Failed
/// beams (NaN) and those too near are dropped, before thinning.
pub fn informative_beams(scan: &LaserScan, count: usize) -> Vec<usize> {
    informative_beams_from(scan, scan.range_min, count)
}

/// The same with `nearest` \[m\] as the shortest informative range.
pub(crate) fn informative_beams_from(scan: &LaserScan, nearest: f64, count: usize) -> Vec<usize> {
    // NaN carries no information.
    let tells = |(_, range): &(usize, &f64)| **range >= nearest;
    thinned(scan.ranges.iter().enumerate().filter(tells).map(|(beam, _)| beam).collect(), count)
}

/// At most `count` of the beams, evenly spread; the first and the last are among them.
pub(crate) fn thinned(beams: Vec<usize>, count: usize) -> Vec<usize> {
    match count {
        _ if beams.len() <= count => beams,
        0 => Vec::new(),
        1 => vec![beams[beams.len() / 2]],
        _ => {
            let (gaps, last) = (count - 1, beams.len() - 1);
            (0..count).map(|k| beams[(k * last + gaps / 2) / gaps]).collect()
        }
    }
}

/// What a beam measured \[m\], +inf for no return; `None` without information.
pub(crate) fn reading(scan: &LaserScan, beam: usize, max_range: f64) -> Option<f64> {
    let range = *scan.ranges.get(beam).filter(|range| **range >= scan.range_min)?;
    let in_reach = range <= scan.range_max && range < max_range;
    Some(if in_reach { range } else { f64::INFINITY })
}
