//! One sensor, simulated in a map and drawn: what does it measure here, and with what errors?
//!
//! [`sense`] puts a sensor of the [list](SENSORS) with one of its data sheets into a map. It measures
//! once at a pose (what observes the world) or along a drive through the free space (what measures
//! the robot's motion). The result holds figures, the raw measurements as CSV, and their errors.
//!
//! ```
//! use loc_sim::sense::{Request, sense};
//! let reading = sense(&Request { sensor: "laser".into(), ..Request::default() })?;
//! assert!(reading.folder.text("scan.svg").unwrap().starts_with("<svg"));
//! assert_eq!(reading.summary["results"]["beams"], 1081);
//! # Ok::<(), loc_sim::Error>(())
//! ```

mod drive;
mod gnss;
mod imu;
mod landmarks;
mod laser;
mod place;
mod radar;
mod rgbd;
mod sonar;
mod wheels;

pub use laser::recorded_scan;
pub use place::{Place, WORLDS};

use crate::output::{Folder, backdrop};
use crate::{Error, Result, config};
use drive::{Drive, DriveSettings};
use loc_core::error::finite;
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::{Pose2, Twist2};
use loc_plot::{Role, Scene};
use nalgebra::Point2;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};
use std::ops::RangeInclusive;
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

/// What a sensor measures, ready to be written.
#[derive(Debug, Clone)]
pub struct Reading {
    /// What was simulated, in a line.
    pub title: String,
    /// The results in the order in which they are printed.
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
    wheels::ENCODER,
    imu::SENSOR,
    imu::COMPASS,
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

/// The sensor in its world, with its settings.
struct Station<'a> {
    preset: &'static str,
    place: &'a Place,
    pose: Option<Pose2>,
    seed: u64,
    changes: &'a [String],
}

impl Station<'_> {
    /// The settings of the preset after the changes.
    fn settings<T: Serialize + DeserializeOwned>(&self, preset: T) -> Result<T> {
        config::changed(self.preset, preset, self.changes)
    }

    /// The given pose, or the one that suits the sensor best.
    fn pose_or(&self, suits: impl FnOnce(&Place) -> Result<Pose2>) -> Result<Pose2> {
        self.pose.map_or_else(|| suits(self.place), Ok)
    }

    /// Drives from the given pose, or from the widest place of the map.
    fn drive(&self, settings: &DriveSettings) -> Result<Drive> {
        settings.drive(self.place, self.pose_or(Place::middle)?)
    }

    /// The generator for the errors of the sensor.
    fn errors(&self) -> ChaCha8Rng {
        stream(self.seed, "sensors")
    }

    /// A scene over the map; the subtitle names the preset and the world, and adds a note.
    fn scene(&self, title: &str, note: &str) -> Scene {
        let colon = if note.is_empty() { "" } else { ": " };
        let subtitle = format!("{} in {}{colon}{note}", self.preset, self.place.name());
        let scene = Scene::new(title).subtitle(subtitle);
        match backdrop(self.place.grid()) {
            Some(backdrop) => scene.backdrop(backdrop),
            None => scene,
        }
    }

    /// The edges of a field of view, up to the walls or to `reach` \[m\].
    fn field_of_view(&self, scene: Scene, eye: Pose2, fov: f64, reach: f64) -> Scene {
        let edges = [-1.0, 1.0].map(|side| {
            let edge = Pose2::new(eye.x, eye.y, eye.theta + 0.5 * side * fov);
            let end = edge.transform(&Point2::new(self.place.range(edge, reach), 0.0));
            ((eye.x, eye.y), xy(end))
        });
        scene.segments(Role::Reference.dashed().width(1.0), "field of view", edges)
    }
}

/// What a simulation gives.
struct Taken {
    pose: Pose2,
    settings: Value,
    results: Vec<(&'static str, Value)>,
    folder: Folder,
}

impl Taken {
    fn new(pose: Pose2, settings: &impl Serialize) -> Self {
        // Numbers that JSON does not know become null; nothing else can go wrong.
        let settings = serde_json::to_value(settings).unwrap_or(Value::Null);
        Taken { pose, settings, results: Vec::new(), folder: Folder::default() }
    }

    /// Adds a result; numbers that are not finite become null.
    fn tell(&mut self, name: &'static str, value: impl Into<Value>) {
        self.results.push((name, value.into()));
    }

    /// Adds a table of numbers.
    fn table<const N: usize>(
        &mut self,
        name: &str,
        columns: [&str; N],
        rows: impl IntoIterator<Item = [f64; N]>,
    ) {
        self.folder.add(name, csv(columns, rows));
    }
}

/// A table of numbers as CSV; what is no number stays empty.
fn csv<const N: usize>(columns: [&str; N], rows: impl IntoIterator<Item = [f64; N]>) -> String {
    let cell = |value: f64| if value.is_nan() { String::new() } else { value.to_string() };
    let rows = rows.into_iter().map(|row| row.map(cell).join(",") + "\n");
    columns.join(",") + "\n" + &rows.collect::<String>()
}

/// Checks how many of something there are.
fn check_count(
    key: &str,
    expected: &str,
    range: RangeInclusive<usize>,
    count: usize,
) -> Result<()> {
    if range.contains(&count) {
        return Ok(());
    }
    Err(config::field(key, expected, &count.to_string()))
}

/// Checks a velocity.
fn check_twist(twist: Twist2) -> Result<()> {
    finite("velocity.vx [m/s]", twist.vx)?;
    finite("velocity.vy [m/s]", twist.vy)?;
    finite("velocity.omega [rad/s]", twist.omega)?;
    Ok(())
}

/// Root of the mean square of the numbers that are finite; NaN without any.
fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    mean(values.into_iter().map(|value| value * value)).sqrt()
}

/// Mean of the numbers that are finite; NaN without any.
fn mean(values: impl IntoIterator<Item = f64>) -> f64 {
    let finite = values.into_iter().filter(|value| value.is_finite());
    let (sum, count) = finite.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// The coordinates of a point, as figures want them.
fn xy(point: Point2<f64>) -> (f64, f64) {
    (point.x, point.y)
}
