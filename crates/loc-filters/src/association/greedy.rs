//! The best pair first, then the best of what is left.

use super::Pairing;
use super::candidates::{Candidates, Fit};

impl Candidates {
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
