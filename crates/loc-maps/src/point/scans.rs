//! Point maps assembled from laser scans with known poses.

use super::PointMap;
use crate::Result;
use crate::bounds::coordinate;
use loc_core::Pose2;
use loc_core::error::positive;
use nalgebra::{Point2, Vector2};
use std::collections::HashMap;

/// Squares along one axis, at most on each side: what a float counts without gaps.
const SQUARES: f64 = 9e15;

/// Gathers the points of scans, and thins them while it does.
///
/// The plane is cut into squares; all points of a square become one at their mean. So a wall seen
/// a thousand times takes no more room than one seen once, and its noise averages out.
#[derive(Debug, Clone)]
pub struct PointMapBuilder {
    square: f64,
    index: HashMap<(i64, i64), usize>,
    sums: Vec<(Vector2<f64>, f64)>,
}

impl PointMapBuilder {
    /// A builder that keeps one point per square of the given side \[m\].
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] where that is not positive.
    pub fn new(square: f64) -> Result<Self> {
        positive("side of the squares of a point map [m]", square)?;
        Ok(PointMapBuilder { square, index: HashMap::new(), sums: Vec::new() })
    }

    /// Adds the points of one scan, in the sensor's frame \[m\], taken at the pose `map_from_sensor`.
    ///
    /// Points that are not finite are beams that hit nothing, and are passed over.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a pose that is not finite, and for points more than
    /// 1000 km away.
    pub fn add_scan(&mut self, map_from_sensor: Pose2, points: &[Point2<f64>]) -> Result<()> {
        for value in [map_from_sensor.x, map_from_sensor.y, map_from_sensor.theta] {
            coordinate("pose of a scan [m, m, rad]", value)?;
        }
        let rotation = map_from_sensor.rotation();
        let translation = map_from_sensor.position().coords;
        for point in points.iter().filter(|point| point.coords.iter().all(|c| c.is_finite())) {
            self.add(rotation * point.coords + translation)?;
        }
        Ok(())
    }

    /// The map of what was added, in the order in which its squares were first met.
    ///
    /// # Errors
    /// As [`PointMap::new`], which cannot happen with points that were accepted.
    pub fn build(self) -> Result<PointMap> {
        PointMap::new(self.sums.into_iter().map(|(sum, count)| Point2::from(sum / count)))
    }

    fn add(&mut self, point: Vector2<f64>) -> Result<()> {
        let number = |value: f64| -> Result<i64> {
            let number = (coordinate("point of a scan [m]", value)? / self.square).floor();
            // Squares are counted exactly unless they are smaller than a nanometre.
            Ok(number.clamp(-SQUARES, SQUARES) as i64)
        };
        let square = (number(point.x)?, number(point.y)?);
        let next = self.sums.len();
        let index = *self.index.entry(square).or_insert(next);
        if index == next {
            self.sums.push((point, 1.0));
        } else {
            self.sums[index].0 += point;
            self.sums[index].1 += 1.0;
        }
        Ok(())
    }
}

impl PointMap {
    /// The map of scans: poses `map_from_sensor` with points in the sensor's frame \[m\], thinned
    /// to one point per square of side `square` \[m\].
    ///
    /// # Errors
    /// As [`PointMapBuilder::new`] and [`PointMapBuilder::add_scan`].
    pub fn from_scans<'a>(
        scans: impl IntoIterator<Item = (Pose2, &'a [Point2<f64>])>,
        square: f64,
    ) -> Result<Self> {
        let mut builder = PointMapBuilder::new(square)?;
        for (map_from_sensor, points) in scans {
            builder.add_scan(map_from_sensor, points)?;
        }
        builder.build()
    }

    /// The map with one point per square of side `square` \[m\].
    ///
    /// # Errors
    /// As [`PointMapBuilder::new`].
    pub fn thinned(&self, square: f64) -> Result<Self> {
        let whole = [(Pose2::IDENTITY, self.points())];
        PointMap::from_scans(whole, square)?.with_half_width(self.half_width())
    }
}
