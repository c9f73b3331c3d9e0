//! Beams that hardly any particle can explain are left out (`do_beamskip` of nav2_amcl).

use crate::{Poses, Result};
use loc_core::error::{positive, probability};
use loc_maps::LikelihoodField;
use loc_maps::likelihood_field::Endpoints;

/// At most about this many particles are asked about each beam, evenly taken from the cloud: the
/// share that agrees is off by 0.015 then, and the pass costs little beside the rating.
const ASKED: usize = 1024;

/// Settings of beam skipping; the defaults are those of nav2_amcl.
///
/// A person or a parcel shortens beams; those that end some `sigma_hit` before a wall pull the
/// estimate until they touch it. So before a scan is rated, each beam is put before the cloud: it
/// is kept if enough particles see it end near an obstacle of the map. (Beams that end far from
/// everything need no skipping here: they cost all poses the same.)
///
/// This only makes sense while the cloud is about the true pose. When it is not, almost all beams
/// look wrong, and they are the ones that say so: where more than `error_threshold` of them would
/// be skipped, or the cloud is wider than `distance`, all are kept. In a static world the beams of
/// a tracked robot agree with the cloud and all but stray ones are kept too.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct BeamSkip {
    /// How far from the nearest obstacle a beam may end to agree with a particle \[m\]
    /// (`beam_skip_distance`); less than the field's `max_distance`, or no beam is skipped.
    pub distance: f64,
    /// A beam is kept if more than this share of the particles agrees with it
    /// (`beam_skip_threshold`).
    pub threshold: f64,
    /// All beams are kept if at least this share would be skipped (`beam_skip_error_threshold`).
    pub error_threshold: f64,
}

impl Default for BeamSkip {
    fn default() -> Self {
        BeamSkip { distance: 0.5, threshold: 0.3, error_threshold: 0.9 }
    }
}

impl BeamSkip {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn validate(&self) -> Result<()> {
        positive("beam_skip_distance [m]", self.distance)?;
        probability("beam_skip_threshold", self.threshold)?;
        probability("beam_skip_error_threshold", self.error_threshold)?;
        Ok(())
    }

    /// For each beam of a scan whether it is kept. The answer depends on the order of the poses
    /// where there are more than 1024, not on threads.
    pub fn keep(
        &self,
        field: &LikelihoodField,
        poses: Poses<'_>,
        endpoints: &Endpoints,
    ) -> Vec<bool> {
        let step = poses.len().div_ceil(ASKED).max(1);
        let [x, y, theta] = [poses.x, poses.y, poses.theta]
            .map(|all| all.iter().copied().step_by(step).collect::<Vec<f64>>());
        if x.is_empty() || spread(&x, &y) > self.distance {
            return vec![true; endpoints.len()];
        }
        let least = self.threshold * x.len() as f64;
        let hits = field.hits(self.distance, [&x, &y, &theta], endpoints);
        let keep: Vec<bool> = hits.into_iter().map(|hits| f64::from(hits) > least).collect();
        let skipped = keep.iter().filter(|keep| !**keep).count();
        if skipped as f64 >= self.error_threshold * keep.len() as f64 {
            return vec![true; endpoints.len()];
        }
        keep
    }

    /// The beams that are kept.
    #[must_use]
    pub fn apply(
        &self,
        field: &LikelihoodField,
        poses: Poses<'_>,
        endpoints: &Endpoints,
    ) -> Endpoints {
        endpoints.selected(&self.keep(field, poses, endpoints))
    }
}

/// Root mean square distance from the mean \[m\].
fn spread(x: &[f64], y: &[f64]) -> f64 {
    let variance = |values: &[f64]| {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let squares: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
        squares / values.len() as f64
    };
    (variance(x) + variance(y)).sqrt()
}
