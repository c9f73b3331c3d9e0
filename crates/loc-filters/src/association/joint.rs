//! Joint compatibility by branch and bound, JCBB (Neira and Tardos 2001).
//!
//! A hypothesis gives each sighting a landmark or none. It is extended one sighting at a time, and
//! abandoned when its pairs do not fit together, or when it cannot come to more pairs than the
//! best one so far. Whether pairs fit together is a chi-square test on their joint innovation,
//! whose covariance is factorised row by row as the hypothesis grows.

use super::candidates::Candidates;
use super::{AssociationSettings, Pairing};
use crate::Result;
use loc_core::stats::chi_square_quantile;
use nalgebra::SMatrix;

/// Chi-square thresholds by the number of numbers.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct JointGate {
    thresholds: Vec<f64>,
}

impl JointGate {
    /// Measurements of one pair have at most so many numbers; larger ones are not gated.
    const LARGEST: usize = 3;

    pub(super) fn new(probability: f64) -> Result<Self> {
        let mut thresholds = Vec::new();
        if probability < 1.0 {
            for dof in 1..=Self::LARGEST * AssociationSettings::GROUP {
                thresholds.push(chi_square_quantile(dof, probability)?);
            }
        }
        Ok(JointGate { thresholds })
    }

    fn threshold(&self, dof: usize) -> f64 {
        self.thresholds.get(dof.wrapping_sub(1)).copied().unwrap_or(f64::INFINITY)
    }
}

/// The partner of each sighting, and whether the search was finished.
pub(super) fn search<const M: usize, P: Pairing<M>>(
    pairing: &P,
    candidates: &Candidates,
    gate: &JointGate,
    budget: &mut usize,
) -> (Vec<Option<usize>>, bool) {
    let mut taken = vec![false; candidates.landmarks];
    let (mut partners, mut complete) = (Vec::new(), true);
    while partners.len() < candidates.fits.len() {
        let first = partners.len();
        let last = (first + AssociationSettings::GROUP).min(candidates.fits.len());
        let mut search = Search::new(pairing, candidates, gate, (first, last), taken);
        // Enough for the first hypothesis: each sighting with the nearest landmark that fits.
        let least = last - first + 2;
        search.budget = (*budget).max(least);
        search.extend(first);
        complete &= search.budget > 0;
        *budget = search.budget;
        taken = search.taken;
        search.best.partners.iter().flatten().for_each(|&landmark| taken[landmark] = true);
        partners.extend(search.best.partners);
    }
    (partners, complete)
}

/// A complete hypothesis.
struct Hypothesis {
    partners: Vec<Option<usize>>,
    pairs: usize,
    nis: f64,
}

/// The hypothesis that is being extended, and the best one so far.
struct Search<'a, const M: usize, P> {
    pairing: &'a P,
    candidates: &'a Candidates,
    gate: &'a JointGate,
    /// One beyond the last sighting of the group.
    last: usize,
    taken: Vec<bool>,
    /// The pairs so far, and for each sighting so far its partner.
    pairs: Vec<(usize, usize)>,
    partners: Vec<Option<usize>>,
    /// Rows of the Cholesky factor of the joint covariance, one after the other, each with
    /// the elements up to its diagonal.
    factor: Vec<f64>,
    /// The joint innovation, whitened.
    whitened: Vec<f64>,
    best: Hypothesis,
    /// Hypotheses that may still be looked at.
    budget: usize,
}

impl<'a, const M: usize, P: Pairing<M>> Search<'a, M, P> {
    fn new(
        pairing: &'a P,
        candidates: &'a Candidates,
        gate: &'a JointGate,
        (first, last): (usize, usize),
        taken: Vec<bool>,
    ) -> Self {
        let none = Hypothesis { partners: vec![None; last - first], pairs: 0, nis: f64::INFINITY };
        Search {
            pairing,
            candidates,
            gate,
            last,
            taken,
            pairs: Vec::new(),
            partners: Vec::new(),
            factor: Vec::new(),
            whitened: Vec::new(),
            best: none,
            budget: 0,
        }
    }

