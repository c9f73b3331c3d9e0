//! What a run leaves behind for people and programs to look at.
//!
//! ```text
//! summary.json               the figures
//! truth.tum                  the truth at 10 Hz
//! estimate_<method>.tum      the estimates at the same stamps
//! covariance_<method>.csv    t and the upper triangle of the covariance over (x, y, theta)
//! *.svg                      the figures to look at
//! report.html                all of it on one page
//! ```

mod backdrop;
pub(crate) mod canvas;
mod comparison;
pub mod figures;
mod folder;
mod illustration;
pub mod mcap;
pub mod perceptual;
pub(crate) mod png;
pub(crate) mod ramp;
mod report;
pub mod svg;
mod table;
mod trajectories;

pub use backdrop::backdrop;
pub use comparison::comparison;
pub use folder::Folder;
pub use illustration::Illustration;
pub(crate) use report::plain;
pub use report::{Made, Report};
pub use table::{final_beliefs, table};

use crate::Result;
use crate::metrics::Summary;
use crate::record::Run;

/// All files of a run, ready to be written.
///
/// # Errors
/// [`loc_core::Error`] for estimates that are not finite.
pub fn files<'a>(
    run: &Run,
    summary: &Summary,
    title: &str,
    made: impl Into<Made<'a>>,
) -> Result<Folder> {
    let made = made.into();
    let mut folder = Folder::default();
    folder.add("summary.json", pretty(summary)?);
    trajectories::add(&mut folder, run)?;
    let figures = figures::all(run, title);
    let report = Report { run, summary, title, made };
    folder.add("report.html", report.html(&figures));
    for figure in figures {
        folder.add(figure.file, figure.svg);
    }
    Ok(folder)
}

/// JSON as a file.
fn pretty(value: &impl serde::Serialize) -> Result<String> {
    let json = serde_json::to_string_pretty(value).map_err(|error| crate::Error::Config {
        file: "summary.json".into(),
        message: error.to_string(),
    })?;
    Ok(json + "\n")
}
