//! Landmarks that walls hide.
//!
//! A landmark map says where landmarks are, not whether they can be seen. Together with a map that
//! has walls it does: from a place only those landmarks are there to which the way is free.
//!
//! ```
//! use loc_maps::{Landmark, LandmarkMap, Occluded};
//! use loc_sensors::world::{LandmarkWorld, Room};
//! let landmarks = LandmarkMap::new([Landmark::planar(1, 2.9, 0.0), Landmark::planar(2, 5.0, 0.0)])?;
//! let room = Room::new([-3.0, -2.0], [3.0, 2.0])?;
//! let mut seen = Vec::new();
//! let world = Occluded { landmarks: &landmarks, walls: &room, slack: 0.1 };
//! world.visit_landmarks(&[0.0, 0.0].into(), 10.0, &mut |id, _| seen.push(id));
//! assert_eq!(seen, [1]);
//! # Ok::<(), loc_maps::Error>(())
//! ```

use loc_sensors::world::{LandmarkWorld, RangeWorld};
use nalgebra::Point2;

/// The landmarks of one map behind the walls of another.
#[derive(Debug, Clone, Copy)]
pub struct Occluded<'a, L: ?Sized, W: ?Sized> {
    /// The landmarks.
    pub landmarks: &'a L,
    /// The walls.
    pub walls: &'a W,
    /// A wall this close before a landmark does not hide it \[m\]: landmarks hang on walls.
    pub slack: f64,
}

impl<L: LandmarkWorld + ?Sized, W: RangeWorld + ?Sized> LandmarkWorld for Occluded<'_, L, W> {
    fn visit_landmarks(
        &self,
        center: &Point2<f64>,
        radius: f64,
        visit: &mut dyn FnMut(u32, Point2<f64>),
    ) {
        self.landmarks.visit_landmarks(center, radius, &mut |id, position| {
            let way = position - center;
            let open = way.norm() - self.slack;
            let hidden = open > 0.0 && self.walls.cast(center, way.y.atan2(way.x), open).is_some();
            if !hidden {
                visit(id, position);
            }
        });
    }
}
