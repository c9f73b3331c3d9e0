//! The figures of a run.

mod errors;
mod map;
mod particles;
mod rail;

use crate::record::Run;
use std::borrow::Cow;

/// A figure, ready to be written.
#[derive(Debug, Clone)]
pub struct FigureFile {
    /// Its file name.
    pub file: Cow<'static, str>,
    /// What it shows, for people who cannot see it.
    pub caption: Cow<'static, str>,
    /// The SVG text.
    pub svg: String,
}

impl FigureFile {
    /// A file with a caption and its SVG text.
    pub fn new(
        file: impl Into<Cow<'static, str>>,
        caption: impl Into<Cow<'static, str>>,
        svg: String,
    ) -> Self {
        FigureFile { file: file.into(), caption: caption.into(), svg }
    }
}

/// Every file name that a figure of a run can have.
pub const NAMES: [&str; 20] = [
    "map.svg",
    "clouds.svg",
    "errors.svg",
    "consistency.svg",
    "rail.svg",
    "density.svg",
    "accuracy.svg",
    "probability.svg",
    "stages.svg",
    "diversity.svg",
    "lateration.svg",
    "resampling.svg",
    "mailbox.svg",
    "beliefs.svg",
    "lines.svg",
    "fusion.svg",
    "biases.svg",
    "histogram.svg",
    "topological.svg",
    "places.svg",
];

/// The figures that suit a run.
pub fn all(run: &Run, title: &str) -> Vec<FigureFile> {
    if run.setup.rail.is_some() {
        return rail::all(run, title);
    }
    let mut figures = vec![map::map(run, title)];
    figures.extend(map::lines(run));
    figures.extend(particles::clouds(run));
    figures.extend(particles::resampling(run));
    figures.extend(errors::fusion(run));
    figures.extend(particles::histogram(run));
    if run.truth.is_empty() {
        return figures;
    }
    figures.push(errors::errors(run));
    figures.extend(errors::consistency(run));
    figures
}

/// Every k-th of `count` things, so that about `wanted` are left; 1 or more.
fn every(count: usize, wanted: usize) -> usize {
    count.div_ceil(wanted.max(1)).max(1)
}
