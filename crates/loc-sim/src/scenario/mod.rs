//! Scenarios: what is simulated, with which sensors, and which methods run on it.
//!
//! A scenario is a TOML file; the built-in ones are files of the same kind, compiled in, so any
//! of them can be printed, changed and run. Numbers are in SI units and radians; an angle may also be a
//! text, `'6 deg'`.
//!
//! ```
//! use loc_sim::scenario::{self, Scenario};
//! let scenario = Scenario::named("circle-drive", &["seed=7".into()])?;
//! let run = scenario.run(None, None, &mut |_share| {})?;
//! assert_eq!(run.truth.len(), 141);
//! # Ok::<(), loc_sim::Error>(())
//! ```

pub mod builtin;
pub mod recording;
mod sensor;

pub use recording::RecordingConfig;
pub use sensor::SensorConfig;

use crate::demonstration::{Demonstration, DemonstrationConfig};
use crate::localizer::{Method, MethodSettings};
use crate::output::Illustration;
use crate::probability_map::{ProbabilityMap, ProbabilityMapConfig};
use crate::record::Run;
use crate::runner::{Observer, ProgressObserver};
use crate::source::drive::DriveConfig;
use crate::source::outdoor::OutdoorConfig;
use crate::source::rail::RailConfig;
use crate::source::tour::TourConfig;
use crate::source::{SimulatedDrive, SimulatedOutdoor, SimulatedRail, SimulatedTour, Source};
use crate::{Error, Result, config, runner};
use loc_filters::RobotSettings;
use serde::Deserialize;
use std::path::Path;
use toml::Table;

/// A scenario, as its TOML file says.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Its name; also that of its output folder.
    pub name: String,
    /// What is to be seen, in one line.
    pub title: String,
    /// The methods of the lectures that it shows.
    #[serde(default)]
    pub ids: Vec<String>,
    /// Seed of all randomness.
    pub seed: u64,
    /// The methods to run, by name.
    #[serde(default)]
    pub methods: Vec<String>,
    /// A robot among landmarks. One of this and the following.
    pub drive: Option<DriveConfig>,
    /// A vehicle on a rail.
    pub rail: Option<RailConfig>,
    /// A robot with a laser in a building.
    pub tour: Option<TourConfig>,
    /// A robot outdoors, with sensors that fall silent.
    pub outdoor: Option<OutdoorConfig>,
    /// A scan that is rated everywhere; no method runs on it.
    pub probability_map: Option<ProbabilityMapConfig>,
    /// What a method does inside; no method runs on it.
    pub demonstration: Option<DemonstrationConfig>,
    /// A sensor that measures once, or along a drive; no method runs on it.
    pub sensor: Option<SensorConfig>,
    /// Settings of the methods, a part of [`MethodSettings`]; what is left out follows the simulated
    /// sensors.
    #[serde(default)]
    pub filter: Table,
    /// Number of threads of the methods that can use several, in place of that of `filter`.
    #[serde(skip)]
    pub threads: Option<usize>,
    /// Whether the run is to compare the methods: those that can search run a second time without
    /// a start pose, and the table tells what each of them needs.
    #[serde(default)]
    pub compare: bool,
    /// The name of a left-handed frame in which final poses are printed as well: `kurt2`.
    pub also_in_frame: Option<String>,
}

