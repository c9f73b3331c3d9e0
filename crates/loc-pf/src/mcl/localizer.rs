//! [`Mcl`] as a [`Localizer`]: events, hypotheses, particles, notes.

use super::{Mcl, MotionModel, MountedScan, ScanModel, Update};
use loc_core::Pose2;
use loc_filters::localizer::{Decision, Estimate, Hypothesis, Localizer, Outcome, ParticleSet};
use loc_sensors::event::{Control, Measurement};

/// Predicts with the poses of an odometry and corrects with scans; a scan is one outcome.
impl<M: MotionModel, S: ScanModel> Localizer for Mcl<M, S> {
    fn predict(&mut self, _stamp: f64, control: &Control) -> loc_filters::Result<()> {
        let Control::Odometry(pose) = control else { return Ok(()) };
        Ok(self.odometry(*pose)?)
    }

    fn correct(
        &mut self,
        _stamp: f64,
        measurement: &Measurement,
    ) -> loc_filters::Result<Vec<Outcome>> {
        let Measurement::Scan { scan, mounting } = measurement else { return Ok(Vec::new()) };
        let odometry = self.path.map_or(Pose2::IDENTITY, |path| path.end());
        let scan = MountedScan { scan, mounting: *mounting };
        let update = self.update(odometry, &[scan])?;
        let is_used = matches!(update, Update::Done(_));
        Ok(is_used.then_some(Outcome::of(Decision::Accepted)).into_iter().collect())
    }

    /// The pose of the last update, moved by the odometry since.
    fn estimate(&self, _stamp: f64) -> loc_filters::Result<Estimate> {
        Ok(Estimate::from(self.belief()).with_lost(self.lost()))
    }

    fn hypotheses(&self) -> Vec<Hypothesis> {
        let clusters = self.estimate.clusters.iter();
        clusters.map(|c| Hypothesis { share: c.share, belief: c.belief }).collect()
    }

    fn particle_count(&self) -> usize {
        self.particles().len()
    }

    fn particle_set(&self, max: usize) -> Option<ParticleSet> {
        Some(ParticleSet { particles: self.particles().thinned(max), weighted: None })
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        if self.frozen > 0 {
            notes.push(format!(
                "{} scans were equal to the one before while the robot moved and were not used",
                self.frozen
            ));
        }
        if self.moved_unnoticed > 0 {
            notes.push(format!(
                "the scans moved {} times while the odometry stood still: do the encoders stick?",
                self.moved_unnoticed
            ));
        }
        let estimate = self.range_offset_estimate();
        let (Some(offset), Some(sigma)) = (estimate.offset(), estimate.sigma()) else {
            return notes;
        };
        let scans = estimate.scans();
        let by = format!("{offset:+.3} m, sigma {sigma:.3} m, by {scans} scans");
        if self.range_offset().abs() > 0.0 {
            notes.push(format!("ranges changed to fit the map's walls by {by}"));
        }
        notes
    }
}
