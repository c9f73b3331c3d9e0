//! The rectangle that the content of a scene takes.

use super::{Scene, Shape, is_place};
use loc_core::Ellipse;

/// A rectangle of the plane \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Bounds {
    pub(super) min: (f64, f64),
    pub(super) max: (f64, f64),
}

impl Bounds {
    /// The rectangle around everything in the scene; none where there is nothing.
    pub(super) fn of(scene: &Scene) -> Option<Bounds> {
        let mut points = None;
        let mut ellipses = None;
        for backdrop in scene.backdrop.iter().filter(|b| b.is_valid()) {
            include(&mut points, backdrop.min);
            include(&mut points, backdrop.max);
        }
        for item in &scene.items {
            for_each_point(&item.shape, |point| include(&mut points, point));
            if let Shape::Ellipses(list) = &item.shape {
                for ellipse in list {
                    let (half_width, half_height) = half_size(ellipse);
                    let (x, y) = (ellipse.center.x, ellipse.center.y);
                    include(&mut ellipses, (x - half_width, y - half_height));
                    include(&mut ellipses, (x + half_width, y + half_height));
                }
            }
        }
        points.map(|points| points.grown_to(ellipses))
    }

    /// Enlarged to ellipses, by at most the longer side in each direction.
    fn grown_to(self, ellipses: Option<Bounds>) -> Bounds {
        let Some(ellipses) = ellipses else {
            return self;
        };
        let (width, height) = self.size();
        let longer = width.max(height);
        let limit = if longer > 0.0 { longer } else { f64::MAX };
        Bounds {
            min: (
                ellipses.min.0.clamp(self.min.0 - limit, self.min.0),
                ellipses.min.1.clamp(self.min.1 - limit, self.min.1),
            ),
            max: (
                ellipses.max.0.clamp(self.max.0, self.max.0 + limit),
                ellipses.max.1.clamp(self.max.1, self.max.1 + limit),
            ),
        }
    }

    /// The rectangle around both.
    pub(super) fn union(self, other: Bounds) -> Bounds {
        Bounds {
            min: (self.min.0.min(other.min.0), self.min.1.min(other.min.1)),
            max: (self.max.0.max(other.max.0), self.max.1.max(other.max.1)),
        }
    }

    /// Larger on each side by this share of the longer side, or by 1 m around a single point.
    pub(super) fn with_margin(self, share: f64) -> Bounds {
        let longer = self.size().0.max(self.size().1);
        let room = if longer > 0.0 { share * longer } else { 1.0 };
        Bounds {
            min: (self.min.0 - room, self.min.1 - room),
            max: (self.max.0 + room, self.max.1 + room),
        }
    }

    /// Width and height \[m\].
    pub(super) fn size(self) -> (f64, f64) {
        (self.max.0 - self.min.0, self.max.1 - self.min.1)
    }

    /// The middle \[m\].
    pub(super) fn center(self) -> (f64, f64) {
        (0.5 * (self.min.0 + self.max.0), 0.5 * (self.min.1 + self.max.1))
    }
}

fn include(bounds: &mut Option<Bounds>, point: (f64, f64)) {
    if !is_place(point) {
        return;
    }
    let all = bounds.get_or_insert(Bounds { min: point, max: point });
    all.min = (all.min.0.min(point.0), all.min.1.min(point.1));
    all.max = (all.max.0.max(point.0), all.max.1.max(point.1));
}

fn for_each_point(shape: &Shape, mut visit: impl FnMut((f64, f64))) {
    match shape {
        Shape::Path(points) | Shape::Dots(points) | Shape::Stars(points) => {
            points.iter().for_each(|&point| visit(point));
        }
        Shape::Segments(segments) => segments.iter().for_each(|&(a, b)| {
            visit(a);
            visit(b);
        }),
        Shape::Ellipses(list) => list.iter().for_each(|e| visit((e.center.x, e.center.y))),
        Shape::Poses(poses) => poses.iter().for_each(|pose| visit((pose.x, pose.y))),
        Shape::Crosses(crosses) => crosses.iter().for_each(|&(place, _)| visit(place)),
    }
}

/// Half the width and height of the upright box around an ellipse \[m\].
fn half_size(ellipse: &Ellipse) -> (f64, f64) {
    let (sin, cos) = ellipse.angle.sin_cos();
    let (a, b) = (ellipse.semi_major, ellipse.semi_minor);
    (f64::hypot(a * cos, b * sin), f64::hypot(a * sin, b * cos))
}
