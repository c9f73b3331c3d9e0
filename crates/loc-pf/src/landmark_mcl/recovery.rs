//! How well the sightings fit, now and in the long run (augmented MCL).

use super::settings::RecoverySettings;

/// Two averages of the mean likelihood of a sighting, as a share of the largest that it could have.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Fit {
    averages: Option<[f64; 2]>,
}

impl Fit {
    /// Takes in the sightings of one moment: the logarithms of their mean likelihood over the cloud
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
        let [slow, fast] = self.averages.get_or_insert([now; 2]);
        *slow += settings.alpha_slow * (now - *slow);
        *fast += settings.alpha_fast * (now - *fast);
        if *slow > 0.0 { (1.0 - settings.factor * *fast / *slow).max(0.0) } else { 0.0 }
    }

    /// The slow and the fast average, each in \[0, 1\].
    pub(super) fn averages(&self) -> Option<[f64; 2]> {
        self.averages
    }
}
