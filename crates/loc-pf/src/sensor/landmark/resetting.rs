//! Sensor resetting: poses drawn from the last observations.
//!
//! A kidnapped robot is relocalized faster if new particles start where the observations put it,
//! not anywhere. Two landmarks by distance and direction fix a pose; one leaves a ring around the
//! landmark; directions alone leave the position open and fix the heading (Lenser and Veloso 2000).

use super::{LandmarkLikelihood, ObservationModel, Placed};
use loc_core::{Pose2, angle};
use loc_maps::Bounds;
use loc_sensors::landmark_camera::Observed;
use nalgebra::{Point2, Vector2};
use rand::{Rng, RngExt};
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::{PI, TAU};

/// Number of times a pose outside the region is drawn again.
const TRIES: usize = 20;

/// Draws poses from the observations of one moment.
///
/// Each draw uses one observation, or two, and adds `spread` times their noise, so that such poses
/// are wider than the likelihood of the observations and may be weighted by them.
#[derive(Debug, Clone)]
pub struct SensorResetting<'a> {
    likelihood: &'a LandmarkLikelihood,
    region: Bounds,
    spread: f64,
}

impl<'a> SensorResetting<'a> {
    /// Draws from observations, within a region of the map.
    pub fn new(likelihood: &'a LandmarkLikelihood, region: Bounds) -> Self {
        SensorResetting { likelihood, region, spread: 2.0 }
    }

    /// The same with another spread, in standard deviations of the observations.
    #[must_use]
    pub fn with_spread(self, spread: f64) -> Self {
        SensorResetting { spread, ..self }
    }

    /// A pose that fits some of the observations. Without any it is a pose anywhere in the region.
    pub fn draw<R: Rng + ?Sized>(&self, rng: &mut R) -> Pose2 {
        for _ in 0..TRIES {
            let inside = |pose: &Pose2| self.region.contains(&pose.position());
            if let Some(pose) = self.fit(rng).filter(inside) {
                return pose;
            }
        }
        anywhere(&self.region, rng)
    }

    fn fit<R: Rng + ?Sized>(&self, rng: &mut R) -> Option<Pose2> {
        let (first, second) = pick(self.likelihood.placed(), rng);
        let (first, second) = (self.blurred(first?, rng), second.map(|it| self.blurred(it, rng)));
        let camera = match (first.observed, second) {
            (Observed::RangeBearing { .. }, Some(second)) => two(&first, &second, rng),
            (Observed::Range { .. }, Some(second)) => two(&first, &second, rng),
            (Observed::RangeBearing { range, bearing }, None) => {
                Some(on_ring(first.landmark, range, Some(bearing), rng))
            }
            (Observed::Range { range }, None) => Some(on_ring(first.landmark, range, None, rng)),
            (Observed::Bearing { bearing }, _) => {
                let place = anywhere(&self.region, rng).position();
                let way = first.landmark - place;
                Some(Pose2::new(place.x, place.y, way.y.atan2(way.x) - bearing))
            }
        };
        Some(camera? * self.likelihood.model().mounting.inverse())
    }

    /// An observation with additional noise.
    fn blurred<R: Rng + ?Sized>(&self, placed: &Placed, rng: &mut R) -> Blurred {
        let ObservationModel { noise, .. } = self.likelihood.model();
        let observed = placed.observation.observed;
        let mut draw = |sigma: f64| -> f64 {
            let unit: f64 = StandardNormal.sample(rng);
            self.spread * sigma * unit
        };
        let range = observed.range().map(|r| (r + draw(noise.range_sigma_at(r))).max(0.0));
        let bearing = observed.bearing().map(|bearing| bearing + draw(noise.bearing_sigma));
        let observed = match (range, bearing) {
            (Some(range), Some(bearing)) => Observed::RangeBearing { range, bearing },
            (Some(range), None) => Observed::Range { range },
            (None, bearing) => Observed::Bearing { bearing: bearing.unwrap_or(0.0) },
        };
        Blurred { landmark: placed.landmark, observed }
    }
}

struct Blurred {
    landmark: Point2<f64>,
    observed: Observed,
}

/// Two observations of different landmarks at random, or the only one. One with a distance comes
/// first, and alone where the other has none.
fn pick<'p, R: Rng + ?Sized>(
    placed: &'p [Placed],
    rng: &mut R,
) -> (Option<&'p Placed>, Option<&'p Placed>) {
    if placed.is_empty() {
        return (None, None);
    }
    let first = &placed[rng.random_range(0..placed.len())];
    let differs = |other: &&Placed| other.landmark != first.landmark;
    let others = placed.iter().filter(differs).count();
    if others == 0 {
        return (Some(first), None);
    }
    let second = placed.iter().filter(differs).nth(rng.random_range(0..others));
    let has_range = |placed: &Placed| placed.observation.observed.range().is_some();
    match (has_range(first), second) {
        (false, Some(second)) if has_range(second) => (Some(second), Some(first)),
        _ => (Some(first), second),
    }
}

