//! A camera that recognises numbered landmarks (B6): their distance, their direction, or both.
//!
//! A [`LandmarkObservation`] is what such a camera reports of one landmark. [`LandmarkNoise`] says how far
//! it may be off, [`LandmarkCamera`] simulates it, with its field of view, missed detections and
//! wrong numbers, and [`CameraCalibration`] corrects what a real one reports.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_sensors::landmark_camera::{LandmarkCamera, LandmarkNoise, Observed};
//! use loc_sensors::world::Landmarks;
//! let camera = LandmarkCamera { noise: LandmarkNoise::NONE, ..LandmarkCamera::default() };
//! let world = Landmarks::from([(5, [3.0, 4.0])]);
//! let seen = camera.observe(&world, Pose2::IDENTITY, &mut stream(1, "camera"));
//! assert!(matches!(seen[0].sight, Observed::RangeBearing { range, .. } if range == 5.0));
//! ```

mod observation;
mod simulated;

pub use observation::{
    CameraCalibration, LandmarkNoise, LandmarkObservation, Observed, ObservedKind,
};
pub use simulated::LandmarkCamera;
