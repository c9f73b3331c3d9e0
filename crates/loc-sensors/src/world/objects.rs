//! Things that move about.

use crate::Result;
use loc_core::error::{finite, non_negative};
use nalgebra::{Point2, Vector2};

/// Something round that moves through the world, such as a person.
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

/// A world with things that move.
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
