//! What light does on its way: glass and mirrors.

use crate::world::{RangeWorld, Surface};
use nalgebra::{Point2, Vector2};
use rand::{Rng, RngExt};

/// Between two mirrors a beam runs back and forth; after this many panes it is lost.
const MAX_PANES: usize = 16;

/// Length of the way \[m\] that a beam takes through the panes of a world until it returns, +inf
/// where it does not within `reach`. `wall` is the distance to the first wall without them.
pub(super) fn through_panes<R: Rng + ?Sized>(
    world: &(impl RangeWorld + ?Sized),
    mut origin: Point2<f64>,
    mut direction: f64,
    mut wall: f64,
    reach: f64,
    rng: &mut R,
) -> f64 {
    let (mut travelled, mut last) = (0.0, None);
    for _ in 0..MAX_PANES {
        let (sin, cos) = direction.sin_cos();
        let along = Vector2::new(cos, sin);
        let Some((index, distance)) = nearest(world, &origin, &along, last) else {
            return travelled + wall;
        };
        if distance >= wall || travelled + distance > reach {
            return travelled + wall;
        }
        origin += along * distance;
        travelled += distance;
        last = Some(index);
        match world.panes()[index].surface {
            Surface::Glass { pass } if rng.random::<f64>() >= pass => return travelled,
            Surface::Glass { .. } => wall -= distance,
            Surface::Mirror => {
                direction = world.panes()[index].reflect(direction);
                let rest = reach - travelled;
                wall = world.cast(&origin, direction, rest).unwrap_or(f64::INFINITY);
            }
        }
    }
    f64::INFINITY
}

/// The nearest pane along a ray and its distance \[m\], without the one that the ray starts on.
fn nearest(
    world: &(impl RangeWorld + ?Sized),
    origin: &Point2<f64>,
    along: &Vector2<f64>,
    start: Option<usize>,
) -> Option<(usize, f64)> {
    let panes = world.panes().iter().enumerate().filter(|(index, _)| Some(*index) != start);
    panes
        .filter_map(|(index, pane)| pane.distance(origin, along).map(|range| (index, range)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
}
