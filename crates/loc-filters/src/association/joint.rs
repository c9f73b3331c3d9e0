//! Joint compatibility by branch and bound, JCBB (Neira and Tardos 2001).
//!
//! A hypothesis gives each observation a landmark or none. It is extended one observation at a time, and
//! abandoned when its pairs do not fit together, or when it cannot reach more pairs than the
//! best one so far. Whether pairs fit together is a chi-square test on their joint innovation,
//! whose covariance is factorised row by row as the hypothesis grows.

use super::individual::{Candidates, Fit, SLACK};
use super::{AssociationSettings, Pairing};
use crate::Result;
use loc_core::stats::chi_square_quantile;
use nalgebra::SMatrix;
use std::f64::consts::TAU;

/// The partner of each observation, and whether the search was finished.
pub(super) fn search<const M: usize, P: Pairing<M>>(
    pairing: &P,
    candidates: &Candidates,
    gate: &JointGate,
    lead: f64,
    budget: &mut usize,
) -> (Vec<Option<usize>>, bool) {
    let mut taken = vec![false; candidates.landmarks];
    let (mut partners, mut complete) = (Vec::new(), true);
    while partners.len() < candidates.fits.len() {
        let first = partners.len();
        let last = (first + AssociationSettings::GROUP).min(candidates.fits.len());
        let mut search = Search::new(pairing, candidates, gate, (first, last), taken);
        // Enough for the first hypothesis: each observation with the nearest landmark that fits.
        search.budget = (*budget).max(last - first + 2);
        search.extend(first);
        let doubtful = if lead > 0.0 { search.doubtful(first, lead) } else { Vec::new() };
        complete &= search.budget > 0;
        *budget = search.budget;
        taken = search.taken;
        search.best.partners.iter().flatten().for_each(|&landmark| taken[landmark] = true);
        doubtful
            .into_iter()
            .for_each(|observation| search.best.partners[observation - first] = None);
        if lead > 0.0 {
            let evidence = Evidence { pairing, lead };
            evidence.drop_uncertain(first, &mut search.best.partners);
        }
        partners.extend(search.best.partners);
    }
    (partners, complete)
}

/// A complete hypothesis.
#[derive(Debug, Clone)]
struct Hypothesis {
    partners: Vec<Option<usize>>,
    pairs: usize,
    nis: f64,
    /// Logarithm of the determinant of the joint covariance.
    log_determinant: f64,
}

impl Hypothesis {
    /// Twice the logarithm of its likelihood, but for a constant that all of the same number of
    /// pairs share.
    fn likelihood(&self) -> f64 {
        -self.nis - self.log_determinant
    }
}

/// A pair of the best hypothesis, which its rivals do without.
struct Rivals {
    first: usize,
    observation: usize,
    landmark: usize,
    best: Hypothesis,
}

/// The hypothesis that is being extended, and the best one so far.
struct Search<'a, const M: usize, P> {
    pairing: &'a P,
    candidates: &'a Candidates,
    gate: &'a JointGate,
    /// One beyond the last observation of the group.
    last: usize,
    taken: Vec<bool>,
    /// The pairs so far, and for each observation so far its partner.
    joint: JointInnovation<M>,
    partners: Vec<Option<usize>>,
    best: Hypothesis,
    /// Hypotheses that may still be looked at.
    budget: usize,
    /// The pair whose rivals are searched for.
    rivals_of: Option<Rivals>,
}

impl<'a, const M: usize, P: Pairing<M>> Search<'a, M, P> {
    fn new(
        pairing: &'a P,
        candidates: &'a Candidates,
        gate: &'a JointGate,
        (first, last): (usize, usize),
        taken: Vec<bool>,
    ) -> Self {
        let none = Hypothesis {
            partners: vec![None; last - first],
            pairs: 0,
            nis: f64::INFINITY,
            log_determinant: 0.0,
        };
        Search {
            pairing,
            candidates,
            gate,
            last,
            taken,
            joint: JointInnovation::default(),
            partners: Vec::new(),
            best: none,
            budget: 0,
            rivals_of: None,
        }
    }

