//! The settings of all methods.

use crate::{Result, config};
use loc_filters::RobotSettings;
use loc_filters::fusion::FusionSettings;
use loc_filters::histogram::GridSettings;
use loc_filters::kalman::rail::RailSettings;
use loc_filters::lateration::SlidingSettings;
use loc_filters::line_matching::LineMatchingSettings;
use loc_filters::slam::SlamSettings;
use loc_pf::{FastSlamSettings, LandmarkMclSettings, MclSettings};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

/// Settings of all methods: the section `[filter]` of a scenario or recording.
///
/// The robot is given once, in `robot`, and every method has a copy of it: [`MethodSettings::of`]
/// makes the copies, and a file may change one of them (`[filter.slam.robot]`).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MethodSettings {
    /// The robot and its sensors.
    pub robot: RobotSettings,
    /// For matching lines of scans with those of a map.
    pub line_matching: LineMatchingSettings,
    /// For the particle filter in a map.
    pub mcl: MclSettings,
    /// For the particle filter among landmarks.
    pub landmark_mcl: LandmarkMclSettings,
    /// For the grid over the poses in a map.
    pub histogram: GridSettings,
    /// For lateration.
    pub lateration: SlidingSettings,
    /// For `fusion`.
    pub fusion: FusionSettings,
    /// For `ekf-slam` and `kf-slam`.
    pub slam: SlamSettings,
    /// For `fastslam`.
    pub fastslam: FastSlamSettings,
    /// Whether methods that can search start without a pose.
    pub global: bool,
    /// Whether the estimates of Kalman filters are smoothed after the run, beside those that they
    /// had during it.
    pub smooth: bool,
    /// For a vehicle on a rail.
    #[serde(skip)]
    pub rail: RailSettings,
    /// Whether methods that can search run a second time without a start pose, beside their run
    /// from the start.
    #[serde(skip)]
    pub also_global: bool,
    /// Seed of the methods that draw random numbers.
    #[serde(skip)]
    pub seed: u64,
}

/// The sections of methods that have a copy of the robot.
const WITH_ROBOT: [&str; 8] = [
    "line_matching",
    "mcl",
    "landmark_mcl",
    "histogram",
    "lateration",
    "fusion",
    "slam",
    "fastslam",
];

impl MethodSettings {
    /// The defaults for a robot.
    pub fn of(robot: RobotSettings) -> Self {
        MethodSettings::default().with_robot(robot)
    }

    /// The same settings for another robot.
    #[must_use]
    pub fn with_robot(self, robot: RobotSettings) -> Self {
        MethodSettings {
            robot,
            line_matching: self.line_matching.robot(robot),
            mcl: self.mcl.robot(robot),
            landmark_mcl: self.landmark_mcl.robot(robot),
            histogram: self.histogram.robot(robot),
            lateration: self.lateration.robot(robot),
            fusion: self.fusion.robot(robot),
            slam: self.slam.robot(robot),
            fastslam: self.fastslam.robot(robot),
            ..self
        }
    }

    /// These settings with what a section `[filter]` gives put over them.
    ///
    /// # Errors
    /// [`crate::Error::Config`] for unknown keys and other types, [`loc_core::Error::OutOfRange`]
    /// for values that are not allowed.
    pub fn overlaid(&self, filter: &Table) -> Result<Self> {
        let wrong = |error: &dyn std::fmt::Display| config::error("filter", &error.to_string());
        let mut given = filter.clone();
        if let Some(Value::Table(robot)) = filter.get("robot") {
            for section in WITH_ROBOT {
                let section = given.entry(section).or_insert_with(|| Table::new().into());
                let Value::Table(section) = section else { continue };
                let mut merged = Value::Table(robot.clone());
                if let Some(own) = section.remove("robot") {
                    put_over(&mut merged, own, false);
                }
                section.insert("robot".into(), merged);
            }
        }
        let mut all = Value::try_from(self).map_err(|e| wrong(&e))?;
        put_over(&mut all, Value::Table(given), true);
        let read: MethodSettings =
            all.try_into().map_err(|e: toml::de::Error| wrong(&e.message()))?;
        read.check()?;
        let MethodSettings { rail, also_global, seed, .. } = self.clone();
        Ok(MethodSettings { rail, also_global, seed, ..read })
    }

    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] with the name of the first that is not allowed.
    pub fn check(&self) -> Result<()> {
        self.robot.check()?;
        self.line_matching.check()?;
        self.mcl.check()?;
        self.landmark_mcl.check()?;
        self.histogram.check()?;
        self.lateration.check()?;
        self.fusion.check()?;
        self.slam.check()?;
        self.fastslam.check()?;
        Ok(())
    }

    /// The section `[filter]` that gives all of these settings, with the robot once.
    ///
    /// # Errors
    /// [`crate::Error::Config`] for a number that TOML has no form for.
    pub fn to_toml(&self) -> Result<String> {
        let wrong = |error: &toml::ser::Error| config::error("filter", &error.to_string());
        let mut filter = Table::try_from(self).map_err(|e| wrong(&e))?;
        let robot = filter.get("robot").cloned();
        for section in WITH_ROBOT {
            let Some(Value::Table(section)) = filter.get_mut(section) else { continue };
            let (Some(Value::Table(own)), Some(Value::Table(all))) =
                (section.get_mut("robot"), &robot)
            else {
                continue;
            };
            own.retain(|key, value| all.get(key) != Some(value));
            if own.is_empty() {
                section.remove("robot");
            }
        }
        let mut whole = Table::new();
        whole.insert("filter".into(), filter.into());
        toml::to_string(&whole).map_err(|e| wrong(&e))
    }
}

/// Puts the values of one table over those of another, key by key.
///
/// Where the other is whole (`has_choices`), a table with a single key is a choice of one among
/// several (`{ cauchy = 2.385 }`), and another choice takes its place.
fn put_over(to: &mut Value, from: Value, has_choices: bool) {
    match (to, from) {
        (Value::Table(to), Value::Table(from)) => {
            let is_choice = has_choices && to.len() == 1 && from.len() == 1;
            if is_choice && from.keys().any(|key| !to.contains_key(key)) {
                *to = from;
                return;
            }
            for (key, value) in from {
                match to.get_mut(&key) {
                    Some(inner) => put_over(inner, value, has_choices),
                    None => {
                        to.insert(key, value);
                    }
                }
            }
        }
        (to, from) => *to = from,
    }
}
