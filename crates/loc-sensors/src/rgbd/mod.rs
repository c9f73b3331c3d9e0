//! An RGB-D camera (B7): an image with a depth for every pixel.
//!
//! A projector casts a pattern of dots on the scene; in the image of the camera beside it, each dot
//! is shifted the more the nearer the surface is. That shift, the disparity, is measured in eighths
//! of a pixel, so depth is coarse far away: the error grows with the square of the depth.
//! [`DepthImage`] and [`ColorImage`] are what it reports, [`DepthCameraSpec`] is its data sheet
//! with its [`DisparityNoise`], [`DepthCamera`] simulates it. [`DepthImage::points`] turns the
//! picture into a point cloud, [`VirtualScan`] into the scan of a laser scanner.
//!
//! ```
//! use loc_core::{Pose2, random::stream};
//! use loc_sensors::rgbd::{DepthCamera, DepthCameraSpec, VirtualScan};
//! use loc_sensors::world::{Extruded, Room};
//! let camera = DepthCamera::new(DepthCameraSpec::xtion_pro())?;
//! let room = Extruded::new(Room::new([-2.0, -2.0], [2.5, 2.0])?, 2.5)?;
//! let frame = camera.capture(&room, Pose2::IDENTITY, &mut stream(1, "camera"));
//! assert!((frame.depth.at(320, 240) - 2.5).abs() < 0.05);
//! let scan = VirtualScan::default().of(&frame.depth, &camera)?;
//! assert!(scan.beams().all(|beam| (beam.range * beam.angle.cos() - 2.5).abs() < 0.1));
//! # Ok::<(), loc_core::Error>(())
//! ```

mod image;
mod simulated;
mod spec;

pub use image::{CloudPoint, ColorImage, DepthImage, Frame, VirtualScan};
pub use simulated::DepthCamera;
pub use spec::{DepthCameraSpec, DisparityNoise};
