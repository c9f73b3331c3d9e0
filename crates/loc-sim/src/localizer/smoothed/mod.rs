//! Kalman filters after the run: estimates that know what came later too.
//!
//! A smoother is no [`Localizer`](super::Localizer): it sees the whole stream of events at once, in
//! the order of their stamps, so that late ones are not late. A Kalman method joins in with one
//! function here that makes its estimates at given times from all events.

mod fusion;
mod landmarks;
mod lines;
mod rail;

use super::{Estimate, Method, MethodSettings};
use crate::source::Setup;
use crate::{Error, Result};
use loc_filters::{ExtendedKalmanFilter as Extended, UnscentedKalmanFilter as Unscented};
use loc_sensors::event::{Event, Payload};

/// The smoothed estimates of a method at `stamps` \[s\], which are in order of time.
///
/// # Errors
/// [`Error::Unsuitable`] for a method that [cannot be smoothed](Method::can_smooth), and what the
/// filter refuses.
pub(crate) fn smoothed(
    method: Method,
    setup: &Setup,
    settings: &MethodSettings,
    events: &[Event],
    stamps: &[f64],
) -> Result<Vec<Estimate>> {
    let name = method.name();
    match method {
        Method::Kf => rail::smoothed(setup, &settings.rail, events, stamps),
        Method::Ekf => landmarks::smoothed::<Extended<3>>(setup, settings.landmark, events, stamps),
        Method::Ukf => {
            landmarks::smoothed::<Unscented<3>>(setup, settings.landmark, events, stamps)
        }
        Method::LineEkf => lines::smoothed::<Extended<_>>(name, setup, settings, events, stamps),
        Method::LineUkf => lines::smoothed::<Unscented<_>>(name, setup, settings, events, stamps),
        Method::Fusion => fusion::smoothed::<Extended<_>>(name, setup, settings, events, stamps),
        Method::FusionUkf => {
            fusion::smoothed::<Unscented<_>>(name, setup, settings, events, stamps)
        }
        _ => Err(Error::Unsuitable {
            method: name.into(),
            expected: "beliefs of a Kalman filter to smooth",
            source_name: setup.name.clone(),
        }),
    }
}

/// Inputs of a filter with the times whose estimates are wanted, in order of time; what is wanted
/// comes after the inputs of its time.
fn in_order<I>(inputs: Vec<(f64, I)>, stamps: &[f64]) -> Vec<(f64, Option<I>)> {
    let wanted = stamps.iter().map(|&stamp| (stamp, None));
    let mut all: Vec<_> = inputs.into_iter().map(|(stamp, input)| (stamp, Some(input))).collect();
    all.extend(wanted);
    // The sort is stable: inputs of one time keep the order in which they came.
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all
}

/// Whether a smoother has a use for an event.
pub(crate) fn is_input(event: &Event) -> bool {
    !matches!(event.payload, Payload::Truth(_))
}
