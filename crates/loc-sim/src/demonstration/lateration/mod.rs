//! Lateration in four rooms (D1 to D4): two landmarks with both places, five landmarks, a robot in
//! space, and a geometry that magnifies noise.
//!
//! In each room the distances are measured once, which gives a place with its error ellipse, and
//! then many times more: the places so found scatter as the ellipse says, or the picture shows that
//! they do not.

mod config;
mod figure;

pub use config::{LaterationConfig, RoomConfig};

use crate::Result;
use crate::output::Illustration;
use loc_core::Gaussian;
use loc_core::random::{ChaCha8Rng, stream};
use loc_filters::lateration::{Caution, LaterationSettings, Range, Solution, locate};
use nalgebra::{Matrix2, Point, Vector2};
use rand_distr::{Distribution, StandardNormal};
use serde_json::{Value, json};

/// What happened in the rooms.
#[derive(Debug, Clone)]
pub struct Lateration {
    /// What was asked for.
    pub config: LaterationConfig,
    /// One for each room.
    pub rooms: Vec<Room>,
}

/// What lateration found in a room. Places are given by two coordinates: x, y in the plane, and
/// x, z for a room in space, which is seen from the side.
#[derive(Debug, Clone)]
pub struct Room {
    /// What is to be seen.
    pub name: String,
    /// Number of coordinates of the room.
    pub dimension: usize,
    /// The landmarks \[m\].
    pub landmarks: Vec<Vector2<f64>>,
    /// The measured distances \[m\].
    pub distances: Vec<f64>,
    /// The robot \[m\].
    pub robot: Vector2<f64>,
    /// The place found, with its covariance \[m\].
    pub best: Gaussian<2>,
    /// The other place, where there is one \[m\].
    pub other: Option<Gaussian<2>>,
    /// Where further measurements put the robot \[m\].
    pub scatter: Vec<Vector2<f64>>,
    /// Standard deviation that the covariance promises, over all coordinates \[m\].
    pub promised: f64,
    /// Root mean square of the errors of the further measurements, over all coordinates \[m\].
    pub measured: f64,
    /// The dilution of precision.
    pub dilution: f64,
    /// What speaks against the place.
    pub cautions: Vec<Caution>,
}

impl Lateration {
    /// Measures and computes in every room.
    ///
    /// # Errors
    /// Values out of range, and rooms in which nothing can be found.
    pub fn new(config: &LaterationConfig, seed: u64) -> Result<Self> {
        config.check()?;
        let mut rng = stream(seed, "demonstration");
        let mut rooms = Vec::with_capacity(config.rooms.len());
        for room in &config.rooms {
            rooms.push(match room.dimension() {
                2 => measure::<2>(config, room, &mut rng)?,
                _ => measure::<3>(config, room, &mut rng)?,
            });
        }
        Ok(Lateration { config: config.clone(), rooms })
    }

    /// The rooms as a figure and numbers.
    pub fn illustrate(&self, title: &str) -> Illustration {
        let mut lines = vec![format!(
            "{:<28}{:>20}{:>10}{:>11}{:>11}",
            "room", "place [m]", "dilution", "sigma [m]", "RMS [m]"
        )];
        for room in &self.rooms {
            let place = format!("({:.2}, {:.2})", room.best.mean.x, room.best.mean.y);
            lines.push(format!(
                "{:<28}{place:>20}{:>10.1}{:>11.3}{:>11.3}",
                room.name, room.dilution, room.promised, room.measured
            ));
            lines.extend(room.cautions.iter().map(|caution| format!("  {}", words(caution))));
        }
        let rooms: Vec<Value> = self.rooms.iter().map(Room::summary).collect();
        let summary = json!({"range_sigma_m": self.config.range_sigma_m, "rooms": rooms});
        Illustration::new(lines, summary, vec![figure::figure(self, title)])
    }
}

