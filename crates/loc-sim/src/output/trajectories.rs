//! Truth and estimates as TUM files, covariances as CSV.

use super::Folder;
use crate::Result;
use crate::record::{MethodRecord, Run};
use loc_core::Trajectory;
use std::fmt::Write;

pub(super) fn add(folder: &mut Folder, run: &Run) -> Result<()> {
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
