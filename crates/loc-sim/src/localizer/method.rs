//! The methods by name.

use super::Localizer;
use super::dead_reckoning::DeadReckoning;
use super::ekf::Ekf;
use super::ekf_slam::EkfSlamMethod;
use super::fastslam::FastSlamMethod;
use super::fusion::Fusion;
use super::histogram::Histogram;
use super::kf_slam::KfSlamMethod;
use super::landmark_mcl::ObservationMcl;
use super::lateration::Lateration;
use super::line_ekf::LineMatching;
use super::mcl::ScanMcl;
use super::rail::RailFilter;
use crate::source::Setup;
use crate::{Error, Result};
use loc_filters::fusion::FusionSettings;
use loc_filters::histogram::GridSettings;
use loc_filters::landmark::LandmarkSettings;
use loc_filters::lateration::SlidingSettings;
use loc_filters::line_matching::LineMatchingSettings;
use loc_filters::slam::SlamSettings;
use loc_filters::{ExtendedKalmanFilter as Extended, UnscentedKalmanFilter as Unscented};
use loc_pf::sensor::landmark::ObservationModel;
use loc_pf::{FastSlamSettings, LandmarkMclSettings, MclSettings};
use std::str::FromStr;

/// A method that a run can use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Method {
    /// Odometry alone (E).
    DeadReckoning,
    /// Ranges to landmarks over a sliding window (D).
    Lateration,
    /// The linear Kalman filter of a vehicle on a rail (G).
    Kf,
    /// The extended Kalman filter with landmarks (H2).
    Ekf,
    /// The unscented Kalman filter with landmarks.
    Ukf,
    /// The extended Kalman filter with the lines of a map (H4).
    LineEkf,
    /// The unscented Kalman filter with the lines of a map.
    LineUkf,
    /// Every sensor there is, in one extended Kalman filter (B, H1).
    Fusion,
    /// Every sensor there is, in one unscented Kalman filter.
    FusionUkf,
    /// Monte Carlo localization (M).
    Mcl,
    /// Markov localization on a grid (K1).
    Histogram,
    /// Linear Kalman SLAM of a robot that never turns (I1).
    KfSlam,
    /// The extended Kalman filter over robot and landmarks (I2 to I4).
    EkfSlam,
    /// Particles that each draw a map of their own: FastSLAM 2.0 (I2 to I4).
    FastSlam,
}

/// What a method needs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Needs {
    /// The sensor beside the odometry.
    pub sensors: &'static str,
    /// The kind of map.
    pub map: &'static str,
}

/// What the methods are told about the robot and its sensors.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MethodSettings {
    /// For a robot in the plane.
    pub landmark: LandmarkSettings,
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

/// What a filter knows about a vehicle on a rail.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RailSettings {
    /// Standard deviation of the commanded acceleration \[m/s^2\].
    pub acceleration_sigma: f64,
    /// Standard deviation of each position sensor \[m\].
    pub sensor_sigmas: Vec<f64>,
}

impl MethodSettings {
    /// Settings of the particle filter among landmarks, with what all methods there are told.
    pub fn landmark_mcl(&self) -> LandmarkMclSettings {
        let LandmarkSettings {
            integration,
            motion_noise,
            observation_noise,
            mounting,
            horizon,
            ..
        } = self.landmark;
        let own = self.landmark_mcl;
        let sights = ObservationModel { noise: observation_noise, mounting, ..own.sights };
        LandmarkMclSettings { integration, motion_noise, sights, horizon, ..own }
    }

    /// Settings of lateration, with what all methods among landmarks are told.
    pub fn lateration(&self) -> SlidingSettings {
        let LandmarkSettings {
            integration,
            motion_noise,
            observation_noise,
            mounting,
            horizon,
            ..
        } = self.landmark;
        SlidingSettings {
            integration,
            motion_noise,
            range_noise: observation_noise,
            antenna: mounting.position(),
            horizon,
            ..self.lateration
        }
    }
}

impl MethodSettings {
    /// Settings of `fusion`, with what all methods among landmarks are told.
    pub fn fusion(&self) -> FusionSettings {
        let LandmarkSettings {
            integration,
            motion_noise,
            observation_noise,
            mounting,
            gate_probability,
            horizon,
        } = self.landmark;
        FusionSettings {
            integration,
            motion_noise,
            observation_noise,
            mounting,
            gate_probability,
            horizon,
            ..self.fusion
        }
    }
}

impl MethodSettings {
    /// Settings of `ekf-slam`, with what all methods among landmarks are told.
    pub fn slam(&self) -> SlamSettings {
        let LandmarkSettings {
            integration,
            motion_noise,
            observation_noise,
            mounting,
            gate_probability,
            ..
        } = self.landmark;
        let observation_noise =
            if self.slam_own_noise { self.slam.observation_noise } else { observation_noise };
        SlamSettings {
            integration,
            motion_noise,
            observation_noise,
            mounting,
            gate_probability,
            ..self.slam
        }
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
        FastSlamSettings {
            integration,
            motion_noise,
            observation_noise,
            mounting,
            gate_probability,
            identities,
            map,
            ..self.fastslam
        }
    }
}

