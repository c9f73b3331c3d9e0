//! LandmarkObservations without numbers, held against the landmarks of one particle.

use super::look::{Look, Place};
use super::particle::{Knowledge, Particle};
use loc_filters::association::{PairInnovation, Pairing};
use loc_sensors::landmark_camera::Observed;
use nalgebra::{Matrix2, Matrix3};

/// Distance and direction are curved coordinates; a bound on a distance must hold in them too.
const SLACK: f64 = 2.0;

/// The looks of all pairs that are not out of the question.
pub(super) struct Pairs {
    /// The landmarks that are near any of the observations.
    slots: Vec<usize>,
    robot: Matrix3<f64>,
    /// For each observation its density, were it of something new.
    elsewhere: Vec<f64>,
    /// For each observation and each of the landmarks the look and the residual's covariance.
    looks: Vec<Option<(Look, Matrix2<f64>)>>,
}

impl Pairs {
    pub(super) fn new(knowledge: &Knowledge<'_>, particle: &Particle, places: &[Place]) -> Self {
        let near = |place: &Place, mark: &Matrix2<f64>| {
            // The variance of a difference is at most twice the sum of both.
            let p = &particle.belief.covariance;
            let robot = p.m11 + p.m22 + place.range.powi(2) * p.m33;
            let variance = robot + place.position.covariance.trace() + mark.trace();
            SLACK * knowledge.new_landmark_gate * 2.0 * variance
        };
        let (mut slots, mut marks) = (Vec::new(), Vec::new());
        particle.map.visit(&mut |slot, mark| {
            let fits = |place: &Place| {
                let squared = (place.position.mean - mark.position.mean).norm_squared();
                squared <= near(place, &mark.position.covariance)
            };
            if places.iter().any(fits) {
                slots.push(slot);
                marks.push(mark.position);
            }
        });
        let looks = places.iter().flat_map(|place| {
            let sight = Observed::RangeBearing { range: place.range, bearing: place.bearing };
            let marks = marks.iter();
            marks.map(move |mark| {
                let squared = (place.position.mean - mark.mean).norm_squared();
                if squared > near(place, &mark.covariance) {
                    return None;
                }
                let pose = &particle.belief.mean;
                let look = Look::new(knowledge.settings, pose, &mark.mean, sight);
                let of_robot =
                    look.by_robot * particle.belief.covariance * look.by_robot.transpose();
                Some((look, look.apart_from_robot(&mark.covariance) + of_robot))
            })
        });
        let density =
            |place: &Place| knowledge.settings.new_share * knowledge.view.density(place.range);
        Pairs {
            looks: looks.collect(),
            slots,
            robot: particle.belief.covariance,
            elsewhere: places.iter().map(density).collect(),
        }
    }

    /// The slot of the k-th landmark.
    pub(super) fn slot(&self, landmark: usize) -> usize {
        self.slots[landmark]
    }

    fn look(&self, (observation, landmark): (usize, usize)) -> Option<&(Look, Matrix2<f64>)> {
        self.looks.get(observation * self.slots.len() + landmark)?.as_ref()
    }
}

impl Pairing<2> for Pairs {
    fn observations(&self) -> usize {
        self.elsewhere.len()
    }

    fn landmarks(&self) -> usize {
        self.slots.len()
    }

    fn innovation(&self, observation: usize, landmark: usize) -> Option<PairInnovation<2>> {
        let (look, covariance) = self.look((observation, landmark))?;
        Some(PairInnovation { residual: look.residual, covariance: *covariance })
    }

    fn elsewhere(&self, observation: usize) -> f64 {
        self.elsewhere[observation]
    }

    /// What is left open of the robot's pose since the last time it was drawn.
    fn cross_covariance(&self, a: (usize, usize), b: (usize, usize)) -> Matrix2<f64> {
        match (self.look(a), self.look(b)) {
            (Some((a, _)), Some((b, _))) => a.by_robot * self.robot * b.by_robot.transpose(),
            _ => Matrix2::zeros(),
        }
    }
}
