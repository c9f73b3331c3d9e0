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

    /// Tables of the logarithm, one for each of the `measured` ranges and all of the same length:
    /// for the expected ranges `0, step, 2 step, ..`, and +inf in the last two entries, so that
    /// there is always a next one to interpolate to.
    ///
    /// # Panics
    /// Never: tables too short for that, or none, are left as they are.
    fn tabulate(&self, measured: &[f64], step: f64, tables: &mut [f32]) {
        for (&measured, table) in measured.iter().zip(rows(tables, measured.len())) {
            let Some((finite, nothing)) = table.split_last_chunk_mut::<2>() else { return };
            for (k, logarithm) in finite.iter_mut().enumerate() {
                // The longest range itself would be no return already.
                let expected = (k as f64 * step).min(self.max_range().next_down());
                *logarithm = self.log_density(expected, measured) as f32;
            }
            nothing.fill(self.log_density(f64::INFINITY, measured) as f32);
        }
    }
}

/// The tables of `count` beams.
pub(super) fn rows(tables: &mut [f32], count: usize) -> impl Iterator<Item = &mut [f32]> {
    let entries = tables.len().checked_div(count).unwrap_or(0).max(1);
    tables.chunks_exact_mut(entries)
}
