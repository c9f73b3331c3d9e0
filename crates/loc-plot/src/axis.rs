//! Axes: how numbers become pixels, round ticks along them, and the plot area with its grid.

use crate::style::Paint;
use crate::text::Anchor;
use crate::writer::{Element, Writer, number};
use crate::{WIDTH, text};

/// Font size of tick labels \[px\].
pub(crate) const TICK_SIZE: f64 = 13.0;

/// A linear or logarithmic scale from an interval of numbers to one of pixels.
#[derive(Debug, Clone)]
pub(crate) struct Axis {
    low: f64,
    high: f64,
    log: bool,
    from: f64,
    to: f64,
    /// What tick labels leave out, where all numbers along the axis are large and alike.
    offset: f64,
    pub(crate) ticks: Vec<Tick>,
}

impl Axis {
    /// A linear axis without ticks.
    pub(crate) fn linear((low, high): (f64, f64), (from, to): (f64, f64)) -> Self {
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
    pub(crate) fn log(range: (f64, f64), pixels: (f64, f64)) -> Self {
        Axis { log: true, offset: 0.0, ..Axis::linear(range, pixels) }
    }

    /// With as many ticks as fit side by side.
    pub(crate) fn across(mut self) -> Self {
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
    pub(crate) fn upwards(mut self) -> Self {
        let most = ((self.to - self.from).abs() / 34.0) as usize + 1;
        self.ticks = self.round_ticks(most.max(3));
        self
    }

    /// With ticks at the multiples of a step.
    pub(crate) fn every(mut self, step: Step) -> Self {
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
    pub(crate) fn label_width(&self) -> f64 {
        self.ticks.iter().map(|tick| text::width(&tick.label, TICK_SIZE)).fold(0.0, f64::max)
    }

    /// Where a number lies \[px\]; NaN for what a logarithmic axis cannot show.
    pub(crate) fn px(&self, value: f64) -> f64 {
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
    pub(crate) fn scale(&self) -> f64 {
        ((self.to - self.from) / (self.high - self.low)).abs()
    }

    /// The axis' name, which says what the tick labels leave out: `x − 4433000 [m]`.
    pub(crate) fn title(&self, name: &str) -> String {
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

/// A mark on an axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    /// Where it stands, in the axis' units.
    pub value: f64,
    /// What is written there.
    pub label: String,
}

/// A step between ticks: 1, 2 or 5 times a power of ten.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Step {
    mantissa: f64,
    exponent: i32,
}

impl Step {
    /// The smallest round step that is not below `size`, a positive number.
    pub(crate) fn at_least(size: f64) -> Self {
        let size = size.clamp(1e-290, 1e290);
        let exponent = size.log10().floor() as i32;
        let mantissa = size / 10f64.powi(exponent);
        // Rounding must not push a size that is itself round to the next step.
        match [1.0, 2.0, 5.0].into_iter().find(|m| mantissa <= m * (1.0 + 1e-9)) {
            Some(mantissa) => Step { mantissa, exponent },
            None => Step { mantissa: 1.0, exponent: exponent + 1 },
        }
    }

    pub(crate) fn size(self) -> f64 {
        self.multiple(1.0)
    }

    /// `count` steps, with a single rounding for decimal fractions.
    fn multiple(self, count: f64) -> f64 {
        if self.exponent < 0 {
            count * self.mantissa / 10f64.powi(-self.exponent)
        } else {
            count * self.mantissa * 10f64.powi(self.exponent)
        }
    }

    /// The multiples of this step within `[min, max]`, labelled.
    pub(crate) fn ticks(self, min: f64, max: f64) -> Vec<Tick> {
        let size = self.size();
        let (first, last) = ((min / size - 1e-9).ceil(), (max / size + 1e-9).floor());
        let count = last - first;
        if !(0.0..=1000.0).contains(&count) {
            return Vec::new();
        }
        let largest = min.abs().max(max.abs());
        let slack = 1e-9 * (max - min);
        (0..=count as u32)
            // Adding 0 makes a negative zero positive.
            .map(|k| self.multiple(first + f64::from(k)) + 0.0)
            .filter(|value| (min - slack..=max + slack).contains(value))
            .map(|value| Tick { value, label: self.label(value, largest) })
            .collect()
    }

    /// The value in as many digits as the step asks for; `largest` decides whether in powers of ten.
    fn label(self, value: f64, largest: f64) -> String {
        let plain = (1e-3..1e7).contains(&largest);
        let text = if plain {
            let decimals = self.exponent.min(0).unsigned_abs() as usize;
            format!("{value:.decimals$}")
        } else if value.abs() > 0.0 {
            let digits = (value.abs().log10() + 1e-9).floor() as i32 - self.exponent;
            let digits = digits.clamp(0, 15) as usize;
            format!("{value:.digits$e}")
        } else {
            "0".to_owned()
        };
        text.replace('-', "\u{2212}")
    }
}

/// At most `at_most` (and at least two) round numbers within `[min, max]`, 1, 2 or 5 times a power
/// of ten apart. Empty where the interval is empty or not finite.
///
/// ```
/// let ticks = loc_plot::linear_ticks(-0.3, 1.1, 5);
/// let labels: Vec<&str> = ticks.iter().map(|tick| tick.label.as_str()).collect();
/// assert_eq!(labels, ["0.0", "0.5", "1.0"]);
/// ```
pub fn linear_ticks(min: f64, max: f64, at_most: usize) -> Vec<Tick> {
    let span = max - min;
    if !span.is_finite() || span <= 0.0 {
        return Vec::new();
    }
    // A finer step may fit all the same, where the ends of the axis lie between ticks.
    let finer = Step::at_least(span / (at_most.max(2) + 1) as f64).ticks(min, max);
    if finer.len() <= at_most {
        return finer;
    }
    Step::at_least(span / (at_most.max(2) - 1) as f64).ticks(min, max)
}

/// At most about `at_most` ticks for a logarithmic axis over `[min, max]`: powers of ten, on short
/// axes with 2 and 5 times them, on very short ones round numbers. Empty where the interval is
/// empty, not finite or not positive.
pub fn log_ticks(min: f64, max: f64, at_most: usize) -> Vec<Tick> {
    if !(min > 0.0 && max > min && max.is_finite()) {
        return Vec::new();
    }
    let (low, high) = (min.log10(), max.log10());
    let at_most = at_most.max(2);
    let decades = high - low;
    if decades < 1.0 {
        let mut ticks = linear_ticks(min, max, at_most);
        ticks.retain(|tick| tick.value > 0.0);
        return ticks;
    }
    let mantissas: &[f64] = if decades * 2.5 <= at_most as f64 { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let every = (decades / at_most as f64).ceil().max(1.0) as i32;
    let exponents = (low.floor() as i32..=high.ceil() as i32).filter(|e| e % every == 0);
    exponents
        .flat_map(|e| mantissas.iter().map(move |m| (*m, e)))
        .map(|(mantissa, exponent)| Step { mantissa, exponent })
        .filter(|step| (min..=max).contains(&step.size()))
        .map(|step| Tick { value: step.size(), label: step.label(step.size(), step.size()) })
        .collect()
}

/// Font size of axis names and of the legend \[px\].
pub(crate) const LABEL_SIZE: f64 = 14.0;
/// Height of the line that names the axis above its area \[px\].
pub(crate) const NAME_HEIGHT: f64 = 24.0;

/// A rectangle of the figure \[px\], y down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Area {
    pub(crate) left: f64,
    pub(crate) top: f64,
    pub(crate) width: f64,
    pub(crate) height: f64,
}

impl Area {
    pub(crate) fn right(&self) -> f64 {
        self.left + self.width
    }

    pub(crate) fn bottom(&self) -> f64 {
        self.top + self.height
    }

    fn rect(&self) -> Element {
        Element::new("rect")
            .num("x", self.left)
            .num("y", self.top)
            .num("width", self.width)
            .num("height", self.height)
    }

    /// Opens a group that shows only what lies within the area.
    ///
    /// The name of the clip path is made of its geometry, so that figures in one page may share
    /// the name: equal names mean equal areas. `rim` \[px\] lets marks at the sides be whole.
    pub(crate) fn open_clip(&self, writer: &mut Writer, rim: f64) {
        let area = Area { left: self.left - rim, width: self.width + 2.0 * rim, ..*self };
        let corners = [area.left, area.top, area.width, area.height].map(number);
        let id = format!("loc-clip-{}", corners.join("-"));
        writer.open(Element::new("clipPath").attr("id", &id));
        writer.add(area.rect());
        writer.close();
        writer.open(Element::new("g").attr("clip-path", &format!("url(#{id})")));
    }

    /// The grid through the ticks of both axes, and the edge around it.
    pub(crate) fn draw_grid(&self, writer: &mut Writer, x: &Axis, y: &Axis) {
        let mut lines = String::new();
        for tick in &x.ticks {
            let (at, from) = (number(x.px(tick.value)), number(self.top));
            lines.push_str(&format!("M{at} {from}V{}", number(self.bottom())));
        }
        for tick in &y.ticks {
            let (at, from) = (number(y.px(tick.value)), number(self.left));
            lines.push_str(&format!("M{from} {at}H{}", number(self.right())));
        }
        if !lines.is_empty() {
            let grid = Element::new("path").attr("d", &lines).no_fill();
            writer.add(grid.stroke(Paint::GRID, 1.0));
        }
        writer.add(self.rect().no_fill().stroke(Paint::EDGE, 1.0));
    }

    /// The numbers below the area and the axis' name under them; returns where they end \[px\].
    pub(crate) fn draw_x_axis(&self, writer: &mut Writer, x: &Axis, name: &str) -> f64 {
        let baseline = self.bottom() + 18.0;
        for tick in &x.ticks {
            let half = 0.5 * text::width(&tick.label, TICK_SIZE);
            let at = x.px(tick.value).min(WIDTH - 3.0 - half);
            label(writer, (at, baseline), Anchor::Middle, &tick.label);
        }
        if name.is_empty() {
            return baseline + 8.0;
        }
        let at = (self.left + 0.5 * self.width, baseline + 21.0);
        let name = text::shorten(&x.title(name), LABEL_SIZE, self.width);
        let element = text::element(at, LABEL_SIZE, Anchor::Middle, Paint::INK);
        writer.text(element, &name);
        baseline + 30.0
    }

    /// The numbers to the left of the area.
    pub(crate) fn draw_y_ticks(&self, writer: &mut Writer, y: &Axis) {
        for tick in &y.ticks {
            let at = (self.left - 7.0, y.px(tick.value) + 0.35 * TICK_SIZE);
            label(writer, at, Anchor::End, &tick.label);
        }
    }

    /// The numbers to the left of the area and the axis' name above it.
    pub(crate) fn draw_y_axis(&self, writer: &mut Writer, y: &Axis, name: &str) {
        self.draw_y_ticks(writer, y);
        let at = (self.left, self.top - 8.0);
        let name = text::shorten(&y.title(name), LABEL_SIZE, self.width);
        let element = text::element(at, LABEL_SIZE, Anchor::Start, Paint::INK);
        writer.text(element, &name);
    }

    /// Says in the middle of the area that there is nothing to see.
    pub(crate) fn draw_no_data(&self, writer: &mut Writer) {
        let middle = (self.left + 0.5 * self.width, self.top + 0.5 * self.height + 5.0);
        let element = text::element(middle, 15.0, Anchor::Middle, Paint::MUTED);
        writer.text(element, "no data");
    }
}

fn label(writer: &mut Writer, at: (f64, f64), anchor: Anchor, label: &str) {
    writer.text(text::element(at, TICK_SIZE, anchor, Paint::MUTED), label);
}
