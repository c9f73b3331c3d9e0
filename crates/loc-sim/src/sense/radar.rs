//! Radar echoes of people who walk about.

use super::{Place, Sensor, Station, Taken, check_count, check_twist, rms, xy};
use crate::Result;
use loc_core::random::stream;
use loc_core::{Pose2, Twist2, angle};
use loc_plot::{Chart, Figure, Role};
use loc_sensors::radar::{Radar, RadarNoise, RadarReturn, RadarSpec};
use loc_sensors::world::MovingObject;
use nalgebra::{Point2, Vector2};
use rand::{Rng, RngExt};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

pub(super) const SENSOR: Sensor = Sensor {
    name: "radar",
    about: "radar echoes of walking people (B9): range, bearing, radial speed",
    presets: &[
        ("ars408-near", "120 deg, 0.2 to 70 m, sigma 0.1 m, 1 deg, 0.1 km/h"),
        ("ars408-cluttered", "the same with 3 false echoes, and people found 8 times of 10"),
    ],
    take,
};

/// Radius of a person \[m\].
const PERSON: f64 = 0.25;

#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Settings {
    mounting: Pose2,
    spec: RadarSpec,
    /// Velocity of the robot.
    velocity: Twist2,
    /// How many people walk about, up to `people_speed` \[m/s\].
    people: usize,
    people_speed: f64,
}

fn take(station: &Station) -> Result<Taken> {
    let mut spec = RadarSpec::ars408_near();
    if station.preset == "ars408-cluttered" {
        spec.noise = RadarNoise { detection_probability: 0.8, clutter: 3.0, ..spec.noise };
    }
    let settings = station.settings(Settings {
        mounting: Pose2::IDENTITY,
        spec,
        velocity: Twist2::forward(0.5, 0.0),
        people: 8,
        people_speed: 1.5,
    })?;
    let Settings { mounting, spec, velocity, people, .. } = settings;
    let radar = Radar { mounting, spec };
    radar.check()?;
    check_twist(velocity)?;
    loc_core::error::non_negative("people_speed [m/s]", settings.people_speed)?;
    check_count("people", "at most 1000", 0..=1000, people)?;
    let open = |place: &Place| {
        place.best_view(1.0, |pose| place.fan(pose, spec.fov, 30.0).into_iter().sum())
    };
    let pose = station.pose_or(open)?;
    let walls = station.place.walls();
    let crowd = crowd(station, pose * mounting, &settings);
    let echoes = radar.observe(walls, crowd.as_slice(), pose, velocity, &mut station.errors());
    let perfect = Radar { spec: RadarSpec { noise: RadarNoise::NONE, ..spec }, ..radar };
    let truth: Vec<Option<RadarReturn>> = crowd
        .iter()
        .map(|one| {
            let alone = std::slice::from_ref(one);
            let seen = perfect.observe(walls, alone, pose, velocity, &mut station.errors());
            seen.first().copied()
        })
        .collect();

    let mut taken = Taken::new(pose, &settings);
    let visible: Vec<RadarReturn> = truth.iter().copied().flatten().collect();
    let pairs: Vec<_> = echoes.iter().map(|echo| (echo, partner(echo, &visible, &spec))).collect();
    let error = |of: fn(&RadarReturn, &RadarReturn) -> f64| {
        rms(pairs.iter().filter_map(|(echo, truth)| truth.map(|truth| of(echo, &truth))))
    };
    taken.tell("people", crowd.len());
    taken.tell("people_in_view", visible.len());
    taken.tell("echoes", echoes.len());
    taken.tell("false_echoes", pairs.iter().filter(|(_, truth)| truth.is_none()).count());
    taken.tell("range_error_rms_m", error(|a, b| a.range - b.range));
    let turn = error(|a, b| angle::difference(a.bearing, b.bearing));
    taken.tell("bearing_error_rms_deg", turn.to_degrees());
    taken.tell("speed_error_rms_m_s", error(|a, b| a.radial_speed - b.radial_speed));
    taken.table(
        "echoes.csv",
        ["range_m", "bearing_rad", "radial_speed_m_s"],
        echoes.iter().map(|echo| [echo.range, echo.bearing, echo.radial_speed]),
    );
    taken.table(
        "people.csv",
        ["x_m", "y_m", "vx_m_s", "vy_m_s", "in_view"],
        crowd.iter().zip(&truth).map(|(one, seen)| {
            let view = if seen.is_some() { 1.0 } else { 0.0 };
            [one.position.x, one.position.y, one.velocity.x, one.velocity.y, view]
        }),
    );
    taken.folder.add("radar.svg", over_map(station, pose * mounting, spec.fov, &crowd, &echoes));
    taken.folder.add("speeds.svg", speeds(&echoes, &visible, station.preset));
    Ok(taken)
}

/// People in free space, most of them where the radar looks.
fn crowd(station: &Station, radar: Pose2, settings: &Settings) -> Vec<MovingObject> {
    let mut rng = stream(station.seed, "world");
    let place = station.place;
    let one = |_| {
        let position = stand(place, radar, settings.spec.fov, &mut rng)?;
        let speed = settings.people_speed * (0.3 + 0.7 * rng.random::<f64>());
        let (sin, cos) = (TAU * rng.random::<f64>()).sin_cos();
        Some(MovingObject { position, velocity: Vector2::new(cos, sin) * speed, radius: PERSON })
    };
    (0..settings.people).filter_map(one).collect()
}

