//! The candidate pairs of observations and landmarks, each gated on its own, and the greedy rules that
//! choose among them.

use super::{PairInnovation, Pairing};
use crate::innovation::finite;
use crate::{Gate, Innovation, Result};

/// A landmark that an observation may be of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    pub(super) landmark: usize,
    pub(super) nis: f64,
    pub(super) log_likelihood: f64,
    /// Whether it passes the gate; one that does not may still be a rival to one that does.
    pub(super) compatible: bool,
}

/// How much smaller a rival's covariance may be, in logarithms of the determinant.
pub(super) const SLACK: f64 = 4.0;

/// For each observation the landmarks that it may be of, nearest first.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Candidates {
    pub(super) fits: Vec<Vec<Fit>>,
    /// NIS of each observation with the landmark nearest to it, inside the gate or not.
    pub(super) nearest: Vec<f64>,
    pub(super) landmarks: usize,
}

impl Candidates {
    /// With a `lead` above 0 also the pairs that may be rivals: less likely than one that passes the
    /// gate by no more than that, in logarithms.
    pub(super) fn new<const M: usize>(
        pairing: &impl Pairing<M>,
        gate: &Gate,
        lead: f64,
    ) -> Result<Self> {
        let wide = if lead > 0.0 { gate.threshold(M) + 2.0 * lead + SLACK } else { 0.0 };
        let (observations, landmarks) = (pairing.observations(), pairing.landmarks());
        let mut candidates = Candidates {
            fits: vec![Vec::new(); observations],
            nearest: vec![f64::INFINITY; observations],
            landmarks,
        };
        for observation in 0..observations {
            for landmark in 0..landmarks {
                if let Some(pair) = pairing.innovation(observation, landmark) {
                    candidates.judge((observation, landmark), &pair, gate, wide)?;
                }
            }
            candidates.fits[observation]
                .sort_by(|a, b| a.nis.total_cmp(&b.nis).then(a.landmark.cmp(&b.landmark)));
        }
        Ok(candidates)
    }

    fn judge<const M: usize>(
        &mut self,
        (observation, landmark): (usize, usize),
        pair: &PairInnovation<M>,
        gate: &Gate,
        wide: f64,
    ) -> Result<()> {
        finite("residual of an observation", &pair.residual)?;
        let (innovation, _) = Innovation::new(pair.residual, pair.covariance, gate)?;
        self.nearest[observation] = self.nearest[observation].min(innovation.nis);
        let (nis, compatible) = (innovation.nis, innovation.accepted);
        if compatible || nis <= wide {
            let log_likelihood = innovation.log_likelihood();
            self.fits[observation].push(Fit { landmark, nis, log_likelihood, compatible });
        }
        Ok(())
    }

    /// Partners in order of a cost, each observation and each landmark once. An observation stays alone
    /// where another landmark, or none, is less likely by less than `lead`, in
    /// logarithms.
    pub(super) fn greedy<const M: usize>(
        &self,
        pairing: &impl Pairing<M>,
        lead: f64,
        cost: impl Fn(&Fit) -> f64,
    ) -> Vec<Option<usize>> {
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (observation, fits) in self.fits.iter().enumerate() {
            let compatible = fits.iter().filter(|fit| fit.compatible);
            pairs.extend(compatible.map(|fit| (cost(fit), observation, fit.landmark)));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut partners = vec![None; self.fits.len()];
        let mut taken = vec![false; self.landmarks];
        for (_, observation, landmark) in pairs {
            if partners[observation].is_none() && !taken[landmark] {
                partners[observation] = Some(landmark);
                taken[landmark] = true;
            }
        }
        for (observation, (partner, fits)) in partners.iter_mut().zip(&self.fits).enumerate() {
            let own = fits.iter().find(|fit| Some(fit.landmark) == *partner);
            let others = fits.iter().filter(|fit| Some(fit.landmark) != *partner);
            let none = pairing.elsewhere(observation).ln();
            let best = others.map(|fit| fit.log_likelihood).fold(none, f64::max);
            if lead > 0.0 && own.is_some_and(|own| own.log_likelihood < best + lead) {
                *partner = None;
            }
        }
        partners
    }
}
