//! Surfaces side by side, their heights as colours.

use super::WIDTH;
use super::axis::{Axis, TICK_SIZE};
use super::frame::{Area, LABEL_SIZE, NAME_HEIGHT};
use super::header::{self, Legend};
use super::pictures::{ColorBar, draw_bar, image};
use super::style::Paint;
use super::text::{self, Anchor};
use super::writer::Writer;

const RIGHT: f64 = 14.0;
const GAP: f64 = 14.0;
/// Height of the strip above a surface, and its distance \[px\].
const STRIP: f64 = 9.0;
const STRIP_GAP: f64 = 8.0;

/// Surfaces over the same axes with one bar that explains the colours. Each is square.
#[derive(Debug, Clone, Default)]
pub struct HeatMaps {
    /// The title.
    pub title: String,
    /// A line under it, in smaller letters.
    pub subtitle: String,
    /// Name of the axis to the right, with its unit.
    pub x_label: String,
    /// Name of the axis upwards, with its unit.
    pub y_label: String,
    /// The numbers at both ends of the axis to the right; finite, the first one less.
    pub x_range: (f64, f64),
    /// The same upwards.
    pub y_range: (f64, f64),
    /// What the strips above the surfaces stand for.
    pub strip_label: String,
    /// The surfaces.
    pub maps: Vec<HeatMap>,
    /// What the colours mean.
    pub bar: Option<ColorBar>,
}

/// A surface as an image.
#[derive(Debug, Clone)]
pub struct HeatMap {
    /// What it shows.
    pub caption: String,
    /// The image that fills the axes, as a data URI.
    pub data_uri: String,
    /// A strip over the same axis to the right, for what the axis upwards has no place for.
    pub strip: Option<String>,
}

impl HeatMaps {
    /// The SVG file.
    pub fn render(&self) -> String {
        let mut writer = Writer::default();
        let top = header::draw(&mut writer, &self.title, &self.subtitle, &Legend::default());
        let strip = if self.maps.iter().any(|map| map.strip.is_some()) { STRIP } else { 0.0 };
        let strip_width = if strip > 0.0 { text::width(&self.strip_label, TICK_SIZE) } else { 0.0 };
        let y_axis = |pixels| Axis::linear(self.y_range, pixels).upwards();
        let left = y_axis((300.0, 0.0)).label_width().max(strip_width) + 14.0;
        let count = self.maps.len().max(1) as f64;
        let width = (WIDTH - left - RIGHT - (count - 1.0) * GAP) / count;
        let top = top + 2.0 * NAME_HEIGHT + if strip > 0.0 { strip + STRIP_GAP } else { 0.0 };
        let mut end = top;
        for (k, map) in self.maps.iter().enumerate() {
            let area = Area { left: left + k as f64 * (width + GAP), top, width, height: width };
            let x = Axis::linear(self.x_range, (area.left, area.right())).across();
            let y = y_axis((area.bottom(), area.top));
            image(&mut writer, &map.data_uri, [area.left, area.top, width, width]);
            self.draw_above(&mut writer, map, &area, k == 0);
            end = area.draw_x_axis(&mut writer, &x, &self.x_label);
            if k == 0 {
                area.draw_y_ticks(&mut writer, &y);
            }
        }
        if let Some(bar) = &self.bar {
            end = draw_bar(&mut writer, bar, left, end + 10.0, WIDTH - left - RIGHT, false);
        }
        writer.finish(&self.title, end + 6.0)
    }

    /// The caption, the name of the axis upwards and the strip.
    fn draw_above(&self, writer: &mut Writer, map: &HeatMap, area: &Area, first: bool) {
        let strip = map.strip.as_deref();
        let above = strip.map_or(0.0, |_| STRIP + STRIP_GAP);
        let mut line = |row: f64, paint: Paint, words: &str| {
            let at = (area.left, area.top - above - 8.0 - row * (NAME_HEIGHT - 4.0));
            let words = text::shorten(words, LABEL_SIZE, area.width);
            writer.text(text::element(at, LABEL_SIZE, Anchor::Start, paint), &words);
        };
        line(1.0, Paint::INK, &map.caption);
        if first {
            line(0.0, Paint::MUTED, &self.y_label);
        }
        if let Some(strip) = strip {
            let top = area.top - above;
            image(writer, strip, [area.left, top, area.width, STRIP]);
            if first {
                let at = (area.left - 7.0, top + STRIP - 2.0);
                let element = text::element(at, TICK_SIZE, Anchor::End, Paint::MUTED);
                writer.text(element, &self.strip_label);
            }
        }
    }
}
