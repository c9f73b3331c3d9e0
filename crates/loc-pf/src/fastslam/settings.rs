//! The settings of FastSLAM.

use crate::Resampling;
use crate::resample::{ResamplePolicy, ResampleWhen};
use loc_filters::MeasurementModel;
use loc_filters::RobotSettings;
use loc_filters::association::{AssociationSettings, Rule};
use loc_filters::landmark::RangeBearingModel;
use loc_filters::slam::{Identities, MapSettings};
use nalgebra::{Point2, Vector2};

loc_core::settings! {
    /// Settings of FastSLAM, with defaults for a small indoor robot.
    #[derive(Copy)]
    pub struct FastSlamSettings {
        /// The robot and its sensors.
        pub robot: RobotSettings = RobotSettings::default() => check;
        /// Number of particles.
        pub particles: usize = 200 => at_least(1);
        /// Whether the data association is known (landmarks have numbers).
        pub identities: Identities = Identities::Known => any;
        /// Data association of landmarks without numbers, for each particle.
        pub association: AssociationSettings = FastSlamSettings::textbook_association() => check;
        /// Management of landmarks in the map. FastSLAM does not use `merge_ratio`.
        pub map: MapSettings = MapSettings::default() => check;
        /// Share of observations, in (0, 1], that a particle expects to be of something new.
        /// Without numbers on landmarks only.
        pub new_share: f64 = 0.01 => share;
        /// Probability, in (0, 1], that a landmark in the middle of the view is not seen. Without
        /// numbers on landmarks only.
        pub miss_share: f64 = 0.3 => share;
        /// The particle set is resampled where its effective sample size falls below this share.
        pub resample_below: f64 = 0.5 => probability;
        /// How particles are drawn.
        pub resampling: Resampling = Resampling::default() => any;
        /// Number of threads; the results are the same for any.
        pub threads: usize = 1 => any;
    }
}

impl FastSlamSettings {
    /// The textbook's association: each particle takes the likeliest landmark, at any
    /// margin. Wrong associations lower the weight of the particle later.
    pub fn textbook_association() -> AssociationSettings {
        let rule = Rule::MaximumLikelihood;
        AssociationSettings::default().rule(rule).gate_probability(0.999).min_ratio(1.0)
    }

    /// When to resample.
    pub(super) fn policy(&self) -> ResamplePolicy {
        ResamplePolicy { every: 1, when: ResampleWhen::EffectiveShareBelow(self.resample_below) }
    }

    pub(super) fn model(&self, landmark: Point2<f64>) -> RangeBearingModel {
        RangeBearingModel { landmark, mounting: self.robot.mounting, noise: self.robot.camera }
    }

    /// Variances of distance and direction of something at a distance \[m\].
    pub(super) fn observation_variances(&self, range: f64) -> Vector2<f64> {
        self.model(Point2::origin()).noise(&Vector2::new(range, 0.0)).diagonal()
    }
}
