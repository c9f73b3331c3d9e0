//! A camera that recognises landmarks on the walls.

use super::{Place, Sensor, Station, Taken, check_count, rms, xy};
use crate::Result;
use loc_core::{Ellipse, Gaussian, Pose2, angle};
use loc_maps::grid::Occupancy;
use loc_maps::{Landmark, LandmarkMap, Occluded};
use loc_plot::{Chart, Figure, Role};
use loc_sensors::landmark_camera::{LandmarkCamera, LandmarkNoise, LandmarkObservation, Observed};
use nalgebra::{Matrix2, Point2, Vector2};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

pub(super) const SENSOR: Sensor = Sensor {
    name: "landmarks",
    about: "a camera that sees numbered landmarks (B6): distance and direction",
    presets: &[
        ("panorama", "all around up to 10 m, sigma 5 cm and 1 deg"),
        ("aibo", "57 deg up to 5 m, sigma 5 cm + 5 % and 2 deg, 9 of 10 found"),
    ],
    take,
};

/// A wall this close before a landmark does not hide it \[m\]: it hangs there.
const SLACK: f64 = 0.15;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    camera: LandmarkCamera,
    /// How many landmarks hang on the walls of a world that has none of its own.
    count: usize,
}

/// A landmark in view: where it is, and where the camera puts it.
struct Seen {
    observation: LandmarkObservation,
    range: f64,
    bearing: f64,
}

fn take(station: &Station) -> Result<Taken> {
    let camera = match station.preset {
        "aibo" => LandmarkCamera {
            fov: 56.9_f64.to_radians(),
            max_range: 5.0,
            detection_probability: 0.9,
            noise: LandmarkNoise {
                range_sigma: 0.05,
                range_sigma_per_m: 0.05,
                bearing_sigma: 2_f64.to_radians(),
            },
            ..LandmarkCamera::default()
        },
        _ => LandmarkCamera::default(),
    };
    let settings = station.settings(Settings { camera, count: 16 })?;
    let camera = settings.camera;
    camera.check()?;
    check_count("count", "1 to 1000 landmarks", 1..=1000, settings.count)?;
    let landmarks = match station.place.landmarks() {
        Some(landmarks) => landmarks.clone(),
        None => on_walls(station.place, settings.count)?,
    };
    let walls = station.place.walls();
    let world = Occluded { landmarks: &landmarks, walls, slack: SLACK };
    let perfect = LandmarkCamera {
        noise: LandmarkNoise::NONE,
        detection_probability: 1.0,
        wrong_identity_probability: 0.0,
        ..camera
    };
    let view = |pose| perfect.observe(&world, pose, &mut station.errors());
    let pose = station.pose_or(|place| place.best_view(0.8, |pose| view(pose).len() as f64))?;
    let observations = camera.observe(&world, pose, &mut station.errors());
    let eye = pose * camera.mounting;
    let truth = view(pose);
    let seen: Vec<Seen> = observations.iter().filter_map(|s| seen(*s, &landmarks, eye)).collect();

    let mut taken = Taken::new(pose, &settings);
    taken.tell("landmarks", landmarks.len());
    taken.tell("in_view", truth.len());
    taken.tell("seen", observations.len());
    taken.tell("range_error_rms_m", rms(seen.iter().filter_map(range_error)));
    taken.tell("bearing_error_rms_deg", rms(seen.iter().filter_map(bearing_error)).to_degrees());
    taken.table(
        "observations.csv",
        ["landmark", "range_m", "bearing_rad", "true_range_m", "true_bearing_rad"],
        seen.iter().map(|seen| {
            let observed = seen.observation.observed;
            let or_none = |value: Option<f64>| value.unwrap_or(f64::NAN);
            let id = f64::from(seen.observation.landmark);
            [id, or_none(observed.range()), or_none(observed.bearing()), seen.range, seen.bearing]
        }),
    );
    taken.folder.add("landmarks.csv", landmarks.to_csv());
    taken.folder.add("landmarks.svg", over_map(station, &settings, eye, &landmarks, &seen));
    taken.folder.add("errors.svg", errors(&seen, &camera.noise, station.preset));
    Ok(taken)
}

/// The observation beside the truth; numbers that were misread are compared with what they claim.
fn seen(observation: LandmarkObservation, landmarks: &LandmarkMap, eye: Pose2) -> Option<Seen> {
    let position = landmarks.get(observation.landmark)?.position.xy();
    let offset = position - eye.position();
    let bearing = angle::wrap(offset.y.atan2(offset.x) - eye.theta);
    Some(Seen { observation, range: offset.norm(), bearing })
}

