//! Places in the colour of their probability, and how sure the robot is of the right one.

use super::{Look, TopologicalTour, place_of};
use crate::output::Canvas;
use crate::output::figures::FigureFile;
use loc_plot::color::LIKELIHOOD;
use loc_plot::{Chart, Figure, Frames, Role, Scene, color};

/// How many looks are shown.
const FRAMES: usize = 9;
/// Radius of the ring around the robot, as a share of the map's larger side.
const RING: f64 = 0.03;

/// Which of so many looks are shown: the first ones densely, the last one too.
pub(super) fn choose(count: usize) -> impl Iterator<Item = usize> {
    let last = count.saturating_sub(1);
    let wanted = (0..FRAMES).map(move |k| {
        let share = k as f64 / (FRAMES - 1) as f64;
        ((last as f64 * share * share).round() as usize).max(k).min(last)
    });
    let mut shown: Vec<usize> = wanted.collect();
    shown.dedup();
    shown.into_iter()
}

pub(super) fn figures(tour: &TopologicalTour, title: &str) -> Vec<FigureFile> {
    beliefs(tour, title).into_iter().chain([over_the_way(tour)]).collect()
}

fn beliefs(tour: &TopologicalTour, title: &str) -> Option<FigureFile> {
    let canvas = Canvas::new(&tour.grid)?;
    let places: Vec<usize> = canvas.places().map(|point| place_of(&tour.map, &point)).collect();
    let ways = tour.map.edges().iter().flat_map(|edge| {
        let [from, to] = edge.between.map(|place| tour.map.places()[place].position);
        let points: Vec<_> =
            [from].into_iter().chain(edge.via.iter().copied()).chain([to]).collect();
        let pair =
            |pair: &[nalgebra::Point2<f64>]| ((pair[0].x, pair[0].y), (pair[1].x, pair[1].y));
        points.windows(2).map(pair).collect::<Vec<_>>()
    });
    let ways: Vec<_> = ways.collect();
    let mut frames = Frames::new(title)
        .subtitle("each place in the colour of its probability")
        .bar(color::bar(&LIKELIHOOD, 0.0, 1.0, "probability of a place"));
    for look in choose(tour.looks.len()).map(|k| &tour.looks[k]) {
        let image = canvas
            .paint(&tour.grid, |pixel, _| color::along(&LIKELIHOOD, look.belief[places[pixel]]));
        let scene = Scene::new("")
            .backdrop(image)
            .segments(Role::Map.width(0.8), "ways of the map", ways.iter().copied())
            .ring("robot", RING * canvas.larger_side(), look.truth);
        frames = frames.frame(caption(tour, look), scene);
    }
    Some(FigureFile {
        file: "topological.svg".into(),
        caption: "The probability of each room, corridor and door, along a tour".into(),
        svg: frames.render(),
    })
}

fn caption(tour: &TopologicalTour, look: &Look) -> String {
    let best = look.most_likely();
    let name = &tour.map.places()[best].name;
    format!("{:.1} m: {name}, {:.0} %", look.way, 100.0 * look.belief[best])
}

fn over_the_way(tour: &TopologicalTour) -> FigureFile {
    let looks = || tour.looks.iter();
    let of_truth = looks().map(|look| (look.way, look.belief[look.place]));
    let nearby = looks().map(|look| {
        let next = tour.map.neighbours(look.place).iter().map(|(next, _)| look.belief[*next]);
        (look.way, look.belief[look.place] + next.sum::<f64>())
    });
    let chart = Chart::new("probability")
        .y_range(0.0, 1.05)
        .line(Role::Method(1), "the right place or one next to it", nearby)
        .line(Role::Method(0), "the right place", of_truth);
    let svg = Figure::new("How sure the robot is of the right place")
        .x_label("way [m]")
        .panel(chart)
        .render();
    FigureFile {
        file: "places.svg".into(),
        caption: "Probability of the right place along the tour".into(),
        svg,
    }
}
