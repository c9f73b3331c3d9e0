//! `line-ekf` and `line-ukf`, smoothed.

use super::in_order;
use crate::Result;
use crate::localizer::line_ekf::filter;
use crate::localizer::{Estimate, MethodSettings};
use crate::source::Setup;
use loc_core::Pose2;
use loc_filters::NonlinearFilter;
use loc_filters::line_matching::STATES;
use loc_filters::smoother::Recorded;
use loc_sensors::event::{Control, Event, Measurement, Payload};
use loc_sensors::laser::LaserScan;

/// What the smoother is given.
enum Input<'a> {
    Odometry(Pose2),
    Scan(&'a LaserScan, Pose2),
}

pub(super) fn smoothed<F: NonlinearFilter<STATES>>(
    method: &str,
    setup: &Setup,
    settings: &MethodSettings,
    events: &[Event],
    stamps: &[f64],
) -> Result<Vec<Estimate>> {
    let inputs = events.iter().filter_map(|event| {
        let input = match &event.payload {
            Payload::Control(Control::Odometry(pose)) => Input::Odometry(*pose),
            Payload::Measurement(Measurement::Scan { scan, mounting }) => {
                Input::Scan(scan, *mounting)
            }
            _ => return None,
        };
        Some((event.stamp, input))
    });
    let mut drive = filter::<Recorded<F, STATES>>(method, setup, settings)?;
    for (_, input) in in_order(inputs.collect(), stamps) {
        match input {
            Some(Input::Odometry(pose)) => drive.odometry(pose)?,
            Some(Input::Scan(scan, mounting)) => drop(drive.scan(scan, mounting)?),
            None => drive.mark(),
        }
    }
    Ok(drive.smooth()?.into_iter().map(Estimate::from).collect())
}
