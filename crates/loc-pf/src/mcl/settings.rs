//! All settings of Monte Carlo localization, with defaults for most robots.

use super::RangeOffset;
use crate::confidence::LostSettings;
use crate::estimate::ClusterSettings;
use crate::motion::OmnidirectionalNoise;
use crate::novelty::{DistanceFilter, EntropyFilter};
use crate::recovery::{AugmentedSettings, SuspicionSettings};
use crate::sensor::{BeamModelSettings, BeamSkip};
use crate::tempering::TemperingSettings;
use crate::{KldSettings, ResamplePolicy, Resampling};
use loc_core::error::non_negative;
use loc_core::motion::OdometryNoise;
use loc_filters::RobotSettings;
use loc_maps::likelihood_field::LikelihoodFieldSettings;

loc_core::settings! {
    /// Settings of [`Mcl`](crate::Mcl).
    ///
    /// In a file, the parts that may be missing (`novelty`, `tempering`, `recovery.suspicion`,
    /// `recovery.augmented`, `beam_skip`) are tables, or `false` for none and `true` for their
    /// defaults.
    pub struct MclSettings {
        /// The robot and its sensors.
        pub robot: RobotSettings = RobotSettings::default() => check;
        /// The number of particles.
        pub particles: KldSettings = KldSettings::default() => check;
        /// Noise of the odometry.
        pub motion: MotionSettings = MotionSettings::Path => check;
        /// How scans rate poses.
        pub sensor: SensorSettings =
            SensorSettings::LikelihoodField(FieldSettings::default()) => check;
        /// Maximum number of beams of a scan that are used (`max_beams`).
        pub beams: usize = 60 => at_least(1);
        /// As how many independent beams a scan counts, if it has more: its beams see the same
        /// walls, with the same errors of the map.
        pub independent_beams: f64 = 20.0 => positive;
        /// What is added to every range \[m\].
        pub range_offset: RangeOffset = RangeOffset::default() => check;
        /// Drops beams that people or new furniture cut short (K3); `None` for none.
        #[serde(with = "optional")]
        pub novelty: Option<NoveltyFilter> = None => each;
        /// Tempering of narrow likelihoods; `None` for the plain filter, which weights once.
        #[serde(with = "optional")]
        pub tempering: Option<TemperingSettings> = Some(TemperingSettings::default()) => each;
        /// No update before the robot has driven this far \[m\] (`update_min_d`) ..
        pub update_distance: f64 = 0.1 => non_negative;
        /// .. or turned this much \[rad\] (`update_min_a`).
        #[serde(with = "loc_core::settings::angle")]
        pub update_turn: f64 = 0.1 => non_negative;
        /// How the plain filter draws particles.
        pub resampling: Resampling = Resampling::default() => any;
        /// When the plain filter draws particles.
        pub policy: ResamplePolicy = ResamplePolicy::default() => check;
        /// Recovery, and the search at the start.
        pub recovery: RecoverySettings = RecoverySettings::default() => check;
        /// Clustering of the particles.
        pub clusters: ClusterSettings = ClusterSettings::default() => check;
        /// When the robot counts as lost.
        pub lost: LostSettings = LostSettings::default() => check;
        /// Number of threads; the results do not depend on it.
        pub threads: usize = 1 => any;
    }
}

/// Noise of the odometry, by one of the models.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum MotionSettings {
    /// Any drive: variances grow with the distance travelled, and odometry fails occasionally; the
    /// noise is that of the robot's path.
    Path,
    /// A differential drive: turn, drive, turn (`alpha1` to `alpha4`).
    Differential(OdometryNoise),
    /// A drive that moves sideways as well (`alpha1` to `alpha5`).
    Omnidirectional(OmnidirectionalNoise),
}

/// How scans rate poses.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum SensorSettings {
    /// By the distance of each beam's end from the nearest obstacle (M7).
    LikelihoodField(FieldSettings),
    /// By the range that each beam should have (M6).
    Beam(BeamModelSettings),
}

/// A novelty filter, against objects that are not in the map (K3).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum NoveltyFilter {
    /// Drops beams that are very likely shorter than expected by the map.
    Distance(DistanceFilter),
    /// Drops beams that increase the entropy of the belief.
    Entropy(EntropyFilter),
}

