//! The smallest world with walls: a rectangle with round pillars, cast exactly.

use super::RangeWorld;
use crate::Result;
use crate::check::in_range;
use loc_core::error::{finite, positive};
use nalgebra::{Point2, Vector2};

/// A rectangular room along the axes of the map, with pillars.
#[derive(Debug, Clone, PartialEq)]
pub struct Room {
    lower: [f64; 2],
    upper: [f64; 2],
    pillars: Vec<Pillar>,
}

/// A round pillar.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pillar {
    /// Its middle \[m\].
    pub center: Point2<f64>,
    /// Its radius \[m\].
    pub radius: f64,
}

impl Room {
    /// A room between its `lower` left and its `upper` right corner \[m\].
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for corners that are not finite, or in the wrong order.
    pub fn new(lower: [f64; 2], upper: [f64; 2]) -> Result<Self> {
        for axis in 0..2 {
            finite("lower corner of a room [m]", lower[axis])?;
            let above = |value: f64| value.is_finite() && value > lower[axis];
            let expected = "a finite number above the lower corner's";
            in_range("upper corner of a room [m]", expected, upper[axis], above)?;
        }
        Ok(Room { lower, upper, pillars: Vec::new() })
    }

    /// Puts up a pillar.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a place that is not finite, or a radius that is not
    /// positive.
    pub fn with_pillar(mut self, center: [f64; 2], radius: f64) -> Result<Self> {
        for coordinate in center {
            finite("middle of a pillar [m]", coordinate)?;
        }
        let radius = positive("radius of a pillar [m]", radius)?;
        self.pillars.push(Pillar { center: Point2::from(center), radius });
        Ok(self)
    }

    /// Distance to the nearest of the four walls along a unit vector.
    fn walls(&self, origin: &Point2<f64>, along: &Vector2<f64>) -> f64 {
        // The ray is inside both pairs of walls between `enter` and `leave`.
        let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
        for axis in 0..2 {
            let (place, step) = (origin[axis], along[axis]);
            let (a, b) = ((self.lower[axis] - place) / step, (self.upper[axis] - place) / step);
            if step != 0.0 {
                enter = enter.max(a.min(b));
                leave = leave.min(a.max(b));
            } else if place < self.lower[axis] || place > self.upper[axis] {
                return f64::INFINITY;
            }
        }
        match (enter, leave) {
            (enter, leave) if leave < enter || leave < 0.0 => f64::INFINITY,
            (enter, leave) => {
                if enter > 0.0 {
                    enter
                } else {
                    leave
                }
            }
        }
    }
}

impl Pillar {
    /// Distance to the pillar along a unit vector.
    fn distance(&self, origin: &Point2<f64>, along: &Vector2<f64>) -> f64 {
        let to_center = self.center - origin;
        let nearest = to_center.dot(along);
        let square = self.radius * self.radius - (to_center.norm_squared() - nearest * nearest);
        if square < 0.0 {
            return f64::INFINITY;
        }
        let half_chord = square.sqrt();
        match nearest - half_chord {
            entry if entry >= 0.0 => entry,
            _ if nearest + half_chord >= 0.0 => nearest + half_chord,
            _ => f64::INFINITY,
        }
    }
}

impl RangeWorld for Room {
    fn cast(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<f64> {
        let (sin, cos) = direction.sin_cos();
        let along = Vector2::new(cos, sin);
        let pillars = self.pillars.iter().map(|pillar| pillar.distance(origin, &along));
        let range = pillars.fold(self.walls(origin, &along), f64::min);
        (range <= max_range).then_some(range)
    }
}
