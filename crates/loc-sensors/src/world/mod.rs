//! What simulated sensors see of a world.
//!
//! A sensor never knows which map it stands in: it asks through these traits, so any map can be
//! its world. [`Landmarks`] is the smallest world with landmarks, a plain list; [`Room`] is the
//! smallest one with walls, a rectangle with pillars whose distances are exact. Around any world
//! with walls, [`Glazed`] puts window panes and mirrors, and [`Extruded`] gives them a height.
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

pub use room::{Glazed, MovingObject, ObjectWorld, Pane, Pillar, Room, Surface};
pub use walls::{Extruded, Landmarks, Rgb, WallHit, WallWorld};

use nalgebra::Point2;

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
