//! The simplest world with walls: a rectangle with round pillars, cast exactly; and panes of glass
//! and mirrors for any world.

use super::RangeWorld;
use crate::Result;
use crate::check::in_range;
use loc_core::error::{finite, positive, probability};
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

/// A straight pane that light passes, or that turns it. It stands in free space: a mirror on a
/// wall belongs a little in front of it.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct Pane {
    /// One end \[m\].
    pub from: [f64; 2],
    /// The other end \[m\].
    pub to: [f64; 2],
    /// What it is made of.
    pub surface: Surface,
}

/// What light does at a pane. Sound returns from every one.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case", deny_unknown_fields))]
pub enum Surface {
    /// Lets a beam through with a probability, and returns it otherwise.
    Glass {
        /// Probability that a beam passes.
        pass: f64,
    },
    /// Turns a beam: what is seen stands elsewhere.
    Mirror,
}

impl Pane {
    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for ends that are not finite or in one place, and for a
    /// probability outside \[0, 1\].
    pub fn check(&self) -> Result<()> {
        for coordinate in self.from.into_iter().chain(self.to) {
            finite("end of a pane [m]", coordinate)?;
        }
        positive("length of a pane [m]", self.along().norm())?;
        if let Surface::Glass { pass } = self.surface {
            probability("probability that a beam passes glass", pass)?;
        }
        Ok(())
    }

    /// Distance \[m\] along the unit vector `along` to the pane; `None` where the ray misses it.
    pub fn distance(&self, origin: &Point2<f64>, along: &Vector2<f64>) -> Option<f64> {
        let side = self.along();
        let to_end = Point2::from(self.from) - origin;
        let turn = along.perp(&side);
        let range = to_end.perp(&side) / turn;
        let share = to_end.perp(along) / turn;
        (range >= 0.0 && range.is_finite() && (0.0..=1.0).contains(&share)).then_some(range)
    }

    /// The direction \[rad\] of a ray of `direction` after a mirror in this pane's place.
    pub fn reflect(&self, direction: f64) -> f64 {
        let side = self.along();
        2.0 * side.y.atan2(side.x) - direction
    }

    fn along(&self) -> Vector2<f64> {
        Vector2::new(self.to[0] - self.from[0], self.to[1] - self.from[1])
    }
}

/// A world with panes put into it.
#[derive(Debug, Clone, PartialEq)]
pub struct Glazed<W> {
    world: W,
    panes: Vec<Pane>,
}

impl<W: RangeWorld> Glazed<W> {
    /// Puts `panes` into a world (one's own or a borrowed one), in addition to those it has.
    ///
    /// # Errors
    /// Those of [`Pane::check`].
    pub fn new(world: W, panes: impl IntoIterator<Item = Pane>) -> Result<Self> {
        let mut all = world.panes().to_vec();
        for pane in panes {
            pane.check()?;
            all.push(pane);
        }
        Ok(Glazed { world, panes: all })
    }
}

impl<W: RangeWorld> RangeWorld for Glazed<W> {
    fn cast(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<f64> {
        self.world.cast(origin, direction, max_range)
    }

    fn cast_fan(
        &self,
        origin: &Point2<f64>,
        first: f64,
        increment: f64,
        max_range: f64,
        ranges: &mut [f64],
    ) {
        self.world.cast_fan(origin, first, increment, max_range, ranges);
    }

    fn panes(&self) -> &[Pane] {
        &self.panes
    }
}
