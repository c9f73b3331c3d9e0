//! `histogram`: Markov localization with a laser on a grid over (x, y, heading) (K1).

use super::{Estimate, Hypothesis, Judgement, Localizer, MethodSettings, PlaceBelief};
use crate::source::Setup;
use crate::{Error, Result};
use loc_core::Pose2;
use loc_filters::histogram::{GridLocalizer, GridUpdate};
use loc_sensors::event::{Control, Measurement};

/// How many places are told, the likeliest ones.
const HYPOTHESES: usize = 5;

#[derive(Debug)]
pub(super) struct Histogram {
    grid: GridLocalizer,
    odometry: Pose2,
    /// Whether the last input changed the belief.
    is_new: bool,
}

impl Histogram {
    pub(super) fn new(setup: &Setup, settings: &MethodSettings) -> Result<Self> {
        let map = setup.map.as_ref().ok_or_else(|| Error::Unsuitable {
            method: "histogram".into(),
            expected: "a map",
            source_name: setup.name.clone(),
        })?;
        let mut grid = GridLocalizer::new(map, settings.histogram)?;
        if !settings.global {
            grid.start_at(&setup.start_belief)?;
        }
        Ok(Histogram { grid, odometry: Pose2::IDENTITY, is_new: true })
    }
}

impl Localizer for Histogram {
    fn predict(&mut self, _stamp: f64, control: &Control) -> Result<()> {
        if let Control::Odometry(pose) = control {
            self.grid.odometry(*pose)?;
            self.odometry = *pose;
        }
        Ok(())
    }

    fn correct(&mut self, _stamp: f64, measurement: &Measurement) -> Result<Vec<Judgement>> {
        self.is_new = false;
        let Measurement::Scan { scan, mounting } = measurement else { return Ok(Vec::new()) };
        let update = self.grid.update(self.odometry, scan, *mounting)?;
        self.is_new = update != GridUpdate::StoodStill;
        let used = Judgement { accepted: true, ..Judgement::REFUSED };
        Ok(if matches!(update, GridUpdate::Done(_)) { vec![used] } else { Vec::new() })
    }

    fn estimate(&self, _stamp: f64) -> Result<Estimate> {
        Ok(self.grid.estimate().into())
    }

    fn hypotheses(&self) -> Vec<Hypothesis> {
        let places = self.grid.hypotheses(HYPOTHESES).into_iter();
        places.map(|(share, belief)| Hypothesis { share, belief }).collect()
    }

    fn place_belief(&self) -> Option<PlaceBelief> {
        let probabilities = || self.grid.position_probabilities().into_iter().map(|p| p as f32);
        let squares = *self.grid.squares();
        self.is_new.then(|| PlaceBelief { squares, probabilities: probabilities().collect() })
    }
}
