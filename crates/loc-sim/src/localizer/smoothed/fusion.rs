//! `fusion` and `fusion-ukf`, smoothed.

use super::in_order;
use crate::Result;
use crate::localizer::driven::DrivenVelocity;
use crate::localizer::fusion::{localizer, take};
use crate::localizer::{Estimate, MethodSettings};
use crate::source::Setup;
use loc_core::Twist2;
use loc_filters::NonlinearFilter;
use loc_filters::fusion::state::STATES;
use loc_filters::smoother::Recorded;
use loc_sensors::event::{Event, Measurement, Payload};

/// What the smoother is given.
enum Input<'a> {
    Velocity(Twist2),
    /// With its own stamp.
    Measurement(f64, &'a Measurement),
}

pub(super) fn smoothed<F: NonlinearFilter<STATES>>(
    method: &str,
    setup: &Setup,
    settings: &MethodSettings,
    events: &[Event],
    stamps: &[f64],
) -> Result<Vec<Estimate>> {
    let settings = settings.fusion();
    let period = 1.0 / settings.imu.rate;
    let mut inputs = Vec::new();
    let mut driven = DrivenVelocity::default();
    for event in events {
        match &event.payload {
            Payload::Control(control) => {
                let velocity = driven.of(event.stamp, control);
                inputs.extend(velocity.map(|(from, twist)| (from, Input::Velocity(twist))));
            }
            Payload::Measurement(measurement) => {
                // A sample of the inertial unit is put where its period begins.
                let inertial = matches!(measurement, Measurement::Inertial(_));
                let from = event.stamp - if inertial { period } else { 0.0 };
                inputs.push((from, Input::Measurement(event.stamp, measurement)));
            }
            _ => {}
        }
    }
    let mut drive = localizer::<Recorded<F, STATES>>(method, setup, settings)?;
    for (stamp, input) in in_order(inputs, stamps) {
        match input {
            Some(Input::Velocity(twist)) => drop(drive.odometry(stamp, twist)?),
            Some(Input::Measurement(stamp, measurement)) => {
                drop(take(&mut drive, stamp, measurement)?);
            }
            None => drive.mark(stamp)?,
        }
    }
    Ok(drive.smooth()?.into_iter().map(|belief| belief.about_pose().into()).collect())
}
