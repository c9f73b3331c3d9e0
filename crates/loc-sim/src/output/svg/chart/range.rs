//! The intervals that charts show.

use super::{Chart, Data, Figure};
use crate::output::svg::drawable;
use crate::output::svg::ticks::Step;

/// Below this share of the largest value, positive data come near 0.
const NEAR_ZERO: f64 = 0.4;

impl Figure {
    /// The x values of all panels, from the least to the largest, rounded outwards by at most half
    /// a percent each; none without data.
    pub(super) fn x_range(&self) -> Option<(f64, f64)> {
        let mut range = None;
        for chart in &self.panels {
            chart.for_each_value(|x, _| include(&mut range, x));
        }
        let (low, high) = range?;
        if high - low > 1e-9 * low.abs().max(high.abs()) {
            let step = Step::at_least((high - low) / 200.0).size();
            return Some(((low / step).floor() * step, (high / step).ceil() * step));
        }
        // A single instant gets a little time around it.
        let half = f64::max(0.5, 1e-9 * low.abs());
        Some((low - half, high + half))
    }
}

impl Chart {
    /// Whether any series has a value to show.
    pub(super) fn has_data(&self) -> bool {
        let mut any = false;
        self.for_each_value(|_, _| any = true);
        any
    }

    /// Whether there is nothing at all that a y axis could tell about.
    pub(super) fn is_blank(&self) -> bool {
        !self.has_data() && self.references.is_empty() && self.y_range.is_none()
    }

    /// The interval of y: the fixed one where it is valid, else what the data need.
    pub(super) fn y_interval(&self) -> (f64, f64) {
        let usable = |v: f64| drawable(v) && (v > 0.0 || !self.log);
        if let Some((low, high)) = self.y_range
            && usable(low)
            && usable(high)
            && high > low
        {
            return (low, high);
        }
        let mut range = None;
        self.for_each_value(|_, y| include(&mut range, y));
        for (value, _) in self.references.iter().filter(|(v, _)| usable(*v)) {
            include(&mut range, *value);
        }
        match range {
            Some((low, high)) if self.log => with_room_log(low, high),
            Some((low, high)) => with_room(low, high),
            None if self.log => (0.1, 10.0),
            None => (0.0, 1.0),
        }
    }

    /// Visits all (x, y) that can be shown.
    fn for_each_value(&self, mut visit: impl FnMut(f64, f64)) {
        let mut visit = |x: f64, y: f64| {
            if drawable(x) && drawable(y) && (y > 0.0 || !self.log) {
                visit(x, y);
            }
        };
        for series in &self.series {
            match &series.data {
                Data::Line(points) | Data::Points(points) => {
                    points.iter().for_each(|&(x, y)| visit(x, y));
                }
                Data::Band(band) => {
                    for &(x, lower, upper) in band {
                        if drawable(lower) && drawable(upper) {
                            visit(x, lower);
                            visit(x, upper);
                        }
                    }
                }
            }
        }
    }
}

fn include(range: &mut Option<(f64, f64)>, value: f64) {
    let (low, high) = range.get_or_insert((value, value));
    (*low, *high) = (low.min(value), high.max(value));
}

fn with_room(low: f64, high: f64) -> (f64, f64) {
    let largest = low.abs().max(high.abs());
    if high - low <= 1e-9 * largest || largest <= 0.0 {
        let half = if largest > 0.0 { 0.1 * largest } else { 1.0 };
        return (low - half, high + half);
    }
    let room = 0.06 * (high - low);
    if low >= 0.0 && low <= NEAR_ZERO * high {
        (0.0, high + room)
    } else if high <= 0.0 && high >= NEAR_ZERO * low {
        (low - room, 0.0)
    } else {
        (low - room, high + room)
    }
}

fn with_room_log(low: f64, high: f64) -> (f64, f64) {
    let factor = (high / low).powf(0.06).max(1.05);
    let factor = if factor.is_finite() { factor } else { 1.0 };
    if high > low { (low / factor, high * factor) } else { (low / 3.0, high * 3.0) }
}
