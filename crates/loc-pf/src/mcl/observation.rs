//! Scans, made ready to rate poses.

use super::{MclSettings, SensorSettings};
use crate::sensor::beam::{telling_beams_from, thinned};
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
    SumOfCubes(Box<SumOfCubes<'a>>),
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

/// Numbers of the beams of a scan to use: valid ones within the settings' ranges for the likelihood
/// field, also those without a return for the beam model; thinned after the others are dropped.
pub(super) fn select(scan: &LaserScan, settings: &MclSettings) -> Vec<usize> {
    match settings.sensor {
        SensorSettings::Beam(_) => {
            let nearest = settings.min_range.max(scan.range_min);
            telling_beams_from(scan, nearest, settings.beams)
        }
        SensorSettings::LikelihoodField(_) => {
            let range = settings.min_range..=settings.max_range;
            // What reports its greatest range has met nothing.
            let returned = |beam: &Beam| beam.range < scan.range_max;
            let beams = scan.beams().filter(|beam| range.contains(&beam.range) && returned(beam));
            thinned(beams.map(|beam| beam.index).collect(), settings.beams)
        }
    }
}

/// Where the chosen beams of all scans end, in the robot's frame, if all ranges are `offset` \[m\]
/// longer than measured.
pub(super) fn endpoints(scans: &[MountedScan<'_>], beams: &[Vec<usize>], offset: f64) -> Endpoints {
    let ends = scans.iter().zip(beams).flat_map(|(mounted, beams)| {
        let returned = beams.iter().map(|&index| (index, mounted.scan.ranges[index]));
        let returned = returned.filter(|(_, range)| mounted.scan.is_valid(*range));
        returned.map(|(index, range)| {
            let range = (range + offset).max(0.0);
            let beam = Beam { index, angle: mounted.scan.angle(index), range };
            mounted.mounting.transform(&beam.point())
        })
    });
    ends.map(|Point2 { coords }| [coords.x, coords.y]).collect()
}