impl Method {
    /// Every method, in the order in which tables list them.
    pub const ALL: [Method; 14] = [
        Method::DeadReckoning,
        Method::Lateration,
        Method::Kf,
        Method::Ekf,
        Method::Ukf,
        Method::LineEkf,
        Method::LineUkf,
        Method::Fusion,
        Method::FusionUkf,
        Method::Histogram,
        Method::Mcl,
        Method::KfSlam,
        Method::EkfSlam,
        Method::FastSlam,
    ];

    /// The name, as the command line has it.
    pub fn name(self) -> &'static str {
        match self {
            Method::DeadReckoning => "dead-reckoning",
            Method::Lateration => "lateration",
            Method::Kf => "kf",
            Method::Ekf => "ekf",
            Method::Ukf => "ukf",
            Method::LineEkf => "line-ekf",
            Method::LineUkf => "line-ukf",
            Method::Fusion => "fusion",
            Method::FusionUkf => "fusion-ukf",
            Method::Mcl => "mcl",
            Method::Histogram => "histogram",
            Method::KfSlam => "kf-slam",
            Method::EkfSlam => "ekf-slam",
            Method::FastSlam => "fastslam",
        }
    }

    /// Whether it can find the robot without being told where it starts.
    pub fn can_search(self) -> bool {
        matches!(self, Method::Lateration | Method::Histogram | Method::Mcl)
    }

    /// What it measures with, beside odometry, on a source; and the map that it needs.
    pub fn needs(self, setup: &Setup) -> Needs {
        let lasers = setup.has_laser || setup.landmarks.is_empty();
        let (sensors, map) = match self {
            Method::DeadReckoning => ("none", "none"),
            Method::Kf => ("position", "none"),
            Method::Lateration => ("ranges", "landmarks"),
            Method::Fusion | Method::FusionUkf => ("camera", "landmarks"),
            Method::Histogram => ("laser", "grid"),
            Method::Mcl if lasers => ("laser", "grid"),
            Method::Ekf | Method::Ukf | Method::Mcl => ("camera", "landmarks"),
            Method::LineEkf | Method::LineUkf => ("laser", "lines"),
            Method::KfSlam | Method::EkfSlam | Method::FastSlam => ("camera", "draws its own"),
        };
        Needs { sensors, map }
    }

    /// Whether it draws random numbers, so that its seed matters.
    pub fn draws(self) -> bool {
        matches!(self, Method::Mcl | Method::FastSlam)
    }

    /// Whether its estimates can be smoothed after the run.
    pub fn can_smooth(self) -> bool {
        matches!(
            self,
            Method::Kf
                | Method::Ekf
                | Method::Ukf
                | Method::LineEkf
                | Method::LineUkf
                | Method::Fusion
                | Method::FusionUkf
        )
    }

    /// The method, ready to run on a source.
    ///
    /// # Errors
    /// [`Error::Unsuitable`] where the source lacks what the method needs, and settings that the
    /// filter refuses.
    pub fn start(self, setup: &Setup, settings: &MethodSettings) -> Result<Box<dyn Localizer>> {
        let name = self.name();
        Ok(match self {
            Method::DeadReckoning if setup.rail.is_some() => {
                Box::new(RailFilter::new(name, setup, &settings.rail, false)?)
            }
            Method::DeadReckoning => Box::new(DeadReckoning::new(setup, settings)?),
            Method::Lateration => Box::new(Lateration::new(setup, settings)?),
            Method::Kf => Box::new(RailFilter::new(name, setup, &settings.rail, true)?),
            Method::Ekf => Box::new(Ekf::<Extended<3>>::new(name, setup, settings)?),
            Method::Ukf => Box::new(Ekf::<Unscented<3>>::new(name, setup, settings)?),
            Method::LineEkf => Box::new(LineMatching::<Extended<_>>::new(name, setup, settings)?),
            Method::LineUkf => Box::new(LineMatching::<Unscented<_>>::new(name, setup, settings)?),
            Method::Fusion => Box::new(Fusion::<Extended<_>>::new(name, setup, settings)?),
            Method::FusionUkf => Box::new(Fusion::<Unscented<_>>::new(name, setup, settings)?),
            // Where both can be had, scans tell more than landmarks.
            Method::Mcl if setup.has_laser || setup.landmarks.is_empty() => {
                Box::new(ScanMcl::new(setup, settings)?)
            }
            Method::Histogram => Box::new(Histogram::new(setup, settings)?),
            Method::Mcl => Box::new(ObservationMcl::new(setup, settings)?),
            Method::KfSlam => Box::new(KfSlamMethod::new(setup, settings)?),
            Method::EkfSlam => Box::new(EkfSlamMethod::new(setup, settings)?),
            Method::FastSlam => Box::new(FastSlamMethod::new(setup, settings)?),
        })
    }
}

impl FromStr for Method {
    type Err = Error;
    fn from_str(name: &str) -> Result<Self> {
        Method::ALL.into_iter().find(|method| method.name() == name).ok_or_else(|| {
            Error::UnknownName {
                what: "method",
                expected: Method::ALL.map(Method::name).join(", "),
                found: name.into(),
            }
        })
    }
}

impl std::fmt::Display for Method {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}
