//! Novelty filters: leaving out the beams that hit what is on no map (K3).
//!
//! A localizer takes for granted that measurements depend on the pose alone. People who walk along
//! with a robot break that for many cycles in a row: the beams that end on them agree with some
//! wrong place, and in the end the filter does too. Fox, Burgard and Thrun ("Markov localization
//! for mobile robots in dynamic environments", 1999) sort beams out before they are used, by what
//! the robot believes already. The [`DistanceFilter`] drops a beam that is almost surely shorter
//! than the map lets expect; it is for range finders, and what to use. The [`EntropyFilter`] drops
//! a beam that would make the robot less sure of its pose; it works for any sensor, but also drops
//! the news that the robot is somewhere else.
//!
//! Both look at a [`BeliefSample`], a few poses of the cloud after the motion and before weighing.
//!
//! ```
//! use loc_core::{Pose2, gaussian::pose_belief, random::stream};
//! use loc_maps::RayCaster;
//! use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
//! use loc_pf::Particles;
//! use loc_pf::mcl::MountedScan;
//! use loc_pf::novelty::{BeliefSample, DistanceFilter};
//! use loc_sensors::laser::LaserScan;
//! let mut grid = OccupancyGrid::filled(GridFrame::new(200, 200, 0.05, Pose2::IDENTITY)?, 0);
//! (0..200).try_for_each(|row| grid.set(Cell::new(160, row), 100))?;
//! let caster = RayCaster::new(&grid);
//! // The wall is 3 m ahead; somebody stands before the second of the five beams.
//! let scan = LaserScan {
//!     angle_min: -0.2, angle_max: 0.2, angle_increment: 0.1,
//!     time_increment: 0.0, scan_time: 0.1, range_min: 0.1, range_max: 20.0,
//!     ranges: vec![3.06, 1.2, 3.0, 3.01, 3.06], intensities: Vec::new(),
//! };
//! let mounted = MountedScan { scan: &scan, mounting: Pose2::IDENTITY };
//! let belief = pose_belief(Pose2::new(5.0, 5.0, 0.0), [0.1, 0.1, 0.05]);
//! let cloud = Particles::from_gaussian(&belief, 500, &mut stream(1, "filter"));
//! let sample = BeliefSample::of(&cloud, 64);
//! let kept = DistanceFilter::default().keep(&caster, &sample, &mounted, &[0, 1, 2, 3, 4])?;
//! assert_eq!((kept.beams, kept.novel), (vec![0, 2, 3, 4], 1));
//! # Ok::<(), loc_pf::Error>(())
//! ```

mod distance;
mod entropy;
mod rating;
mod sample;

pub use distance::DistanceFilter;
pub use entropy::EntropyFilter;
pub use rating::{by_casting, by_field};
pub use sample::BeliefSample;

/// What a filter says of the beams of a scan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Kept {
    /// Numbers of the beams to use, in the order in which they were given.
    pub beams: Vec<usize>,
    /// How many did not fit the belief; they are kept nevertheless where there are too many.
    pub novel: usize,
}

/// The beams without the novel ones, or all of them where more than a share `most` is novel: then
/// it is the belief that does not fit.
fn without(beams: &[usize], is_novel: &[bool], most: f64) -> Kept {
    let novel = is_novel.iter().filter(|novel| **novel).count();
    let all = novel as f64 > most * beams.len() as f64;
    let pairs = beams.iter().zip(is_novel);
    let kept = pairs.filter(|(_, novel)| all || !**novel).map(|(beam, _)| *beam);
    Kept { beams: kept.collect(), novel }
}
