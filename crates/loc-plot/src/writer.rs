//! The writer of SVG text: elements, numbers, escaping.

use crate::WIDTH;
use crate::style::{Paint, Style, style_sheet};
use std::collections::BTreeSet;

const FONTS: &str = "system-ui, -apple-system, 'Segoe UI', Roboto, 'Helvetica Neue', \
                     'Liberation Sans', Arial, sans-serif";

/// An element with its attributes, to be handed to a [`Writer`].
pub(crate) struct Element {
    tag: &'static str,
    attributes: String,
    classes: Vec<String>,
    paints: Vec<Paint>,
}

impl Element {
    pub(crate) fn new(tag: &'static str) -> Self {
        Element { tag, attributes: String::new(), classes: Vec::new(), paints: Vec::new() }
    }

    pub(crate) fn attr(mut self, name: &str, value: &str) -> Self {
        let value = escape(value);
        self.attributes.push_str(&format!(" {name}=\"{value}\""));
        self
    }

    pub(crate) fn num(self, name: &str, value: f64) -> Self {
        self.attr(name, &number(value))
    }

    pub(crate) fn class(mut self, name: &str) -> Self {
        self.classes.push(name.to_owned());
        self
    }

    pub(crate) fn fill(self, paint: Paint) -> Self {
        self.painted("fill", "f", paint)
    }

    pub(crate) fn no_fill(self) -> Self {
        self.attr("fill", "none")
    }

    pub(crate) fn stroke(self, paint: Paint, width: f64) -> Self {
        self.painted("stroke", "s", paint).num("stroke-width", width)
    }

    /// A line in the given style, round at its ends and corners.
    pub(crate) fn line_style(self, style: Style, usual_width: f64) -> Self {
        let width = style.width_or(usual_width);
        let line = self
            .stroke(style.paint(), width)
            .attr("stroke-linecap", "round")
            .attr("stroke-linejoin", "round");
        match style.dashes(width) {
            Some(dashes) => line.attr("stroke-dasharray", &dashes),
            None => line,
        }
    }

    /// The inside of an ellipse: a hint of its line's colour.
    pub(crate) fn region(self, style: Style) -> Self {
        self.fill(style.paint()).attr("fill-opacity", "0.06").attr("stroke-opacity", "0.75")
    }

    fn painted(mut self, property: &str, prefix: &str, paint: Paint) -> Self {
        self.paints.push(paint);
        self.class(&format!("loc-{prefix}-{}", paint.name)).attr(property, paint.light)
    }
}

/// Collects elements and knows which colours they use.
#[derive(Default)]
pub(crate) struct Writer {
    body: String,
    paints: BTreeSet<Paint>,
    open: Vec<&'static str>,
}

impl Writer {
    /// An element without content.
    pub(crate) fn add(&mut self, element: Element) {
        self.start(element, "/>\n");
    }

    /// An element around all that follows, until [`close`](Writer::close).
    pub(crate) fn open(&mut self, element: Element) {
        let tag = element.tag;
        self.start(element, ">\n");
        self.open.push(tag);
    }

    pub(crate) fn close(&mut self) {
        if let Some(tag) = self.open.pop() {
            self.body.push_str(&format!("</{tag}>\n"));
        }
    }

    /// An element that holds a text.
    pub(crate) fn text(&mut self, element: Element, text: &str) {
        let tag = element.tag;
        self.start(element, ">");
        self.body.push_str(&format!("{}</{tag}>\n", escape(text)));
    }

    fn start(&mut self, element: Element, end: &str) {
        self.paints.extend(element.paints);
        self.body.push_str(&format!("<{}", element.tag));
        if !element.classes.is_empty() {
            let classes = element.classes.join(" ");
            self.body.push_str(&format!(" class=\"{classes}\""));
        }
        self.body.push_str(&element.attributes);
        self.body.push_str(end);
    }

    /// The whole file, on paper of the given height \[px\].
    pub(crate) fn finish(mut self, title: &str, height: f64) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.paints.insert(Paint::PAPER);
        let (width, height) = (number(WIDTH), number(height.ceil()));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"loc-figure\" role=\"img\" \
             width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"{FONTS}\">\n<title>{}</title>\n{}\
             <rect class=\"loc-f-paper\" width=\"{width}\" height=\"{height}\" fill=\"{}\"/>\n\
             {}</svg>\n",
            escape(title),
            style_sheet(&self.paints),
            Paint::PAPER.light,
            self.body
        )
    }
}

/// A number with at most two decimals and nothing superfluous; 0 for what is not finite.
pub(crate) fn number(value: f64) -> String {
    let text = format!("{:.2}", if value.is_finite() { value } else { 0.0 });
    match text.trim_end_matches('0').trim_end_matches('.') {
        "-0" | "" => "0".to_owned(),
        short => short.to_owned(),
    }
}

/// Appends a point to the data of a path.
pub(crate) fn push_point(data: &mut String, (x, y): (f64, f64)) {
    data.push_str(&number(x));
    let y = number(y);
    if !y.starts_with('-') {
        data.push(' ');
    }
    data.push_str(&y);
}

/// Text that is safe inside elements and attributes; characters that XML forbids become U+FFFD.
fn escape(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\n' | '\r' | '\t' => safe.push(' '),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => safe.push('\u{fffd}'),
            c => safe.push(c),
        }
    }
    safe
}
