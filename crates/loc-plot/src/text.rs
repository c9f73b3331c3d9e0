//! How much room a text takes, without knowing the font that will show it.

use crate::style::Paint;
use crate::writer::{Element, Writer};

/// Where a text stands relative to its point.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// How much wider than Arial the widest of the usual fonts runs.
const WIDEST: f64 = 1.15;

/// Width of a text \[px\] in the widest of the usual sans-serif fonts.
pub(crate) fn width(text: &str, size: f64) -> f64 {
    WIDEST * size * text.chars().map(em_width).sum::<f64>()
}

fn em_width(c: char) -> f64 {
    match c {
        'i' | 'j' | 'l' | '\'' | '|' => 0.22,
        'f' | 't' | 'I' | '.' | ',' | ':' | ';' | '!' | ' ' | '[' | ']' | '/' => 0.28,
        'r' | '-' | '(' | ')' => 0.33,
        'c' | 'k' | 's' | 'v' | 'x' | 'y' | 'z' | 'J' => 0.5,
        'w' | 'A'..='H' | 'K' | 'N'..='V' | 'X'..='Z' => 0.72,
        'm' | 'M' | 'W' | '@' | '%' => 0.9,
        c if c.is_ascii() => 0.56,
        c if u32::from(c) < 0x1100 || ('\u{2000}'..'\u{2e80}').contains(&c) => 0.7,
        _ => 1.0,
    }
}

/// The text, cut with an ellipsis where it is wider than `room` \[px\].
pub(crate) fn shorten(text: &str, size: f64, room: f64) -> String {
    if width(text, size) <= room {
        return text.to_owned();
    }
    let room = room - width("…", size);
    let mut used = 0.0;
    let kept: String = text
        .chars()
        .take_while(|&c| {
            used += WIDEST * size * em_width(c);
            used <= room
        })
        .collect();
    format!("{}…", kept.trim_end())
}

/// The text in lines no wider than `room` \[px\], broken between words; at most `lines`.
pub(crate) fn wrap(text: &str, size: f64, room: f64, lines: usize) -> Vec<String> {
    let mut wrapped: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        let full = wrapped.len() >= lines;
        match wrapped.last_mut() {
            Some(line) if full || width(&format!("{line} {word}"), size) <= room => {
                line.push(' ');
                line.push_str(word);
            }
            _ => wrapped.push(word.to_owned()),
        }
    }
    for line in &mut wrapped {
        *line = shorten(line, size, room);
    }
    wrapped
}

/// A `text` element.
pub(crate) fn element((x, y): (f64, f64), size: f64, anchor: Anchor, paint: Paint) -> Element {
    let element = Element::new("text").num("x", x).num("y", y).num("font-size", size).fill(paint);
    match anchor {
        Anchor::Start => element,
        Anchor::Middle => element.attr("text-anchor", "middle"),
        Anchor::End => element.attr("text-anchor", "end"),
    }
}

/// A text with a rim of paper around its letters, readable on top of lines.
pub(crate) fn draw_with_halo(writer: &mut Writer, element: Element, text: &str) {
    let element = element
        .stroke(Paint::PAPER, 3.0)
        .attr("stroke-linejoin", "round")
        .attr("paint-order", "stroke");
    writer.text(element, text);
}
