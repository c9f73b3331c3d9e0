//! The settings of the methods in a scenario, in the units of configuration files.

use crate::Result;
use crate::localizer::MethodSettings;
use crate::output::Illustration;
use crate::output::figures::FigureFile;
use crate::sense::{Request, sense};
use crate::source::{ObservationNoiseConfig, OdometryNoiseConfig};
use loc_core::error::{non_negative, positive};
use loc_core::motion::Integration;
use loc_filters::association::Rule;
use loc_filters::fusion::FusionSettings;
use loc_filters::histogram::GridSettings;
use loc_filters::landmark::RobotSettings;
use loc_filters::lateration::{Loss, SlidingSettings};
use loc_filters::line_matching::LineMatchingSettings;
use loc_filters::slam::{Identities, Jacobians, SlamSettings};
use loc_pf::{FastSlamSettings, LandmarkMclSettings, MclSettings};
use serde::Deserialize;

/// Settings of the methods. What is left out follows the simulated sensors, or the defaults.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FilterConfig {
    /// Rule of dead reckoning: `euler`, `midpoint` or `exact-arc`.
    pub integration: Integration,
    /// How far odometry is believed to be off.
    pub odometry: Option<OdometryNoiseConfig>,
    /// How far observations are believed to be off.
    pub camera: Option<ObservationNoiseConfig>,
    /// Share of right observations that the gate lets pass, 1 for no gate.
    pub gate_probability: Option<f64>,
    /// How late an input may come.
    pub horizon_s: Option<f64>,
    /// Settings of line matching; where left out, it knows the noise of a simulated laser.
    pub line_matching: Option<LineMatchingSettings>,
    /// Settings of the particle filter.
    pub mcl: MclSettings,
    /// Settings of the grid over the poses in a map.
    pub histogram: GridSettings,
    /// What the particle filter among landmarks is told beside.
    pub landmark_mcl: LandmarkMclConfig,
    /// What lateration is told beside.
    pub lateration: LaterationConfig,
    /// What fusion is told beside.
    pub fusion: FusionConfig,
    /// What SLAM is told beside.
    pub slam: SlamConfig,
    /// What FastSLAM is told beside, and beside what SLAM is told.
    pub fastslam: FastSlamConfig,
    /// Whether methods that can find the robot anywhere are not told where it starts.
    pub global: bool,
    /// Whether the estimates of Kalman filters are smoothed after the run as well.
    pub smooth: bool,
}

impl FilterConfig {
    /// The settings of all methods, with what this section says put over `landmark`.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`], and what [`MclSettings::check`] says.
    pub(super) fn methods(&self, landmark: RobotSettings) -> Result<MethodSettings> {
        self.mcl.check()?;
        self.histogram.check()?;
        let line_matching = self.line_matching.unwrap_or_default();
        line_matching.check()?;
        Ok(MethodSettings {
            landmark: self.apply(landmark)?,
            horizon: self.horizon(MethodSettings::default().horizon)?,
            mcl: self.mcl.clone(),
            histogram: self.histogram,
            landmark_mcl: self.landmark_mcl.settings()?,
            lateration: self.lateration.settings()?,
            line_matching,
            fusion: self.fusion.settings()?,
            slam: self.slam.settings()?,
            slam_own_noise: self.slam.camera.is_some(),
            fastslam: self.fastslam.settings()?,
            global: self.global,
            smooth: self.smooth,
            ..MethodSettings::default()
        })
    }

    /// How late an input may come \[s\], `usual` where this section does not say.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(super) fn horizon(&self, usual: f64) -> Result<f64> {
        Ok(non_negative("filter.horizon_s", self.horizon_s.unwrap_or(usual))?)
    }

    /// Settings with what this section says put over `settings`.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(super) fn apply(&self, mut settings: RobotSettings) -> Result<RobotSettings> {
        settings.integration = self.integration;
        if let Some(noise) = &self.odometry {
            settings.motion_noise = noise.noise()?;
        }
        if let Some(noise) = &self.camera {
            settings.observation_noise = noise.noise()?;
        }
        if let Some(probability) = self.gate_probability {
            settings.gate_probability = positive("filter.gate_probability", probability)?;
        }
        Ok(settings)
    }
}

/// What `mcl` is told beside the noise of odometry and camera. What is left out has the default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LandmarkMclConfig {
    /// Number of particles.
    pub particles: Option<usize>,
    /// Share of observations that say nothing, such as misread numbers.
    pub outlier_share: Option<f64>,
    /// Distance within which the wrong ones lie.
    pub outlier_range_m: Option<f64>,
    /// How far the robot may be outside of the box around the landmarks.
    pub margin_m: Option<f64>,
    /// Decay of the slow average of how well observations fit.
    pub alpha_slow: Option<f64>,
    /// Decay of the fast one; 0 for no recovery.
    pub alpha_fast: Option<f64>,
    /// Number of threads.
    pub threads: Option<usize>,
}

