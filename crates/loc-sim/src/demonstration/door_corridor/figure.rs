//! The belief after each step as bars.

use super::super::bars;
use super::{DoorCorridor, Step};
use crate::output::figures::FigureFile;
use loc_plot::{Chart, Figure, Role};

/// Room above the highest bar, as a share of it.
const HEADROOM: f64 = 1.15;

pub(super) fn figure(corridor: &DoorCorridor, title: &str) -> FigureFile {
    let cell = corridor.steps[0].belief.cell();
    let mut figure = Figure::new(title)
        .subtitle(format!("probability of each cell of {cell:.2} m, after each step"))
        .x_label("place in the corridor [m]");
    for step in &corridor.steps {
        figure = figure.panel(panel(corridor, step));
    }
    FigureFile {
        file: "beliefs.svg".into(),
        caption: "The belief over the places of a corridor after each step".into(),
        svg: figure.render(),
    }
}

fn panel(corridor: &DoorCorridor, step: &Step) -> Chart {
    let (config, belief) = (&corridor.config, &step.belief);
    let highest = belief.probabilities().iter().copied().fold(0.0, f64::max);
    let top = HEADROOM * highest;
    let mut chart = Chart::new(step.name.as_str()).y_range(0.0, top);
    for door in &config.doors_m {
        let half = 0.5 * config.door_width_m;
        let wall = [(door - half, 0.0, top), (door + half, 0.0, top)];
        chart = chart.band(Role::Map, "door", wall);
    }
    let heights = belief.centers().zip(belief.probabilities().iter().copied());
    let robot = [(step.truth, 0.0), (step.truth, top)];
    // The ends of the corridor, so that all panels are equally wide.
    let ends = [(0.0, 0.0), (config.length_m, 0.0)];
    bars(chart, Role::Method(0), "belief", 0.9 * belief.cell(), heights)
        .line(Role::Truth.dashed(), "robot", robot)
        .line(Role::Map, "", ends)
}