/// A camera's pose from two observations, the first with a distance.
fn two<R: Rng + ?Sized>(first: &Blurred, second: &Blurred, rng: &mut R) -> Option<Pose2> {
    let range = first.observed.range()?;
    match (first.observed.bearing(), second.observed.range(), second.observed.bearing()) {
        (Some(bearing), Some(other_range), Some(other_bearing)) => {
            let seen = [(range, bearing), (other_range, other_bearing)];
            Some(fixed([first.landmark, second.landmark], seen))
        }
        (bearing, Some(other_range), other_bearing) => {
            let place = on_both(first.landmark, range, second.landmark, other_range, rng);
            let heading = match (bearing, other_bearing) {
                (Some(bearing), _) => towards(place, first.landmark) - bearing,
                (None, Some(bearing)) => towards(place, second.landmark) - bearing,
                (None, None) => PI * (2.0 * rng.random::<f64>() - 1.0),
            };
            Some(Pose2::new(place.x, place.y, heading))
        }
        (Some(bearing), None, _) => Some(on_ring(first.landmark, range, Some(bearing), rng)),
        (None, None, other) => {
            let place = on_ring(first.landmark, range, None, rng).position();
            let heading = towards(place, second.landmark) - other?;
            Some(Pose2::new(place.x, place.y, heading))
        }
    }
}

/// The pose from which two landmarks are observed: their line gives the heading, their middle the
/// position.
fn fixed(landmarks: [Point2<f64>; 2], seen: [(f64, f64); 2]) -> Pose2 {
    let in_camera = seen.map(|(range, bearing)| {
        let (sin, cos) = bearing.sin_cos();
        Vector2::new(range * cos, range * sin)
    });
    let (line, seen_line) = (landmarks[1] - landmarks[0], in_camera[1] - in_camera[0]);
    let heading = angle::wrap(line.y.atan2(line.x) - seen_line.y.atan2(seen_line.x));
    let middle = nalgebra::center(&landmarks[0], &landmarks[1]);
    let seen_middle = 0.5 * (in_camera[0] + in_camera[1]);
    let (sin, cos) = heading.sin_cos();
    let turned_x = cos * seen_middle.x - sin * seen_middle.y;
    let turned_y = sin * seen_middle.x + cos * seen_middle.y;
    Pose2::new(middle.x - turned_x, middle.y - turned_y, heading)
}

/// A pose on the ring around a landmark; its heading is uniform where no direction was measured.
fn on_ring<R: Rng + ?Sized>(
    landmark: Point2<f64>,
    range: f64,
    bearing: Option<f64>,
    rng: &mut R,
) -> Pose2 {
    let direction = TAU * rng.random::<f64>();
    let (sin, cos) = direction.sin_cos();
    let bearing = bearing.unwrap_or_else(|| TAU * rng.random::<f64>());
    // The landmark lies the opposite way.
    let heading = direction + PI - bearing;
    Pose2::new(landmark.x + range * cos, landmark.y + range * sin, heading)
}

/// One of the two intersections of circles; where they do not intersect, the point between them.
fn on_both<R: Rng + ?Sized>(
    a: Point2<f64>,
    range_a: f64,
    b: Point2<f64>,
    range_b: f64,
    rng: &mut R,
) -> Point2<f64> {
    let line = b - a;
    let distance = line.norm();
    let along = 0.5 * (distance + (range_a * range_a - range_b * range_b) / distance);
    let across = (range_a * range_a - along * along).max(0.0).sqrt();
    let side = if rng.random::<bool>() { across } else { -across };
    let unit = line / distance;
    a + along * unit + side * Vector2::new(-unit.y, unit.x)
}

fn towards(from: Point2<f64>, to: Point2<f64>) -> f64 {
    let way = to - from;
    way.y.atan2(way.x)
}

/// A pose anywhere in a region.
pub(crate) fn anywhere<R: Rng + ?Sized>(region: &Bounds, rng: &mut R) -> Pose2 {
    let [u, v, w]: [f64; 3] = [rng.random(), rng.random(), rng.random()];
    let (min, max) = (region.min, region.max);
    let (x, y) = (min.x + u * (max.x - min.x), min.y + v * (max.y - min.y));
    Pose2::new(x, y, PI * (2.0 * w - 1.0))
}
