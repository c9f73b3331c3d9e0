//! Lateration in four rooms (D1 to D4): two landmarks with both places, five landmarks, a robot in
//! space, and a geometry that magnifies noise.
//!
//! In each room the distances are measured once, which gives a place with its error ellipse, and
//! then many times more: the scatter of the places so found is compared with the ellipse.

use super::{Demonstration, check_count};
use crate::Result;
use crate::config::field;
use crate::output::Illustration;
use crate::output::figures::FigureFile;
use loc_core::Gaussian;
use loc_core::error::positive;
use loc_core::random::{ChaCha8Rng, stream};
use loc_filters::lateration::{Caution, Fix, LaterationSettings, Range, Solution, locate};
use loc_plot::{Frames, Role, Scene};
use nalgebra::{Matrix2, Point, Vector2};
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;
use serde_json::{Value, json};
use std::f64::consts::TAU;

/// Rooms in which a robot measures distances to landmarks.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LaterationConfig {
    /// Standard deviation of every distance \[m\].
    pub range_sigma: f64,
    /// How often the distances are measured anew, to see where the places scatter.
    pub draws: usize,
    /// The rooms.
    pub rooms: Vec<RoomConfig>,
}

/// A robot and its landmarks, in the plane (x, y) or in space (x, y, z).
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RoomConfig {
    /// What is to be seen.
    pub name: String,
    /// The landmarks \[m\].
    pub landmarks: Vec<Vec<f64>>,
    /// Where the robot is \[m\].
    pub robot: Vec<f64>,
    /// Where it is believed to be beforehand; it decides between two places \[m\].
    pub start: Option<Vec<f64>>,
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

/// Points of a circle.
const POINTS: u32 = 360;
/// Margin around all places \[m\].
const MARGIN: f64 = 1.0;

impl LaterationConfig {
    /// Measures and computes in every room.
    ///
    /// # Errors
    /// Values out of range, and rooms in which nothing can be found.
    pub fn measure(&self, seed: u64) -> Result<Vec<Room>> {
        self.check()?;
        let mut rng = stream(seed, "demonstration");
        let room = |room: &RoomConfig| match room.dimension() {
            2 => measure::<2>(self, room, &mut rng),
            _ => measure::<3>(self, room, &mut rng),
        };
        self.rooms.iter().map(room).collect()
    }

    fn draw(&self, rooms: &[Room], title: &str) -> FigureFile {
        let subtitle = format!(
            "distances good to {} m, measured once (circles, ellipse) and {} times more (dots)",
            self.range_sigma, self.draws
        );
        let mut frames = Frames::new(title).subtitle(subtitle).columns(2);
        let window = Window::around(rooms);
        for (k, room) in rooms.iter().enumerate() {
            let letter = char::from(b'a'.saturating_add(k as u8));
            frames = frames.frame(format!("{letter}: {}", room.name), scene(room, &window));
        }
        let caption = "Landmarks, measured distances, the place found with its error ellipse, the \
                       other place, and where further measurements put the robot";
        FigureFile::new("lateration.svg", caption, frames.render())
    }
}

impl Demonstration for LaterationConfig {
    fn check(&self) -> Result<()> {
        positive("demonstration.range_sigma", self.range_sigma)?;
        check_count("demonstration.draws", self.draws, 100_000)?;
        check_count("demonstration.rooms", self.rooms.len(), 12)?;
        self.rooms.iter().try_for_each(RoomConfig::check)
    }

    fn run(&self, title: &str, seed: u64) -> Result<Illustration> {
        let rooms = self.measure(seed)?;
        let mut lines = vec![format!(
            "{:<28}{:>20}{:>10}{:>11}{:>11}",
            "room", "place [m]", "dilution", "sigma [m]", "RMS [m]"
        )];
        for room in &rooms {
            let place = format!("({:.2}, {:.2})", room.best.mean.x, room.best.mean.y);
            let Room { name, dilution, promised, measured, .. } = room;
            let accuracy = format!("{dilution:>10.1}{promised:>11.3}{measured:>11.3}");
            lines.push(format!("{name:<28}{place:>20}{accuracy}"));
            lines.extend(room.cautions.iter().map(|caution| format!("  {}", words(caution))));
        }
        let summaries: Vec<Value> = rooms.iter().map(Room::summary).collect();
        let summary = json!({"range_sigma_m": self.range_sigma, "rooms": summaries});
        Ok(Illustration::new(lines, summary, vec![self.draw(&rooms, title)]))
    }
}

impl RoomConfig {
    /// Number of coordinates.
    fn dimension(&self) -> usize {
        self.robot.len()
    }

    fn check(&self) -> Result<()> {
        let d = self.dimension();
        let found = |place: &[f64]| format!("{place:?} in {}", self.name);
        if !(2..=3).contains(&d) {
            let key = "demonstration.rooms.robot";
            return Err(field(key, "2 or 3 coordinates", &found(&self.robot)));
        }
        for place in self.landmarks.iter().chain(&self.start).chain([&self.robot]) {
            if place.len() != d || !place.iter().all(|value| value.is_finite()) {
                let expected = format!("places of {d} finite coordinates, as the robot has");
                return Err(field("demonstration.rooms", &expected, &found(place)));
            }
        }
        Ok(())
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
    let robot = place(&room.robot);
    let start = room.start.as_deref().map(place);
    let landmarks: Vec<Point<f64, D>> = room.landmarks.iter().map(|l| place(l)).collect();
    let mut once = || -> Result<(Vec<Range<D>>, Solution<D>)> {
        let range = |landmark: &Point<f64, D>| {
            let noise: f64 = StandardNormal.sample(rng);
            let distance = nalgebra::distance(landmark, &robot) + config.range_sigma * noise;
            Range { landmark: *landmark, distance: distance.max(0.0), sigma: config.range_sigma }
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
        scatter.push(shown_part(&found));
    }
    let belief = |fix: &Fix<D>| {
        let (a, b) = (0, D - 1);
        let s = &fix.covariance;
        let covariance = Matrix2::new(s[(a, a)], s[(a, b)], s[(b, a)], s[(b, b)]);
        Gaussian { mean: shown_part(&fix.position), covariance }
    };
    Ok(Room {
        name: room.name.clone(),
        dimension: D,
        landmarks: landmarks.iter().map(shown_part).collect(),
        distances: ranges.iter().map(|range| range.distance).collect(),
        robot: shown_part(&robot),
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
fn shown_part<const D: usize>(place: &Point<f64, D>) -> Vector2<f64> {
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

fn scene(room: &Room, window: &Window) -> Scene {
    let pair = |place: &Vector2<f64>| (place.x, place.y);
    let mut scene = Scene::new("");
    if room.dimension == 2 {
        for (landmark, distance) in room.landmarks.iter().zip(&room.distances) {
            let circle = Role::Measurement.width(0.8);
            let points = around(landmark, *distance);
            scene = scene.path(circle, "measured distance", points.map(|p| window.inside(p)));
        }
    } else {
        // From the side a distance is no circle: the line of sight stands for it.
        let lines = room.landmarks.iter().map(|landmark| (pair(landmark), pair(&room.best.mean)));
        scene = scene.segments(Role::Measurement.width(0.8), "measured distance", lines);
    }
    let scatter = room.scatter.iter().map(pair);
    scene = scene.dots(Role::Method(5).width(1.8), "further measurements", scatter);
    scene = scene.ellipses(Role::Method(0), "place found, 2 sigma", [room.best.ellipse(2.0)]);
    if let Some(other) = &room.other {
        scene = scene.ellipses(Role::Method(1), "other place", [other.ellipse(2.0)]);
        scene = scene.stars(Role::Method(1), "other place", [pair(&other.mean)]);
    }
    scene = scene.stars(Role::Method(0), "place found, 2 sigma", [pair(&room.best.mean)]);
    let named = room.landmarks.iter().map(|landmark| (pair(landmark), ""));
    scene.crosses(Role::Landmark, "landmark", named).dots(
        Role::Truth.width(4.0),
        "robot",
        [pair(&room.robot)],
    )
}

fn around(middle: &Vector2<f64>, radius: f64) -> impl Iterator<Item = (f64, f64)> {
    let angle = |k: u32| TAU * f64::from(k) / f64::from(POINTS);
    (0..=POINTS)
        .map(move |k| (middle.x + radius * angle(k).cos(), middle.y + radius * angle(k).sin()))
}

/// The part of the plane that is shown; circles run out of it.
struct Window {
    low: Vector2<f64>,
    high: Vector2<f64>,
}

impl Window {
    /// Around all that is not a circle.
    fn around(rooms: &[Room]) -> Self {
        let places = rooms.iter().flat_map(|room| {
            let found = [room.robot, room.best.mean].into_iter();
            let other = room.other.as_ref().map(|other| other.mean);
            found.chain(other).chain(room.landmarks.iter().copied())
        });
        let nothing = (Vector2::repeat(f64::MAX), Vector2::repeat(f64::MIN));
        let (low, high) =
            places.fold(nothing, |(low, high), place| (low.inf(&place), high.sup(&place)));
        let margin = Vector2::repeat(MARGIN);
        Window { low: low - margin, high: high + margin }
    }

    /// The point, or none where it lies outside.
    fn inside(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let inside =
            (self.low.x..=self.high.x).contains(&x) && (self.low.y..=self.high.y).contains(&y);
        if inside { (x, y) } else { (f64::NAN, f64::NAN) }
    }
}