    /// The observations for which another landmark would make a set of as many pairs that is less
    /// likely by less than `lead`, in logarithms.
    fn doubtful(&mut self, first: usize, lead: f64) -> Vec<usize> {
        let best = self.best.clone();
        let mut doubtful = Vec::new();
        for (observation, partner) in (first..).zip(&best.partners) {
            let Some(landmark) = *partner else { continue };
            if self.candidates.fits[observation].len() < 2 {
                continue;
            }
            self.rivals_of = Some(Rivals { first, observation, landmark, best: best.clone() });
            // Beyond this an alternative is no rival, unless its covariance is far smaller.
            self.best.nis = best.nis + 2.0 * lead + SLACK;
            self.best.partners.clear();
            self.extend(first);
            let found = !self.best.partners.is_empty();
            if found && self.best.likelihood() + 2.0 * lead > best.likelihood() {
                doubtful.push(observation);
            }
        }
        (self.best, self.rivals_of) = (best, None);
        doubtful
    }

    /// Whether a pair may be made: in search of the best set one that passes the gate, in search
    /// of rivals another one for an observation that has a partner in the best.
    fn allows(&self, observation: usize, fit: &Fit) -> bool {
        match &self.rivals_of {
            None => fit.compatible,
            Some(rivals) => {
                let known = rivals.best.partners[observation - rivals.first].is_some();
                known && (observation, fit.landmark) != (rivals.observation, rivals.landmark)
            }
        }
    }

    /// Decides on the observations from `observation` on, in all ways that may be better than the best.
    fn extend(&mut self, observation: usize) {
        if self.budget == 0 {
            return;
        }
        self.budget -= 1;
        let nis = self.joint.nis();
        let hope = |s: &usize| self.candidates.fits[*s].iter().any(|fit| self.allows(*s, fit));
        let most = self.joint.pairs.len() + (observation..self.last).filter(hope).count();
        // More pairs never make the joint NIS smaller.
        if most < self.best.pairs || (most == self.best.pairs && nis >= self.best.nis) {
            return;
        }
        if observation == self.last {
            self.best = Hypothesis {
                partners: self.partners.clone(),
                pairs: self.joint.pairs.len(),
                nis,
                log_determinant: self.joint.log_determinant(),
            };
            return;
        }
        let candidates = self.candidates;
        for fit in &candidates.fits[observation] {
            let pair = (observation, fit.landmark);
            if self.allows(observation, fit) && !self.taken[fit.landmark] && self.push(pair) {
                self.taken[fit.landmark] = true;
                self.partners.push(Some(fit.landmark));
                self.extend(observation + 1);
                self.partners.pop();
                self.taken[fit.landmark] = false;
                self.joint.pop();
            }
        }
        self.partners.push(None);
        self.extend(observation + 1);
        self.partners.pop();
    }

    /// Adds a pair to the hypothesis; `false`, and no change, where it does not fit the others.
    fn push(&mut self, pair: (usize, usize)) -> bool {
        if !self.joint.push(self.pairing, pair) {
            return false;
        }
        // Rivals are judged by their likelihood, not by the gate.
        let fits =
            self.rivals_of.is_some() || self.joint.nis() <= self.gate.threshold(self.joint.len());
        if !fits {
            self.joint.pop();
        }
        fits
    }
}

/// Chi-square thresholds by the number of numbers.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::association) struct JointGate {
    thresholds: Vec<f64>,
}

impl JointGate {
    /// Maximum dimension of the measurement of one pair; larger ones are not gated.
    const LARGEST: usize = 3;

