//! Data association: matching observations with known landmarks (H3, I4).
//!
//! Few landmarks carry a number that a sensor can read. Trees, table legs and walls look alike, and the
//! filter has to decide which of the known ones was observed. Each pair of a
//! observation and a landmark has an innovation: how far the two are apart, and how far they may be.
//! A [`Pairing`] computes it; the rules here only compare:
//!
//! * [`Rule::NearestNeighbor`] takes the pairs in order of their distance (NIS), each observation and
//!   each landmark once;
//! * [`Rule::MaximumLikelihood`] takes them in order of their likelihood, so that of two landmarks
//!   at the same distance the one that is known better wins;
//! * [`Rule::JointCompatibility`] searches the largest set of pairs that fit *together*. An
//!   error of the pose displaces all observations alike, and only this rule uses that.
//!
//! A wrong pair does more harm than a missing one. So all three leave an observation out where another
//! landmark, or something that is not in the map, explains it about as well
//! ([`AssociationSettings::min_ratio`], [`Pairing::elsewhere`]).
//!
//! Line maps, landmark maps and SLAM use the same rules through their own [`Pairing`].
//!
//! ```
//! use loc_filters::association::{AssociationSettings, Associator, PairInnovation, Pairing, Rule};
//! use nalgebra::{Matrix1, Vector1};
//!
//! /// Places on a line, measured to 0.1; the robot that measures may itself be off by 1.
//! struct OnALine { seen: [f64; 2], known: [f64; 3] }
//! impl Pairing<1> for OnALine {
//!     fn observations(&self) -> usize { self.seen.len() }
//!     fn landmarks(&self) -> usize { self.known.len() }
//!     fn innovation(&self, observation: usize, landmark: usize) -> Option<PairInnovation<1>> {
//!         let residual = Vector1::new(self.seen[observation] - self.known[landmark]);
//!         Some(PairInnovation { residual, covariance: Matrix1::new(1.01) })
//!     }
//!     fn cross_covariance(&self, _: (usize, usize), _: (usize, usize)) -> Matrix1<f64> {
//!         Matrix1::new(1.0)
//!     }
//! }
//!
//! // Both are seen 0.9 too far to the right, so that the nearest landmark is the wrong one.
//! let line = OnALine { seen: [0.9, 2.4], known: [0.0, 1.5, 3.1] };
//! let trusting = AssociationSettings::default().min_ratio(1.0);
//! let by = |rule| Associator::new(trusting.rule(rule));
//! let nearest = by(Rule::NearestNeighbor)?.associate(&line)?;
//! assert_eq!(nearest.partners, [Some(1), Some(2)]);
//! let joint = by(Rule::JointCompatibility)?.associate(&line)?;
//! assert_eq!(joint.partners, [Some(0), Some(1)]);
//! # Ok::<(), loc_filters::Error>(())
//! ```

mod individual;
mod joint;

use crate::{Gate, Result};
use individual::Candidates;
use nalgebra::{SMatrix, SVector};

/// The innovation of one observation with one landmark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairInnovation<const M: usize> {
    /// What was seen minus what was expected of this landmark, angles wrapped.
    pub residual: SVector<f64, M>,
    /// Its covariance `H P H^T + R`, M x M, positive definite.
    pub covariance: SMatrix<f64, M, M>,
}

/// How well an observation fits a landmark, for observations of `M` numbers.
pub trait Pairing<const M: usize> {
    /// Number of observations.
    fn observations(&self) -> usize;

    /// Number of landmarks.
    fn landmarks(&self) -> usize;

    /// The innovation, were the observation one of this landmark; `None` where that is out of the
    /// question, which a pairing that has a cheap test says without computing more.
    fn innovation(&self, observation: usize, landmark: usize) -> Option<PairInnovation<M>>;

    /// Density of observations like this one, per unit of its `M` numbers, were it not of any landmark
    /// here: where the camera sees all around, one over what it sees. A pair must then be
    /// likelier than that by [`AssociationSettings::min_ratio`]. 0 where everything that can be
    /// seen is known.
    fn elsewhere(&self, _observation: usize) -> f64 {
        0.0
    }

    /// Covariance between the innovations of two pairs (observation, landmark) of different
    /// observations, `H_a P H_b^T`, M x M. Zero unless both depend on the same unknown, such as the
    /// robot's pose; a particle filter, in which each particle has a certain pose, leaves it at zero.
    fn cross_covariance(&self, _a: (usize, usize), _b: (usize, usize)) -> SMatrix<f64, M, M> {
        SMatrix::zeros()
    }
}

