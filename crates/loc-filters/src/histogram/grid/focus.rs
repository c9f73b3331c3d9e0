//! Where the fine grid looks: it is opened at the most likely place, and takes over from the coarse
//! grid what lies within its reach.

use super::belief::Belief;
use super::correct::Correction;
use super::moments::Sums;
use super::scan::Scan;
use super::sensor::Sensor;
use super::settings::{FineSettings, GridSettings};
use super::space::PoseSpace;
use super::stack::Stack;
use super::window::{Place, Window};
use crate::Result;
use loc_core::{Gaussian, Pose2, angle};
use std::collections::BTreeMap;

/// The places about the most likely cell of the coarse grid, as far as a fine grid reaches.
#[derive(Debug, Clone, Copy)]
pub(super) struct Peak {
    /// Their probability.
    pub(super) share: f64,
    /// Their mean and covariance.
    pub(super) gaussian: Gaussian<3>,
    /// The pose of the most likely cell.
    middle: Pose2,
}

impl Peak {
    /// The place about the most likely cell of those that `is_open` lets count; `None` where these
    /// hold nothing.
    fn among(
        stack: &Stack,
        space: &PoseSpace,
        settings: &FineSettings,
        is_open: impl Fn(Pose2) -> bool,
    ) -> Option<Self> {
        let open = || {
            let cells = stack.cells().map(|(layer, place, mass)| (space.pose(layer, place), mass));
            cells.filter(|(pose, _)| is_open(*pose))
        };
        let (middle, _) = open().reduce(|best, cell| if cell.1 > best.1 { cell } else { best })?;
        let near = || open().filter(|(pose, _)| is_within(*pose, middle, settings));
        let (cell, sector) = (space.squares().resolution(), space.heading_step());
        let (share, gaussian) = Sums::gaussian(near, cell, sector)?;
        Some(Peak { share, gaussian, middle })
    }

    /// `None` for a grid that holds nothing.
    pub(super) fn of(stack: &Stack, space: &PoseSpace, settings: &FineSettings) -> Option<Self> {
        Peak::among(stack, space, settings, |_| true)
    }

    /// Up to `most` places that do not overlap, the most likely cells first.
    pub(super) fn several(
        stack: &Stack,
        space: &PoseSpace,
        settings: &FineSettings,
        most: usize,
    ) -> Vec<Self> {
        let mut peaks: Vec<Peak> = Vec::new();
        while peaks.len() < most {
            let is_open =
                |pose: Pose2| peaks.iter().all(|peak| !is_within(pose, peak.middle, settings));
            let Some(peak) = Peak::among(stack, space, settings, is_open) else { break };
            peaks.push(peak);
        }
        peaks
    }
}

fn is_within(pose: Pose2, middle: Pose2, settings: &FineSettings) -> bool {
    (pose.x - middle.x).abs() <= settings.reach
        && (pose.y - middle.y).abs() <= settings.reach
        && angle::difference(pose.theta, middle.theta).abs() <= settings.turn
}

impl Belief {
    /// Lets the fine grid take over what the coarse one has within its reach, after a correction
    /// with `scan`; moves it to another place where that is more likely.
    pub(super) fn focus(
        &mut self,
        correction: &Correction,
        scan: &Scan,
        sensor: &Sensor,
        space: &PoseSpace,
        settings: &GridSettings,
    ) -> Result<()> {
        let mut fine: Option<Vec<f64>> = None;
        let peak = Peak::of(&self.stack, space, &settings.fine);
        let followed = self.in_window();
        if let Some(peak) =
            peak.filter(|p| p.share >= settings.fine.from_share && p.share > followed)
        {
            self.close_window(space);
            let window = Window::at(peak.gaussian.pose(), &settings.fine)?;
            fine = Some(sensor.rate_window(&window, scan));
            self.window = Some(window);
        }
        let likelihoods = fine.as_ref().unwrap_or(&correction.fine);
        self.absorb(likelihoods, space);
        self.recenter()
    }

    /// Moves what the coarse grid has within the reach of the fine one into that.
    fn absorb(&mut self, log_likelihoods: &[f64], space: &PoseSpace) {
        let Some(window) = self.window.as_mut() else { return };
        let within: BTreeMap<Place, f64> = self
            .stack
            .cells()
            .filter(|(layer, place, _)| window.cell_of(space.pose(*layer, *place)).is_some())
            .map(|(layer, place, mass)| ((layer, place), mass))
            .collect();
        if within.is_empty() {
            return;
        }
        let highest = log_likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let layer_length = window.stack().size().layer();
        let left = window.absorb(&within, space, |layer, place| {
            (log_likelihoods[layer * layer_length + place] - highest).exp()
        });
        self.stack.change(|layer, place, mass| {
            let taken = within.contains_key(&(layer, place)) && !left.contains(&(layer, place));
            if taken { 0.0 } else { mass }
        });
    }

    fn recenter(&mut self) -> Result<()> {
        let Some(window) = self.window.as_mut() else { return Ok(()) };
        let before = window.stack().total();
        if let Some(gaussian) = window.gaussian() {
            window.recenter(gaussian.pose())?;
        }
        self.anywhere += (before - window.stack().total()).max(0.0);
        Ok(())
    }
}
