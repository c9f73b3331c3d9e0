//! The methods by name: what each needs, its settings, and how it starts on a source.
//!
//! A new method implements [`Localizer`] in a crate below; here it gets a name in [`Method`], its
//! settings in [`MethodSettings`], and a line in [`Method::start`].

mod settings;

pub use settings::MethodSettings;

use crate::source::Setup;
use crate::{Error, Result};
use loc_core::random::stream;
use loc_filters::dead_reckoning::DeadReckoning;
use loc_filters::delayed::{Delayed, Sequential};
use loc_filters::fusion::FusedLocalizer;
use loc_filters::fusion::state::STATES;
use loc_filters::histogram::GridLocalizer;
use loc_filters::kalman::rail::RailLocalizer;
use loc_filters::landmark::LandmarkLocalizer;
use loc_filters::lateration::SlidingLateration;
use loc_filters::line_matching::{self, LineFilter};
use loc_filters::localizer::{Estimate, Localizer};
use loc_filters::slam::{LinearSlamLocalizer, SlamLocalizer};
use loc_filters::smoother::{Recorded, smooth};
use loc_filters::{
    ExtendedKalmanFilter as Extended, NonlinearFilter, UnscentedKalmanFilter as Unscented,
};
use loc_maps::{LandmarkMap, LineMap, OccupancyGrid};
use loc_pf::{FastSlamLocalizer, LandmarkMcl, Mcl};
use loc_sensors::event::Event;
use std::str::FromStr;
use std::sync::Arc;

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

    /// Whether it can find the robot without a start pose.
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
        let make = Make { method: self, setup, settings };
        Ok(match self {
            Method::DeadReckoning if setup.rail.is_some() => {
                Box::new(make.rail()?.without_corrections())
            }
            Method::DeadReckoning => Box::new(make.dead_reckoning()?),
            Method::Lateration => make.delayed(make.lateration()?)?,
            Method::Kf => Box::new(make.rail()?),
            Method::Ekf => make.delayed(make.landmarks::<Extended<3>>()?)?,
            Method::Ukf => make.delayed(make.landmarks::<Unscented<3>>()?)?,
            Method::LineEkf => Box::new(make.lines::<Extended<{ line_matching::STATES }>>()?),
            Method::LineUkf => Box::new(make.lines::<Unscented<{ line_matching::STATES }>>()?),
            Method::Fusion => make.delayed(make.fusion::<Extended<STATES>>()?)?,
            Method::FusionUkf => make.delayed(make.fusion::<Unscented<STATES>>()?)?,
            Method::Histogram => Box::new(make.histogram()?),
            // Where both can be had, scans tell more than landmarks.
            Method::Mcl if setup.has_laser || setup.landmarks.is_empty() => Box::new(make.mcl()?),
            Method::Mcl => make.delayed(make.landmark_mcl()?)?,
            Method::KfSlam => Box::new(make.kf_slam()?),
            Method::EkfSlam => make.delayed(make.ekf_slam()?)?,
            Method::FastSlam => make.delayed(make.fastslam()?)?,
        })
    }

    /// The smoothed estimates at `stamps` \[s\], which are in order of time, from all events.
    ///
    /// # Errors
    /// [`Error::Unsuitable`] for a method that [cannot be smoothed](Method::can_smooth), and what the
    /// filter refuses.
    pub(crate) fn smooth(
        self,
        setup: &Setup,
        settings: &MethodSettings,
        events: &[Event],
        stamps: &[f64],
    ) -> Result<Vec<Estimate>> {
        let make = Make { method: self, setup, settings };
        Ok(match self {
            Method::Kf => smooth(make.rail()?.recorded()?, events, stamps)?,
            Method::Ekf => smooth(make.landmarks::<Recorded<Extended<3>, 3>>()?, events, stamps)?,
            Method::Ukf => smooth(make.landmarks::<Recorded<Unscented<3>, 3>>()?, events, stamps)?,
            Method::LineEkf => smooth(make.lines::<Recorded<Extended<_>, _>>()?, events, stamps)?,
            Method::LineUkf => smooth(make.lines::<Recorded<Unscented<_>, _>>()?, events, stamps)?,
            Method::Fusion => smooth(make.fusion::<Recorded<Extended<_>, _>>()?, events, stamps)?,
            Method::FusionUkf => {
                smooth(make.fusion::<Recorded<Unscented<_>, _>>()?, events, stamps)?
            }
            _ => return Err(make.unsuitable("beliefs of a Kalman filter to smooth")),
        })
    }
}

/// Makes the localizers from what is known of a source.
struct Make<'a> {
    method: Method,
    setup: &'a Setup,
    settings: &'a MethodSettings,
}