loc_core::settings! {
    /// Settings of the likelihood field model.
    #[derive(Copy)]
    pub struct FieldSettings {
        /// The field; its `sigma_hit` is at least 20 times the square of a cell's side \[m\], which
        /// is 0.05 m for cells of 0.05 m and 0.2 m for cells of 0.1 m.
        pub field: LikelihoodFieldSettings = LikelihoodFieldSettings::default() => check;
        /// How the beams of a scan are taken together.
        pub weighting: Weighting = Weighting::Product => any;
        /// Beam skipping: leaves out beams that end on objects that are not in the map.
        #[serde(with = "optional")]
        pub beam_skip: Option<BeamSkip> = None => each;
    }
}

/// How the beams of a scan are taken together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Weighting {
    /// The product of their likelihoods.
    #[default]
    Product,
    /// `1 + sum p^3`, which nav2_amcl's `likelihood_field` computes; for comparison with it.
    SumOfCubes,
}

loc_core::settings! {
    /// How the robot is found again, and found at the start.
    #[derive(Copy)]
    pub struct RecoverySettings {
        /// Searches the whole map for the scan at a start without pose and when the robot may be
        /// elsewhere; without it, such a start spreads particles uniformly.
        pub search: bool = true => any;
        /// When to suspect that the robot is elsewhere; `None` for never.
        #[serde(with = "optional")]
        pub suspicion: Option<SuspicionSettings> = Some(SuspicionSettings::default()) => each;
        /// Random particles by running averages of the evidence; `None` for none.
        #[serde(with = "optional")]
        pub augmented: Option<AugmentedSettings> = None => each;
    }
}

impl Default for NoveltyFilter {
    /// The distance filter, which suits lasers.
    fn default() -> Self {
        NoveltyFilter::Distance(DistanceFilter::default())
    }
}

impl MotionSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn check(&self) -> loc_core::Result<()> {
        match self {
            MotionSettings::Path => Ok(()),
            MotionSettings::Differential(noise) => {
                let OdometryNoise { alpha1, alpha2, alpha3, alpha4 } = *noise;
                for alpha in [alpha1, alpha2, alpha3, alpha4] {
                    non_negative("alpha1 to alpha4 of the odometry", alpha)?;
                }
                Ok(())
            }
            MotionSettings::Omnidirectional(noise) => noise.check(),
        }
    }
}

impl NoveltyFilter {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn check(&self) -> loc_core::Result<()> {
        match self {
            NoveltyFilter::Distance(filter) => filter.check(),
            NoveltyFilter::Entropy(filter) => filter.check(),
        }
    }
}

impl SensorSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn check(&self) -> loc_core::Result<()> {
        match self {
            SensorSettings::LikelihoodField(settings) => settings.check(),
            SensorSettings::Beam(settings) => settings.check(),
        }
    }
}

/// Parts of the filter that can be switched off in a settings file: `tempering = false`.
///
/// TOML has no word for "none", and a key that is left out means the default. So such a part is
/// written as its table, or as `false` (also `"off"`) for none; `true` (also `"on"`) is the part
/// with its defaults.
#[cfg(feature = "serde")]
mod optional {
    use serde::de::value::MapAccessDeserializer;
    use serde::de::{Error, MapAccess, Unexpected, Visitor};
    use serde::{Deserialize, Deserializer, Serialize, Serializer};
    use std::fmt;
    use std::marker::PhantomData;

    pub(super) fn serialize<T, S>(part: &Option<T>, serializer: S) -> Result<S::Ok, S::Error>
    where
        T: Serialize,
        S: Serializer,
    {
        match part {
            Some(part) => part.serialize(serializer),
            None => serializer.serialize_bool(false),
        }
    }

    pub(super) fn deserialize<'de, T, D>(deserializer: D) -> Result<Option<T>, D::Error>
    where
        T: Deserialize<'de> + Default,
        D: Deserializer<'de>,
    {
        deserializer.deserialize_any(Part(PhantomData))
    }

    struct Part<T>(PhantomData<T>);

    impl<'de, T: Deserialize<'de> + Default> Visitor<'de> for Part<T> {
        type Value = Option<T>;

        fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
            formatter.write_str("a table of settings, false (off) or true (the defaults)")
        }

        fn visit_bool<E: Error>(self, is_on: bool) -> Result<Option<T>, E> {
            Ok(is_on.then(T::default))
        }

        fn visit_str<E: Error>(self, text: &str) -> Result<Option<T>, E> {
            match text {
                "off" => Ok(None),
                "on" => Ok(Some(T::default())),
                _ => Err(E::invalid_value(Unexpected::Str(text), &self)),
            }
        }

        /// What other formats than TOML write for nothing.
        fn visit_unit<E: Error>(self) -> Result<Option<T>, E> {
            Ok(None)
        }

        fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<Option<T>, A::Error> {
            T::deserialize(MapAccessDeserializer::new(map)).map(Some)
        }
    }
}
