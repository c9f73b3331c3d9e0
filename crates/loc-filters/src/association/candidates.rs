//! The pairs that fit on their own.

use super::{PairInnovation, Pairing};
use crate::innovation::finite;
use crate::{Gate, Innovation, Result};

/// A landmark that a sighting may be of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    pub(super) landmark: usize,
    pub(super) nis: f64,
    pub(super) log_likelihood: f64,
}

/// For each sighting the landmarks that it may be of, nearest first.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Candidates {
    pub(super) fits: Vec<Vec<Fit>>,
    /// NIS of each sighting with the landmark nearest to it, inside the gate or not.
    pub(super) nearest: Vec<f64>,
    pub(super) landmarks: usize,
}

impl Candidates {
    pub(super) fn new<const M: usize>(pairing: &impl Pairing<M>, gate: &Gate) -> Result<Self> {
        let (sightings, landmarks) = (pairing.sightings(), pairing.landmarks());
        let mut candidates = Candidates {
            fits: vec![Vec::new(); sightings],
            nearest: vec![f64::INFINITY; sightings],
            landmarks,
        };
        for sighting in 0..sightings {
            for landmark in 0..landmarks {
                if let Some(pair) = pairing.innovation(sighting, landmark) {
                    candidates.judge(sighting, landmark, &pair, gate)?;
                }
            }
            candidates.fits[sighting]
                .sort_by(|a, b| a.nis.total_cmp(&b.nis).then(a.landmark.cmp(&b.landmark)));
        }
        Ok(candidates)
    }

    fn judge<const M: usize>(
        &mut self,
        sighting: usize,
        landmark: usize,
        pair: &PairInnovation<M>,
        gate: &Gate,
    ) -> Result<()> {
        finite("residual of a sighting", &pair.residual)?;
        let (innovation, _) = Innovation::new(pair.residual, pair.covariance, gate)?;
        self.nearest[sighting] = self.nearest[sighting].min(innovation.nis);
        if innovation.accepted {
            let log_likelihood = innovation.log_likelihood();
            self.fits[sighting].push(Fit { landmark, nis: innovation.nis, log_likelihood });
        }
        Ok(())
    }
}
