//! The exponential map of SE(2): a constant twist, driven for one unit of time, is an arc.

use super::Pose2;
use crate::motion::Chord;
use nalgebra::Vector3;

impl Pose2 {
    /// Where a frame ends that moves by (dx, dy, dtheta) with constant velocity in its own frame.
    ///
    /// Exact arc about the instantaneous centre of rotation, stable as dtheta tends to 0.
    pub fn exp(tangent: &Vector3<f64>) -> Pose2 {
        let chord = Chord::exact(tangent.z);
        let (dx, dy) = (tangent.x, tangent.y);
        Pose2::new(
            chord.along * dx - chord.across * dy,
            chord.across * dx + chord.along * dy,
            tangent.z,
        )
    }

    /// The tangent vector (dx, dy, dtheta) that [`exp`](Pose2::exp) takes to this pose, with
    /// dtheta in (-pi, pi].
    pub fn log(self) -> Vector3<f64> {
        let chord = Chord::exact(self.theta);
        let square = chord.along * chord.along + chord.across * chord.across;
        Vector3::new(
            (chord.along * self.x + chord.across * self.y) / square,
            (chord.along * self.y - chord.across * self.x) / square,
            self.theta,
        )
    }
}
