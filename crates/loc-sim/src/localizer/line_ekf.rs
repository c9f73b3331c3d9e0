//! `line-ekf` and `line-ukf`: lines of laser scans against the lines of a map (H4).

use super::{Estimate, Judgement, Localizer, MethodSettings, Whitened};
use crate::source::Setup;
use crate::{Error, Result};
use loc_filters::NonlinearFilter;
use loc_filters::line_matching::{LineFilter, LineMatchingSettings, LinePair, LineUpdate, STATES};
use loc_maps::LineMap;
use loc_sensors::event::{Control, Measurement};
use std::sync::Arc;

#[derive(Debug)]
pub(super) struct LineMatching<F> {
    filter: LineFilter<F>,
    last: Option<LineUpdate>,
}

impl<F: NonlinearFilter<STATES>> LineMatching<F> {
    pub(super) fn new(method: &str, setup: &Setup, settings: &MethodSettings) -> Result<Self> {
        Ok(LineMatching { filter: filter(method, setup, settings)?, last: None })
    }
}

/// A filter in the lines of the setup or, without any, in those found in its grid.
pub(super) fn filter<F: NonlinearFilter<STATES>>(
    method: &str,
    setup: &Setup,
    settings: &MethodSettings,
) -> Result<LineFilter<F>> {
    let own = settings.line_matching;
    let (lines, settings) = match (&setup.lines, &setup.map) {
        (Some(lines), _) => (lines.clone(), own),
        (None, Some(grid)) => {
            let lines = LineMap::from_grid(grid, &Default::default())?;
            // Walls that were mapped are not quite straight, and not quite in their place.
            let map_sigma = own.map_sigma.max(grid.resolution());
            (Arc::new(lines), LineMatchingSettings { map_sigma, ..own })
        }
        (None, None) => {
            return Err(Error::Unsuitable {
                method: method.into(),
                expected: "a map",
                source_name: setup.name.clone(),
            });
        }
    };
    Ok(LineFilter::new(lines, settings, setup.start_belief)?)
}

impl<F: NonlinearFilter<STATES>> Localizer for LineMatching<F> {
    fn predict(&mut self, _stamp: f64, control: &Control) -> Result<()> {
        if let Control::Odometry(pose) = control {
            self.filter.odometry(*pose)?;
        }
        Ok(())
    }

    fn correct(&mut self, _stamp: f64, measurement: &Measurement) -> Result<Vec<Judgement>> {
        let Measurement::Scan { scan, mounting } = measurement else { return Ok(Vec::new()) };
        let update = self.filter.scan(scan, *mounting)?;
        let judgements = update.pairs.iter().map(judge).collect();
        self.last = Some(update);
        Ok(judgements)
    }

    fn estimate(&self, _stamp: f64) -> Result<Estimate> {
        Ok(self.filter.belief().into())
    }

    fn lines(&self) -> Option<&LineUpdate> {
        self.last.as_ref()
    }
}

/// A line without a partner is one that was turned away.
fn judge(pair: &Option<LinePair>) -> Judgement {
    let Some(LinePair { innovation, .. }) = pair else { return Judgement::REFUSED };
    Judgement {
        accepted: innovation.accepted,
        nis: Some(innovation.nis),
        degrees_of_freedom: 2,
        whitened: Whitened::from(innovation.whitened),
        seen_at: None,
    }
}
