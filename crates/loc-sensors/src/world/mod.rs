//! The traits through which simulated sensors query a world.
//!
//! A sensor depends on these traits only, so any map can be its world. [`Landmarks`] is the
//! simplest world with landmarks, a plain list; [`Room`] is the simplest one with walls, a
//! rectangle with pillars whose distances are exact. Around any world with walls, [`Glazed`] puts
//! window panes and mirrors, and [`Extruded`] gives them a height.
//!
//! ```
//! use loc_sensors::world::{RangeWorld, Room};
//! use nalgebra::Point2;
//! let room = Room::new([0.0, 0.0], [4.0, 3.0])?;
//! assert_eq!(room.cast(&Point2::new(1.0, 1.0), 0.0, 10.0), Some(3.0));
//! # Ok::<(), loc_core::Error>(())
//! ```

mod room;
mod walls;

pub use room::{Glazed, Pane, Pillar, Room, Surface};
pub use walls::{Extruded, Rgb, WallHit, WallWorld};

use crate::Result;
use loc_core::error::{finite, non_negative};
use nalgebra::{Point2, Vector2};

/// A world with numbered landmarks.
pub trait LandmarkWorld {
    /// Calls `visit` with number and position \[m\] of each landmark at most `radius` \[m\] from
    /// `center`, always in the same order.
    fn visit_landmarks(
        &self,
        center: &Point2<f64>,
        radius: f64,
        visit: &mut dyn FnMut(u32, Point2<f64>),
    );
}

/// A list of numbered landmarks.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Landmarks(Vec<(u32, Point2<f64>)>);

impl<const K: usize> From<[(u32, [f64; 2]); K]> for Landmarks {
    fn from(landmarks: [(u32, [f64; 2]); K]) -> Self {
        Landmarks(landmarks.into_iter().map(|(id, xy)| (id, Point2::from(xy))).collect())
    }
}

impl LandmarkWorld for Landmarks {
    fn visit_landmarks(
        &self,
        center: &Point2<f64>,
        radius: f64,
        visit: &mut dyn FnMut(u32, Point2<f64>),
    ) {
        for (id, position) in &self.0 {
            if nalgebra::distance(center, position) <= radius {
                visit(*id, *position);
            }
        }
    }
}

/// A world with walls.
pub trait RangeWorld {
    /// Distance from `origin` \[m\] to the first obstacle in `direction` \[rad\], both in the map
    /// frame; `None` where there is none within `max_range` \[m\].
    fn cast(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<f64>;

    /// The same for a fan of rays from one point, into `ranges`: ray k in direction
    /// `first + k * increment`, +inf where nothing is hit. Worlds that gain by it override it.
    fn cast_fan(
        &self,
        origin: &Point2<f64>,
        first: f64,
        increment: f64,
        max_range: f64,
        ranges: &mut [f64],
    ) {
        for (k, range) in ranges.iter_mut().enumerate() {
            let direction = first + k as f64 * increment;
            *range = self.cast(origin, direction, max_range).unwrap_or(f64::INFINITY);
        }
    }

    /// Glass and mirrors, which [`cast`](RangeWorld::cast) does not see: light passes them or
    /// turns on them. A world has none unless it says so.
    fn panes(&self) -> &[Pane] {
        &[]
    }
}

impl<W: RangeWorld + ?Sized> RangeWorld for &W {
    fn cast(&self, origin: &Point2<f64>, direction: f64, max_range: f64) -> Option<f64> {
        (**self).cast(origin, direction, max_range)
    }

    fn cast_fan(
        &self,
        origin: &Point2<f64>,
        first: f64,
        increment: f64,
        max_range: f64,
        ranges: &mut [f64],
    ) {
        (**self).cast_fan(origin, first, increment, max_range, ranges);
    }

    fn panes(&self) -> &[Pane] {
        (**self).panes()
    }
}

/// A round object that moves through the world, such as a person.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct MovingObject {
    /// Its middle in the map \[m\].
    pub position: Point2<f64>,
    /// Its velocity in the map \[m/s\].
    pub velocity: Vector2<f64>,
    /// Its radius \[m\].
    pub radius: f64,
}

impl MovingObject {
    /// Checks every value.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a negative radius, NaN and infinity.
    pub fn check(&self) -> Result<()> {
        for value in self.position.iter() {
            finite("position of an object [m]", *value)?;
        }
        for value in self.velocity.iter() {
            finite("velocity of an object [m/s]", *value)?;
        }
        non_negative("radius of an object [m]", self.radius)?;
        Ok(())
    }
}

/// A world with moving objects.
pub trait ObjectWorld {
    /// Calls `visit` with each object whose middle is at most `radius` \[m\] from `center`, always
    /// in the same order.
    fn visit_objects(&self, center: &Point2<f64>, radius: f64, visit: &mut dyn FnMut(MovingObject));
}

impl ObjectWorld for [MovingObject] {
    fn visit_objects(
        &self,
        center: &Point2<f64>,
        radius: f64,
        visit: &mut dyn FnMut(MovingObject),
    ) {
        let near = |object: &&MovingObject| nalgebra::distance(&object.position, center) <= radius;
        self.iter().filter(near).for_each(|object| visit(*object));
    }
}
