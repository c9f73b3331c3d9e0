//! All combinations of settings and seeds.

use super::Axis;
#[cfg(doc)]
use crate::Error;
use crate::Result;
use crate::config::field;

/// The most runs of a study.
pub const MAX_RUNS: u64 = 1_000_000;

/// A grid of settings, each combination of which (a cell) is run under the same seeds: what
/// differs between two cells is then the setting, not the luck.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    axes: Vec<Axis>,
    cells: usize,
    first_seed: u64,
    runs: u64,
}

/// One run of a study.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Job {
    /// The combination of settings, counted from 0.
    pub cell: usize,
    /// The seed.
    pub seed: u64,
}

impl Grid {
    /// All combinations of the values of `axes`, each under `runs` seeds from `first_seed` on.
    ///
    /// # Errors
    /// [`Error::Config`] for no runs, more than [`MAX_RUNS`], seeds beyond 64 bits, and an axis
    /// that comes twice.
    pub fn new(axes: Vec<Axis>, first_seed: u64, runs: u64) -> Result<Self> {
        if runs == 0 {
            return Err(field("--runs", "at least 1", "0"));
        }
        for (k, axis) in axes.iter().enumerate() {
            if axes[..k].iter().any(|other| other.key() == axis.key()) {
                return Err(field("--vary", "every key once", &format!("{} twice", axis.key())));
            }
        }
        let lengths = axes.iter().map(|axis| axis.values().len() as u128);
        let cells = lengths.fold(1_u128, u128::saturating_mul);
        let total = cells.saturating_mul(u128::from(runs));
        if total > u128::from(MAX_RUNS) {
            let found = format!("{cells} settings x {runs} runs = {total}");
            return Err(field("--runs, --vary", &format!("at most {MAX_RUNS} runs"), &found));
        }
        if first_seed.checked_add(runs - 1).is_none() {
            let found = format!("{runs} seeds from {first_seed} on");
            return Err(field("--seed", &format!("seeds up to {}", u64::MAX), &found));
        }
        // At most MAX_RUNS.
        Ok(Grid { axes, cells: cells as usize, first_seed, runs })
    }

    /// The settings that are varied.
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// How many combinations of settings there are.
    pub fn cells(&self) -> usize {
        self.cells
    }

    /// How many seeds each is run under.
    pub fn runs(&self) -> u64 {
        self.runs
    }

    /// The first of the seeds.
    pub fn first_seed(&self) -> u64 {
        self.first_seed
    }

    /// How many runs there are.
    pub fn len(&self) -> usize {
        self.cells * self.runs as usize
    }

    /// Whether there are none, which [`Grid::new`] does not allow.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The run of a number, counted from 0: cell by cell, seed by seed.
    pub fn job(&self, index: usize) -> Job {
        let runs = self.runs as usize;
        Job { cell: index / runs, seed: self.first_seed + (index % runs) as u64 }
    }

    /// The number of a run; `None` for one that is not in the grid.
    pub fn index(&self, job: Job) -> Option<usize> {
        let offset = job.seed.checked_sub(self.first_seed).filter(|offset| *offset < self.runs)?;
        (job.cell < self.cells).then(|| job.cell * self.runs as usize + offset as usize)
    }

    /// Which value each axis has in a cell; the last axis runs fastest.
    pub fn place(&self, cell: usize) -> Vec<usize> {
        let mut rest = cell;
        let mut place: Vec<usize> = self
            .axes
            .iter()
            .rev()
            .map(|axis| {
                let count = axis.values().len();
                let k = rest % count;
                rest /= count;
                k
            })
            .collect();
        place.reverse();
        place
    }

    /// The changes of the configuration that make a cell.
    pub fn changes(&self, cell: usize) -> Vec<String> {
        let pairs = self.axes.iter().zip(self.place(cell));
        pairs.map(|(axis, k)| axis.change(k)).collect()
    }
}
