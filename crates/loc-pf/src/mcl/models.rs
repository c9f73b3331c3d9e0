//! The models that [`Mcl`](super::Mcl) is open to: how the robot moves, and how likely scans are.
//!
//! The models of the settings ([`MotionSettings`], [`SensorSettings`]) implement these traits, and so
//! may a user's own: tempering, recovery, clusters and the lost figure work with any.

use super::scan::{MountedScan, Observation};
use super::{FieldSettings, MotionSettings, SensorSettings, Weighting};
use crate::motion::{DifferentialStep, DrivenPath, NoisyStep, OmnidirectionalStep};
use crate::sensor::{BeamLikelihood, BeamSkip, FieldLikelihood, SumOfCubes};
use crate::{Likelihood, Motion, PosesMut, Result, Transport};
use loc_core::Pose2;
use loc_core::random::ChaCha8Rng;
use loc_filters::RobotSettings;
use loc_maps::likelihood_field::{Endpoints, LikelihoodFieldSettings};
use loc_maps::{LikelihoodField, RayCaster};

/// A motion model: how the robot may have moved along a path of its odometry.
pub trait MotionModel: Send + Sync {
    /// A step with its noise.
    type Step: Motion + Transport;

    /// The step along a path, for a robot with these properties.
    ///
    /// # Errors
    /// A path that the model has no step for.
    fn step(&self, path: &DrivenPath, robot: &RobotSettings) -> Result<Self::Step>;
}

/// A sensor model: how likely scans are at each of many poses.
///
/// ```
/// use loc_core::{Pose2, gaussian::pose_belief, random::stream};
/// use loc_maps::{RayCaster, worlds::{self, WorldSettings}};
/// use loc_pf::mcl::{MountedScan, MotionSettings, ScanModel, ScanView};
/// use loc_pf::{Mcl, MclSettings};
/// # use loc_sensors::laser::{LaserScanner, LaserSpec};
/// /// Every beam that ends within 10 cm of an obstacle counts for the pose, whatever the others do.
/// struct Votes;
/// impl ScanModel for Votes {
///     type Likelihood<'a> = Box<dyn Fn(Pose2) -> f64 + Sync + 'a>;
///
///     fn likelihood<'a>(&'a self, scan: &ScanView<'a>) -> loc_pf::Result<Self::Likelihood<'a>> {
///         let (field, ends, exponent) = (scan.field, scan.endpoints, scan.exponent);
///         let near = field.settings().likelihood(0.1).ln();
///         Ok(Box::new(move |pose: Pose2| {
///             let places = ends.points().map(|end| pose.transform(&end));
///             let votes = places.filter(|place| field.log_likelihood_at(place) > near);
///             exponent * 2.0 * votes.count() as f64
///         }))
///     }
/// }
/// # let map = worlds::office(&WorldSettings { width: 300, height: 300, ..Default::default() })?.grid;
/// # let truth = Pose2::new(7.5, 7.5, 0.4);
/// # let laser = LaserScanner::new(LaserSpec::sick_lms100())?;
/// # let scan = laser.scan(&RayCaster::new(&map), truth, &mut stream(1, "laser"));
/// let (settings, rng) = (MclSettings::default(), stream(1, "mcl"));
/// let mut mcl = Mcl::with_models(&map, settings, MotionSettings::Path, Votes, rng)?;
/// mcl.start_at(&pose_belief(Pose2::new(7.4, 7.6, 0.35), [0.2, 0.2, 0.1]))?;
/// mcl.update(Pose2::IDENTITY, &[MountedScan { scan: &scan, mounting: Pose2::IDENTITY }])?;
/// assert!(mcl.pose().distance(truth) < 0.1);
/// # Ok::<(), loc_pf::Error>(())
/// ```
pub trait ScanModel: Send + Sync {
    /// Scans of one time, prepared to rate poses. A `Box<dyn Fn(Pose2) -> f64 + Sync + 'a>` is one:
    /// it returns the log-likelihood at a pose.
    type Likelihood<'a>: Likelihood
    where
        Self: 'a;

    /// Prepares scans to rate poses.
    ///
    /// # Errors
    /// Scans that the model cannot rate.
    fn likelihood<'a>(&'a self, scan: &ScanView<'a>) -> Result<Self::Likelihood<'a>>;

    /// The likelihood field of [`ScanView::field`], which the search of the map uses as well.
    fn field(&self) -> LikelihoodFieldSettings {
        LikelihoodFieldSettings::default()
    }

    /// Whether the model needs [`ScanView::caster`].
    fn casts_rays(&self) -> bool {
        false
    }

    /// Whether beams without a return are used.
    fn uses_beams_without_return(&self) -> bool {
        false
    }

