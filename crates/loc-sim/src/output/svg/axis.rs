//! An axis: how numbers become pixels, and the ticks along it.

use super::text;
use super::ticks::{Step, Tick, linear_ticks, log_ticks};

/// Font size of tick labels \[px\].
pub(super) const TICK_SIZE: f64 = 13.0;

/// A linear or logarithmic scale from an interval of numbers to one of pixels.
#[derive(Debug, Clone)]
pub(super) struct Axis {
    low: f64,
    high: f64,
    log: bool,
    from: f64,
    to: f64,
    /// What tick labels leave out, where all numbers along the axis are large and alike.
    offset: f64,
    pub(super) ticks: Vec<Tick>,
}

impl Axis {
    /// A linear axis without ticks.
    pub(super) fn linear((low, high): (f64, f64), (from, to): (f64, f64)) -> Self {
        let span = high - low;
        let largest = low.abs().max(high.abs());
        let offset = if largest >= 1e5 && largest > 1e3 * span && span > 0.0 {
            round_origin(low, high)
        } else {
            0.0
        };
        Axis { low, high, log: false, from, to, offset, ticks: Vec::new() }
    }

    /// A logarithmic axis over positive numbers, without ticks.
    pub(super) fn log(range: (f64, f64), pixels: (f64, f64)) -> Self {
        Axis { log: true, offset: 0.0, ..Axis::linear(range, pixels) }
    }

    /// With as many ticks as fit side by side.
    pub(super) fn across(mut self) -> Self {
        let most = ((self.to - self.from).abs() / 52.0) as usize;
        for count in (2..=most.max(2)).rev() {
            self.ticks = self.round_ticks(count);
            if self.labels_fit() {
                break;
            }
        }
        self
    }

    /// With ticks for labels above each other.
    pub(super) fn upwards(mut self) -> Self {
        let most = ((self.to - self.from).abs() / 34.0) as usize + 1;
        self.ticks = self.round_ticks(most.max(3));
        self
    }

    /// With ticks at the multiples of a step.
    pub(super) fn every(mut self, step: Step) -> Self {
        let ticks = step.ticks(self.low - self.offset, self.high - self.offset);
        self.ticks = self.shifted(ticks);
        self
    }

    fn round_ticks(&self, at_most: usize) -> Vec<Tick> {
        if self.log {
            return log_ticks(self.low, self.high, at_most);
        }
        let (low, high) = (self.low - self.offset, self.high - self.offset);
        self.shifted(linear_ticks(low, high, at_most))
    }

    fn shifted(&self, mut ticks: Vec<Tick>) -> Vec<Tick> {
        for tick in &mut ticks {
            tick.value += self.offset;
        }
        ticks
    }

    fn labels_fit(&self) -> bool {
        self.ticks.windows(2).all(|pair| {
            let room = (self.px(pair[1].value) - self.px(pair[0].value)).abs();
            room >= 10.0 + self.label_width()
        })
    }

    /// Width of the widest tick label \[px\].
    pub(super) fn label_width(&self) -> f64 {
        self.ticks.iter().map(|tick| text::width(&tick.label, TICK_SIZE)).fold(0.0, f64::max)
    }

    /// Where a number lies \[px\]; NaN for what a logarithmic axis cannot show.
    pub(super) fn px(&self, value: f64) -> f64 {
        let share = if self.log {
            (value.ln() - self.low.ln()) / (self.high.ln() - self.low.ln())
        } else {
            (value - self.low) / (self.high - self.low)
        };
        if !share.is_finite() {
            return f64::NAN;
        }
        // Far outside, only the direction counts; larger numbers trouble renderers.
        self.from + share.clamp(-100.0, 100.0) * (self.to - self.from)
    }

    /// Pixels of one unit along a linear axis.
    pub(super) fn scale(&self) -> f64 {
        ((self.to - self.from) / (self.high - self.low)).abs()
    }

    /// The axis' name, which says what the tick labels leave out: `x − 4433000 [m]`.
    pub(super) fn title(&self, name: &str) -> String {
        if self.offset.abs() <= 0.0 {
            return name.to_owned();
        }
        let (quantity, unit) = match name.find(" [") {
            Some(at) => name.split_at(at),
            None => (name, ""),
        };
        let sign = if self.offset > 0.0 { '\u{2212}' } else { '+' };
        let amount = if self.offset.abs() < 1e12 {
            format!("{:.0}", self.offset.abs())
        } else {
            format!("{:e}", self.offset.abs())
        };
        format!("{quantity} {sign} {amount}{unit}")
    }
}

/// A round number near an interval that is far from 0: one beside its middle, else one below it.
fn round_origin(low: f64, high: f64) -> f64 {
    let span = high - low;
    let unit = 10f64.powi(span.log10().ceil() as i32 + 1);
    let middle = low + 0.5 * span;
    let nearest = (middle / unit).round() * unit;
    if (nearest - middle).abs() <= span { nearest } else { (low / unit).floor() * unit }
}
