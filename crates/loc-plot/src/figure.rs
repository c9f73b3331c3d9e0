//! Figures: charts above each other over a shared axis, mostly time.

use crate::axis::{Area, Axis, NAME_HEIGHT, Step, TICK_SIZE};
use crate::chart::{Chart, Data, draw_panel, include, y_axis};
use crate::header::{Glyph, Legend};
use crate::style::{Paint, Role};
use crate::text::Anchor;
use crate::writer::Writer;
use crate::{WIDTH, header, marks, text};

/// Room to the right of the panels \[px\].
const RIGHT: f64 = 20.0;
/// Room between panels \[px\].
const GAP: f64 = 12.0;

/// Charts above each other that share the x axis, with a title and one legend.
#[derive(Debug, Clone, Default)]
pub struct Figure {
    title: String,
    subtitle: String,
    x_label: String,
    panels: Vec<Chart>,
    marks: Vec<(f64, String)>,
}

impl Figure {
    /// A figure without panels; a title of many words takes two lines.
    pub fn new(title: impl Into<String>) -> Self {
        Figure { title: title.into(), ..Figure::default() }
    }

    /// A line under the title, in smaller letters.
    #[must_use]
    pub fn subtitle(mut self, subtitle: impl Into<String>) -> Self {
        self.subtitle = subtitle.into();
        self
    }

    /// The name of the shared axis, with its unit: `"time [s]"`.
    #[must_use]
    pub fn x_label(mut self, x_label: impl Into<String>) -> Self {
        self.x_label = x_label.into();
        self
    }

    /// A vertical line through all charts, with its label in the first one: a moment when
    /// something happened.
    #[must_use]
    pub fn mark(mut self, x: f64, label: impl Into<String>) -> Self {
        self.marks.push((x, label.into()));
        self
    }

    /// Adds a chart below those before.
    #[must_use]
    pub fn panel(mut self, chart: Chart) -> Self {
        self.panels.push(chart);
        self
    }

    /// The SVG file.
    pub fn render(&self) -> String {
        draw(self)
    }

    /// The x values of all panels, from the least to the largest, rounded outwards by at most half
    /// a percent each; none without data.
    fn x_range(&self) -> Option<(f64, f64)> {
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

fn draw(figure: &Figure) -> String {
    let mut writer = Writer::default();
    let mut end = header::draw(&mut writer, &figure.title, &figure.subtitle, &legend(figure));
    let empty = [Chart::default()];
    let panels: &[Chart] = if figure.panels.is_empty() { &empty } else { &figure.panels };
    let height = panel_height(panels.len());
    let left = label_width(panels, height).max(16.0) + 14.0;
    let width = WIDTH - left - RIGHT;
    let range = figure.x_range();
    let mut x = Axis::linear(range.unwrap_or((0.0, 1.0)), (left, left + width));
    if range.is_some() {
        x = x.across();
    }
    let mut area = None;
    for chart in panels {
        let top = end + NAME_HEIGHT;
        let panel = Area { left, top, width, height };
        draw_panel(&mut writer, chart, &panel, &x);
        draw_marks(&mut writer, &figure.marks, area.is_none(), &panel, &x);
        end = panel.bottom() + GAP;
        area = Some(panel);
    }
    if let Some(lowest) = area {
        end = lowest.draw_x_axis(&mut writer, &x, &figure.x_label);
    }
    writer.finish(&figure.title, end)
}

fn panel_height(panels: usize) -> f64 {
    match panels {
        0 | 1 => 290.0,
        2 => 190.0,
        _ => 140.0,
    }
}

fn label_width(panels: &[Chart], height: f64) -> f64 {
    panels.iter().map(|chart| y_axis(chart, (height, 0.0)).label_width()).fold(0.0, f64::max)
}

fn legend(figure: &Figure) -> Legend {
    let mut legend = Legend::default();
    for series in figure.panels.iter().flat_map(|chart| &chart.series) {
        let glyph = match series.data {
            Data::Line(_) => Glyph::Line,
            Data::Points(_) => Glyph::Dots,
            Data::Band(_) => Glyph::Band,
        };
        legend.add(&series.label, glyph, series.style);
    }
    legend
}

/// Vertical lines, and with `named` what happened there.
fn draw_marks(writer: &mut Writer, marks: &[(f64, String)], named: bool, area: &Area, x: &Axis) {
    for (value, label) in marks {
        let at = x.px(*value);
        if !(area.left..=area.right()).contains(&at) {
            continue;
        }
        let line = [(at, area.top), (at, area.bottom())];
        marks::draw_line(writer, Role::Truth.dashed().width(1.1), &line);
        if named {
            let width = text::width(label, TICK_SIZE);
            let left = at + 6.0 + width > area.right();
            let (at, anchor) =
                if left { (at - 6.0, Anchor::End) } else { (at + 6.0, Anchor::Start) };
            let place = (at, area.top + 15.0);
            let element = text::element(place, TICK_SIZE, anchor, Paint::INK);
            text::draw_with_halo(writer, element, label);
        }
    }
}