    /// Beam skipping; `None` for none.
    fn beam_skip(&self) -> Option<BeamSkip> {
        None
    }

    /// Whether the likelihood is the product over a likelihood field, so that a common offset of the
    /// ranges can be estimated from it.
    fn is_field_product(&self) -> bool {
        false
    }
}

/// Scans of one time and what they may be compared with.
#[derive(Debug, Clone, Copy)]
pub struct ScanView<'a> {
    /// The scans with the mountings of their scanners.
    pub scans: &'a [MountedScan<'a>],
    /// For each scan the numbers of the beams to use.
    pub beams: &'a [Vec<usize>],
    /// Where these beams end, in the robot's frame.
    pub endpoints: &'a Endpoints,
    /// The likelihood field of the map.
    pub field: &'a LikelihoodField,
    /// The obstacles of the map, for a model that casts rays.
    pub caster: Option<&'a RayCaster>,
    /// Power to which the product of the beams' likelihoods is to be raised, in (0, 1]: they are not
    /// independent of each other.
    pub exponent: f64,
}

/// A step by one of the models of [`MotionSettings`].
#[derive(Debug, Clone, Copy)]
pub enum ModelStep {
    /// Along a path.
    Path(NoisyStep),
    /// Of a differential drive.
    Differential(DifferentialStep),
    /// Of an omnidirectional drive.
    Omnidirectional(OmnidirectionalStep),
}

impl MotionModel for MotionSettings {
    type Step = ModelStep;

    fn step(&self, path: &DrivenPath, robot: &RobotSettings) -> Result<ModelStep> {
        let (from, to) = (path.start(), path.end());
        Ok(match self {
            MotionSettings::Path => ModelStep::Path(NoisyStep::new(path, &robot.path)),
            MotionSettings::Differential(noise) => {
                ModelStep::Differential(DifferentialStep::between(from, to, noise)?)
            }
            MotionSettings::Omnidirectional(noise) => {
                ModelStep::Omnidirectional(OmnidirectionalStep::between(from, to, noise)?)
            }
        })
    }
}

impl Motion for ModelStep {
    fn sample(&self, poses: PosesMut<'_>, rng: &mut ChaCha8Rng) {
        match self {
            ModelStep::Path(step) => step.sample(poses, rng),
            ModelStep::Differential(step) => step.sample(poses, rng),
            ModelStep::Omnidirectional(step) => step.sample(poses, rng),
        }
    }
}

impl Transport for ModelStep {
    #[inline]
    fn moved(&self, pose: Pose2, noise: [f64; 4]) -> Pose2 {
        match self {
            ModelStep::Path(step) => step.moved(pose, noise),
            ModelStep::Differential(step) => step.moved(pose, noise),
            ModelStep::Omnidirectional(step) => step.moved(pose, noise),
        }
    }
}

impl ScanModel for SensorSettings {
    type Likelihood<'a> = Observation<'a>;

    fn likelihood<'a>(&'a self, scan: &ScanView<'a>) -> Result<Observation<'a>> {
        let ScanView { scans, beams, endpoints, field, caster, exponent } = *scan;
        Ok(match (self, caster) {
            (SensorSettings::Beam(model), Some(caster)) => {
                let rate = |(mounted, beams): (&MountedScan<'_>, &Vec<usize>)| {
                    BeamLikelihood::new(caster, model, mounted, beams, exponent)
                };
                Observation::Beams(scans.iter().zip(beams).map(rate).collect::<Result<_>>()?)
            }
            (SensorSettings::LikelihoodField(model), _)
                if model.weighting == Weighting::SumOfCubes =>
            {
                Observation::SumOfCubes(Box::new(SumOfCubes::new(field, endpoints)))
            }
            _ => Observation::Product(FieldLikelihood { field, endpoints, exponent }),
        })
    }

    fn field(&self) -> LikelihoodFieldSettings {
        match self {
            SensorSettings::LikelihoodField(settings) => settings.field,
            SensorSettings::Beam(_) => LikelihoodFieldSettings::default(),
        }
    }

    fn casts_rays(&self) -> bool {
        matches!(self, SensorSettings::Beam(_))
    }

    fn uses_beams_without_return(&self) -> bool {
        matches!(self, SensorSettings::Beam(_))
    }

    fn beam_skip(&self) -> Option<BeamSkip> {
        match self {
            SensorSettings::LikelihoodField(FieldSettings { beam_skip, .. }) => *beam_skip,
            SensorSettings::Beam(_) => None,
        }
    }

    fn is_field_product(&self) -> bool {
        matches!(self, SensorSettings::LikelihoodField(field) if field.weighting == Weighting::Product)
    }
}
