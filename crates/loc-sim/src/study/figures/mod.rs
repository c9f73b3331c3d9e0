//! The figures of a study: how the methods fare over the values of each setting that is varied;
//! without any, over the runs and over time.

mod by_setting;
mod lines;
mod single;

use super::{Results, Study};

/// A figure, ready to be written.
pub(super) struct StudyFigure {
    pub(super) file: String,
    pub(super) caption: &'static str,
    pub(super) svg: String,
}

/// The figures that suit a study.
pub(super) fn all(study: &Study, results: &Results) -> Vec<StudyFigure> {
    let axes = study.grid().axes();
    if results.groups.len() <= study.records().len() {
        return single::all(results);
    }
    let varied = (0..axes.len()).filter(|&k| axes[k].values().len() > 1);
    varied.flat_map(|k| by_setting::all(study, results, k)).collect()
}
