//! States of which some are angles.

use loc_core::angle;
use nalgebra::SVector;

/// A state whose angles are in (-pi, pi]; indices beyond the state are passed over.
pub(crate) fn wrapped<const N: usize>(
    mut state: SVector<f64, N>,
    angles: &[usize],
) -> SVector<f64, N> {
    for &index in angles {
        if let Some(value) = state.get_mut(index) {
            *value = angle::wrap(*value);
        }
    }
    state
}
