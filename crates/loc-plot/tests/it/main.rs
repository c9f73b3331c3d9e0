//! Tests of `loc-plot` through its public face: files that every viewer can read, and pictures that
//! show the data.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod charts;
mod drives;
mod gallery;
mod scenes;
mod thinning;
mod ticks;

use roxmltree::{Document, Node};

/// The elements of a kind.
fn elements<'a>(doc: &'a Document<'a>, tag: &'a str) -> impl Iterator<Item = Node<'a, 'a>> {
    doc.descendants().filter(move |node| node.has_tag_name(tag))
}

/// An attribute that is a number.
fn number(node: Node, name: &str) -> f64 {
    node.attribute(name).unwrap().parse().unwrap()
}

/// All texts of a figure.
fn texts(svg: &str) -> Vec<String> {
    let doc = Document::parse(svg).unwrap();
    let text = |node: Node| node.text().unwrap_or_default().to_owned();
    elements(&doc, "text").map(text).collect()
}

/// The points of a path of straight lines, one list per subpath.
fn subpaths(data: &str) -> Vec<Vec<(f64, f64)>> {
    let subpath = |part: &str| {
        let part = part.replace("h.01", "").replace('Z', "");
        let spaced = part.replace('L', " ").replace('-', " -");
        let numbers: Vec<f64> = spaced.split_whitespace().map(|n| n.parse().unwrap()).collect();
        numbers.chunks(2).map(|pair| (pair[0], pair[1])).collect()
    };
    data.split('M').skip(1).map(subpath).collect()
}

/// The data of all paths in a colour, without those of grid and legend (which lie unclipped).
fn drawn(svg: &str, class: &str) -> Vec<String> {
    let doc = Document::parse(svg).unwrap();
    let clipped = |node: &Node| node.ancestors().any(|a| a.has_attribute("clip-path"));
    elements(&doc, "path")
        .filter(|node| clipped(node) && node.attribute("class").unwrap().contains(class))
        .map(|node| node.attribute("d").unwrap().to_owned())
        .collect()
}

/// What holds for every figure: sound XML, light colours without style sheet and dark ones with
/// it, nothing from elsewhere, sane numbers, nothing cut off.
fn check(svg: &str) {
    let doc = Document::parse(svg).unwrap();
    let (sheet, rest) = svg.split_once("</style>").unwrap();
    let (plain, dark) = sheet.split_once("@media (prefers-color-scheme:dark)").unwrap();
    assert!(!plain.contains("var(") && dark.contains("--loc-paper"));
    for foreign in ["<script", "@import", "http", "url(h"] {
        assert!(!rest.contains(foreign), "{foreign}");
    }
    let root = doc.root_element();
    let (width, height) = (number(root, "width"), number(root, "height"));
    for node in doc.descendants().filter(Node::is_element) {
        for class in node.attribute("class").unwrap_or_default().split(' ') {
            if let Some(name) = class.strip_prefix("loc-f-") {
                assert!(node.has_attribute("fill") && dark.contains(&format!("--loc-{name}:")));
            }
            if let Some(name) = class.strip_prefix("loc-s-") {
                assert!(node.has_attribute("stroke") && dark.contains(&format!("--loc-{name}:")));
            }
        }
        for attribute in node.attributes().filter(|a| a.name() != "href") {
            check_numbers(attribute.value());
        }
    }
    for text in elements(&doc, "text") {
        let (x, y) = (number(text, "x"), number(text, "y"));
        assert!((0.0..=width).contains(&x) && (10.0..=height).contains(&y), "{text:?}");
    }
}

/// No number has more than two decimals, is a negative zero, or is none at all.
fn check_numbers(value: &str) {
    assert!(!value.contains("NaN") && !value.contains("inf"), "{value}");
    let is_part = |c: char| c.is_ascii_digit() || c == '.' || c == '-';
    for word in value.split(|c| !is_part(c)) {
        assert!(word != "-0" && !word.starts_with("-0 "), "{value}");
        if let Some((_, decimals)) = word.split_once('.') {
            let decimals = decimals.split(['-', '.']).next().unwrap();
            assert!(decimals.len() <= 2, "{value}");
        }
    }
}

/// Numbers that break careless code.
const WILD: [f64; 14] = [
    0.0,
    -0.0,
    1.0,
    -3.5,
    1e-9,
    5.8e6,
    -1e15,
    1e99,
    1e-300,
    1e300,
    f64::MAX,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
];
