//! Divergence of a filter: it is noticed by its rejections, and ended by its measurements.
//!
//! A gate keeps outliers out. A filter that has gone wrong by more than its covariance says takes
//! the right measurements for outliers, rejects all of them and stays wrong, as confident as
//! before. [`DivergenceMonitor`] counts the decisions of the gate: where the majority of the last ones are
//! rejections, which a consistent filter has once in many years, the belief is widened so far that the
//! rejected measurements fit, and they lead it back.
//!
//! ```
//! use loc_filters::divergence::DivergenceMonitor;
//! let mut monitor = DivergenceMonitor::default();
//! // One outlier in ten is no divergence; rejections one after the other are one.
//! assert!((0..1000).all(|k| !monitor.observe(k % 10 > 0)));
//! assert_eq!((0..12).filter(|_| monitor.observe(false)).count(), 1);
//! ```

use crate::extended::{LinearizedMotion, MotionModel};
use crate::localizer::{Outcome, observed_position};
use loc_core::Pose2;
use loc_maps::LandmarkMap;
use loc_sensors::landmark_camera::LandmarkObservation;
use nalgebra::{SMatrix, SVector};

/// Number of last decisions that are counted.
const WINDOW: u32 = 12;

/// Number of rejections among them from which on the filter has diverged.
const REJECTIONS: u32 = 9;

/// The last decisions of a gate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DivergenceMonitor {
    /// Rejections as bits, the last decision lowest.
    recent: u32,
    restarts: u32,
}

impl DivergenceMonitor {
    /// Counts a decision; whether the filter has diverged and is to be widened now. The count starts
    /// anew then.
    pub fn observe(&mut self, accepted: bool) -> bool {
        self.recent = (self.recent << 1 | u32::from(!accepted)) & ((1 << WINDOW) - 1);
        let has_diverged = self.recent.count_ones() >= REJECTIONS;
        if has_diverged {
            self.recent = 0;
            self.restarts += 1;
        }
        has_diverged
    }

    /// Counts the decisions of a measurement; whether the filter has diverged.
    pub(crate) fn observe_all(&mut self, outcomes: &[Outcome]) -> bool {
        let gated = outcomes.iter().filter(|outcome| outcome.nis.is_some());
        gated.fold(false, |diverged, outcome| self.observe(outcome.accepted()) | diverged)
    }

    /// What a user should know: how often the filter had diverged, last at `stamp` \[s\].
    pub(crate) fn notes(&self, stamp: f64) -> Vec<String> {
        let times = match self.restarts {
            0 => return Vec::new(),
            1 => "once".to_owned(),
            count => format!("{count} times"),
        };
        vec![format!(
            "the filter had diverged {times}, last at {stamp:.1} s: its belief was widened until the \
             measurements fitted again"
        )]
    }

    /// How often the filter had diverged.
    pub fn restarts(&self) -> u32 {
        self.restarts
    }
}

/// How far landmarks are from where they are seen, at the largest \[m\]; 0 without a distance and a
/// direction.
pub(crate) fn gap(map: &LandmarkMap, camera: Pose2, observations: &[LandmarkObservation]) -> f64 {
    let gaps = observations.iter().filter_map(|observation| {
        let landmark = map.get(observation.landmark)?.position.xy();
        Some(nalgebra::distance(&observed_position(camera, observation)?, &landmark))
    });
    gaps.fold(0.0, f64::max)
}

/// No motion, and noise with these standard deviations of the states.
pub(crate) struct Widening<const N: usize>(pub(crate) SVector<f64, N>);

impl<const N: usize> Widening<N> {
    /// Widens a position, which comes first of the states, by a gap \[m\] between measurements and
    /// what was expected, and the heading, which is the third, by what such a gap may come from.
    pub(crate) fn by(gap: f64) -> Self {
        let position = gap.max(MIN_WIDENING);
        let mut sigmas = SVector::<f64, N>::zeros();
        (sigmas[0], sigmas[1]) = (position, position);
        sigmas[2] = (position / HEADING_ARM).min(MAX_TURN);
        Widening(sigmas)
    }
}

/// A diverged belief is widened by at least this much \[m\].
const MIN_WIDENING: f64 = 0.5;

/// Distance at which a turn moves a landmark as far as the position is widened \[m\].
const HEADING_ARM: f64 = 3.0;

/// A diverged belief is widened by at most this much in its heading \[rad\].
const MAX_TURN: f64 = 1.5;

impl<const N: usize> MotionModel<N> for Widening<N> {
    fn predict(&self, state: &SVector<f64, N>) -> SVector<f64, N> {
        *state
    }

    fn linearize(&self, state: &SVector<f64, N>) -> LinearizedMotion<N> {
        let noise = SMatrix::from_diagonal(&self.0.component_mul(&self.0));
        LinearizedMotion { state: *state, jacobian: SMatrix::identity(), noise }
    }
}