    pub(in crate::association) fn new(probability: f64) -> Result<Self> {
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

/// Residuals of some pairs, whitened by the Cholesky factor of their joint covariance.
#[derive(Debug, Clone, Default)]
struct JointInnovation<const M: usize> {
    pairs: Vec<(usize, usize)>,
    /// Rows of the factor, one after the other, each with the elements up to its diagonal.
    factor: Vec<f64>,
    whitened: Vec<f64>,
}

impl<const M: usize> JointInnovation<M> {
    /// Number of numbers.
    fn len(&self) -> usize {
        self.whitened.len()
    }

    fn nis(&self) -> f64 {
        self.whitened.iter().map(|value| value * value).sum()
    }

    /// Logarithm of the determinant of the joint covariance.
    fn log_determinant(&self) -> f64 {
        let diagonal = (0..self.len()).map(|row| self.factor[row * (row + 3) / 2]);
        2.0 * diagonal.map(f64::ln).sum::<f64>()
    }

    fn log_likelihood(&self) -> f64 {
        -0.5 * (self.nis() + self.log_determinant() + self.len() as f64 * TAU.ln())
    }

    /// Adds a pair; `false`, and no change, where the pairs have no joint covariance.
    fn push(&mut self, pairing: &impl Pairing<M>, pair: (usize, usize)) -> bool {
        let rows = self.len();
        if self.grow(pairing, pair).is_none() {
            self.shrink(rows);
            return false;
        }
        self.pairs.push(pair);
        true
    }

    /// Takes the last pair away.
    fn pop(&mut self) {
        self.pairs.pop();
        self.shrink(self.len() - M);
    }

    fn shrink(&mut self, rows: usize) {
        self.whitened.truncate(rows);
        self.factor.truncate(rows * (rows + 1) / 2);
    }

    fn grow(&mut self, pairing: &impl Pairing<M>, pair: (usize, usize)) -> Option<()> {
        let own = pairing.innovation(pair.0, pair.1)?;
        let earlier = self.pairs.iter();
        let cross: Vec<SMatrix<f64, M, M>> =
            earlier.map(|other| pairing.cross_covariance(pair, *other)).collect();
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

/// Holds "these observations are of these landmarks" against "they are of something else".
///
/// Where the robot is uncertain by metres, some landmark fits whatever is seen, and that it fits
/// says nothing. Two that fit together say much more: what is seen twice has the same distance on
/// the map, however far the robot is off.
pub(in crate::association) struct Evidence<'a, P> {
    pub(in crate::association) pairing: &'a P,
    /// How much likelier the pairs must be, in logarithms.
    pub(in crate::association) lead: f64,
}

impl<P> Evidence<'_, P> {
    /// Leaves out partners that are not much likelier than chance, of observations from `first` on.
    pub(in crate::association) fn drop_uncertain<const M: usize>(
        &self,
        first: usize,
        partners: &mut [Option<usize>],
    ) where
        P: Pairing<M>,
    {
        let mut pairs: Vec<(usize, usize)> =
            (first..).zip(partners.iter()).filter_map(|(s, p)| p.map(|p| (s, p))).collect();
        if pairs.iter().all(|pair| self.pairing.elsewhere(pair.0) <= 0.0) {
            return;
        }
        let supported = self.supported_pairs(&mut pairs);
        for (observation, partner) in (first..).zip(partners) {
            *partner = partner.filter(|landmark| supported.contains(&(observation, *landmark)));
        }
    }

    /// Removes the pair that has the least support of the others, until all are supported; then those that
    /// only support each other, unless they are likely together.
    fn supported_pairs<const M: usize>(
        &self,
        pairs: &mut Vec<(usize, usize)>,
    ) -> Vec<(usize, usize)>
    where
        P: Pairing<M>,
    {
        loop {
            let all = self.of(pairs);
            let without = |k: usize| {
                let others: Vec<_> = without(pairs, k);
                all - self.of(&others)
            };
            let support = (0..pairs.len()).map(|k| (without(k), k));
            match support.min_by(|a, b| a.0.total_cmp(&b.0)) {
                Some((least, k)) if least < self.lead => pairs.remove(k),
                _ => break,
            };
        }
        let strong = self.independent_pairs(pairs);
        if self.of(pairs) - self.of(&strong) < self.lead { strong } else { pairs.clone() }
    }

    /// Pairs that are likely on their own, and those that these make likely.
    fn independent_pairs<const M: usize>(&self, pairs: &[(usize, usize)]) -> Vec<(usize, usize)>
    where
        P: Pairing<M>,
    {
        let (mut strong, mut weak) = (Vec::new(), pairs.to_vec());
        loop {
            let known = self.of(&strong);
            let helped = |pair: &(usize, usize)| {
                let more: Vec<_> = strong.iter().chain([pair]).copied().collect();
                self.of(&more) - known >= self.lead
            };
            let (new, rest): (Vec<_>, Vec<_>) = weak.iter().partition(|pair| helped(pair));
            if new.is_empty() {
                return strong;
            }
            strong.extend(new);
            weak = rest;
        }
    }

    /// Logarithm of the likelihood of all pairs together over that of as many chances.
    fn of<const M: usize>(&self, pairs: &[(usize, usize)]) -> f64
    where
        P: Pairing<M>,
    {
        let mut joint = JointInnovation::<M>::default();
        let mut chance = 0.0;
        for &pair in pairs {
            if !joint.push(self.pairing, pair) {
                return f64::NEG_INFINITY;
            }
            chance += self.pairing.elsewhere(pair.0).max(f64::MIN_POSITIVE).ln();
        }
        joint.log_likelihood() - chance
    }
}

fn without(pairs: &[(usize, usize)], k: usize) -> Vec<(usize, usize)> {
    let others = pairs.iter().enumerate().filter(|(other, _)| *other != k);
    others.map(|(_, pair)| *pair).collect()
}
