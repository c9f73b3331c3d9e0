//! Charts: quantities over one another, in one panel.

use crate::axis::{Area, Axis, TICK_SIZE};
use crate::labels::Room;
use crate::marks::Px;
use crate::style::{Paint, Role, Style};
use crate::text::Anchor;
use crate::writer::{Element, Writer};
use crate::{drawable, marks, text};

/// Width of the columns in which lines are thinned \[px\].
const COLUMN: f64 = 0.5;
/// Below this share of the largest value, positive data come near 0.
const NEAR_ZERO: f64 = 0.4;

/// Quantities over one another: lines, bands, points and limits. One panel of a
/// [`Figure`](crate::Figure).
///
/// Values that are not finite break a line or band; on a logarithmic axis so do values that are
/// not positive. A label names a series in the figure's legend; series of the same colour and
/// label share one entry, also across panels, and those with an empty label have none.
#[derive(Debug, Clone, Default)]
pub struct Chart {
    y_label: String,
    pub(crate) series: Vec<Series>,
    references: Vec<(f64, String)>,
    y_range: Option<(f64, f64)>,
    log: bool,
}

#[derive(Debug, Clone)]
pub(crate) struct Series {
    pub(crate) style: Style,
    pub(crate) label: String,
    pub(crate) data: Data,
}

#[derive(Debug, Clone)]
pub(crate) enum Data {
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
    /// long series four per half pixel (see [`thin_columns`](crate::thin_columns)), and those
    /// that would not change it by an eighth of a pixel (see [`simplify`](crate::simplify)).
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

    /// Bars from 0 to a height, filled and with an edge, of pairs (middle, height), `width` wide.
    #[must_use]
    pub fn bars(
        self,
        role: Role,
        label: &str,
        width: f64,
        bars: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let gap = f64::NAN;
        let (mut filled, mut edges) = (Vec::new(), Vec::new());
        for (x, height) in bars {
            let (left, right) = (x - 0.5 * width, x + 0.5 * width);
            filled.extend([(left, 0.0, height), (right, 0.0, height), (gap, gap, gap)]);
            edges.extend([(left, 0.0), (left, height), (right, height), (right, 0.0), (gap, gap)]);
        }
        self.band(role, label, filled).line(role.width(0.8), "", edges)
    }

