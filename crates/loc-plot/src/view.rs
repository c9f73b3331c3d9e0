//! The rectangle of the plane that a scene takes ([`Bounds`]), and its place in the figure: from
//! metres to pixels, with equal scales ([`View`]).

use crate::WIDTH;
use crate::axis::{Area, Axis, Step};
use crate::scene::{Scene, Shape, is_place};
use loc_core::Ellipse;

/// Free room around the content, as a share of its size on each side.
const MARGIN: f64 = 0.06;
/// The plot is at least this high, as a share of its width, and at most the other.
const ASPECT: (f64, f64) = (0.36, 1.1);
/// Room to the right of the plot \[px\].
const RIGHT: f64 = 18.0;

/// Where things of the plane lie in the figure.
pub(crate) struct View {
    pub(crate) area: Area,
    pub(crate) x: Axis,
    pub(crate) y: Axis,
}

impl View {
    /// Fits the bounds below `top` \[px\] and right of the numbers of the y axis.
    pub(crate) fn fit(bounds: Bounds, top: f64) -> View {
        // How wide those numbers are follows from the scale, and the scale from what they leave.
        let draft = View::right_of(bounds, 40.0, top);
        View::right_of(bounds, draft.y.label_width().max(16.0) + 14.0, top)
    }

    fn right_of(bounds: Bounds, left: f64, top: f64) -> View {
        let center = bounds.center();
        let (width, height) = padded(bounds);
        let plot_width = WIDTH - left - RIGHT;
        let plot_height = plot_width * (height / width).clamp(ASPECT.0, ASPECT.1);
        let scale = (plot_width / width).min(plot_height / height);
        let range = |middle: f64, pixels: f64| {
            let half = 0.5 * pixels / scale;
            (middle - half, middle + half)
        };
        let area = Area { left, top, width: plot_width, height: plot_height };
        let step = Step::at_least(60.0 / scale);
        View {
            area,
            x: Axis::linear(range(center.0, plot_width), (left, area.right())).every(step),
            y: Axis::linear(range(center.1, plot_height), (area.bottom(), top)).every(step),
        }
    }

    /// Puts the bounds into an area of the same shape, to the edge and without ticks.
    pub(crate) fn exactly(bounds: Bounds, area: Area) -> View {
        let center = bounds.center();
        let (width, height) = bounds.size();
        let scale = (area.width / width).min(area.height / height);
        let range = |middle: f64, pixels: f64| {
            let half = 0.5 * pixels / scale;
            (middle - half, middle + half)
        };
        let x = Axis::linear(range(center.0, area.width), (area.left, area.right()));
        let y = Axis::linear(range(center.1, area.height), (area.bottom(), area.top));
        View { area, x, y }
    }

    /// Where a point of the plane lies \[px\].
    pub(crate) fn px(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.x.px(x), self.y.px(y))
    }

    /// Pixels of one metre, the same along both axes.
    pub(crate) fn scale(&self) -> f64 {
        self.x.scale()
    }
}

/// Size of the view before it takes the shape of the plot \[m\]. A single point gets two metres
/// around it, far from the origin more: what numbers there can tell apart.
fn padded(bounds: Bounds) -> (f64, f64) {
    let (width, height) = bounds.size();
    let farthest = [bounds.min.0, bounds.min.1, bounds.max.0, bounds.max.1]
        .into_iter()
        .fold(0.0, |most: f64, v| most.max(v.abs()));
    let longer = width.max(height);
    let smallest = if longer > 0.0 { 1e-9 } else { 2.0 };
    let smallest = f64::max(smallest, 1e-9 * farthest);
    let grow = |size: f64| (size + 2.0 * MARGIN * longer).max(smallest);
    (grow(width).max(1.6 * smallest), grow(height))
}

/// A rectangle of the plane \[m\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bounds {
    pub(crate) min: (f64, f64),
    pub(crate) max: (f64, f64),
}

impl Bounds {
    /// The rectangle around everything in the scene; none where there is nothing.
    pub(crate) fn of(scene: &Scene) -> Option<Bounds> {
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
    pub(crate) fn union(self, other: Bounds) -> Bounds {
        Bounds {
            min: (self.min.0.min(other.min.0), self.min.1.min(other.min.1)),
            max: (self.max.0.max(other.max.0), self.max.1.max(other.max.1)),
        }
    }

    /// Larger on each side by this share of the longer side, or by 1 m around a single point.
    pub(crate) fn with_margin(self, share: f64) -> Bounds {
        let longer = self.size().0.max(self.size().1);
        let room = if longer > 0.0 { share * longer } else { 1.0 };
        Bounds {
            min: (self.min.0 - room, self.min.1 - room),
            max: (self.max.0 + room, self.max.1 + room),
        }
    }

    /// Width and height \[m\].
    pub(crate) fn size(self) -> (f64, f64) {
        (self.max.0 - self.min.0, self.max.1 - self.min.1)
    }

    /// The middle \[m\].
    pub(crate) fn center(self) -> (f64, f64) {
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
