//! How likely a single beam is at a pose of the laser.

use crate::sensor::beam::{BeamModel, RangeModel};
use loc_maps::{LikelihoodField, RayCaster};
use nalgebra::Point2;

/// By the likelihood field: how near a beam ends to an obstacle. Beams without a return are
/// equally likely everywhere.
///
/// The closure takes the place of the laser in the map \[m\], the direction of the beam there as a
/// unit vector, and its range \[m\], and returns the logarithm.
pub fn by_field(field: &LikelihoodField) -> impl Fn(Point2<f64>, [f64; 2], f64) -> f64 + '_ {
    move |laser, [x, y], range| {
        if !range.is_finite() {
            return 0.0;
        }
        field.log_likelihood_at(&Point2::new(laser.x + range * x, laser.y + range * y))
    }
}

/// By the beam model: a ray for each beam and pose. The closure is as for [`by_field`].
pub fn by_casting<'a>(
    caster: &'a RayCaster,
    model: &'a BeamModel,
) -> impl Fn(Point2<f64>, [f64; 2], f64) -> f64 + 'a {
    let frame = caster.frame();
    let max_length = model.max_range() / frame.resolution();
    move |laser, direction, range| {
        let Point2 { coords } = frame.to_cells(&laser);
        let along = frame.turn_to_grid(direction);
        let length = caster.cast_in_cells([coords.x, coords.y], along, max_length);
        let expected = length.map_or(f64::INFINITY, |length| length * frame.resolution());
        model.log_density(expected, range)
    }
}