    /// Vertical lines from 0 to a height, of pairs (x, height).
    #[must_use]
    pub fn stems(
        self,
        style: impl Into<Style>,
        label: &str,
        stems: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let stem = |(x, height): (f64, f64)| [(x, 0.0), (x, height), (f64::NAN, f64::NAN)];
        self.line(style, label, stems.into_iter().flat_map(stem))
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

    /// Whether any series has a value to show.
    fn has_data(&self) -> bool {
        let mut any = false;
        self.for_each_value(|_, _| any = true);
        any
    }

    /// Whether there is nothing at all that a y axis could tell about.
    fn is_blank(&self) -> bool {
        !self.has_data() && self.references.is_empty() && self.y_range.is_none()
    }

    /// The interval of y: the fixed one where it is valid, else what the data need.
    fn y_interval(&self) -> (f64, f64) {
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
    pub(crate) fn for_each_value(&self, mut visit: impl FnMut(f64, f64)) {
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

pub(crate) fn include(range: &mut Option<(f64, f64)>, value: f64) {
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

pub(crate) fn y_axis(chart: &Chart, pixels: (f64, f64)) -> Axis {
    let range = chart.y_interval();
    let axis = if chart.log { Axis::log(range, pixels) } else { Axis::linear(range, pixels) };
    if chart.is_blank() { axis } else { axis.upwards() }
}

pub(crate) fn draw_panel(writer: &mut Writer, chart: &Chart, area: &Area, x: &Axis) {
    let y = y_axis(chart, (area.bottom(), area.top));
    area.draw_grid(writer, x, &y);
    area.open_clip(writer, 3.0);
    draw_lines(writer, chart, area, &y);
    let (bands, others): (Vec<_>, Vec<_>) =
        chart.series.iter().partition(|series| matches!(series.data, Data::Band(_)));
    for series in bands.into_iter().chain(others) {
        draw_series(writer, series, x, &y);
    }
    draw_labels(writer, chart, area, x, &y);
    writer.close();
    if !chart.has_data() {
        area.draw_no_data(writer);
    }
    area.draw_y_axis(writer, &y, &chart.y_label);
}

fn draw_series(writer: &mut Writer, series: &Series, x: &Axis, y: &Axis) {
    match &series.data {
        Data::Line(points) => {
            let pixels = pixels(points, x, y);
            let mut thinned: Vec<Px> = Vec::new();
            for run in marks::runs(&pixels) {
                thinned.extend(marks::thin_columns(run, COLUMN));
                thinned.push((f64::NAN, f64::NAN));
            }
            marks::draw_line(writer, series.style, &thinned);
        }
        Data::Points(points) => {
            marks::draw_dots(writer, series.style, 4.0, &pixels(points, x, y));
        }
        Data::Band(band) => draw_band(writer, series.style, &band_pixels(band, x, y)),
    }
}

fn pixels(points: &[(f64, f64)], x: &Axis, y: &Axis) -> Vec<Px> {
    let px = |axis: &Axis, v: f64| if drawable(v) { axis.px(v) } else { f64::NAN };
    points.iter().map(|&(u, v)| (px(x, u), px(y, v))).collect()
}

/// Lower and upper edge of the parts of a band. A lower edge that a logarithmic axis cannot show
/// lies at the bottom.
fn band_pixels(band: &[(f64, f64, f64)], x: &Axis, y: &Axis) -> Vec<(Vec<Px>, Vec<Px>)> {
    let shown = |&(u, lower, upper): &(f64, f64, f64)| {
        drawable(u) && drawable(lower) && drawable(upper) && y.px(upper).is_finite()
    };
    band.split(|row| !shown(row))
        .filter(|part| !part.is_empty())
        .map(|part| {
            let edge = |value: fn(&(f64, f64, f64)) -> f64| -> Vec<Px> {
                let points = part.iter().map(|row| {
                    let at = y.px(value(row));
                    (x.px(row.0), if at.is_finite() { at } else { 1e5 })
                });
                points.collect()
            };
            (edge(|row| row.1), edge(|row| row.2))
        })
        .collect()
}

fn draw_band(writer: &mut Writer, style: Style, parts: &[(Vec<Px>, Vec<Px>)]) {
    let thinned =
        |edge: &[Px]| marks::simplify(&marks::thin_columns(edge, COLUMN), marks::TOLERANCE);
    let data: String = parts
        .iter()
        .map(|(lower, upper)| {
            let mut outline = thinned(lower);
            outline.extend(thinned(upper).into_iter().rev());
            marks::polyline(&outline) + "Z"
        })
        .collect();
    if !data.is_empty() {
        let path = Element::new("path").attr("d", &data).fill(style.paint());
        writer.add(path.attr("fill-opacity", "0.2"));
    }
}

/// Horizontal lines to compare with.
fn draw_lines(writer: &mut Writer, chart: &Chart, area: &Area, y: &Axis) {
    for (value, _) in &chart.references {
        let at = y.px(*value);
        let line = [(area.left, at), (area.right(), at)];
        marks::draw_line(writer, Role::Reference.dashed().width(1.3), &line);
    }
}

/// The labels of horizontal lines, above or below the line and at its right or left end, wherever
/// they cover least.
fn draw_labels(writer: &mut Writer, chart: &Chart, area: &Area, x: &Axis, y: &Axis) {
    let named = |(value, label): &&(f64, String)| y.px(*value).is_finite() && !label.is_empty();
    let references: Vec<_> = chart.references.iter().filter(named).collect();
    if references.is_empty() {
        return;
    }
    let mut room = booked_room(chart, area, x, y);
    for (value, label) in references {
        let at = y.px(*value);
        let label = text::shorten(label, TICK_SIZE, 0.7 * area.width);
        let width = text::width(&label, TICK_SIZE);
        let (right, left) = (area.right() - 8.0 - width, area.left + 8.0);
        let (above, below) = (at - 18.0, at + 2.5);
        let place = |left: f64, top: f64| [left, top, left + width, top + 15.0];
        let places =
            [place(right, above), place(right, below), place(left, above), place(left, below)];
        if let Some([from, _, to, bottom]) = room.take(&places) {
            let (at, anchor) = if from < right { (from, Anchor::Start) } else { (to, Anchor::End) };
            let element = text::element((at, bottom - 2.5), TICK_SIZE, anchor, Paint::MUTED);
            text::draw_with_halo(writer, element, &label);
        }
    }
}

/// The room that lines and points take.
fn booked_room(chart: &Chart, area: &Area, x: &Axis, y: &Axis) -> Room {
    let mut room = Room::new(*area);
    for (value, _) in &chart.references {
        let at = y.px(*value);
        if at.is_finite() {
            room.book_segment((area.left, at), (area.right(), at));
        }
    }
    for series in &chart.series {
        match &series.data {
            Data::Line(points) => {
                let pixels = pixels(points, x, y);
                marks::runs(&pixels).for_each(|run| room.book_path(run));
            }
            Data::Points(points) => {
                let pixels = pixels(points, x, y);
                let shown = marks::runs(&pixels).flatten();
                shown.for_each(|&point| room.book_mark(point, 2.0));
            }
            Data::Band(_) => {}
        }
    }
    room
}