/// Landmarks on walls that border on free space, spread evenly: each as far as possible from all
/// before.
fn on_walls(place: &Place, count: usize) -> Result<LandmarkMap> {
    let grid = place.grid();
    let reach = 1.5 * grid.resolution();
    let near_free = |point: &Point2<f64>| {
        (0..8).any(|k| {
            let (sin, cos) = (f64::from(k) * TAU / 8.0).sin_cos();
            let beside = point + Vector2::new(cos, sin) * reach;
            grid.occupancy_at(&beside) == Occupancy::Free
        })
    };
    let walls: Vec<_> = grid.centers_of(Occupancy::Occupied).filter(near_free).collect();
    let step = walls.len().div_ceil(5000).max(1);
    let walls: Vec<_> = walls.into_iter().step_by(step).collect();
    let mut apart = vec![f64::INFINITY; walls.len()];
    let mut landmarks = Vec::new();
    let mut next = walls.first().copied();
    while let Some(point) = next.filter(|_| landmarks.len() < count.min(walls.len())) {
        landmarks.push(Landmark::planar(landmarks.len() as u32 + 1, point.x, point.y));
        for (distance, wall) in apart.iter_mut().zip(&walls) {
            *distance = distance.min(nalgebra::distance(wall, &point));
        }
        let farthest = apart.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        next = farthest.map(|(index, _)| walls[index]);
    }
    Ok(LandmarkMap::new(landmarks)?)
}

/// Where an observation puts its landmark; a missing number is taken from the truth.
fn measured(seen: &Seen, eye: Pose2) -> Point2<f64> {
    let observed = seen.observation.observed;
    let range = observed.range().unwrap_or(seen.range);
    let (sin, cos) = observed.bearing().unwrap_or(seen.bearing).sin_cos();
    eye.transform(&Point2::new(range * cos, range * sin))
}

fn two_sigma(seen: &Seen, eye: Pose2, noise: &LandmarkNoise) -> Option<Ellipse> {
    let Observed::RangeBearing { range, bearing } = seen.observation.observed else { return None };
    let (along, across) = (noise.range_sigma_at(range), range * noise.bearing_sigma);
    let turn = Pose2::new(0.0, 0.0, eye.theta + bearing).rotation();
    let covariance =
        turn * Matrix2::new(along * along, 0.0, 0.0, across * across) * turn.transpose();
    Some(Gaussian { mean: measured(seen, eye).coords, covariance }.ellipse(2.0))
}

fn over_map(
    station: &Station,
    settings: &Settings,
    eye: Pose2,
    landmarks: &LandmarkMap,
    seen: &[Seen],
) -> String {
    let (camera, of) = (&settings.camera, landmarks.len());
    let note = format!("{} of {of} landmarks seen, the others hidden or out of view", seen.len());
    let mut scene = station.scene("Landmarks as a camera sees them", &note);
    if camera.fov < TAU {
        scene = station.field_of_view(scene, eye, camera.fov, camera.max_range);
    }
    let places = || seen.iter().map(|seen| xy(measured(seen, eye)));
    let ellipses = seen.iter().filter_map(|seen| two_sigma(seen, eye, &camera.noise));
    let named = landmarks.iter().map(|l| ((l.position.x, l.position.y), l.id.to_string()));
    let sights = places().map(|place| ((eye.x, eye.y), place));
    scene
        .segments(Role::Method(5).width(0.7), "line of sight", sights)
        .ellipses(Role::Method(1).width(1.0), "measured, 2 sigma", ellipses)
        .stars(Role::Method(1), "measured, 2 sigma", places())
        .crosses(Role::Method(0), "landmark", named)
        .poses(Role::Truth, "camera", [eye])
        .render()
}

fn errors(seen: &[Seen], noise: &LandmarkNoise, preset: &str) -> String {
    let ranges = seen.iter().filter_map(|s| Some((s.range, range_error(s)?)));
    let turns = seen.iter().filter_map(|s| Some((s.range, bearing_error(s)?.to_degrees())));
    let farthest = seen.iter().map(|seen| seen.range).fold(0.5, f64::max);
    let chart = |name: &str, two_sigma: &dyn Fn(f64) -> f64, errors: Vec<(f64, f64)>| {
        let span = (0..=20).map(|k| f64::from(k) / 20.0 * farthest);
        let band = span.map(|range| (range, -two_sigma(range), two_sigma(range)));
        Chart::new(name)
            .band(Role::Method(1), "2 sigma", band)
            .points(Role::Method(1).width(5.0), "observation", errors)
            .reference(0.0, "")
    };
    let (of_range, of_bearing) =
        (|range| 2.0 * noise.range_sigma_at(range), 2.0 * noise.bearing_sigma.to_degrees());
    let range = chart("error of the range [m]", &of_range, ranges.collect());
    let bearing = chart("error of the bearing [deg]", &|_| of_bearing, turns.collect());
    let figure = Figure::new("Errors of the observations").subtitle(preset);
    figure.x_label("true range [m]").panel(range).panel(bearing).render()
}

fn range_error(seen: &Seen) -> Option<f64> {
    Some(seen.observation.observed.range()? - seen.range)
}

fn bearing_error(seen: &Seen) -> Option<f64> {
    Some(angle::difference(seen.observation.observed.bearing()?, seen.bearing))
}
