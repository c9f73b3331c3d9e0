//! Central differences, the independent computation that Jacobians are held against.

use loc_core::angle;
use nalgebra::{SMatrix, SVector};

/// The Jacobian of `f` at `x` by central differences; row `angle_row` of the output is an angle.
pub(crate) fn jacobian<const M: usize, const N: usize>(
    f: impl Fn(SVector<f64, N>) -> SVector<f64, M>,
    x: SVector<f64, N>,
    angle_row: Option<usize>,
) -> SMatrix<f64, M, N> {
    let mut out = SMatrix::<f64, M, N>::zeros();
    for column in 0..N {
        let h = 1e-6 * (1.0 + x[column].abs());
        let (mut above, mut below) = (x, x);
        above[column] += h;
        below[column] -= h;
        let mut slope = f(above) - f(below);
        if let Some(row) = angle_row {
            slope[row] = angle::wrap(slope[row]);
        }
        out.set_column(column, &(slope / (2.0 * h)));
    }
    out
}