/// What a scenario simulates.
enum Kind<'a> {
    Drive(&'a DriveConfig),
    Rail(&'a RailConfig),
    Tour(&'a TourConfig),
    Outdoor(&'a OutdoorConfig),
    ProbabilityMap(&'a ProbabilityMapConfig),
    Demonstration(&'a DemonstrationConfig),
    Sensor(&'a SensorConfig),
}

impl Scenario {
    /// A built-in scenario, with changes of the form `key.subkey=value`.
    ///
    /// # Errors
    /// [`Error::UnknownName`], and [`Error::Config`] for changes that do not fit.
    pub fn named(name: &str, changes: &[String]) -> Result<Self> {
        Scenario::parse(&format!("scenario {name}"), builtin::text(name)?, changes)
    }

    /// A scenario from a TOML file, with changes.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`], and [`Error::Config`] with line and key.
    pub fn read(file: &Path, changes: &[String]) -> Result<Self> {
        let text = std::fs::read_to_string(file).map_err(loc_core::Error::io(file))?;
        Scenario::parse(&file.display().to_string(), &text, changes)
    }

    /// A scenario from TOML text; `file` is only named in errors.
    ///
    /// # Errors
    /// [`Error::Config`] with line and key.
    pub fn parse(file: &str, text: &str, changes: &[String]) -> Result<Self> {
        let changes = Scenario::in_full(file, text, changes)?;
        config::check_filter(file, text, &changes)?;
        let scenario: Scenario = config::parse(file, text, &changes)?;
        scenario.check().map_err(|error| config::error(file, &error.to_string()))?;
        Ok(scenario)
    }

    /// Changes with their keys in full: a few settings have short names, and the name of what is
    /// simulated may be left out (`laser.every` for `tour.laser.every`).
    ///
    /// # Errors
    /// [`Error::Config`] for text that is no TOML.
    pub(crate) fn in_full(file: &str, text: &str, changes: &[String]) -> Result<Vec<String>> {
        if changes.is_empty() {
            return Ok(Vec::new());
        }
        Ok(expand(&config::table(file, text, &[])?, changes))
    }

    fn check(&self) -> Result<()> {
        let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
        if self.name.is_empty() || !self.name.chars().all(plain) {
            let expected = "a name of letters, digits, `-` and `_`";
            return Err(config::field("name", expected, &self.name));
        }
        if self.also_in_frame.as_deref().is_some_and(|frame| frame != "kurt2") {
            let found = self.also_in_frame.clone().unwrap_or_default();
            return Err(config::field("also_in_frame", "kurt2", &found));
        }
        self.method_list()?;
        match self.kind()? {
            Kind::Drive(drive) => drive.check()?,
            Kind::Rail(_) if !self.filter.is_empty() => {
                return Err(config::field("filter", "none for a vehicle on a rail", "one"));
            }
            Kind::Rail(rail) => rail.check()?,
            Kind::Tour(tour) => tour.check()?,
            Kind::Outdoor(outdoor) => outdoor.check()?,
            Kind::ProbabilityMap(map) => map.check()?,
            Kind::Demonstration(demonstration) => demonstration.check()?,
            Kind::Sensor(sensor) => sensor.check()?,
        }
        self.settings().map(|_| ())
    }

    /// The one thing that the scenario simulates.
    fn kind(&self) -> Result<Kind<'_>> {
        let kinds = [
            self.drive.as_ref().map(Kind::Drive),
            self.rail.as_ref().map(Kind::Rail),
            self.tour.as_ref().map(Kind::Tour),
            self.outdoor.as_ref().map(Kind::Outdoor),
            self.probability_map.as_ref().map(Kind::ProbabilityMap),
            self.demonstration.as_ref().map(Kind::Demonstration),
            self.sensor.as_ref().map(Kind::Sensor),
        ];
        let mut given = kinds.into_iter().flatten();
        match (given.next(), given.next()) {
            (Some(kind), None) => Ok(kind),
            (first, _) => {
                let found = if first.is_some() { "several" } else { "none" };
                Err(config::field(
                    "drive, rail, tour, outdoor, probability_map, demonstration, sensor",
                    "one of them",
                    found,
                ))
            }
        }
    }

    /// The methods that the scenario asks for.
    ///
    /// # Errors
    /// [`Error::UnknownName`].
    pub fn method_list(&self) -> Result<Vec<Method>> {
        self.methods.iter().map(|name| name.parse()).collect()
    }

    /// The simulated source under a seed.
    ///
    /// # Errors
    /// What a checked scenario cannot have; kept for scenarios that were built by hand.
    pub fn source(&self, seed: u64) -> Result<Box<dyn Source>> {
        Ok(match self.kind()? {
            Kind::Drive(drive) => Box::new(SimulatedDrive::new(&self.name, drive, seed)?),
            Kind::Rail(rail) => Box::new(SimulatedRail::new(&self.name, rail, seed)?),
            Kind::Tour(tour) => Box::new(SimulatedTour::new(&self.name, tour, seed)?),
            Kind::Outdoor(outdoor) => Box::new(SimulatedOutdoor::new(&self.name, outdoor, seed)?),
            Kind::ProbabilityMap(_) => return Err(self.unmoved("probability_map")),
            Kind::Demonstration(_) => return Err(self.unmoved("demonstration")),
            Kind::Sensor(_) => return Err(self.unmoved("sensor")),
        })
    }

    fn unmoved(&self, found: &str) -> Error {
        config::field(&self.name, "a scenario with a robot that moves", found)
    }

    /// The settings of the methods.
    ///
    /// # Errors
    /// Settings out of range.
    pub fn settings(&self) -> Result<MethodSettings> {
        let robot = match self.kind()? {
            Kind::Drive(drive) => drive.robot()?,
            Kind::Tour(tour) => tour.robot()?,
            Kind::Outdoor(outdoor) => outdoor.robot()?,
            _ => RobotSettings::default(),
        };
        let mut settings = MethodSettings::of(robot);
        match self.kind()? {
            Kind::Outdoor(outdoor) => settings.fusion = outdoor.fusion(settings.fusion)?,
            Kind::Tour(tour) => {
                let extractor = &mut settings.line_matching.extractor;
                extractor.noise = tour.laser.scanner()?.spec.noise;
                // Walls of cells are smooth, and simulated beams go where they should.
                (extractor.roughness, extractor.angle_sigma) = (0.0, 0.0);
            }
            _ => {}
        }
        let mut settings = settings.overlaid(&self.filter)?;
        if let Some(threads) = self.threads {
            settings.mcl.threads = threads;
            settings.landmark_mcl.threads = threads;
            settings.fastslam.threads = threads;
        }
        let rail = self.rail.as_ref().map(RailConfig::settings).unwrap_or_default();
        Ok(MethodSettings { rail, seed: self.seed, also_global: self.compare, ..settings })
    }

    /// Changes a setting of the methods, as `--set filter.KEY=VALUE` does on the command line.
    ///
    /// # Errors
    /// [`Error::Config`] for text that is no `KEY=VALUE`, and for settings that are not valid.
    pub fn set_filter(&mut self, change: &str) -> Result<()> {
        config::change(&mut self.filter, change)?;
        self.settings().map(|_| ())
    }

    /// What a scenario shows that needs no method; `None` for one that [`run`](Scenario::run) is
    /// for.
    ///
    /// # Errors
    /// Values that do not fit the building.
    pub fn illustrate(&self, seed: u64) -> Result<Option<Illustration>> {
        Ok(match self.kind()? {
            Kind::ProbabilityMap(config) => {
                Some(ProbabilityMap::new(config, seed)?.illustrate(&self.title, config))
            }
            Kind::Demonstration(demonstration) => Some(demonstration.run(&self.title, seed)?),
            Kind::Sensor(sensor) => Some(sensor.illustrate(seed)?),
            Kind::Drive(_) | Kind::Rail(_) | Kind::Tour(_) | Kind::Outdoor(_) => None,
        })
    }

    /// Runs the scenario, with another seed or other methods where given. `progress` gets the
    /// share that is done.
    ///
    /// # Errors
    /// What the source or a method reports; [`Error::Config`] for a scenario without a robot that
    /// moves.
    pub fn run(
        &self,
        seed: Option<u64>,
        methods: Option<&[Method]>,
        progress: &mut dyn FnMut(f64),
    ) -> Result<Run> {
        self.run_observed(seed, methods, &mut ProgressObserver(progress))
    }

    /// The same with an observer.
    ///
    /// # Errors
    /// As [`run`](Scenario::run).
    pub fn run_observed(
        &self,
        seed: Option<u64>,
        methods: Option<&[Method]>,
        observer: &mut dyn Observer,
    ) -> Result<Run> {
        let seed = seed.unwrap_or(self.seed);
        let mut source = self.source(seed)?;
        let methods = methods.map_or_else(|| self.method_list(), |given| Ok(given.to_vec()))?;
        if methods.is_empty() {
            return Err(Error::UnknownName {
                what: "methods",
                expected: Method::ALL.map(Method::name).join(", "),
                found: String::new(),
            });
        }
        let settings = MethodSettings { seed, ..self.settings()? };
        runner::run_observed(source.as_mut(), &methods, &settings, observer)
    }
}

/// Sections of what is simulated, one of them per scenario.
const KINDS: [&str; 7] =
    ["drive", "rail", "tour", "outdoor", "probability_map", "demonstration", "sensor"];

/// The other sections and keys of a scenario.
const OTHERS: [&str; 8] =
    ["name", "title", "ids", "seed", "methods", "filter", "compare", "also_in_frame"];

/// Short names, with the keys that they stand for.
pub(crate) const NAMES: [(&str, &[&str]); 4] = [
    (
        "filter.particles",
        &[
            "filter.mcl.particles.min_particles",
            "filter.mcl.particles.max_particles",
            "filter.landmark_mcl.particles",
        ],
    ),
    ("laser.sigma", &["laser.sigma"]),
    ("camera.range_sigma", &["camera.noise.range_sigma"]),
    ("camera.bearing_sigma", &["camera.noise.bearing_sigma"]),
];

/// Expands short names of settings in changes of the command line.
///
/// The section of what is simulated may be left out: `laser.every=0.1` stands for
/// `tour.laser.every=0.1` in a scenario with a tour. A few settings have names of their own, see
/// [`NAMES`].
fn expand(config: &Table, changes: &[String]) -> Vec<String> {
    let kind = KINDS.into_iter().find(|kind| config.contains_key(*kind));
    let mut full = Vec::with_capacity(changes.len());
    for change in changes {
        let Some((key, value)) = change.split_once('=') else {
            full.push(change.clone());
            continue;
        };
        let key = key.trim();
        let names = NAMES.iter().find(|(name, _)| *name == key);
        let one = [key];
        for key in names.map_or(one.as_slice(), |(_, keys)| *keys) {
            full.push(format!("{}={value}", within(kind, config, key)));
        }
    }
    full
}

/// A key with the section of the scenario in front, where it is left out.
fn within(kind: Option<&str>, config: &Table, key: &str) -> String {
    let first = key.split('.').next().unwrap_or_default();
    let known = KINDS.contains(&first) || OTHERS.contains(&first) || config.contains_key(first);
    match kind {
        Some(kind) if !known && key.contains('.') => format!("{kind}.{key}"),
        _ => key.to_owned(),
    }
}
