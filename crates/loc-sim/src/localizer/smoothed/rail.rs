//! `kf`, smoothed.

use super::in_order;
use crate::localizer::rail::{estimate, motion, sensor};
use crate::localizer::{Estimate, RailSettings};
use crate::source::Setup;
use crate::{Error, Result};
use loc_filters::smoother::Recorded;
use loc_filters::{Gate, KalmanFilter};
use loc_sensors::event::{Control, Event, Measurement, Payload};
use nalgebra::Vector1;

/// What the smoother is given.
enum Input {
    Acceleration(f64),
    Position { sensor: usize, position: f64 },
}

pub(super) fn smoothed(
    setup: &Setup,
    settings: &RailSettings,
    events: &[Event],
    stamps: &[f64],
) -> Result<Vec<Estimate>> {
    let Some(start) = setup.rail else {
        return Err(Error::Unsuitable {
            method: "kf".into(),
            expected: "a vehicle on a rail",
            source_name: setup.name.clone(),
        });
    };
    let inputs = events.iter().filter_map(|event| {
        let input = match event.payload {
            Payload::Control(Control::Acceleration(a)) => Input::Acceleration(a),
            Payload::Measurement(Measurement::RailPosition { sensor, position }) => {
                Input::Position { sensor, position }
            }
            _ => return None,
        };
        Some((event.stamp, input))
    });
    let mut filter = Recorded::new(KalmanFilter::new(start)?);
    let (mut now, mut acceleration, mut marks) = (setup.start, 0.0, Vec::new());
    for (stamp, input) in in_order(inputs.collect(), stamps) {
        if stamp > now {
            filter.predict(&motion(settings, stamp - now)?, &Vector1::new(acceleration))?;
            now = stamp;
        }
        match input {
            Some(Input::Acceleration(commanded)) => acceleration = commanded,
            Some(Input::Position { sensor: index, position }) => {
                let sensor = sensor(settings, index)?;
                filter.correct(&sensor, &Vector1::new(position), &Gate::OPEN)?;
            }
            None => marks.push(filter.past().len() - 1),
        }
    }
    let beliefs = filter.past().smooth()?;
    Ok(marks.into_iter().filter_map(|moment| beliefs.get(moment).copied().map(estimate)).collect())
}
