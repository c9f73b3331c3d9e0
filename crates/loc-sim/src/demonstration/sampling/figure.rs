//! Histograms of the draws under their densities, and the pairs.

use super::super::bars;
use super::{Drawn, Sampling};
use crate::output::figures::FigureFile;
use loc_plot::{Chart, Figure, Role};

/// Bars over +-4 standard deviations.
const BARS: usize = 48;
const REACH: f64 = 4.0;

/// Pairs that are drawn.
const MAX_PAIRS: usize = 1500;

pub(super) fn figures(sampling: &Sampling, title: &str) -> Vec<FigureFile> {
    let sigma = sampling.config.sigma;
    let mut figure = Figure::new(title)
        .subtitle(format!(
            "{} draws of each kind; bars counted, lines as they should be",
            sampling.config.draws
        ))
        .x_label("x");
    for kind in &sampling.kinds {
        figure = figure.panel(histogram(kind, sigma));
    }
    let pairs = sampling.pairs.iter().take(MAX_PAIRS).copied();
    let given = sampling.config.correlation;
    let chart = Chart::new("y").points(Role::Method(0).width(2.5), "", pairs);
    let pairs = Figure::new("Two random numbers that share a part")
        .subtitle(format!(
            "Correlation {:.3} in the sample, {given} in the draw",
            sampling.correlation()
        ))
        .x_label("x")
        .panel(chart);
    vec![
        FigureFile {
            file: "sampling.svg".into(),
            caption: "Histograms of four ways to draw, under the densities they should have".into(),
            svg: figure.render(),
        },
        FigureFile {
            file: "correlation.svg".into(),
            caption: "Pairs of correlated draws".into(),
            svg: pairs.render(),
        },
    ]
}

fn histogram(kind: &Drawn, sigma: f64) -> Chart {
    let width = 2.0 * REACH * sigma / BARS as f64;
    let middle = |bar: usize| (bar as f64 + 0.5) * width - REACH * sigma;
    let mut counts = [0_u32; BARS];
    for value in &kind.values {
        let place = ((value + REACH * sigma) / width).floor();
        if (0.0..BARS as f64).contains(&place) {
            counts[place as usize] += 1;
        }
    }
    let scale = 1.0 / (width * kind.values.len() as f64);
    let counted = (0..BARS).map(|bar| (middle(bar), f64::from(counts[bar]) * scale));
    let chart =
        bars(Chart::new(format!("density, {}", kind.name)), Role::Method(0), "", width, counted);
    let points = (0..=400).map(|k| (f64::from(k) / 200.0 - 1.0) * REACH * sigma);
    let density = kind.density;
    chart.line(Role::Truth, "", points.map(|x| (x, density(x, sigma))))
}
