//! Studies: grids, their journal, their results, and the command.

#[cfg(feature = "cli")]
mod command;
mod grid;
#[cfg(feature = "cli")]
mod interruption;
mod journal;
mod parquet;
mod results;

use loc_sim::localizer::Method;
use loc_sim::study::{Axis, Study, StudyOptions, StudySource};

/// A study of `landmark-drive`, shortened to its first leg.
fn drive(runs: u64, vary: &[&str], methods: &[Method]) -> Study {
    let vary: Vec<Axis> = vary.iter().map(|text| text.parse().unwrap()).collect();
    let course = "drive.course=[{duration_s=6.0,v_m_s=0.5,omega_deg_s=10.0}]".to_owned();
    let source = StudySource::named("landmark-drive", &[course]).unwrap();
    let methods = methods.to_vec();
    Study::new(source, StudyOptions { runs, vary, methods, ..Default::default() }).unwrap()
}