impl LandmarkMclConfig {
    /// The library's form.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(super) fn settings(&self) -> Result<LandmarkMclSettings> {
        let mut settings = LandmarkMclSettings::default();
        let put = |to: &mut f64, from: Option<f64>| *to = from.unwrap_or(*to);
        put(&mut settings.sights.outlier_share, self.outlier_share);
        put(&mut settings.sights.outlier_range, self.outlier_range_m);
        put(&mut settings.margin, self.margin_m);
        put(&mut settings.recovery.alpha_slow, self.alpha_slow);
        put(&mut settings.recovery.alpha_fast, self.alpha_fast);
        settings.particles = self.particles.unwrap_or(settings.particles);
        settings.threads = self.threads.unwrap_or(settings.threads);
        settings.check()?;
        Ok(settings)
    }
}

/// What `fastslam` is told beside the noise of odometry and camera, and beside what `[filter.slam]`
/// says of identities and the size of the map. What is left out has the default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FastSlamConfig {
    /// Number of particles.
    pub particles: Option<usize>,
    /// `nearest-neighbor`, `maximum-likelihood` or `joint-compatibility`.
    pub association: Option<Rule>,
    /// Share of right pairs that the gate of the association lets pass.
    pub association_probability: Option<f64>,
    /// How much likelier than any other explanation a pair must be.
    pub min_ratio: Option<f64>,
    /// Share of observations that are expected to be of something new.
    pub new_share: Option<f64>,
    /// Probability that a landmark in the middle of the view is not seen.
    pub miss_share: Option<f64>,
    /// Share of effective particles below which they are drawn anew.
    pub resample_below: Option<f64>,
    /// Number of threads.
    pub threads: Option<usize>,
}

impl FastSlamConfig {
    /// The library's form; what all methods among landmarks share is put in by the method.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] and [`loc_core::Error::Length`].
    pub(super) fn settings(&self) -> Result<FastSlamSettings> {
        let mut settings = FastSlamSettings::default();
        let put = |to: &mut f64, from: Option<f64>| *to = from.unwrap_or(*to);
        put(&mut settings.association.gate_probability, self.association_probability);
        put(&mut settings.association.min_ratio, self.min_ratio);
        put(&mut settings.new_share, self.new_share);
        put(&mut settings.miss_share, self.miss_share);
        put(&mut settings.resample_below, self.resample_below);
        settings.association.rule = self.association.unwrap_or(settings.association.rule);
        settings.particles = self.particles.unwrap_or(settings.particles);
        settings.threads = self.threads.unwrap_or(settings.threads);
        settings.check()?;
        Ok(settings)
    }
}

/// What `ekf-slam` is told beside the noise of odometry and camera. What is left out has the
/// default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SlamConfig {
    /// `known` where numbers are read off the landmarks, `unknown` where the method must find out.
    pub identities: Identities,
    /// `invariant`, `current`, or `first` for first estimates.
    pub jacobians: Jacobians,
    /// How far observations are believed to be off, where that is not as for the other methods.
    pub camera: Option<ObservationNoiseConfig>,
    /// Share of the variance of observations that those of one moment have in common.
    pub common_share: Option<f64>,
    /// How long that lasts.
    pub common_time_s: Option<f64>,
    /// `nearest-neighbor`, `maximum-likelihood` or `joint-compatibility`.
    pub association: Rule,
    /// Share of right pairs that the gate of the association lets pass.
    pub association_probability: Option<f64>,
    /// How much likelier than any other explanation a pair must be.
    pub min_ratio: Option<f64>,
    /// The same for two landmarks that become one.
    pub merge_ratio: Option<f64>,
    /// The most landmarks in the map.
    pub max_landmarks: Option<usize>,
    /// The score from which on a landmark is no longer provisional: 1 for one observation.
    pub confirm_score: Option<f64>,
    /// What an observation that contradicts a landmark takes from its score.
    pub contradiction_cost: Option<f64>,
    /// Works on the landmarks within this radius at a time.
    pub submap_radius_m: Option<f64>,
}