/// Which observation is of which landmark.
#[derive(Debug, Clone, PartialEq)]
pub struct Association {
    /// For each observation its landmark, or `None` for one that fits none, or two about equally well.
    /// No landmark occurs twice.
    pub partners: Vec<Option<usize>>,
    /// For each observation the NIS with the landmark that fits it best on its own, whichever observation got that
    /// landmark; infinite where the pairing rules all of them out. It distinguishes an
    /// observation of a new landmark from one whose landmark went to another observation.
    pub nearest: Vec<f64>,
    /// Whether the search was finished. One that ran into its limit returns the best set it has
    /// seen, which is never worse than taking the observations in turn, each with its nearest
    /// landmark that fits those before.
    pub complete: bool,
}

impl Association {
    /// Number of observations that have a landmark.
    pub fn matched(&self) -> usize {
        self.partners.iter().flatten().count()
    }
}

/// A rule of association with its gates, computed once.
#[derive(Debug, Clone, PartialEq)]
pub struct Associator {
    settings: AssociationSettings,
    gate: Gate,
    joint: joint::JointGate,
}

impl Associator {
    /// An associator from its settings.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a gate probability outside (0, 1], and for a ratio below 1.
    pub fn new(settings: AssociationSettings) -> Result<Self> {
        let gate = Gate::probability(settings.gate_probability)?;
        let joint = joint::JointGate::new(settings.gate_probability)?;
        loc_core::error::in_range(
            "least ratio of two likelihoods",
            ">= 1",
            settings.min_ratio,
            |r| r.is_finite() && r >= 1.0,
        )?;
        Ok(Associator { settings, gate, joint })
    }

    /// The settings.
    pub fn settings(&self) -> &AssociationSettings {
        &self.settings
    }

    /// Matches observations with landmarks. Any number of either is fine, none included.
    ///
    /// # Errors
    /// [`crate::Error::NotFinite`] for a residual, [`loc_core::Error::NotACovariance`] for a
    /// covariance that is not positive definite.
    pub fn associate<const M: usize>(&self, pairing: &impl Pairing<M>) -> Result<Association> {
        self.associate_within(pairing, &mut self.settings.search_limit.clone())
    }

    /// The same with a number of hypotheses that several calls share.
    pub(crate) fn associate_within<const M: usize>(
        &self,
        pairing: &impl Pairing<M>,
        budget: &mut usize,
    ) -> Result<Association> {
        let lead = self.settings.min_ratio.ln();
        let candidates = Candidates::new(pairing, &self.gate, lead)?;
        let (partners, complete) = match self.settings.rule {
            Rule::NearestNeighbor => (candidates.greedy(pairing, lead, |fit| fit.nis), true),
            Rule::MaximumLikelihood => {
                (candidates.greedy(pairing, lead, |fit| -fit.log_likelihood), true)
            }
            Rule::JointCompatibility => {
                joint::search(pairing, &candidates, &self.joint, lead, budget)
            }
        };
        Ok(Association { partners, nearest: candidates.nearest, complete })
    }
}

/// How observations are matched with landmarks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Rule {
    /// Pairs in order of their Mahalanobis distance.
    NearestNeighbor,
    /// Pairs in order of their likelihood.
    MaximumLikelihood,
    /// The largest set of pairs that fit together, found by branch and bound: JCBB (Neira and Tardos 2001).
    #[default]
    JointCompatibility,
}

loc_core::settings! {
    /// Settings of an [`Associator`].
    #[derive(Copy)]
    pub struct AssociationSettings {
        /// The rule.
        pub rule: Rule = Rule::JointCompatibility => any;
        /// Share of right pairs (and of right sets of pairs) that the gate lets pass, 1 for no
        /// gate.
        pub gate_probability: f64 = 0.99 => share;
        /// A pair is accepted only if the best set of pairs without it is that many times less
        /// likely; 1 to believe the likelier one, however little. An observation that two landmarks
        /// explain about equally well is better left out than given to the wrong one.
        pub min_ratio: f64 = 10.0 => at_least(1.0);
        /// Maximum number of hypotheses of the joint search for the observations of one moment.
        pub search_limit: usize = 5_000 => at_least(1);
    }
}

impl AssociationSettings {
    /// Number of observations that the joint search takes together; more are taken in groups of this size,
    /// in the order in which they came, each group choosing from the landmarks that are left.
    pub const GROUP: usize = 32;
}
