//! Charts over a shared axis, mostly time.

mod draw;
mod range;
mod references;

use super::style::Style;

/// Quantities over one another: lines, bands, points and limits. One panel of a [`Figure`].
///
/// Values that are not finite break a line or band; on a logarithmic axis so do values that are
/// not positive. A label names a series in the figure's legend; series of the same colour and
/// label share one entry, also across panels, and those with an empty label have none.
#[derive(Debug, Clone, Default)]
pub struct Chart {
    y_label: String,
    series: Vec<Series>,
    references: Vec<(f64, String)>,
    y_range: Option<(f64, f64)>,
    log: bool,
}

/// Charts above each other that share the x axis, with a title and one legend.
#[derive(Debug, Clone, Default)]
pub struct Figure {
    title: String,
    subtitle: String,
    x_label: String,
    panels: Vec<Chart>,
    marks: Vec<(f64, String)>,
}

#[derive(Debug, Clone)]
struct Series {
    style: Style,
    label: String,
    data: Data,
}

#[derive(Debug, Clone)]
enum Data {
    Line(Vec<(f64, f64)>),
    Points(Vec<(f64, f64)>),
    /// x, lower, upper.
    Band(Vec<(f64, f64, f64)>),
}

impl Chart {
    /// An empty chart of a quantity: `"position error [m]"`.
    pub fn new(y_label: impl Into<String>) -> Self {
        Chart { y_label: y_label.into(), ..Chart::default() }
    }

    /// A line through points (x, y). Points that cannot be seen are left out of the file: of a
    /// long series four per half pixel (see [`thin_columns`](super::thin_columns)), and those
    /// that would not change it by an eighth of a pixel (see [`simplify`](super::simplify)).
    #[must_use]
    pub fn line(
        self,
        style: impl Into<Style>,
        label: &str,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        self.with(style, label, Data::Line(points.into_iter().collect()))
    }

    /// A filled band between two curves, of triples (x, lower, upper). Bands lie under lines
    /// and points.
    #[must_use]
    pub fn band(
        self,
        style: impl Into<Style>,
        label: &str,
        band: impl IntoIterator<Item = (f64, f64, f64)>,
    ) -> Self {
        self.with(style, label, Data::Band(band.into_iter().collect()))
    }

    /// Separate dots at (x, y).
    #[must_use]
    pub fn points(
        self,
        style: impl Into<Style>,
        label: &str,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        self.with(style, label, Data::Points(points.into_iter().collect()))
    }

    /// A horizontal line to compare with, its label written along it.
    #[must_use]
    pub fn reference(mut self, value: f64, label: impl Into<String>) -> Self {
        self.references.push((value, label.into()));
        self
    }

    /// Fixes the range of y. A range that is empty, not finite, or not positive on a logarithmic
    /// axis is ignored, and the data decide: with a little room above and below, and down to 0
    /// where they are positive and come near it.
    #[must_use]
    pub fn y_range(mut self, low: f64, high: f64) -> Self {
        self.y_range = Some((low, high));
        self
    }

    /// Makes the y axis logarithmic.
    #[must_use]
    pub fn log_y(mut self) -> Self {
        self.log = true;
        self
    }

    fn with(mut self, style: impl Into<Style>, label: &str, data: Data) -> Self {
        self.series.push(Series { style: style.into(), label: label.to_owned(), data });
        self
    }
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
        draw::draw(self)
    }
}
