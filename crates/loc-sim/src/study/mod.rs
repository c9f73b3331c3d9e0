//! Studies: one scenario under many settings and many seeds.
//!
//! One run is a single random sample; the accuracy of a method needs many seeds, and the effect of a
//! setting needs runs that differ in it alone. A study runs every combination of the varied settings
//! (a [`Grid`]) under the same seeds, on all cores, and gives confidence intervals of the figures.
//! Finished runs are kept in a [`journal`], so that an interrupted study continues where it stopped.
//!
//! ```
//! use loc_sim::localizer::Method;
//! use loc_sim::study::{Study, StudyOptions, StudySource};
//! let source = StudySource::named("landmark-drive", &[])?;
//! let vary = vec!["filter.robot.gate_probability=0.9,0.999".parse()?];
//! let options = StudyOptions { runs: 3, vary, methods: vec![Method::Ekf], ..Default::default() };
//! let study = Study::new(source, options)?;
//! let folder = std::env::temp_dir().join(format!("loc-sim-study-{}", std::process::id()));
//! assert!(study.run(&folder, 2, &mut |_progress| true)?);
//! let results = study.results(&folder)?;
//! assert_eq!((results.groups.len(), results.groups[0].runs), (2, 3));
//! # std::fs::remove_dir_all(&folder).map_err(loc_core::Error::io(&folder))?;
//! # Ok::<(), loc_sim::Error>(())
//! ```

mod figures;
mod grid;
pub mod journal;
mod outcome;
pub mod parquet;
mod results;
mod runner;
mod table;

pub use grid::{Axis, AxisValue, Grid, Job, MAX_RUNS};
pub use outcome::{CONFIDENCE, Group, MethodOutcome, RunOutcome, Spread, Success, TIMES};
pub use results::Results;
pub use runner::{StudyProgress, StudySource};
pub use table::table;

use crate::localizer::Method;
use crate::metrics::Alignment;
use crate::scenario::Scenario;
use crate::{Error, Result};
use journal::{Fingerprint, Journal};
use std::path::Path;

/// Up to this many combinations of settings are all checked before the first run.
const CHECKED: usize = 10_000;

/// The options of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyOptions {
    /// Seeds per combination of settings.
    pub runs: u64,
    /// The first seed; the scenario's where left out.
    pub first_seed: Option<u64>,
    /// The settings that are varied.
    pub vary: Vec<Axis>,
    /// The methods; the scenario's where left out.
    pub methods: Vec<Method>,
    /// How estimates are aligned with the frame of the truth.
    pub align: Alignment,
    /// Whether the estimates of Kalman filters are smoothed as well.
    pub smooth: bool,
    /// When a run counts as a success.
    pub success: Success,
    /// Identifies the build of the program, so that runs of different builds are never mixed.
    pub program: String,
}

impl Default for StudyOptions {
    fn default() -> Self {
        StudyOptions {
            runs: 100,
            first_seed: None,
            vary: Vec::new(),
            methods: Vec::new(),
            align: Alignment::default(),
            smooth: false,
            success: Success::default(),
            program: env!("CARGO_PKG_VERSION").to_owned(),
        }
    }
}

/// A study that has been checked and can be run.
#[derive(Debug, Clone)]
pub struct Study {
    source: StudySource,
    scenario: Scenario,
    grid: Grid,
    methods: Vec<Method>,
    /// The names of the records of a run: the methods, then their smoothed forms.
    records: Vec<String>,
    smooth: bool,
    align: Alignment,
    success: Success,
    program: String,
}

impl Study {
    /// A study of a scenario. The settings are checked, all combinations of them unless there are
    /// more than ten thousand.
    ///
    /// # Errors
    /// [`Error::Config`] with the setting that does not fit and what there is instead, for grids
    /// without runs or with too many, and for a scenario without a robot that moves.
    pub fn new(source: StudySource, options: StudyOptions) -> Result<Self> {
        let scenario = source.scenario(&[])?;
        let first_seed = options.first_seed.unwrap_or(scenario.seed);
        let grid = Grid::new(options.vary, first_seed, options.runs)?;
        if scenario.illustrate(first_seed)?.is_some() {
            let expected = "a scenario with a robot that moves";
            return Err(crate::config::field("study", expected, &scenario.name));
        }
        let methods = match options.methods.as_slice() {
            [] => scenario.method_list()?,
            given => given.to_vec(),
        };
        if methods.is_empty() {
            let expected = format!("one of {}", Method::ALL.map(Method::name).join(", "));
            return Err(crate::config::field("--method", &expected, ""));
        }
        if let Some(k) = (1..methods.len()).find(|&k| methods[..k].contains(&methods[k])) {
            let found = format!("{} twice", methods[k]);
            return Err(crate::config::field("--method", "every method once", &found));
        }
        source.check_axes(grid.axes())?;
        if grid.cells() <= CHECKED {
            (0..grid.cells())
                .try_for_each(|cell| source.scenario(&grid.changes(cell)).map(drop))?;
        }
        let StudyOptions { align, smooth, success, program, .. } = options;
        let smooth = smooth || scenario.settings()?.smooth;
        let smoothed = methods.iter().filter(|method| smooth && method.can_smooth());
        let mut records: Vec<String> = methods.iter().map(ToString::to_string).collect();
        records.extend(smoothed.map(|method| format!("{method}-smoothed")));
        Ok(Study { source, scenario, grid, methods, records, smooth, align, success, program })
    }