impl SlamConfig {
    /// The library's form; noise, mounting and gate are put in by the method.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(super) fn settings(&self) -> Result<SlamSettings> {
        let mut settings = SlamSettings::default();
        let put = |to: &mut f64, from: Option<f64>| *to = from.unwrap_or(*to);
        settings.identities = self.identities;
        settings.jacobians = self.jacobians;
        if let Some(noise) = &self.camera {
            settings.observation_noise = noise.noise()?;
        }
        put(&mut settings.common_share, self.common_share);
        put(&mut settings.common_time, self.common_time_s);
        settings.association.rule = self.association;
        put(&mut settings.association.gate_probability, self.association_probability);
        put(&mut settings.association.min_ratio, self.min_ratio);
        put(&mut settings.map.merge_ratio, self.merge_ratio);
        put(&mut settings.map.confirm_score, self.confirm_score);
        put(&mut settings.map.contradiction_cost, self.contradiction_cost);
        settings.map.max_landmarks = self.max_landmarks.unwrap_or(settings.map.max_landmarks);
        settings.submap_radius = self.submap_radius_m;
        settings.check()?;
        Ok(settings)
    }
}

/// What `fusion` is told beside the noise of odometry, ranges and simulated sensors. What is left
/// out has the default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FusionConfig {
    /// Standard deviation of the range scale; 0 for ranges that are right.
    pub scale_sigma: Option<f64>,
    /// Standard deviation of the range offset.
    pub offset_sigma_m: Option<f64>,
    /// How fast the speed changes while no accelerometer measures it, per root of a second.
    pub speed_walk_m_s: Option<f64>,
    /// How fast the turn rate changes, per root of a second.
    pub turn_walk_deg_s: Option<f64>,
}

impl FusionConfig {
    /// The library's form.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(super) fn settings(&self) -> Result<FusionSettings> {
        let mut settings = FusionSettings::default();
        let put = |to: &mut f64, from: Option<f64>| *to = from.unwrap_or(*to);
        put(&mut settings.range_bias.scale_sigma, self.scale_sigma);
        put(&mut settings.range_bias.offset_sigma, self.offset_sigma_m);
        put(&mut settings.speed_walk, self.speed_walk_m_s);
        put(&mut settings.turn_walk, self.turn_walk_deg_s.map(f64::to_radians));
        settings.check()?;
        Ok(settings)
    }
}

/// What `lateration` is told beside the noise of odometry and ranges. What is left out has the
/// default.
#[derive(Debug, Clone, Copy, PartialEq, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LaterationConfig {
    /// How many of the last ranges count.
    pub window: Option<usize>,
    /// Whether odometry carries older ranges to now.
    pub odometry: Option<bool>,
    /// Without odometry, how fast the robot may be.
    pub walk_m_s: Option<f64>,
    /// How much outliers cost: `quadratic`, `{ huber = 1.345 }` or `{ cauchy = 2.385 }`.
    pub loss: Option<Loss>,
    /// Standard deviation of the range scale; 0 for ranges that are right.
    pub scale_sigma: Option<f64>,
    /// Standard deviation of the range offset.
    pub offset_sigma_m: Option<f64>,
}

impl LaterationConfig {
    /// The library's form.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub(super) fn settings(&self) -> Result<SlidingSettings> {
        let mut settings = SlidingSettings::default();
        let put = |to: &mut f64, from: Option<f64>| *to = from.unwrap_or(*to);
        put(&mut settings.walk, self.walk_m_s);
        put(&mut settings.bias.scale_sigma, self.scale_sigma);
        put(&mut settings.bias.offset_sigma, self.offset_sigma_m);
        settings.window = self.window.unwrap_or(settings.window);
        settings.odometry = self.odometry.unwrap_or(settings.odometry);
        settings.loss = self.loss.unwrap_or(settings.loss);
        settings.check()?;
        Ok(settings)
    }
}

/// A sensor in a world; see [`crate::sense`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorConfig {
    /// Its name, as `loc-sim sense --list` gives it.
    pub name: String,
    /// Its data sheet; the first one where left out.
    pub preset: Option<String>,
    /// The world that it stands in; the first one where left out.
    pub world: Option<String>,
}

impl SensorConfig {
    /// Checks the names.
    ///
    /// # Errors
    /// [`crate::Error::UnknownName`].
    pub(super) fn check(&self) -> Result<()> {
        self.request(1).check()
    }

    fn request(&self, seed: u64) -> Request {
        Request {
            sensor: self.name.clone(),
            preset: self.preset.clone(),
            world: self.world.clone(),
            seed,
            ..Request::default()
        }
    }

    /// What it reads, with its figures and tables.
    pub(super) fn illustrate(&self, seed: u64) -> Result<Illustration> {
        let reading = sense(&self.request(seed))?;
        let svg = |name: &&str| name.ends_with(".svg");
        let figures = reading.folder.names().filter(svg).map(|name| FigureFile {
            file: name.to_owned().into(),
            caption: reading.title.clone().into(),
            svg: reading.folder.text(name).unwrap_or_default().to_owned(),
        });
        let figures = figures.collect();
        let lines = reading.lines();
        Ok(Illustration { lines, summary: reading.summary, figures, data: reading.folder })
    }
}
