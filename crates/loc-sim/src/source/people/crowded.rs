//! A world with people before its walls.

use loc_core::angle;
use loc_sensors::world::{MovingObject, Pane, RangeWorld};
use nalgebra::{Point2, Vector2};

/// Walls with round people before them. Someone who covers the laser itself is not seen.
#[derive(Debug, Clone, Copy)]
pub struct Crowded<'a, W> {
    pub(super) walls: W,
    pub(super) people: &'a [MovingObject],
}

impl<W: RangeWorld> RangeWorld for Crowded<'_, W> {
    fn cast(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<f64> {
        let (sin, cos) = direction.sin_cos();
        let wall = self.walls.cast(origin, direction, max_range).unwrap_or(f64::INFINITY);
        let people = self.people.iter();
        let hits = people.filter_map(|person| distance(person, origin, &Vector2::new(cos, sin)));
        let range = hits.fold(wall, f64::min);
        (range <= max_range).then_some(range)
    }

    fn cast_fan(
        &self,
        origin: &Point2<f64>,
        first: f64,
        increment: f64,
        max_range: f64,
        ranges: &mut [f64],
    ) {
        self.walls.cast_fan(origin, first, increment, max_range, ranges);
        for person in self.people {
            let to_person = person.position - origin;
            let far = to_person.norm();
            if far <= person.radius || far - person.radius > max_range {
                continue;
            }
            let middle = to_person.y.atan2(to_person.x);
            let half = (person.radius / far).asin() + increment.abs();
            for (k, range) in ranges.iter_mut().enumerate() {
                let direction = first + k as f64 * increment;
                if angle::difference(direction, middle).abs() > half {
                    continue;
                }
                let (sin, cos) = direction.sin_cos();
                let hit = distance(person, origin, &Vector2::new(cos, sin));
                *range = hit.filter(|hit| *hit <= max_range).map_or(*range, |hit| hit.min(*range));
            }
        }
    }

    fn panes(&self) -> &[Pane] {
        self.walls.panes()
    }
}

/// Distance along a unit vector to someone; `None` where the ray misses them.
fn distance(person: &MovingObject, origin: &Point2<f64>, along: &Vector2<f64>) -> Option<f64> {
    let to_person = person.position - origin;
    let nearest = to_person.dot(along);
    let past = to_person.norm_squared() - nearest * nearest;
    let square = person.radius * person.radius - past;
    let range = nearest - square.sqrt();
    // NaN for a ray that misses is not above 0 either.
    (range > 0.0).then_some(range)
}
