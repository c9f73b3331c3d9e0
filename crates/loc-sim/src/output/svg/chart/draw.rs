//! Drawing a figure of charts.

use super::{Chart, Data, Figure, Series, references};
use crate::output::svg::axis::Axis;
use crate::output::svg::frame::{Area, NAME_HEIGHT};
use crate::output::svg::header::{self, Glyph, Legend};
use crate::output::svg::marks::{self, Px};
use crate::output::svg::style::Style;
use crate::output::svg::thin;
use crate::output::svg::writer::{Element, Writer};
use crate::output::svg::{WIDTH, drawable};

/// Room to the right of the panels \[px\].
const RIGHT: f64 = 20.0;
/// Room between panels \[px\].
const GAP: f64 = 12.0;
/// Width of the columns in which lines are thinned \[px\].
const COLUMN: f64 = 0.5;

pub(super) fn draw(figure: &Figure) -> String {
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
        references::draw_marks(&mut writer, &figure.marks, area.is_none(), &panel, &x);
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

fn y_axis(chart: &Chart, pixels: (f64, f64)) -> Axis {
    let range = chart.y_interval();
    let axis = if chart.log { Axis::log(range, pixels) } else { Axis::linear(range, pixels) };
    if chart.is_blank() { axis } else { axis.upwards() }
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

fn draw_panel(writer: &mut Writer, chart: &Chart, area: &Area, x: &Axis) {
    let y = y_axis(chart, (area.bottom(), area.top));
    area.draw_grid(writer, x, &y);
    area.open_clip(writer, 3.0);
    references::draw_lines(writer, chart, area, &y);
    let (bands, others): (Vec<_>, Vec<_>) =
        chart.series.iter().partition(|series| matches!(series.data, Data::Band(_)));
    for series in bands.into_iter().chain(others) {
        draw_series(writer, series, x, &y);
    }
    references::draw_labels(writer, chart, area, x, &y);
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
                thinned.extend(thin::thin_columns(run, COLUMN));
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

pub(super) fn pixels(points: &[(f64, f64)], x: &Axis, y: &Axis) -> Vec<Px> {
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
    let thinned = |edge: &[Px]| thin::simplify(&thin::thin_columns(edge, COLUMN), marks::TOLERANCE);
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