    fn nis(&self) -> f64 {
        self.whitened.iter().map(|value| value * value).sum()
    }

    /// Decides on the sightings from `sighting` on, in all ways that may be better than the best.
    fn extend(&mut self, sighting: usize) {
        if self.budget == 0 {
            return;
        }
        self.budget -= 1;
        let nis = self.nis();
        let hope = |s: &usize| !self.candidates.fits[*s].is_empty();
        let most = self.pairs.len() + (sighting..self.last).filter(hope).count();
        // More pairs never make the joint NIS smaller.
        if most < self.best.pairs || (most == self.best.pairs && nis >= self.best.nis) {
            return;
        }
        if sighting == self.last {
            self.best =
                Hypothesis { partners: self.partners.clone(), pairs: self.pairs.len(), nis };
            return;
        }
        let candidates = self.candidates;
        for fit in &candidates.fits[sighting] {
            if !self.taken[fit.landmark] && self.push((sighting, fit.landmark)) {
                self.taken[fit.landmark] = true;
                self.partners.push(Some(fit.landmark));
                self.extend(sighting + 1);
                self.partners.pop();
                self.taken[fit.landmark] = false;
                self.pop();
            }
        }
        self.partners.push(None);
        self.extend(sighting + 1);
        self.partners.pop();
    }

    /// Adds a pair to the hypothesis; `false`, and no change, where it does not fit the others.
    fn push(&mut self, pair: (usize, usize)) -> bool {
        let before = self.whitened.len();
        self.pairs.push(pair);
        let fits =
            self.grow(pair).is_some() && self.nis() <= self.gate.threshold(self.whitened.len());
        if !fits {
            self.pairs.pop();
            self.shrink(before);
        }
        fits
    }

    fn pop(&mut self) {
        self.pairs.pop();
        self.shrink(self.whitened.len() - M);
    }

    fn shrink(&mut self, rows: usize) {
        self.whitened.truncate(rows);
        self.factor.truncate(rows * (rows + 1) / 2);
    }

    /// Appends the rows of a pair to the factor and the whitened innovation.
    fn grow(&mut self, pair: (usize, usize)) -> Option<()> {
        let own = self.pairing.innovation(pair.0, pair.1)?;
        let earlier = &self.pairs[..self.pairs.len() - 1];
        let cross: Vec<SMatrix<f64, M, M>> =
            earlier.iter().map(|other| self.pairing.cross_covariance(pair, *other)).collect();
        for row in 0..M {
            let covariances = cross.iter().flat_map(|block| (0..M).map(move |c| block[(row, c)]));
            let own_covariances = (0..=row).map(|c| own.covariance[(row, c)]);
            let covariances: Vec<f64> = covariances.chain(own_covariances).collect();
            self.append(&covariances, own.residual[row])?;
        }
        Some(())
    }

    /// Appends one row: its covariances with all rows before it and with itself.
    fn append(&mut self, covariances: &[f64], residual: f64) -> Option<()> {
        let rows = self.whitened.len();
        let mut new = Vec::with_capacity(rows + 1);
        let mut start = 0;
        for (j, covariance) in covariances.iter().enumerate().take(rows) {
            let row = &self.factor[start..=start + j];
            let known: f64 = row.iter().zip(&new).map(|(a, b): (&f64, &f64)| a * b).sum();
            new.push((covariance - known) / row[j]);
            start += j + 1;
        }
        let pivot = covariances[rows] - new.iter().map(|v| v * v).sum::<f64>();
        // Pairs whose joint covariance is singular, or not one at all, say nothing together.
        if !(pivot > 0.0 && pivot.is_finite()) {
            return None;
        }
        let explained: f64 = new.iter().zip(&self.whitened).map(|(a, b)| a * b).sum();
        self.whitened.push((residual - explained) / pivot.sqrt());
        new.push(pivot.sqrt());
        self.factor.extend(new);
        Some(())
    }
}
