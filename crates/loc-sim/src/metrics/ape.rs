//! Absolute pose error: how far each estimated pose is from the true one.
//!
//! The translation part is also known as ATE, the absolute trajectory error (J. Sturm et al., A
//! benchmark for the evaluation of RGB-D SLAM systems, IROS 2012). The rotation part is the angle
//! of the turn between the two orientations; in the plane, the size of the heading error.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_sim::metrics::{Pair, ape};
//! let pairs = [Pair::new(Pose2::new(3.0, 4.0, 3.1), Pose2::new(0.0, 0.0, -3.1))];
//! assert_eq!(ape::translation_errors(&pairs), [5.0]);
//! // Across the wrap, 6.2 rad apart are 4.8 degrees apart.
//! assert!((ape::rotation_errors(&pairs)[0] - 4.766).abs() < 1e-3);
//! ```

use super::{Pair, RigidPose};

/// Distance between the two positions of each pair \[m\].
pub fn translation_errors<P: RigidPose>(pairs: &[Pair<P>]) -> Vec<f64> {
    let distance = |pair: &Pair<P>| (pair.estimate.position() - pair.reference.position()).norm();
    pairs.iter().map(distance).collect()
}

/// Angle between the two orientations of each pair, in \[0, 180\] \[deg\].
pub fn rotation_errors<P: RigidPose>(pairs: &[Pair<P>]) -> Vec<f64> {
    let turn = |pair: &Pair<P>| pair.estimate.between(pair.reference).rotation_angle();
    pairs.iter().map(|pair| turn(pair).to_degrees()).collect()
}
