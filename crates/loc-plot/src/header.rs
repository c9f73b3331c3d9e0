//! What stands above the plots: title, subtitle and legend, which so cover no data.

use crate::axis::LABEL_SIZE;
use crate::style::{Paint, Style};
use crate::text::Anchor;
use crate::writer::{Element, Writer};
use crate::{WIDTH, marks, text};

const LEFT: f64 = 14.0;
const ROOM: f64 = WIDTH - 2.0 * LEFT;
const TITLE_SIZE: f64 = 19.0;
const KEY_WIDTH: f64 = 30.0;
const ROW: f64 = 22.0;

/// The shape that stands for a thing in the legend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Glyph {
    Line,
    Band,
    Ellipse,
    Dots,
    Cross,
    Star,
    Arrow,
}

/// The entries of a legend; one label in one colour is one entry, with the shapes of all things
/// that bear it.
#[derive(Default)]
pub(crate) struct Legend {
    keys: Vec<(String, Vec<(Glyph, Style)>)>,
}

impl Legend {
    /// Adds a thing; one without label stays out of the legend.
    pub(crate) fn add(&mut self, label: &str, glyph: Glyph, style: Style) {
        if label.trim().is_empty() {
            return;
        }
        let same = |(name, shapes): &&mut (String, Vec<(Glyph, Style)>)| {
            name == label && shapes.iter().all(|(_, s)| s.paint() == style.paint())
        };
        match self.keys.iter_mut().find(same) {
            Some((_, shapes)) if shapes.iter().any(|(g, _)| *g == glyph) => {}
            Some((_, shapes)) => shapes.push((glyph, style)),
            None => self.keys.push((label.to_owned(), vec![(glyph, style)])),
        }
    }

    /// Draws the entries in rows below `top`; returns where they end \[px\].
    fn draw(&self, writer: &mut Writer, top: f64) -> f64 {
        let (mut x, mut baseline) = (LEFT, top + 15.0);
        for (label, shapes) in &self.keys {
            let label = text::shorten(label, LABEL_SIZE, ROOM - KEY_WIDTH - 7.0);
            let needed = KEY_WIDTH + 7.0 + text::width(&label, LABEL_SIZE);
            if x > LEFT && x + needed > LEFT + ROOM {
                (x, baseline) = (LEFT, baseline + ROW);
            }
            for &(glyph, style) in shapes {
                draw_glyph(writer, glyph, style, (x + 0.5 * KEY_WIDTH, baseline - 4.5));
            }
            let at = (x + KEY_WIDTH + 7.0, baseline);
            let element = text::element(at, LABEL_SIZE, Anchor::Start, Paint::INK);
            writer.text(element, &label);
            x += needed + 16.0;
        }
        if self.keys.is_empty() { top } else { baseline + 8.0 }
    }
}

/// Draws title, subtitle and legend; returns where they end \[px\].
pub(crate) fn draw(writer: &mut Writer, title: &str, subtitle: &str, legend: &Legend) -> f64 {
    let mut end = 8.0;
    // Bold letters run wider.
    for line in text::wrap(title, 1.12 * TITLE_SIZE, ROOM, 2) {
        end += 25.0;
        let at = (LEFT, end - 5.0);
        let element = text::element(at, TITLE_SIZE, Anchor::Start, Paint::INK);
        writer.text(element.attr("font-weight", "600"), &line);
    }
    for line in text::wrap(subtitle, LABEL_SIZE, ROOM, 3) {
        end += 19.0;
        let at = (LEFT, end - 4.0);
        let element = text::element(at, LABEL_SIZE, Anchor::Start, Paint::MUTED);
        writer.text(element, &line);
    }
    legend.draw(writer, end + 3.0)
}

fn draw_glyph(writer: &mut Writer, glyph: Glyph, style: Style, (x, y): (f64, f64)) {
    let (left, right) = (x - 0.5 * KEY_WIDTH, x + 0.5 * KEY_WIDTH);
    match glyph {
        Glyph::Line => marks::draw_line(writer, style, &[(left + 1.0, y), (right - 1.0, y)]),
        Glyph::Dots => {
            marks::draw_dots(writer, style, 3.0, &[(x - 6.0, y), (x, y), (x + 6.0, y)]);
        }
        Glyph::Cross => marks::draw_crosses(writer, style, &[(x, y)]),
        Glyph::Star => marks::draw_stars(writer, style, &[(x, y)]),
        Glyph::Arrow => marks::draw_arrows(writer, style, &[((x, y), 0.0)]),
        Glyph::Band => writer.add(
            Element::new("rect")
                .num("x", left)
                .num("y", y - 6.0)
                .num("width", KEY_WIDTH)
                .num("height", 12.0)
                .fill(style.paint())
                .attr("fill-opacity", "0.2"),
        ),
        Glyph::Ellipse => writer.add(
            Element::new("ellipse")
                .num("cx", x)
                .num("cy", y)
                .num("rx", 10.0)
                .num("ry", 5.5)
                .line_style(style, 1.2)
                .region(style),
        ),
    }
}