impl Room {
    fn summary(&self) -> Value {
        json!({
            "name": self.name,
            "coordinates": if self.dimension == 2 { ["x", "y"] } else { ["x", "z"] },
            "robot_m": self.robot.as_slice(),
            "place_m": self.best.mean.as_slice(),
            "other_place_m": self.other.as_ref().map(|other| other.mean.as_slice()),
            "dilution": self.dilution,
            "promised_sigma_m": self.promised,
            "measured_rms_m": self.measured,
            "cautions": self.cautions.iter().map(words).collect::<Vec<_>>(),
        })
    }
}

fn measure<const D: usize>(
    config: &LaterationConfig,
    room: &RoomConfig,
    rng: &mut ChaCha8Rng,
) -> Result<Room> {
    // Checked: every place has as many coordinates as the room.
    let place =
        |coordinates: &[f64]| Point::<f64, D>::from(std::array::from_fn(|k| coordinates[k]));
    let robot = place(&room.robot_m);
    let start = room.start_m.as_deref().map(place);
    let landmarks: Vec<Point<f64, D>> = room.landmarks_m.iter().map(|l| place(l)).collect();
    let mut once = || -> Result<(Vec<Range<D>>, Solution<D>)> {
        let range = |landmark: &Point<f64, D>| {
            let noise: f64 = StandardNormal.sample(rng);
            let distance = nalgebra::distance(landmark, &robot) + config.range_sigma_m * noise;
            Range { landmark: *landmark, distance: distance.max(0.0), sigma: config.range_sigma_m }
        };
        let ranges: Vec<Range<D>> = landmarks.iter().map(range).collect();
        let solution = locate(&ranges, start, &LaterationSettings::default())?;
        Ok((ranges, solution))
    };
    let (ranges, solution) = once()?;
    let (mut scatter, mut square) = (Vec::with_capacity(config.draws), 0.0);
    for _ in 0..config.draws {
        let found = once()?.1.best.position;
        square += (found - robot).norm_squared() / config.draws as f64;
        scatter.push(seen(&found));
    }
    let belief = |fix: &loc_filters::lateration::Fix<D>| {
        let (a, b) = (0, D - 1);
        let s = &fix.covariance;
        let covariance = Matrix2::new(s[(a, a)], s[(a, b)], s[(b, a)], s[(b, b)]);
        Gaussian { mean: seen(&fix.position), covariance }
    };
    Ok(Room {
        name: room.name.clone(),
        dimension: D,
        landmarks: landmarks.iter().map(seen).collect(),
        distances: ranges.iter().map(|range| range.distance).collect(),
        robot: seen(&robot),
        best: belief(&solution.best),
        other: solution.other.as_ref().map(belief),
        scatter,
        promised: solution.best.covariance.trace().sqrt(),
        measured: f64::sqrt(square),
        dilution: solution.best.dilution.position(),
        cautions: solution.cautions,
    })
}

/// The first and the last coordinate: all of a room in the plane, the side view of one in space.
fn seen<const D: usize>(place: &Point<f64, D>) -> Vector2<f64> {
    Vector2::new(place[0], place[D - 1])
}

/// A caution in words.
fn words(caution: &Caution) -> String {
    match caution {
        Caution::Ambiguous { .. } => "two places fit alike: the start decides".into(),
        Caution::NoIntersection { gap, .. } => {
            format!("the circles miss each other by {gap:.2} m: the nearest place")
        }
        Caution::BadGeometry { dilution } if dilution.is_infinite() => {
            "all landmarks lie in one direction: noise is magnified beyond bounds".into()
        }
        Caution::BadGeometry { dilution } => format!("noise is magnified {dilution:.1} times"),
        Caution::Contradiction { chi_square, degrees_of_freedom } => format!(
            "the distances contradict each other: chi-square {chi_square:.1} of \
             {degrees_of_freedom}"
        ),
        _ => "another caution".into(),
    }
}
