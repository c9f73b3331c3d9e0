//! A source whose events are corrected by the calibration of its sensors.

use super::{ArrivalQueue, Setup, Source};
use crate::Result;
use loc_sensors::event::{Control, Event, Measurement, Payload};
use loc_sensors::landmark_camera::CameraCalibration;
use loc_sensors::wheel::OdometryCalibration;

/// Corrects the systematic errors of odometry and camera in a source's events.
///
/// Every method then gets the same corrected events, and needs no calibration of its own. An
/// event that is delayed to the time at which it took effect is known from that time on.
#[derive(Debug)]
pub struct Calibrated<S> {
    source: S,
    odometry: OdometryCalibration,
    camera: CameraCalibration,
    queue: ArrivalQueue,
    ended: bool,
}

impl<S: Source> Calibrated<S> {
    /// A source with its calibration.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a calibration that is not valid.
    pub fn new(
        source: S,
        odometry: OdometryCalibration,
        camera: CameraCalibration,
    ) -> Result<Self> {
        odometry.check()?;
        camera.check()?;
        Ok(Calibrated { source, odometry, camera, queue: ArrivalQueue::default(), ended: false })
    }

    fn correct(&self, mut event: Event) -> Event {
        match &mut event.payload {
            Payload::Control(Control::Velocity(twist)) => {
                *twist = self.odometry.correct(*twist);
                event.stamp += self.odometry.delay;
            }
            Payload::Measurement(Measurement::Landmarks(observations)) => {
                for observation in observations {
                    observation.observed = self.camera.correct(observation.observed);
                }
                event.stamp -= self.camera.delay;
            }
            _ => {}
        }
        event.arrival = event.arrival.max(event.stamp);
        event
    }
}

impl<S: Source> Source for Calibrated<S> {
    fn setup(&self) -> &Setup {
        self.source.setup()
    }

    fn next_event(&mut self) -> Result<Option<Event>> {
        while !self.ended {
            let Some(event) = self.source.next_event()? else {
                self.ended = true;
                break;
            };
            let known_until = event.arrival;
            let event = self.correct(event);
            self.queue.push(event);
            if let Some(first) = self.queue.pop(known_until) {
                return Ok(Some(first));
            }
        }
        Ok(self.queue.pop(f64::INFINITY))
    }

    fn notes(&self) -> Vec<String> {
        self.source.notes()
    }

    fn truth_has_heading(&self) -> bool {
        self.source.truth_has_heading()
    }

    fn has_truth(&self) -> bool {
        self.source.has_truth()
    }
}
