//! `line-ekf`: lines of laser scans against the lines of a map (H4).

use super::{Estimate, Judgement, Localizer, MethodSettings, Whitened};
use crate::event::{Control, Measurement};
use crate::source::Setup;
use crate::{Error, Result};
use loc_filters::line_matching::{LineEkf, LineMatchingSettings, LinePair, LineUpdate};
use loc_maps::LineMap;
use std::sync::Arc;

#[derive(Debug)]
pub(super) struct LineMatching {
    ekf: LineEkf,
    last: Option<LineUpdate>,
}

impl LineMatching {
    /// In the lines of the setup or, without any, in those found in its grid.
    pub(super) fn new(setup: &Setup, settings: &MethodSettings) -> Result<Self> {
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
                    method: "line-ekf".into(),
                    expected: "a map",
                    source_name: setup.name.clone(),
                });
            }
        };
        let ekf = LineEkf::new(lines, settings, setup.start_belief)?;
        Ok(LineMatching { ekf, last: None })
    }
}

impl Localizer for LineMatching {
    fn predict(&mut self, _stamp: f64, control: &Control) -> Result<()> {
        if let Control::Odometry(pose) = control {
            self.ekf.odometry(*pose)?;
        }
        Ok(())
    }

    fn correct(&mut self, _stamp: f64, measurement: &Measurement) -> Result<Vec<Judgement>> {
        let Measurement::Scan { scan, mounting } = measurement else { return Ok(Vec::new()) };
        let update = self.ekf.scan(scan, *mounting)?;
        let judgements = update.pairs.iter().map(judge).collect();
        self.last = Some(update);
        Ok(judgements)
    }

    fn estimate(&self, _stamp: f64) -> Result<Estimate> {
        Ok(self.ekf.belief().into())
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
