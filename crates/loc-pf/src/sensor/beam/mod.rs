//! The beam model: how likely are the ranges of a scan, given what the map lets expect (M6)?
//!
//! For a pose one casts every beam in the map and compares what it should measure with what it
//! did. A range may be the expected one with a little noise (hit), shorter because somebody
//! stands in the way (short), missing (max), or anything (random); [`BeamModel`] weighs these four
//! against each other. Beams that see nothing tell something too: that there is no wall near. The
//! likelihood field, which casts no rays and is faster for it, cannot know that.
//!
//! [`BeamLikelihood`] holds a scan against a map, from the place of the *laser* on the robot.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::worlds::{self, WorldSettings};
//! use loc_maps::RayCaster;
//! use loc_pf::mcl::MountedScan;
//! use loc_pf::sensor::beam::{BeamLikelihood, BeamModelSettings, telling_beams};
//! use loc_sensors::laser::LaserScan;
//! use loc_sensors::world::RangeWorld;
//! let world = worlds::office(&WorldSettings { width: 200, height: 200, ..Default::default() })?;
//! let caster = RayCaster::new(&world.grid);
//! let truth = Pose2::new(5.0, 5.0, 0.3);
//! let mut scan = LaserScan {
//!     angle_min: -1.5, angle_max: 1.45, angle_increment: 0.05,
//!     time_increment: 0.0, scan_time: 0.1, range_min: 0.1, range_max: 20.0,
//!     ranges: vec![0.0; 60], intensities: Vec::new(),
//! };
//! caster.cast_fan(&truth.position(), 0.3 - 1.5, 0.05, 20.0, &mut scan.ranges);
//! let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
//! let beams = telling_beams(&scan, 30);
//! let settings = BeamModelSettings::default();
//! let likelihood = BeamLikelihood::new(&caster, &settings, &mounted, &beams, 1.0)?;
//! let right = likelihood.log_likelihood(truth);
//! let wrong = likelihood.log_likelihood(Pose2::new(5.0, 5.0, 0.6));
//! assert!(right > wrong + 3.0);
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod likelihood;
mod model;
mod range_model;
mod select;
mod settings;

pub use likelihood::BeamLikelihood;
pub use model::BeamModel;
pub use range_model::RangeModel;
pub use select::telling_beams;
pub(crate) use select::{reading, telling_beams_from, thinned};
pub use settings::{BeamForm, BeamModelSettings};
