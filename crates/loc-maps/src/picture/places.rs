//! A topological map as shapes.

use super::{n, pixels, xy};
use crate::TopologicalMap;
use crate::topological::{Place, PlaceKind};
use std::fmt::Write as _;

/// Places as SVG: outlines below, then edges, then dots and names.
pub(super) fn draw(map: &TopologicalMap) -> String {
    // Writing to a string cannot fail.
    let mut text = String::from("<g class=\"places\">\n");
    let mut outlined: Vec<&Place> =
        map.places().iter().filter(|place| !place.outline.is_empty()).collect();
    // What lies inside a ring of corridors is drawn over it.
    outlined.sort_by(|a, b| b.area().total_cmp(&a.area()));
    for place in outlined {
        let corners: Vec<String> = place.outline.iter().map(|p| xy(p.x, p.y)).collect();
        let (fill, line) = (colour(place.kind), pixels(1.5));
        let path = corners.join("L");
        let _ = writeln!(
            text,
            "<path fill=\"{fill}\" fill-opacity=\"0.25\" stroke=\"{fill}\" stroke-width=\"{line}\" \
             d=\"M{path}z\"/>"
        );
    }
    let mut edges = String::new();
    for edge in map.edges() {
        let [a, b] = edge.between.map(|place| map.places()[place].position);
        let way = [a].into_iter().chain(edge.via.iter().copied()).chain([b]);
        let way: Vec<String> = way.map(|point| xy(point.x, point.y)).collect();
        let _ = write!(edges, "M{}", way.join("L"));
    }
    let line = pixels(2.0);
    let _ = writeln!(
        text,
        "<path fill=\"none\" stroke=\"#333\" stroke-linejoin=\"round\" stroke-width=\"{line}\" d=\"{edges}\"/>"
    );
    for place in map.places() {
        draw_place(&mut text, place);
    }
    text + "</g>\n"
}

fn draw_place(text: &mut String, place: &Place) {
    let (x, y) = (n(place.position.x), n(-place.position.y));
    let (fill, radius) =
        (colour(place.kind), if place.kind == PlaceKind::Door { 4.0 } else { 7.0 });
    let (r, line, size) = (pixels(radius), pixels(1.5), pixels(13.0));
    let name = escaped(&place.name);
    let _ = writeln!(
        text,
        "<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\" fill=\"{fill}\" stroke=\"#fff\" \
         stroke-width=\"{line}\"><title>{name}</title></circle>"
    );
    // The names of doors would only hide them.
    if place.kind != PlaceKind::Door {
        let (shift, halo) = (pixels(-11.0), pixels(3.0));
        let _ = writeln!(
            text,
            "<text x=\"{x}\" y=\"{y}\" dy=\"{shift}\" font-size=\"{size}\" text-anchor=\"middle\" \
             paint-order=\"stroke\" stroke=\"#fff\" stroke-width=\"{halo}\">{name}</text>"
        );
    }
}

fn colour(kind: PlaceKind) -> &'static str {
    match kind {
        PlaceKind::Room => "#0072b2",
        PlaceKind::Corridor => "#009e73",
        PlaceKind::Door => "#d55e00",
    }
}

/// A name as it may stand in XML: characters that XML has no room for are left out.
fn escaped(text: &str) -> String {
    let mut safe = String::new();
    for character in text.chars().filter(|c| !c.is_control()) {
        match character {
            '&' => safe += "&amp;",
            '<' => safe += "&lt;",
            '>' => safe += "&gt;",
            other => safe.push(other),
        }
    }
    safe
}
