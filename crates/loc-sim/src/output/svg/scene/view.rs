//! From metres to pixels, with equal scales.

use super::bounds::Bounds;
use crate::output::svg::WIDTH;
use crate::output::svg::axis::Axis;
use crate::output::svg::frame::Area;
use crate::output::svg::ticks::Step;

/// Free room around the content, as a share of its size on each side.
const MARGIN: f64 = 0.06;
/// The plot is at least this high, as a share of its width, and at most the other.
const ASPECT: (f64, f64) = (0.36, 1.1);
/// Room to the right of the plot \[px\].
const RIGHT: f64 = 18.0;

/// Where things of the plane lie in the figure.
pub(super) struct View {
    pub(super) area: Area,
    pub(super) x: Axis,
    pub(super) y: Axis,
}

impl View {
    /// Fits the bounds below `top` \[px\] and right of the numbers of the y axis.
    pub(super) fn fit(bounds: Bounds, top: f64) -> View {
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
    pub(super) fn exactly(bounds: Bounds, area: Area) -> View {
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
    pub(super) fn px(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.x.px(x), self.y.px(y))
    }

    /// Pixels of one metre, the same along both axes.
    pub(super) fn scale(&self) -> f64 {
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
