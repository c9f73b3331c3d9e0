//! What a likelihood over poses needs to know about ranges.

/// How likely a range is where the map lets expect another one: `p(measured | expected)` (K2).
///
/// Ranges are in metres; +inf stands for no return, where nothing was in reach or nothing is
/// expected to be.
pub trait RangeModel {
    /// Ranges from here on count as no return \[m\]; finite and above 0.
    fn max_range(&self) -> f64;

    /// Distance of two expected ranges between which the logarithm may be interpolated \[m\].
    fn step(&self) -> f64;

    /// `ln p(measured | expected)`, a density \[1/m\] for a finite `measured` and a probability for
    /// +inf. Finite for every pair of ranges that are not NaN.
    fn log_density(&self, expected: f64, measured: f64) -> f64;

    /// The logarithms for one measured range and the expected ranges `0, step, 2 step, ..`, the
    /// last of them for +inf.
    fn tabulate(&self, measured: f64, step: f64, logarithms: &mut [f32]) {
        let Some((nothing, finite)) = logarithms.split_last_mut() else { return };
        for (k, logarithm) in finite.iter_mut().enumerate() {
            *logarithm = self.log_density(k as f64 * step, measured) as f32;
        }
        *nothing = self.log_density(f64::INFINITY, measured) as f32;
    }
}
