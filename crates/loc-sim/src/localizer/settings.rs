//! The settings of all methods.

use loc_filters::fusion::FusionSettings;
use loc_filters::histogram::GridSettings;
use loc_filters::kalman::rail::RailSettings;
use loc_filters::landmark::RobotSettings;
use loc_filters::lateration::SlidingSettings;
use loc_filters::line_matching::LineMatchingSettings;
use loc_filters::slam::SlamSettings;
use loc_pf::sensor::landmark::ObservationModel;
use loc_pf::{FastSlamSettings, LandmarkMclSettings, MclSettings};

/// Settings of all methods; what belongs to the robot and its sensors is said once.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodSettings {
    /// For a robot in the plane.
    pub landmark: RobotSettings,
    /// How late an input may come \[s\].
    pub horizon: f64,
    /// For a vehicle on a rail.
    pub rail: RailSettings,
    /// For matching lines of scans with those of a map.
    pub line_matching: LineMatchingSettings,
    /// For the particle filter in a map.
    pub mcl: MclSettings,
    /// For the particle filter among landmarks; what it shares with the other methods among
    /// landmarks, it takes from there.
    pub landmark_mcl: LandmarkMclSettings,
    /// For the grid over the poses in a map.
    pub histogram: GridSettings,
    /// For lateration; what it shares with the other methods among landmarks, it takes from there.
    pub lateration: SlidingSettings,
    /// For `fusion`; what it shares with the other methods among landmarks, it takes from there.
    pub fusion: FusionSettings,
    /// For `ekf-slam`; what it shares with the other methods among landmarks, it takes from there.
    pub slam: SlamSettings,
    /// Whether `ekf-slam` keeps the noise of observations that stands in its own settings.
    pub slam_own_noise: bool,
    /// For `fastslam`; what it shares with `ekf-slam`, it takes from there.
    pub fastslam: FastSlamSettings,
    /// Whether methods that can find the robot anywhere are not told where it starts.
    pub global: bool,
    /// Whether those methods run a second time without being told, beside their run from the start.
    pub also_global: bool,
    /// Whether the estimates of Kalman filters are smoothed after the run, beside those that they
    /// had during it.
    pub smooth: bool,
    /// Seed of the methods that draw random numbers.
    pub seed: u64,
}

impl Default for MethodSettings {
    fn default() -> Self {
        MethodSettings {
            landmark: RobotSettings::default(),
            horizon: 2.0,
            rail: RailSettings::default(),
            line_matching: LineMatchingSettings::default(),
            mcl: MclSettings::default(),
            landmark_mcl: LandmarkMclSettings::default(),
            histogram: GridSettings::default(),
            lateration: SlidingSettings::default(),
            fusion: FusionSettings::default(),
            slam: SlamSettings::default(),
            slam_own_noise: false,
            fastslam: FastSlamSettings::default(),
            global: false,
            also_global: false,
            smooth: false,
            seed: 0,
        }
    }
}

impl MethodSettings {
    /// Settings of the particle filter among landmarks, with what all methods there are told.
    pub fn landmark_mcl(&self) -> LandmarkMclSettings {
        let RobotSettings { integration, motion_noise, observation_noise, mounting, .. } =
            self.landmark;
        let own = self.landmark_mcl;
        let sights = ObservationModel { noise: observation_noise, mounting, ..own.sights };
        own.robot(own.robot.integration(integration).odometry(motion_noise)).sights(sights)
    }

    /// Settings of lateration, with what all methods among landmarks are told.
    pub fn lateration(&self) -> SlidingSettings {
        let RobotSettings { integration, motion_noise, observation_noise, mounting, .. } =
            self.landmark;
        self.lateration.robot(self.lateration.robot.integration(integration).odometry(motion_noise).camera(observation_noise)).antenna(mounting.position())
    }

    /// Settings of `fusion`, with what all methods among landmarks are told.
    pub fn fusion(&self) -> FusionSettings {
        let RobotSettings {
            integration,
            motion_noise,
            observation_noise,
            mounting,
            gate_probability,
        } = self.landmark;
        self.fusion.robot(self.fusion.robot.integration(integration).odometry(motion_noise).camera(observation_noise).mounting(mounting).gate_probability(gate_probability))
    }

    /// Settings of `ekf-slam`, with what all methods among landmarks are told.
    pub fn slam(&self) -> SlamSettings {
        let RobotSettings {
            integration,
            motion_noise,
            observation_noise,
            mounting,
            gate_probability,
            ..
        } = self.landmark;
        let observation_noise =
            if self.slam_own_noise { self.slam.observation_noise } else { observation_noise };
        self.slam.robot(self.slam.robot.integration(integration).odometry(motion_noise).camera(observation_noise).mounting(mounting).gate_probability(gate_probability))
    }

    /// Settings of `fastslam`, with what all methods among landmarks are told.
    pub fn fastslam(&self) -> FastSlamSettings {
        let SlamSettings {
            integration,
            motion_noise,
            observation_noise,
            mounting,
            gate_probability,
            identities,
            map,
            ..
        } = self.slam();
        self.fastslam.robot(self.fastslam.robot.integration(integration).odometry(motion_noise).camera(observation_noise).mounting(mounting).gate_probability(gate_probability)).identities(identities).map(map)
    }
}
