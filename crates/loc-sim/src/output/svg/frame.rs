//! The plot area with its grid and its axes.

use super::WIDTH;
use super::axis::{Axis, TICK_SIZE};
use super::style::Paint;
use super::text::{self, Anchor};
use super::writer::{Element, Writer, number};

/// Font size of axis names and of the legend \[px\].
pub(super) const LABEL_SIZE: f64 = 14.0;
/// Height of the line that names the axis above its area \[px\].
pub(super) const NAME_HEIGHT: f64 = 24.0;

/// A rectangle of the figure \[px\], y down.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Area {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) width: f64,
    pub(super) height: f64,
}

impl Area {
    pub(super) fn right(&self) -> f64 {
        self.left + self.width
    }

    pub(super) fn bottom(&self) -> f64 {
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
    pub(super) fn open_clip(&self, writer: &mut Writer, rim: f64) {
        let area = Area { left: self.left - rim, width: self.width + 2.0 * rim, ..*self };
        let corners = [area.left, area.top, area.width, area.height].map(number);
        let id = format!("loc-clip-{}", corners.join("-"));
        writer.open(Element::new("clipPath").attr("id", &id));
        writer.add(area.rect());
        writer.close();
        writer.open(Element::new("g").attr("clip-path", &format!("url(#{id})")));
    }

    /// The grid through the ticks of both axes, and the edge around it.
    pub(super) fn draw_grid(&self, writer: &mut Writer, x: &Axis, y: &Axis) {
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
    pub(super) fn draw_x_axis(&self, writer: &mut Writer, x: &Axis, name: &str) -> f64 {
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
    pub(super) fn draw_y_ticks(&self, writer: &mut Writer, y: &Axis) {
        for tick in &y.ticks {
            let at = (self.left - 7.0, y.px(tick.value) + 0.35 * TICK_SIZE);
            label(writer, at, Anchor::End, &tick.label);
        }
    }

    /// The numbers to the left of the area and the axis' name above it.
    pub(super) fn draw_y_axis(&self, writer: &mut Writer, y: &Axis, name: &str) {
        self.draw_y_ticks(writer, y);
        let at = (self.left, self.top - 8.0);
        let name = text::shorten(&y.title(name), LABEL_SIZE, self.width);
        let element = text::element(at, LABEL_SIZE, Anchor::Start, Paint::INK);
        writer.text(element, &name);
    }

    /// Says in the middle of the area that there is nothing to see.
    pub(super) fn draw_no_data(&self, writer: &mut Writer) {
        let middle = (self.left + 0.5 * self.width, self.top + 0.5 * self.height + 5.0);
        let element = text::element(middle, 15.0, Anchor::Middle, Paint::MUTED);
        writer.text(element, "no data");
    }
}

fn label(writer: &mut Writer, at: (f64, f64), anchor: Anchor, label: &str) {
    writer.text(text::element(at, TICK_SIZE, anchor, Paint::MUTED), label);
}
