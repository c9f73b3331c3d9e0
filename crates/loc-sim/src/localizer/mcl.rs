//! `mcl`: Monte Carlo localization with a laser in an occupancy grid (M).

use super::{Cloud, Estimate, Hypothesis, Judgement, Localizer, MethodSettings};
use crate::source::Setup;
use crate::{Error, Result};
use loc_core::Pose2;
use loc_core::random::stream;
use loc_pf::Mcl;
use loc_pf::mcl::{MountedScan, Update};
use loc_sensors::event::{Control, Measurement};

#[derive(Debug)]
pub(super) struct ScanMcl {
    mcl: Mcl,
    odometry: Pose2,
}

impl ScanMcl {
    pub(super) fn new(setup: &Setup, settings: &MethodSettings) -> Result<Self> {
        let map = setup.map.as_ref().ok_or_else(|| Error::Unsuitable {
            method: "mcl".into(),
            expected: "a map",
            source_name: setup.name.clone(),
        })?;
        let mut mcl = Mcl::new(map, settings.mcl.clone(), stream(settings.seed, "mcl"))?;
        if !settings.global {
            mcl.start_at(&setup.start_belief)?;
        }
        Ok(ScanMcl { mcl, odometry: Pose2::IDENTITY })
    }
}

impl Localizer for ScanMcl {
    fn predict(&mut self, _stamp: f64, control: &Control) -> Result<()> {
        if let Control::Odometry(pose) = control {
            self.mcl.odometry(*pose)?;
            self.odometry = *pose;
        }
        Ok(())
    }

    fn correct(&mut self, _stamp: f64, measurement: &Measurement) -> Result<Vec<Judgement>> {
        if let Measurement::Scan { scan, mounting } = measurement {
            let scan = MountedScan { scan, mounting: *mounting };
            if let Update::Done { .. } = self.mcl.update(self.odometry, &[scan])? {
                let used = Judgement { accepted: true, ..Judgement::REFUSED };
                return Ok(vec![used]);
            }
        }
        Ok(Vec::new())
    }

    fn estimate(&self, _stamp: f64) -> Result<Estimate> {
        Ok(self.mcl.belief().into())
    }

    fn particle_count(&self) -> usize {
        self.mcl.particles().len()
    }

    fn hypotheses(&self) -> Vec<Hypothesis> {
        let clusters = self.mcl.estimate().clusters.iter();
        clusters.map(|c| Hypothesis { share: c.share, belief: c.belief }).collect()
    }

    fn notes(&self) -> Vec<String> {
        let estimate = self.mcl.range_offset_estimate();
        let (Some(offset), Some(sigma)) = (estimate.offset(), estimate.sigma()) else {
            return Vec::new();
        };
        let scans = estimate.scans();
        let by = format!("{offset:+.3} m, sigma {sigma:.3} m, by {scans} scans");
        let is_used = self.mcl.range_offset().abs() > 0.0;
        is_used
            .then(|| format!("ranges changed to fit the map's walls by {by}"))
            .into_iter()
            .collect()
    }

    fn cloud(&self) -> Option<Cloud> {
        Some(Cloud::of(self.mcl.particles()))
    }
}
