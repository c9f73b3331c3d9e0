//! Joint compatibility by branch and bound, JCBB (Neira and Tardos 2001).
//!
//! A hypothesis gives each observation a landmark or none. It is extended one observation at a time, and
//! abandoned when its pairs do not fit together, or when it cannot come to more pairs than the
//! best one so far. Whether pairs fit together is a chi-square test on their joint innovation,
//! whose covariance is factorised row by row as the hypothesis grows.

mod evidence;
mod gate;
mod innovation;

pub(super) use gate::JointGate;

use super::candidates::{Candidates, Fit, SLACK};
use super::{AssociationSettings, Pairing};
use innovation::JointInnovation;

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
            let evidence = evidence::Evidence { pairing, lead };
            evidence.drop_unsure(first, &mut search.best.partners);
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