    /// The scenario as it is without any variation.
    pub fn scenario(&self) -> &Scenario {
        &self.scenario
    }

    /// All combinations of settings and seeds.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The methods.
    pub fn methods(&self) -> &[Method] {
        &self.methods
    }

    /// The names of the records of a run: the methods, then their smoothed forms.
    pub fn records(&self) -> &[String] {
        &self.records
    }

    /// The settings of a combination that are varied, with their values.
    fn settings_of(&self, cell: usize) -> Vec<(String, toml::Value)> {
        let pairs = self.grid.axes().iter().zip(self.grid.place(cell));
        let value = |(axis, k): (&Axis, usize)| {
            axis.values().get(k).map(|value| (axis.key().to_owned(), value.value().clone()))
        };
        pairs.filter_map(value).collect()
    }

    fn fingerprint(&self) -> Result<Fingerprint> {
        let axis = |axis: &Axis| {
            let values: Vec<String> = axis.values().iter().map(|v| v.value().to_string()).collect();
            format!("{}={}", axis.key(), values.join(","))
        };
        Ok(Fingerprint {
            journal: 1,
            program: self.program.clone(),
            scenario: self.source.settings()?,
            vary: self.grid.axes().iter().map(axis).collect(),
            methods: self.records.clone(),
            align: self.align.name().to_owned(),
        })
    }

    /// Opens the journal of this study in a folder, or creates one there.
    ///
    /// # Errors
    /// Those of [`Journal::open`].
    pub fn journal(&self, folder: &Path) -> Result<Journal> {
        Journal::open(folder, &self.fingerprint()?, &self.grid)
    }

    /// Executes the runs that are missing in the folder's journal. `progress` gets the state and
    /// returns whether to continue. Returns whether all runs are done.
    ///
    /// A run in which a method fails is recorded as failed.
    ///
    /// # Errors
    /// Those of [`Journal`]; and errors that affect every run, such as a method without the sensors
    /// that it needs. Finished runs are kept.
    pub fn run(
        &self,
        folder: &Path,
        threads: usize,
        progress: &mut dyn FnMut(StudyProgress) -> bool,
    ) -> Result<bool> {
        let mut journal = self.journal(folder)?;
        runner::complete(&self.grid, &mut journal, threads, &|job| self.one(job), progress)
    }

    /// One run.
    fn one(&self, job: Job) -> Result<RunOutcome> {
        let mut scenario = self.source.scenario(&self.grid.changes(job.cell))?;
        if self.smooth {
            scenario.filter.insert("smooth".into(), true.into());
        }
        let run = scenario.run(Some(job.seed), Some(&self.methods), &mut |_| {});
        match run.and_then(|run| RunOutcome::of(job, &run, self.align)) {
            Ok(outcome) => Ok(outcome),
            Err(
                error @ (Error::Config { .. }
                | Error::Unsuitable { .. }
                | Error::UnknownName { .. }),
            ) => Err(error),
            Err(error) => Ok(RunOutcome::failed(job, &error)),
        }
    }

    /// The figures over all runs that the folder's journal holds.
    ///
    /// # Errors
    /// Those of [`Journal`], and [`Error::UnknownName`] where success is defined by an
    /// unknown figure.
    pub fn results(&self, folder: &Path) -> Result<Results> {
        Results::of(self, &self.journal(folder)?)
    }

    /// Writes the results beside the journal: `runs.csv`, `runs.parquet`,
    /// `times.csv`, `study.json`, figures and `report.html`. `command` is named in the report.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`] and those of [`results`](Study::results).
    pub fn write(&self, folder: &Path, command: &str) -> Result<Results> {
        let journal = self.journal(folder)?;
        let results = Results::of(self, &journal)?;
        results::write(self, &journal, &results, folder, command)?;
        Ok(results)
    }
}
