//! `ekf` and `ukf`, smoothed.

use super::in_order;
use crate::Result;
use crate::localizer::Estimate;
use crate::localizer::driven::DrivenVelocity;
use crate::source::Setup;
use loc_core::Twist2;
use loc_filters::NonlinearFilter;
use loc_filters::landmark::{LandmarkSettings, LandmarkSmoother};
use loc_sensors::event::{Event, Measurement, Payload};
use loc_sensors::landmark_camera::LandmarkObservation;

/// What the smoother is given.
enum Input<'a> {
    Velocity(Twist2),
    LandmarkObservations(&'a [LandmarkObservation]),
}

pub(super) fn smoothed<F: NonlinearFilter<3>>(
    setup: &Setup,
    settings: LandmarkSettings,
    events: &[Event],
    stamps: &[f64],
) -> Result<Vec<Estimate>> {
    let mut inputs = Vec::new();
    // Poses of an odometry tell of velocities from the pose before on, in the order they came in.
    let mut driven = DrivenVelocity::default();
    for event in events {
        match &event.payload {
            Payload::Control(control) => {
                let velocity = driven.of(event.stamp, control);
                inputs.extend(velocity.map(|(from, twist)| (from, Input::Velocity(twist))));
            }
            Payload::Measurement(Measurement::Landmarks(observations)) => {
                inputs.push((event.stamp, Input::LandmarkObservations(observations)));
            }
            _ => {}
        }
    }
    let map = setup.landmarks.clone();
    let start = setup.start_belief;
    let mut drive = LandmarkSmoother::<F>::with_filter(map, settings, setup.start, start)?;
    for (stamp, input) in in_order(inputs, stamps) {
        // Inputs from before the start belong to the start.
        let stamp = stamp.max(setup.start);
        match input {
            Some(Input::Velocity(twist)) => drive.velocity(stamp, twist)?,
            Some(Input::LandmarkObservations(observations)) => {
                drop(drive.observations(stamp, observations)?);
            }
            None => drive.mark(stamp)?,
        }
    }
    Ok(drive.smooth()?.into_iter().map(Estimate::from).collect())
}
