//! Round numbers along an axis.

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
pub(super) struct Step {
    mantissa: f64,
    exponent: i32,
}

impl Step {
    /// The smallest round step that is not below `size`, a positive number.
    pub(super) fn at_least(size: f64) -> Self {
        let size = size.clamp(1e-290, 1e290);
        let exponent = size.log10().floor() as i32;
        let mantissa = size / 10f64.powi(exponent);
        // Rounding must not push a size that is itself round to the next step.
        match [1.0, 2.0, 5.0].into_iter().find(|m| mantissa <= m * (1.0 + 1e-9)) {
            Some(mantissa) => Step { mantissa, exponent },
            None => Step { mantissa: 1.0, exponent: exponent + 1 },
        }
    }

    pub(super) fn size(self) -> f64 {
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
    pub(super) fn ticks(self, min: f64, max: f64) -> Vec<Tick> {
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
/// let ticks = loc_sim::output::svg::linear_ticks(-0.3, 1.1, 5);
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
