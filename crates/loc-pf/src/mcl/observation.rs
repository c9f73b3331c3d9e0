//! Scans, made ready to rate poses.

use super::MclSettings;
use crate::sensor::{BeamLikelihood, FieldLikelihood, SumOfCubes};
use crate::{Likelihood, Poses};
use loc_core::Pose2;
use loc_maps::likelihood_field::Endpoints;
use loc_sensors::laser::{Beam, LaserScan};
use nalgebra::Point2;

/// A scan with the place of its scanner on the robot.
#[derive(Debug, Clone, Copy)]
pub struct MountedScan<'a> {
    /// The scan.
    pub scan: &'a LaserScan,
    /// Where the scanner sits (`base_from_laser`).
    pub mounting: Pose2,
}

/// Scans that were made at one moment, ready to rate poses.
pub(super) enum Observation<'a> {
    Product(FieldLikelihood<'a>),
    SumOfCubes(SumOfCubes<'a>),
    Beams(Vec<BeamLikelihood<'a>>),
}

impl Likelihood for Observation<'_> {
    fn rate(&self, poses: Poses<'_>, log_weights: &mut [f64]) {
        match self {
            Observation::Product(scan) => scan.rate(poses, log_weights),
            Observation::SumOfCubes(scan) => scan.rate(poses, log_weights),
            Observation::Beams(scans) => {
                scans.iter().for_each(|scan| scan.rate(poses, log_weights));
            }
        }
    }
}

/// Where the beams of all scans end, in the robot's frame: of each scan the valid ones within the
/// settings' ranges, thinned after the others are dropped.
pub(super) fn endpoints(scans: &[MountedScan<'_>], settings: &MclSettings) -> Endpoints {
    let ends = scans.iter().flat_map(|mounted| {
        let within = |beam: &Beam| (settings.min_range..=settings.max_range).contains(&beam.range);
        let beams: Vec<Beam> = mounted.scan.beams().filter(within).collect();
        let beams = thinned(beams, settings.beams);
        beams.into_iter().map(move |beam| mounted.mounting.transform(&beam.point()))
    });
    ends.map(|Point2 { coords }| [coords.x, coords.y]).collect()
}

/// At most `count` of the beams, evenly spread; the first and the last are among them.
fn thinned(beams: Vec<Beam>, count: usize) -> Vec<Beam> {
    if beams.len() <= count {
        return beams;
    }
    let (gaps, last) = (count.saturating_sub(1).max(1), beams.len() - 1);
    (0..count).map(|k| beams[(k * last + gaps / 2) / gaps]).collect()
}
