//! The built-in scenarios, and which of the lectures' IDs each of them shows.

use crate::{Error, Result};

/// The scenario that runs if none is named.
pub const DEFAULT: &str = "overview";

/// Name and TOML text of every built-in scenario, in the order in which they are listed.
pub const ALL: [(&str, &str); 41] = [
    ("overview", include_str!("../../scenarios/overview.toml")),
    ("kurt2-example", include_str!("../../scenarios/kurt2-example.toml")),
    ("circle-drive", include_str!("../../scenarios/circle-drive.toml")),
    ("ackermann-drive", include_str!("../../scenarios/ackermann-drive.toml")),
    ("mecanum-drive", include_str!("../../scenarios/mecanum-drive.toml")),
    ("sampling", include_str!("../../scenarios/sampling.toml")),
    ("lateration", include_str!("../../scenarios/lateration.toml")),
    ("two-sensors", include_str!("../../scenarios/two-sensors.toml")),
    ("accelerated-vehicle", include_str!("../../scenarios/accelerated-vehicle.toml")),
    ("landmark-drive", include_str!("../../scenarios/landmark-drive.toml")),
    ("aibo-soccer", include_str!("../../scenarios/aibo-soccer.toml")),
    ("line-matching", include_str!("../../scenarios/line-matching.toml")),
    ("sensor-fusion", include_str!("../../scenarios/sensor-fusion.toml")),
    ("mailbox", include_str!("../../scenarios/mailbox.toml")),
    ("door-corridor", include_str!("../../scenarios/door-corridor.toml")),
    ("mcl-1d", include_str!("../../scenarios/mcl-1d.toml")),
    ("diversity", include_str!("../../scenarios/diversity.toml")),
    ("grid-localization", include_str!("../../scenarios/grid-localization.toml")),
    ("topological-localization", include_str!("../../scenarios/topological-localization.toml")),
    ("slam-linear", include_str!("../../scenarios/slam-linear.toml")),
    ("slam-landmarks", include_str!("../../scenarios/slam-landmarks.toml")),
    ("slam-loop", include_str!("../../scenarios/slam-loop.toml")),
    ("slam-unnumbered", include_str!("../../scenarios/slam-unnumbered.toml")),
    ("position-tracking", include_str!("../../scenarios/position-tracking.toml")),
    ("beam-model", include_str!("../../scenarios/beam-model.toml")),
    ("global-localization", include_str!("../../scenarios/global-localization.toml")),
    ("kidnapped-robot", include_str!("../../scenarios/kidnapped-robot.toml")),
    ("crowded-museum", include_str!("../../scenarios/crowded-museum.toml")),
    ("probability-map", include_str!("../../scenarios/probability-map.toml")),
    ("perceptual-model", include_str!("../../scenarios/perceptual-model.toml")),
    ("maps", include_str!("../../scenarios/maps.toml")),
    ("wheel-sensor", include_str!("../../scenarios/wheel-sensor.toml")),
    ("steering-encoder", include_str!("../../scenarios/steering-encoder.toml")),
    ("inertial-sensor", include_str!("../../scenarios/inertial-sensor.toml")),
    ("compass", include_str!("../../scenarios/compass.toml")),
    ("landmark-camera", include_str!("../../scenarios/landmark-camera.toml")),
    ("depth-camera", include_str!("../../scenarios/depth-camera.toml")),
    ("laser-scanner", include_str!("../../scenarios/laser-scanner.toml")),
    ("radar", include_str!("../../scenarios/radar.toml")),
    ("gps", include_str!("../../scenarios/gps.toml")),
    ("sonar", include_str!("../../scenarios/sonar.toml")),
];

/// The TOML text of a built-in scenario.
///
/// # Errors
/// [`Error::UnknownName`] with the known names.
pub fn text(name: &str) -> Result<&'static str> {
    let found = ALL.iter().find(|(known, _)| *known == name);
    found.map(|(_, text)| *text).ok_or_else(|| Error::UnknownName {
        what: "scenario",
        expected: ALL.map(|(known, _)| known).join(", "),
        found: name.into(),
    })
}

/// An ID of the lectures' inventory, and the scenario that shows it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Shown {
    /// The ID.
    pub id: &'static str,
    /// What it stands for.
    pub what: &'static str,
    /// The built-in scenario that shows it.
    pub scenario: &'static str,
    /// The figure to look at, in the scenario's folder.
    pub figure: &'static str,
}

const fn shown(
    id: &'static str,
    what: &'static str,
    scenario: &'static str,
    figure: &'static str,
) -> Shown {
    Shown { id, what, scenario, figure }
}

