//! One sensor, simulated in a map and drawn: what does it see here, and how wrong is it?
//!
//! Before a robot is localized one wants to know what it has to go by. [`sense`] puts a sensor of
//! the [list](SENSORS) with one of its data sheets into a map, lets it read once at a pose (what
//! looks at the world) or along a drive through the free space (what feels the robot's motion),
//! and returns figures, the raw readings as CSV, and how far they are from the truth.
//!
//! ```
//! use loc_sim::sense::{Request, sense};
//! let reading = sense(&Request { sensor: "laser".into(), ..Request::default() })?;
//! assert!(reading.folder.text("scan.svg").unwrap().starts_with("<svg"));
//! assert_eq!(reading.summary["results"]["beams"], 1081);
//! # Ok::<(), loc_sim::Error>(())
//! ```

mod compass;
mod drive;
mod encoder;
mod gnss;
mod imu;
mod landmarks;
mod laser;
mod place;
mod radar;
mod recorded;
mod rgbd;
mod sonar;
mod station;
mod wheels;

pub use place::{Place, WORLDS};
pub use recorded::recorded_scan;
pub use station::{Station, Taken};

use crate::output::Folder;
use crate::{Error, Result};
use loc_core::Pose2;
use serde_json::{Map, Value, json};
use std::path::PathBuf;

/// What to simulate, and where.
#[derive(Debug, Clone, Default)]
pub struct Request {
    /// Name of the sensor.
    pub sensor: String,
    /// Name of one of its presets; the first one where left out.
    pub preset: Option<String>,
    /// A map of map_server to stand in.
    pub map: Option<PathBuf>,
    /// Name of a built-in world to stand in, where there is no map; the first one where left out.
    pub world: Option<String>,
    /// Where the robot stands or starts; a place with a view where left out.
    pub pose: Option<Pose2>,
    /// Seed of all random draws.
    pub seed: u64,
    /// Changes to the settings, `key.subkey=value`.
    pub changes: Vec<String>,
}

/// What a sensor has read, ready to be written.
#[derive(Debug, Clone)]
pub struct Reading {
    /// What was simulated, in a line.
    pub title: String,
    /// The figures in the order in which they are told.
    pub results: Vec<(&'static str, Value)>,
    /// The content of `summary.json`.
    pub summary: Value,
    /// All files.
    pub folder: Folder,
}

/// A sensor that can be simulated.
#[derive(Debug)]
pub struct Sensor {
    /// Its name on the command line.
    pub name: &'static str,
    /// What it measures.
    pub about: &'static str,
    /// Names of its data sheets, with what they say.
    pub presets: &'static [(&'static str, &'static str)],
    take: fn(&Station) -> Result<Taken>,
}

/// Every sensor, in the order in which they are listed.
pub static SENSORS: [Sensor; 10] = [
    laser::SENSOR,
    rgbd::SENSOR,
    landmarks::SENSOR,
    sonar::SENSOR,
    radar::SENSOR,
    wheels::SENSOR,
    encoder::SENSOR,
    imu::SENSOR,
    compass::SENSOR,
    gnss::SENSOR,
];

/// Simulates a sensor.
///
/// # Errors
/// [`Error::UnknownName`] for a sensor, preset or world that there is not, [`Error::Config`] for a
/// pose that is not in free space and for settings that do not exist, [`Error::Map`] and
/// [`Error::Core`] for maps that cannot be read and values out of range.
pub fn sense(request: &Request) -> Result<Reading> {
    let (sensor, preset) = request.sensor()?;
    let place = match (&request.map, &request.world) {
        (Some(map), _) => Place::open(map)?,
        (None, Some(world)) => Place::named(world, request.seed)?,
        (None, None) => Place::named(WORLDS[0], request.seed)?,
    };
    let pose = request.pose.map(|pose| place.check(pose)).transpose()?;
    let station =
        Station { preset, place: &place, pose, seed: request.seed, changes: &request.changes };
    let taken = (sensor.take)(&station)?;
    let pose = json!({
        "x_m": taken.pose.x, "y_m": taken.pose.y, "heading_deg": taken.pose.theta.to_degrees(),
    });
    let results: Map<String, Value> =
        taken.results.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
    let summary = json!({
        "sensor": sensor.name, "preset": preset, "world": place.name(), "seed": request.seed,
        "pose": pose, "settings": taken.settings, "results": results,
    });
    let mut folder = taken.folder;
    folder.add("summary.json", format!("{summary:#}\n"));
    let title = format!("{} ({preset}) in {}, at {}", sensor.name, place.name(), taken.pose);
    Ok(Reading { title, results: taken.results, summary, folder })
}

impl Request {
    /// Checks the names, without a simulation.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn check(&self) -> Result<()> {
        self.sensor()?;
        self.world.as_deref().map_or(Ok(0), |world| pick("world", WORLDS.into_iter(), world))?;
        Ok(())
    }

    /// The sensor, and the name of its data sheet.
    fn sensor(&self) -> Result<(&'static Sensor, &'static str)> {
        let names = SENSORS.iter().map(|sensor| sensor.name);
        let sensor = &SENSORS[pick("sensor", names, &self.sensor)?];
        let presets = sensor.presets.iter().map(|(name, _)| *name);
        let preset = self.preset.as_deref().or(presets.clone().next()).unwrap_or_default();
        let (preset, _) = sensor.presets[pick("preset", presets, preset)?];
        Ok((sensor, preset))
    }
}

impl Reading {
    /// The figures for people, a line each.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![self.title.clone()];
        for (name, value) in &self.results {
            let value = match value.as_f64() {
                Some(number) if value.is_f64() => format!("{number:.4}"),
                _ if value.is_null() => "-".to_owned(),
                _ => value.to_string(),
            };
            lines.push(format!("{name:<28} {value:>12}"));
        }
        lines
    }
}

/// The place of a name in a list.
fn pick(
    what: &'static str,
    names: impl Iterator<Item = &'static str> + Clone,
    name: &str,
) -> Result<usize> {
    names.clone().position(|known| known == name).ok_or_else(|| Error::UnknownName {
        what,
        expected: names.collect::<Vec<_>>().join(", "),
        found: name.into(),
    })
}
