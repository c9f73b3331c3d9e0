//! The best pair first, then the best of what is left.

use super::candidates::{Candidates, Fit};

impl Candidates {
    /// Partners in order of a cost, each sighting and each landmark once.
    pub(super) fn greedy(&self, cost: impl Fn(&Fit) -> f64) -> Vec<Option<usize>> {
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (sighting, fits) in self.fits.iter().enumerate() {
            pairs.extend(fits.iter().map(|fit| (cost(fit), sighting, fit.landmark)));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        let mut partners = vec![None; self.fits.len()];
        let mut taken = vec![false; self.landmarks];
        for (_, sighting, landmark) in pairs {
            if partners[sighting].is_none() && !taken[landmark] {
                partners[sighting] = Some(landmark);
                taken[landmark] = true;
            }
        }
        partners
    }
}
