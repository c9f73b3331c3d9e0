//! What a method believes about the error of a sensor.

/// An error of a sensor that lasts, as a method estimates it.
///
/// ```
/// use loc_sim::localizer::SensorError;
/// let bias = SensorError { name: "gyroscope [deg/s]", mean: 0.02, sigma: 0.005 };
/// assert!(bias.mean > 3.0 * bias.sigma, "known to be wrong");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SensorError {
    /// The sensor with the unit of the error.
    pub name: &'static str,
    /// The error, in that unit.
    pub mean: f64,
    /// Its standard deviation.
    pub sigma: f64,
}
