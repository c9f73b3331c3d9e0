//! The rooms, side by side.

use super::{Lateration, Room};
use crate::output::figures::FigureFile;
use loc_plot::{Frames, Role, Scene};
use nalgebra::Vector2;
use std::f64::consts::TAU;

/// Points of a circle.
const POINTS: u32 = 360;
/// Room around all places \[m\].
const RIM: f64 = 1.0;

pub(super) fn figure(demonstration: &Lateration, title: &str) -> FigureFile {
    let config = &demonstration.config;
    let mut frames = Frames::new(title)
        .subtitle(format!(
            "distances good to {} m, measured once (circles, ellipse) and {} times more (dots)",
            config.range_sigma_m, config.draws
        ))
        .columns(2);
    let window = Window::around(&demonstration.rooms);
    for (k, room) in demonstration.rooms.iter().enumerate() {
        let letter = char::from(b'a'.saturating_add(k as u8));
        frames = frames.frame(format!("{letter}: {}", room.name), scene(room, &window));
    }
    FigureFile {
        file: "lateration.svg".into(),
        caption:
            "Landmarks, measured distances, the place found with its error ellipse, the other \
                  place, and where further measurements put the robot"
                .into(),
        svg: frames.render(),
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
        let sights = room.landmarks.iter().map(|landmark| (pair(landmark), pair(&room.best.mean)));
        scene = scene.segments(Role::Measurement.width(0.8), "measured distance", sights);
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
        let rim = Vector2::repeat(RIM);
        Window { low: low - rim, high: high + rim }
    }

    /// The point, or none where it lies outside.
    fn inside(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let inside =
            (self.low.x..=self.high.x).contains(&x) && (self.low.y..=self.high.y).contains(&y);
        if inside { (x, y) } else { (f64::NAN, f64::NAN) }
    }
}