/// A place to stand with room around it; `None` where none is found.
fn stand(place: &Place, radar: Pose2, fov: f64, rng: &mut impl Rng) -> Option<Point2<f64>> {
    let corners = place.grid().frame().corners();
    (0..1000).find_map(|tried| {
        let (share, along, aside) = (rng.random::<f64>(), rng.random::<f64>(), rng.random::<f64>());
        // Behind walls too, so that one sees what they hide; anywhere, where there is no room.
        let position = if tried < 200 {
            let direction = radar.theta + (share - 0.5) * 1.2 * fov;
            let (sin, cos) = direction.sin_cos();
            let toward = Pose2::new(radar.x, radar.y, direction);
            let range = along.sqrt() * (1.6 * place.range(toward, 20.0));
            radar.position() + Vector2::new(cos, sin) * range
        } else {
            let (x, y) = (corners[1] - corners[0], corners[3] - corners[0]);
            corners[0] + x * along + y * aside
        };
        let apart = nalgebra::distance(&position, &radar.position()) > 0.8;
        (apart && place.clearance(&position) > 1.2 * PERSON).then_some(position)
    })
}

/// The true echo that one belongs to.
fn partner(echo: &RadarReturn, truth: &[RadarReturn], spec: &RadarSpec) -> Option<RadarReturn> {
    let noise = &spec.noise;
    let off = |error: f64, sigma: f64| (error / sigma.max(1e-6)).powi(2);
    let distance = |truth: &RadarReturn| {
        off(echo.range - truth.range, noise.range_sigma)
            + off(angle::difference(echo.bearing, truth.bearing), noise.bearing_sigma)
            + off(echo.radial_speed - truth.radial_speed, noise.speed_sigma)
    };
    let nearest = truth.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    // Three numbers beyond 5 standard deviations are none of its errors.
    (distance(nearest) < 30.0).then_some(*nearest)
}

fn over_map(
    station: &Station,
    radar: Pose2,
    fov: f64,
    crowd: &[MovingObject],
    echoes: &[RadarReturn],
) -> String {
    let note = "a line shows the way that the range changes in a second";
    let scene = station.scene("Radar echoes of people who walk", note);
    let mut scene = station.field_of_view(scene, radar, fov, 70.0);
    let seen = |echo: &RadarReturn, range: f64| {
        let (sin, cos) = echo.bearing.sin_cos();
        radar.transform(&Point2::new(range * cos, range * sin))
    };
    let on_map =
        |echo: &&RadarReturn| station.place.grid().value_at(&seen(echo, echo.range)).is_some();
    let shown: Vec<&RadarReturn> = echoes.iter().filter(on_map).collect();
    let walk = |one: &MovingObject| (xy(one.position), xy(one.position + one.velocity));
    scene = scene.segments(Role::Map.width(1.2), "person, way of a second", crowd.iter().map(walk));
    let heading = |one: &MovingObject| {
        Pose2::new(one.position.x, one.position.y, one.velocity.y.atan2(one.velocity.x))
    };
    scene = scene.poses(Role::Map, "person, way of a second", crowd.iter().map(heading));
    for (role, label, sign) in
        [(Role::Method(1), "echo, coming", -1.0), (Role::Method(0), "echo, going", 1.0)]
    {
        let of_sign = || shown.iter().filter(move |echo| echo.radial_speed * sign > 0.0);
        let changes = of_sign().map(|echo| {
            let end = (echo.range + echo.radial_speed.clamp(-5.0, 5.0)).max(0.0);
            (xy(seen(echo, echo.range)), xy(seen(echo, end)))
        });
        scene = scene.segments(role.width(2.2), label, changes);
        scene = scene.stars(role, label, of_sign().map(|echo| xy(seen(echo, echo.range))));
    }
    scene.poses(Role::Truth, "radar", [radar]).render()
}

fn speeds(echoes: &[RadarReturn], truth: &[RadarReturn], preset: &str) -> String {
    let by_bearing = |list: &[RadarReturn], of: fn(&RadarReturn) -> f64| -> Vec<(f64, f64)> {
        list.iter().map(|echo| (echo.bearing.to_degrees(), of(echo))).collect()
    };
    let chart = |name: &str, of: fn(&RadarReturn) -> f64| {
        Chart::new(name)
            .points(Role::Truth.width(8.0), "person in view", by_bearing(truth, of))
            .points(Role::Method(1).width(4.0), "echo", by_bearing(echoes, of))
    };
    let figure = Figure::new("Echoes by their direction").subtitle(preset);
    let speed = chart("radial speed [m/s]", |echo| echo.radial_speed).reference(0.0, "");
    let figure = figure.x_label("bearing, counter-clockwise [deg]");
    figure.panel(chart("range [m]", |echo| echo.range)).panel(speed).render()
}
