//! Images side by side ([`Pictures`]) and surfaces over the same axes ([`HeatMaps`]), with the
//! meaning of their colours ([`ColorBar`]).

use crate::axis::{Area, Axis, LABEL_SIZE, NAME_HEIGHT, TICK_SIZE};
use crate::header::Legend;
use crate::style::Paint;
use crate::text::Anchor;
use crate::writer::{Element, Writer};
use crate::{WIDTH, header, text};

/// Margin to the left and to the right, and between pictures \[px\].
const LEFT: f64 = 14.0;
const RIGHT: f64 = 14.0;
const GAP: f64 = 14.0;
/// Height and distance of the bar that explains colours \[px\].
const BAR: f64 = 11.0;
/// Height of the strip above a surface, and its distance \[px\].
const STRIP: f64 = 9.0;
const STRIP_GAP: f64 = 8.0;

/// Images in rows, with a title, captions and colour bars. The colours of photographs stay as they
/// are in dark surroundings.
#[derive(Debug, Clone, Default)]
pub struct Pictures {
    title: String,
    subtitle: String,
    rows: Vec<Vec<Picture>>,
}

/// An image with a caption.
#[derive(Debug, Clone)]
pub struct Picture {
    /// What it shows.
    pub caption: String,
    /// The image as a data URI: `data:image/png;base64,...`.
    pub data_uri: String,
    /// Width by height.
    pub aspect: f64,
    /// What its colours mean, where they mean something.
    pub bar: Option<ColorBar>,
}

/// What colours mean: the numbers from the left to the right end of a strip of colours.
#[derive(Debug, Clone)]
pub struct ColorBar {
    /// The strip as a data URI.
    pub data_uri: String,
    /// The number at the left end.
    pub low: f64,
    /// The number at the right end.
    pub high: f64,
    /// The quantity with its unit: `depth [m]`.
    pub name: String,
}

impl Pictures {
    /// A figure without images.
    pub fn new(title: impl Into<String>) -> Self {
        Pictures { title: title.into(), ..Pictures::default() }
    }

    /// A line under the title, in smaller letters.
    #[must_use]
    pub fn subtitle(mut self, subtitle: impl Into<String>) -> Self {
        self.subtitle = subtitle.into();
        self
    }

    /// Adds images side by side, below those before; they share the width evenly.
    #[must_use]
    pub fn row(mut self, pictures: impl IntoIterator<Item = Picture>) -> Self {
        self.rows.push(pictures.into_iter().collect());
        self
    }

    /// The SVG file.
    pub fn render(&self) -> String {
        let mut writer = Writer::default();
        let mut top =
            header::draw(&mut writer, &self.title, &self.subtitle, &Legend::default()) + 8.0;
        for row in self.rows.iter().filter(|row| !row.is_empty()) {
            let count = row.len() as f64;
            let width = (WIDTH - 2.0 * LEFT - (count - 1.0) * GAP) / count;
            let ends = row.iter().enumerate().map(|(k, picture)| {
                let left = LEFT + k as f64 * (width + GAP);
                draw(&mut writer, picture, left, top, width)
            });
            top = ends.fold(top, f64::max) + 10.0;
        }
        writer.finish(&self.title, top)
    }
}

/// Draws an image with its caption above it; returns where it ends \[px\].
fn draw(writer: &mut Writer, picture: &Picture, left: f64, top: f64, width: f64) -> f64 {
    let caption = text::shorten(&picture.caption, LABEL_SIZE, width);
    let at = (left, top + 14.0);
    writer.text(text::element(at, LABEL_SIZE, Anchor::Start, Paint::INK), &caption);
    let top = top + 21.0;
    let height = (width / picture.aspect).clamp(1.0, 2.0 * WIDTH);
    image(writer, &picture.data_uri, [left, top, width, height]);
    match &picture.bar {
        Some(bar) => draw_bar(writer, bar, left, top + height + 8.0, width, false),
        None => top + height,
    }
}

/// Draws a strip of colours with its numbers below and its name beside it, with other colours in
/// dark surroundings where the images that it explains have them; returns where it ends \[px\].
pub(crate) fn draw_bar(
    writer: &mut Writer,
    bar: &ColorBar,
    left: f64,
    top: f64,
    width: f64,
    turns_dark: bool,
) -> f64 {
    let name = text::width(&bar.name, TICK_SIZE) + 8.0;
    let width = width - name;
    draw_image(writer, &bar.data_uri, [left, top, width, BAR], turns_dark);
    let axis = Axis::linear((bar.low, bar.high), (left, left + width)).across();
    for tick in &axis.ticks {
        let half = 0.5 * text::width(&tick.label, TICK_SIZE);
        let x = axis.px(tick.value).clamp(left + half, left + width - half);
        let element = text::element((x, top + BAR + 14.0), TICK_SIZE, Anchor::Middle, Paint::MUTED);
        writer.text(element, &tick.label);
    }
    let at = (left + width + 8.0, top + BAR - 1.0);
    writer.text(text::element(at, TICK_SIZE, Anchor::Start, Paint::MUTED), &bar.name);
    top + BAR + 20.0
}

pub(crate) fn image(writer: &mut Writer, data_uri: &str, place: [f64; 4]) {
    draw_image(writer, data_uri, place, false);
}

/// Images that stand for paper, such as maps, change their colours in dark surroundings.
fn draw_image(
    writer: &mut Writer,
    data_uri: &str,
    [left, top, width, height]: [f64; 4],
    turns_dark: bool,
) {
    let place = |element: Element| {
        element.num("x", left).num("y", top).num("width", width).num("height", height)
    };
    // Anything but an image in the file itself would need the network.
    if data_uri.starts_with("data:image/") {
        let element = Element::new("image");
        let element = if turns_dark { element.class("loc-image") } else { element };
        let element = place(element).attr("preserveAspectRatio", "none");
        writer.add(element.attr("href", data_uri));
    }
    writer.add(place(Element::new("rect")).no_fill().stroke(Paint::EDGE, 1.0));
}

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
