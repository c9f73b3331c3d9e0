//! Walls with heights and colours, for cameras.

use super::RangeWorld;
use crate::Result;
use loc_core::error::positive;
use nalgebra::Point2;

/// A colour: red, green, blue.
pub type Rgb = [u8; 3];

/// A wall that a planar ray meets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WallHit {
    /// Distance along the ray \[m\].
    pub range: f64,
    /// Height of its upper edge above the floor \[m\]; it stands on the floor.
    pub height: f64,
    /// Colour of its surface.
    pub color: Rgb,
}

/// A world whose walls have heights and colours and stand on a level floor.
pub trait WallWorld {
    /// Calls `visit` with the walls that a planar ray meets within `max_range` \[m\], nearest
    /// first, until it returns false: it does once nothing behind can be seen.
    fn visit_walls(
        &self,
        origin: &Point2<f64>,
        direction: f64,
        max_range: f64,
        visit: &mut dyn FnMut(WallHit) -> bool,
    );

    /// Colour of the floor.
    fn floor_color(&self) -> Rgb {
        [120, 110, 100]
    }
}

/// Any world with walls, all of them equally high: the nearest one hides the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Extruded<W> {
    world: W,
    height: f64,
    stripes: Vec<Rgb>,
}

/// Width of the stripes that walls are painted with \[m\].
const STRIPE: f64 = 0.5;

impl<W: RangeWorld> Extruded<W> {
    /// Walls of `height` \[m\], painted white.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] unless the height is positive.
    pub fn new(world: W, height: f64) -> Result<Self> {
        let height = positive("height of walls [m]", height)?;
        Ok(Extruded { world, height, stripes: vec![[230, 230, 225]] })
    }

    /// Paints the walls in upright stripes, 0.5 m wide along the diagonal of the map.
    #[must_use]
    pub fn with_stripes(mut self, colors: impl IntoIterator<Item = Rgb>) -> Self {
        let colors: Vec<Rgb> = colors.into_iter().collect();
        if !colors.is_empty() {
            self.stripes = colors;
        }
        self
    }

    fn color(&self, place: &Point2<f64>) -> Rgb {
        let stripe = ((place.x + place.y) / STRIPE).floor() as i64;
        self.stripes[stripe.rem_euclid(self.stripes.len() as i64) as usize]
    }
}

impl<W: RangeWorld> WallWorld for Extruded<W> {
    fn visit_walls(
        &self,
        origin: &Point2<f64>,
        direction: f64,
        max_range: f64,
        visit: &mut dyn FnMut(WallHit) -> bool,
    ) {
        if let Some(range) = self.world.cast(origin, direction, max_range) {
            let (sin, cos) = direction.sin_cos();
            let place = Point2::new(origin.x + range * cos, origin.y + range * sin);
            visit(WallHit { range, height: self.height, color: self.color(&place) });
        }
    }
}

/// Several worlds in one place, such as high walls and low furniture: they occlude one another
/// by distance and height.
impl WallWorld for [&dyn WallWorld] {
    fn visit_walls(
        &self,
        origin: &Point2<f64>,
        direction: f64,
        max_range: f64,
        visit: &mut dyn FnMut(WallHit) -> bool,
    ) {
        let mut walls = Vec::new();
        for world in self {
            world.visit_walls(origin, direction, max_range, &mut |wall| {
                walls.push(wall);
                true
            });
        }
        walls.sort_by(|a, b| a.range.total_cmp(&b.range));
        for wall in walls {
            if !visit(wall) {
                return;
            }
        }
    }

    fn floor_color(&self) -> Rgb {
        self.first().map_or([120, 110, 100], |world| world.floor_color())
    }
}