/// Every ID of the lectures' inventory.
pub const IDS: [Shown; 66] = [
    shown("A1", "position tracking", "position-tracking", "map.svg"),
    shown("A2", "global localization", "global-localization", "clouds.svg"),
    shown("A3", "kidnapped robot", "kidnapped-robot", "errors.svg"),
    shown("B1", "wheel sensor", "wheel-sensor", "drive.svg"),
    shown("B2", "steering encoder", "steering-encoder", "encoder.svg"),
    shown("B3", "accelerometer", "inertial-sensor", "imu.svg"),
    shown("B4", "gyroscope", "inertial-sensor", "drift.svg"),
    shown("B5", "compass", "compass", "heading.svg"),
    shown("B6", "camera that sees landmarks", "landmark-camera", "landmarks.svg"),
    shown("B7", "depth camera", "depth-camera", "camera.svg"),
    shown("B8", "laser scanner", "laser-scanner", "scan.svg"),
    shown("B9", "radar", "radar", "radar.svg"),
    shown("B10", "satellite positions", "gps", "gnss.svg"),
    shown("B11", "sonar", "sonar", "sonar.svg"),
    shown("C1", "occupancy grid", "maps", "grid.svg"),
    shown("C2", "line map", "maps", "lines.svg"),
    shown("C3", "point map", "maps", "points.svg"),
    shown("C4", "topological map", "maps", "places.svg"),
    shown("C5", "likelihood field", "maps", "field.svg"),
    shown("C6", "landmark map", "maps", "grid.svg"),
    shown("D1", "two landmarks, two solutions", "lateration", "lateration.svg"),
    shown("D2", "more landmarks, least squares", "lateration", "lateration.svg"),
    shown("D3", "position in space", "lateration", "lateration.svg"),
    shown("D4", "bad geometry", "lateration", "lateration.svg"),
    shown("E1", "differential drive", "kurt2-example", "map.svg"),
    shown("E2", "Euler, midpoint, exact arc", "circle-drive", "map.svg"),
    shown("E3", "Ackermann drive", "ackermann-drive", "map.svg"),
    shown("E4", "Mecanum drive", "mecanum-drive", "map.svg"),
    shown("E5", "left-handed frame of KURT2", "kurt2-example", "map.svg"),
    shown("E6", "error propagation", "circle-drive", "map.svg"),
    shown("E7", "error model of the control", "circle-drive", "errors.svg"),
    shown("E8", "simulation of a circle", "circle-drive", "map.svg"),
    shown("F1", "events and Bayes' rule", "mailbox", "mailbox.svg"),
    shown("F2", "expectation, covariance, correlation", "sampling", "correlation.svg"),
    shown("F3", "normal density", "sampling", "sampling.svg"),
    shown("F4", "drawing random numbers", "sampling", "sampling.svg"),
    shown("F5", "Bayes filter, mailbox", "mailbox", "mailbox.svg"),
    shown("G1", "Kalman filter in one dimension", "two-sensors", "density.svg"),
    shown("G2", "Kalman filter in n dimensions", "accelerated-vehicle", "rail.svg"),
    shown("G3", "two sensors", "two-sensors", "density.svg"),
    shown("G4", "accelerated vehicle", "accelerated-vehicle", "accuracy.svg"),
    shown("G5", "steps without measurement", "accelerated-vehicle", "rail.svg"),
    shown("H1", "extended Kalman filter", "landmark-drive", "map.svg"),
    shown("H2", "distance and bearing", "landmark-drive", "map.svg"),
    shown("H3", "unknown association", "line-matching", "lines.svg"),
    shown("H4", "line matching", "line-matching", "lines.svg"),
    shown("I1", "linear SLAM", "slam-linear", "map.svg"),
    shown("I2", "SLAM with a heading", "slam-landmarks", "map.svg"),
    shown("I3", "SLAM by distance and bearing", "slam-loop", "map.svg"),
    shown("I4", "SLAM, association unknown", "slam-unnumbered", "map.svg"),
    shown("K1", "Markov localization", "door-corridor", "beliefs.svg"),
    shown("K2", "perceptual model", "perceptual-model", "surfaces.svg"),
    shown("K3", "people in the way", "crowded-museum", "map.svg"),
    shown("L", "comparison with the truth", "overview", "consistency.svg"),
    shown("M1", "Monte Carlo localization", "position-tracking", "clouds.svg"),
    shown("M2", "its stages in one dimension", "mcl-1d", "stages.svg"),
    shown("M3", "a search in twelve frames", "global-localization", "clouds.svg"),
    shown("M4", "motion with noise", "position-tracking", "clouds.svg"),
    shown("M5", "landmarks as measurement", "aibo-soccer", "clouds.svg"),
    shown("M6", "beam model", "beam-model", "map.svg"),
    shown("M7", "likelihood field as measurement", "probability-map", "probability.svg"),
    shown("M8", "roulette wheel", "diversity", "diversity.svg"),
    shown("M9", "low-variance resampling (spoke wheel)", "diversity", "diversity.svg"),
    shown("M10", "robot soccer", "aibo-soccer", "resampling.svg"),
    shown("M11", "diversity", "diversity", "diversity.svg"),
    shown("M12", "probability map of a scan", "probability-map", "probability.svg"),
];
