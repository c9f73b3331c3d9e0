//! The settings of data association.

/// How observations are matched with landmarks.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Rule {
    /// Pairs in order of their Mahalanobis distance.
    NearestNeighbor,
    /// Pairs in order of their likelihood.
    MaximumLikelihood,
    /// The most pairs that fit together, found by branch and bound: JCBB (Neira and Tardos 2001).
    #[default]
    JointCompatibility,
}

/// What an associator can be told.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct AssociationSettings {
    /// The rule.
    pub rule: Rule,
    /// Share of right pairs (and of right sets of pairs) that the gate lets pass, 1 for no gate.
    pub gate_probability: f64,
    /// A pair is believed only if the best set of pairs without it is that many times less likely;
    /// 1 to believe the likelier one, however little. An observation that two landmarks explain about
    /// equally well is better left out than given to the wrong one.
    pub min_ratio: f64,
    /// The most hypotheses that the joint search looks at for the observations of one moment.
    pub search_limit: usize,
}

impl AssociationSettings {
    /// The joint search takes so many observations together; more are taken in groups of this size,
    /// in the order in which they came, each group choosing from the landmarks that are left.
    pub const GROUP: usize = 32;
}

impl Default for AssociationSettings {
    fn default() -> Self {
        AssociationSettings {
            rule: Rule::JointCompatibility,
            gate_probability: 0.99,
            min_ratio: 10.0,
            search_limit: 5_000,
        }
    }
}
