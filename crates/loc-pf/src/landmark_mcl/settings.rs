//! All settings of Monte Carlo localization with landmarks.

use crate::Resampling;
use crate::sensor::landmark::ObservationModel;
use loc_filters::RobotSettings;

loc_core::settings! {
    /// Settings of [`LandmarkMcl`](super::LandmarkMcl), with defaults that serve a small indoor
    /// robot.
    #[derive(Copy)]
    pub struct LandmarkMclSettings {
        /// The robot and its sensors.
        pub robot: RobotSettings = RobotSettings::default() => check;
        /// Number of particles.
        pub particles: usize = 2000 => at_least(1);
        /// Share of outliers, such as misread numbers, in \[0, 1).
        pub outlier_share: f64 = 0.01 => holds(
            "a number in [0, 1)",
            |s| (0.0..1.0).contains(&s.outlier_share)
        );
        /// Distance up to which landmarks are seen \[m\]: outliers are uniform within it.
        pub outlier_range: f64 = 10.0 => positive;
        /// How far the robot may be outside of the box around the landmarks \[m\].
        pub margin: f64 = 1.0 => positive;
        /// The particle set is resampled where its effective sample size falls below this share.
        pub resample_below: f64 = 0.5 => probability;
        /// How particles are drawn.
        pub resampling: Resampling = Resampling::default() => any;
        /// What to do when lost.
        pub recovery: RecoverySettings = RecoverySettings::default() => check;
        /// Number of threads.
        pub threads: usize = 1 => any;
    }
}

loc_core::settings! {
    /// When observations no longer fit, particles are put where they would (augmented MCL).
    #[derive(Copy)]
    pub struct RecoverySettings {
        /// Decay of the slow average of how well observations fit; also known as alpha_slow.
        pub alpha_slow: f64 = 0.01 => probability;
        /// Decay of the fast one; 0 for no recovery. Also known as alpha_fast.
        pub alpha_fast: f64 = 0.1 => probability;
        /// The fast average must fall below the slow one divided by this before anything is done;
        /// the share of new particles is then `1 - fast / slow`. 1 is the textbook, which replaces
        /// a few whenever observations fit a little worse than usual.
        pub factor: f64 = 2.0 => at_least(1.0);
        /// Share of the new particles that are put where the observations are, the others anywhere.
        pub sensor_resetting: f64 = 0.9 => probability;
    }
}

impl LandmarkMclSettings {
    /// The observation model of the robot's camera with these outliers.
    pub fn observation_model(&self) -> ObservationModel {
        ObservationModel {
            noise: self.robot.camera,
            mounting: self.robot.mounting,
            outlier_share: self.outlier_share,
            outlier_range: self.outlier_range,
        }
    }
}
