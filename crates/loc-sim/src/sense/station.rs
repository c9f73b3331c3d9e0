//! Where a sensor stands with what settings, and what it brings back.

use super::Place;
use crate::output::{Folder, backdrop};
use crate::{Result, config};
use loc_core::error::finite;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, Twist2};
use loc_plot::Scene;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::fmt::Write;

/// A sensor's place in the world, and its settings.
#[derive(Debug)]
pub struct Station<'a> {
    pub(super) preset: &'static str,
    pub(super) place: &'a Place,
    pub(super) pose: Option<Pose2>,
    pub(super) seed: u64,
    pub(super) changes: &'a [String],
}

/// What a simulation brings back.
#[derive(Debug, Clone)]
pub struct Taken {
    pub(super) pose: Pose2,
    pub(super) settings: Value,
    pub(super) results: Vec<(&'static str, Value)>,
    pub(super) folder: Folder,
}

impl Station<'_> {
    /// The settings of the preset after the changes.
    pub(super) fn settings<T>(&self, preset: T) -> Result<T>
    where
        T: Serialize + DeserializeOwned,
    {
        config::changed(self.preset, preset, self.changes)
    }

    /// The given pose, or the one that suits the sensor best.
    pub(super) fn pose_or(&self, suits: impl FnOnce(&Place) -> Result<Pose2>) -> Result<Pose2> {
        self.pose.map_or_else(|| suits(self.place), Ok)
    }

    /// The generator for the errors of the sensor.
    pub(super) fn errors(&self) -> ChaCha8Rng {
        stream(self.seed, "sensors")
    }

    /// A scene over the map.
    pub(super) fn scene(&self, title: &str, subtitle: &str) -> Scene {
        let scene = Scene::new(title).subtitle(subtitle);
        match backdrop(self.place.grid()) {
            Some(backdrop) => scene.backdrop(backdrop),
            None => scene,
        }
    }
}

impl Taken {
    pub(super) fn new(pose: Pose2, settings: &impl Serialize) -> Self {
        // Numbers that JSON does not know become null; nothing else can go wrong.
        let settings = serde_json::to_value(settings).unwrap_or(Value::Null);
        Taken { pose, settings, results: Vec::new(), folder: Folder::default() }
    }

    /// Adds a figure to tell; numbers that are not finite become null.
    pub(super) fn tell(&mut self, name: &'static str, value: impl Into<Value>) {
        self.results.push((name, value.into()));
    }

    /// Adds a table of numbers; what is no number stays empty.
    pub(super) fn table<const N: usize>(
        &mut self,
        name: &str,
        columns: [&str; N],
        rows: impl IntoIterator<Item = [f64; N]>,
    ) {
        let mut text = columns.join(",") + "\n";
        for row in rows {
            for (k, value) in row.into_iter().enumerate() {
                let comma = if k > 0 { "," } else { "" };
                // Writing to a String cannot fail.
                let _ = match value {
                    value if value.is_nan() => write!(text, "{comma}"),
                    value => write!(text, "{comma}{value}"),
                };
            }
            text.push('\n');
        }
        self.folder.add(name, text);
    }
}

/// Root of the mean square of the numbers that are finite; NaN without any.
pub(super) fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    mean(values.into_iter().map(|value| value * value)).sqrt()
}

/// Mean of the numbers that are finite; NaN without any.
pub(super) fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values.into_iter().filter(|value| value.is_finite()) {
        sum += value;
        count += 1.0;
    }
    sum / count
}

/// Lets a velocity pass that a robot can have.
pub(super) fn check_twist(twist: Twist2) -> Result<()> {
    finite("velocity.vx [m/s]", twist.vx)?;
    finite("velocity.vy [m/s]", twist.vy)?;
    finite("velocity.omega [rad/s]", twist.omega)?;
    Ok(())
}