impl Make<'_> {
    fn unsuitable(&self, expected: &'static str) -> Error {
        let (method, source_name) = (self.method.name().into(), self.setup.name.clone());
        Error::Unsuitable { method, expected, source_name }
    }

    /// A localizer that takes inputs up to the horizon of the settings late.
    fn delayed<L: Sequential + 'static>(&self, localizer: L) -> Result<Box<dyn Localizer>> {
        Ok(Box::new(Delayed::new(localizer, self.settings.robot.horizon)?))
    }

    fn map(&self) -> Result<&OccupancyGrid> {
        self.setup.map.as_deref().ok_or_else(|| self.unsuitable("a map"))
    }

    fn landmark_map(&self) -> Result<Arc<LandmarkMap>> {
        if self.setup.landmarks.is_empty() {
            return Err(self.unsuitable("landmarks"));
        }
        Ok(self.setup.landmarks.clone())
    }

    fn dead_reckoning(&self) -> Result<DeadReckoning> {
        let (start, belief) = (self.setup.start, self.setup.start_belief);
        Ok(DeadReckoning::new(self.settings.robot, start, belief)?)
    }

    fn rail(&self) -> Result<RailLocalizer> {
        let start = self.setup.rail.ok_or_else(|| self.unsuitable("a vehicle on a rail"))?;
        Ok(RailLocalizer::new(self.settings.rail.clone(), self.setup.start, start)?)
    }

    fn lateration(&self) -> Result<SlidingLateration> {
        let (map, settings) = (self.landmark_map()?, self.settings.lateration);
        let lateration = SlidingLateration::new(map, settings, self.setup.start)?;
        if self.settings.global {
            return Ok(lateration);
        }
        Ok(lateration.start_at(&self.setup.start_belief)?)
    }

    fn landmarks<F: NonlinearFilter<3>>(&self) -> Result<LandmarkLocalizer<F>> {
        let (map, settings) = (self.landmark_map()?, self.settings.robot);
        let (start, belief) = (self.setup.start, self.setup.start_belief);
        Ok(LandmarkLocalizer::with_filter(map, settings, start, belief)?)
    }

    /// In the lines of the setup or, without any, in those found in its grid.
    fn lines<F: NonlinearFilter<{ line_matching::STATES }>>(&self) -> Result<LineFilter<F>> {
        let own = self.settings.line_matching;
        let (lines, settings) = match (&self.setup.lines, &self.setup.map) {
            (Some(lines), _) => (lines.clone(), own),
            (None, Some(grid)) => {
                let lines = LineMap::from_grid(grid, &Default::default())?;
                // Walls that were mapped are not quite straight, and not quite in their place.
                let map_sigma = own.map_sigma.max(grid.resolution());
                (Arc::new(lines), own.map_sigma(map_sigma))
            }
            (None, None) => return Err(self.unsuitable("a map")),
        };
        Ok(LineFilter::new(lines, settings, self.setup.start_belief)?)
    }

    fn fusion<F: NonlinearFilter<STATES>>(&self) -> Result<FusedLocalizer<F>> {
        if self.setup.rail.is_some() {
            return Err(self.unsuitable("a robot in the plane"));
        }
        let (map, settings) = (self.setup.landmarks.clone(), self.settings.fusion);
        let (start, belief) = (self.setup.start, self.setup.start_belief);
        Ok(FusedLocalizer::with_filter(map, settings, start, belief)?)
    }

    fn histogram(&self) -> Result<GridLocalizer> {
        let mut grid = GridLocalizer::new(self.map()?, self.settings.histogram)?;
        if !self.settings.global {
            grid.start_at(&self.setup.start_belief)?;
        }
        Ok(grid)
    }

    fn mcl(&self) -> Result<Mcl> {
        let rng = stream(self.settings.seed, "mcl");
        let mut mcl = Mcl::new(self.map()?, self.settings.mcl.clone(), rng)?;
        if !self.settings.global {
            mcl.start_at(&self.setup.start_belief)?;
        }
        Ok(mcl)
    }

    fn landmark_mcl(&self) -> Result<LandmarkMcl> {
        let (map, rng) = (self.setup.landmarks.clone(), stream(self.settings.seed, "mcl"));
        let (settings, start) = (self.settings.landmark_mcl, self.setup.start);
        Ok(if self.settings.global {
            LandmarkMcl::anywhere(map, settings, start, rng)?
        } else {
            LandmarkMcl::new(map, settings, start, &self.setup.start_belief, rng)?
        })
    }

    fn kf_slam(&self) -> Result<LinearSlamLocalizer> {
        let (start, belief) = (self.setup.start, &self.setup.start_belief);
        Ok(LinearSlamLocalizer::new(self.settings.slam, start, belief)?)
    }

    fn ekf_slam(&self) -> Result<SlamLocalizer> {
        let (start, belief) = (self.setup.start, self.setup.start_belief);
        Ok(SlamLocalizer::new(self.settings.slam, start, belief)?)
    }

    fn fastslam(&self) -> Result<FastSlamLocalizer> {
        let rng = stream(self.settings.seed, "fastslam");
        let (start, belief) = (self.setup.start, self.setup.start_belief);
        Ok(FastSlamLocalizer::new(self.settings.fastslam, start, belief, rng)?)
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
