//! The five stages as stems: a line for each particle, as high as its weight.

use super::{Mcl1d, Stage};
use crate::output::figures::FigureFile;
use loc_plot::{Chart, Figure, Role};

/// Half the width of a door \[m\].
const HALF_DOOR: f64 = 0.5;

/// Room above the highest stem, as a share of it.
const HEADROOM: f64 = 1.15;

pub(super) fn figure(demonstration: &Mcl1d, title: &str) -> FigureFile {
    let particles = demonstration.config.particles;
    let mut figure = Figure::new(title)
        .subtitle(format!(
            "{particles} particles, each a line as high as its weight; 1 is an equal share"
        ))
        .x_label("place in the corridor [m]");
    for stage in &demonstration.stages {
        figure = figure.panel(panel(demonstration, stage));
    }
    FigureFile {
        file: "stages.svg".into(),
        caption: "Particles with their weights in a corridor with doors, in five stages".into(),
        svg: figure.render(),
    }
}

/// Weights are drawn as multiples of an equal share.
fn panel(demonstration: &Mcl1d, stage: &Stage) -> Chart {
    let config = &demonstration.config;
    let equal = 1.0 / config.particles as f64;
    let highest = stage.particles.iter().map(|(_, weight)| weight / equal).fold(0.0, f64::max);
    let top = HEADROOM * highest;
    let mut chart = Chart::new(stage.name).y_range(0.0, top);
    for door in &config.doors_m {
        let wall = [(door - HALF_DOOR, 0.0, top), (door + HALF_DOOR, 0.0, top)];
        chart = chart.band(Role::Map, "door", wall);
    }
    let stems = stage
        .particles
        .iter()
        .flat_map(|&(place, weight)| [(place, 0.0), (place, weight / equal), (f64::NAN, f64::NAN)]);
    chart = chart.line(Role::Method(0).width(0.7), "particle", stems);
    if stage.weighed {
        // Right before a door the report is as likely as it can be.
        let most = config.doors_m.iter().map(|&door| config.likelihood(door)).fold(0.0, f64::max);
        let scale = highest / most;
        let curve = (0..=400).map(|k| config.length_m * f64::from(k) / 400.0);
        let curve = curve.map(|place| (place, scale * config.likelihood(place)));
        chart = chart.line(Role::Method(1), "likelihood of seeing a door (its own scale)", curve);
    }
    let robot = [(stage.truth, 0.0), (stage.truth, top)];
    // The ends of the corridor, so that all panels are equally wide.
    let ends = [(0.0, 0.0), (config.length_m, 0.0)];
    chart.line(Role::Truth.dashed(), "robot", robot).line(Role::Map, "", ends)
}
