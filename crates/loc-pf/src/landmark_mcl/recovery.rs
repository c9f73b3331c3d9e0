//! How well the observations fit, now and in the long run (augmented MCL).

use super::settings::RecoverySettings;

/// Two averages of the mean likelihood of an observation, as a share of the largest that it could have.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Fit {
    count: u32,
    slow: f64,
    fast: f64,
}

impl Fit {
    /// Takes in the observations of one moment: the logarithms of their mean likelihood over the cloud
    /// and of the largest possible one, and their number. Answers with the share of particles to
    /// replace.
    pub(super) fn update(
        &mut self,
        log_mean: f64,
        log_peak: f64,
        count: usize,
        settings: &RecoverySettings,
    ) -> f64 {
        let now = ((log_mean - log_peak) / count.max(1) as f64).exp().clamp(0.0, 1.0);
        self.count = self.count.saturating_add(1);
        // The first ones are averaged evenly, so that neither average hangs on the very first.
        let first = f64::from(self.count).recip();
        self.slow += settings.alpha_slow.max(first) * (now - self.slow);
        self.fast += settings.alpha_fast.max(first) * (now - self.fast);
        let off = settings.alpha_fast <= 0.0 || self.fast * settings.factor >= self.slow;
        if off { 0.0 } else { 1.0 - self.fast / self.slow }
    }

    /// The slow and the fast average, each in \[0, 1\].
    pub(super) fn averages(&self) -> Option<[f64; 2]> {
        (self.count > 0).then_some([self.slow, self.fast])
    }
}
