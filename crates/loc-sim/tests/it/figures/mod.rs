//! Figures: files that every viewer can read, and pictures that do not lie.

mod drives;
mod gallery;

use roxmltree::Document;

/// The file as XML; panics where it is not well-formed.
fn parse(svg: &str) -> Document<'_> {
    Document::parse(svg).unwrap()
}

fn dark_and_light_sheet(svg: &str) {
    assert!(svg.contains("prefers-color-scheme:dark"));
    assert!(!svg.contains("<script") && !svg.contains("http://www.w3.org/1999"));
}
