//! Which part of the map the filter works on, where it does not work on all of it.

use super::look::Place;
use super::pairs::Bound;
use super::{EkfSlam, Identities};
use crate::Result;
use loc_sensors::landmark_camera::LandmarkObservation;
use nalgebra::Point2;

/// The landmarks in hand: those around the place where they were taken.
#[derive(Debug, Clone, Copy)]
pub(super) struct Focus {
    center: Point2<f64>,
    radius: f64,
    /// The largest variance of a landmark outside \[m^2\]; corrections only make it smaller.
    outside_variance: f64,
}

impl EkfSlam {
    /// Makes sure that the observations can only be of landmarks in hand.
    pub(super) fn refocus(&mut self, observations: &[LandmarkObservation]) -> Result<()> {
        let Some(radius) = self.settings.submap_radius else { return Ok(()) };
        let numbered = self.settings.identities == Identities::Known;
        let known = |seen: &LandmarkObservation| self.numbers.get(&seen.landmark).copied();
        let named: Vec<usize> =
            if numbered { observations.iter().filter_map(known).collect() } else { Vec::new() };
        let places = if numbered { &[] } else { observations };
        let places: Vec<Place> = places.iter().filter_map(|seen| self.place(seen)).collect();
        let center = Point2::from(self.state.robot().xy());
        if let Some(focus) = &self.focus {
            let near = nalgebra::distance(&center, &focus.center) <= 0.5 * focus.radius;
            let in_hand = named.iter().all(|&landmark| self.state.is_in_hand(landmark));
            if near && in_hand && self.reach_from(&focus.center, &places, focus) <= focus.radius {
                return Ok(());
            }
        }
        self.state.settle()?;
        self.take_around(center, radius, &named, &places)
    }

    /// Takes the landmarks around a place in hand, and those that are named.
    fn take_around(
        &mut self,
        center: Point2<f64>,
        radius: f64,
        named: &[usize],
        places: &[Place],
    ) -> Result<()> {
        let variance = |landmark: usize| self.state.block(landmark, landmark).trace();
        let widest = (0..self.entries.len()).map(variance).fold(0.0, f64::max);
        let mut focus = Focus { center, radius, outside_variance: widest };
        // Wide enough to be left only after a while.
        focus.radius = radius.max(2.0 * self.reach_from(&center, places, &focus));
        let near = |landmark: &usize| {
            let position = self.state.position(*landmark);
            nalgebra::distance(&center, &position) <= focus.radius || named.contains(landmark)
        };
        let members: Vec<usize> = (0..self.entries.len()).filter(near).collect();
        self.state.take(members)?;
        self.focus = Some(focus);
        Ok(())
    }

    /// How far from the centre a landmark outside may be that one of the places fits, or that may
    /// be the same as one seen lately \[m\].
    fn reach_from(&self, center: &Point2<f64>, places: &[Place], focus: &Focus) -> f64 {
        let farthest = |place: &Place| {
            let bound = Bound::new(self, place).distance(focus.outside_variance);
            nalgebra::distance(center, &place.position) + bound
        };
        let of_observations = places.iter().map(farthest).fold(0.0, f64::max);
        if self.settings.identities == Identities::Known {
            return of_observations;
        }
        let farthest = |recent: usize| {
            let position = self.state.position(recent);
            let variance = self.state.block(recent, recent).trace();
            let bound = self.twin_distance(variance + focus.outside_variance);
            nalgebra::distance(center, &position) + bound
        };
        self.recent().into_iter().map(farthest).fold(of_observations, f64::max)
    }
}
