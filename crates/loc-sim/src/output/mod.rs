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

pub mod figures;
mod folder;
pub mod mcap;
mod report;
mod scene;
mod table;

pub use folder::{Folder, Illustration};
pub(crate) use report::plain;
pub use report::{Made, Report};
pub(crate) use scene::Canvas;
pub use scene::backdrop;
pub use table::{comparison, final_beliefs, table};

use crate::Result;
use crate::metrics::Summary;
use crate::record::{MethodRecord, Run};
use loc_core::Trajectory;
use std::fmt::Write;

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
    add_trajectories(&mut folder, run)?;
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

/// Truth and estimates as TUM files, covariances as CSV.
fn add_trajectories(folder: &mut Folder, run: &Run) -> Result<()> {
    let mut truth = Trajectory::new();
    for pose in &run.truth {
        truth.push(pose.stamp, pose.value.pose)?;
    }
    if !truth.is_empty() {
        folder.add("truth.tum", truth.to_tum());
    }
    for record in &run.methods {
        let name = record.name();
        let mut estimate = Trajectory::new();
        for (stamp, given) in run.stamps.iter().zip(&record.estimates) {
            estimate.push(*stamp, given.pose)?;
        }
        folder.add(format!("estimate_{name}.tum"), estimate.to_tum());
        if let Some(csv) = covariances(run, record) {
            folder.add(format!("covariance_{name}.csv"), csv);
        }
    }
    Ok(())
}

/// `None` for a method that has no covariances.
fn covariances(run: &Run, record: &MethodRecord) -> Option<String> {
    let mut csv = String::from("t,xx,xy,xtheta,yy,ytheta,thetatheta\n");
    let mut any = false;
    for (stamp, estimate) in run.stamps.iter().zip(&record.estimates) {
        let Some(s) = estimate.covariance else { continue };
        any = true;
        // Writing to a String cannot fail.
        let _ =
            writeln!(csv, "{},{},{},{},{},{},{}", stamp, s.m11, s.m12, s.m13, s.m22, s.m23, s.m33);
    }
    any.then_some(csv)
}
