//! A scan, made ready to rate the poses of a grid.

use super::settings::GridSettings;
use super::space::PoseSpace;
use loc_core::Pose2;
use loc_maps::LikelihoodField;
use loc_maps::likelihood_field::Endpoints;
use loc_sensors::laser::LaserScan;

/// The most headings of a sector that are looked at.
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
            range_min: scan.range_min.max(settings.min_range),
            range_max: scan.range_max.min(settings.max_range),
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

    /// The ends for a robot that looks along `heading` \[rad\] of the grid, in cells from the
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
