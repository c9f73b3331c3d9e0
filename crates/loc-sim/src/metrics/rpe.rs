//! Relative pose error: how far each estimated motion is from the true one.
//!
//! Compared are not the poses, but the motions from one pair to the next. An error made early is
//! counted once, where the absolute error carries it along for the rest of the drive; so this is
//! the figure for drift (J. Sturm et al., IROS 2012). No alignment changes it.
//!
//! The step is always one pair, as by default in `evo_rpe`, so the figures depend on the rate of
//! the trajectories: compare only those of one recording.
//!
//! ```
//! use loc_core::Pose2;
//! use loc_sim::metrics::{Pair, rpe};
//! let pair = |estimated, x| Pair::new(Pose2::new(estimated, 0.0, 0.0), Pose2::new(x, 0.0, 0.0));
//! let errors = rpe::translation_errors(&[pair(7.0, 0.0), pair(8.0, 1.0), pair(9.25, 2.0)]);
//! assert_eq!(errors, [0.0, 0.25]);
//! ```

use super::{Pair, RigidPose};

/// Length of the translation that is between the two motions of each step \[m\].
pub fn translation_errors<P: RigidPose>(pairs: &[Pair<P>]) -> Vec<f64> {
    errors(pairs).map(|e| e.position().norm()).collect()
}

/// Angle of the rotation that is between the two motions of each step, in \[0, 180\] \[deg\].
pub fn rotation_errors<P: RigidPose>(pairs: &[Pair<P>]) -> Vec<f64> {
    errors(pairs).map(|error| error.rotation_angle().to_degrees()).collect()
}

/// The estimated motion as seen from the true one, from each pair to the next.
fn errors<P: RigidPose>(pairs: &[Pair<P>]) -> impl Iterator<Item = P> {
    pairs.windows(2).map(|step| {
        let truth = step[0].reference.between(step[1].reference);
        truth.between(step[0].estimate.between(step[1].estimate))
    })
}
