//! The scenarios that are compiled in.

use crate::{Error, Result};

/// The one that runs when none is named.
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
/// [`Error::UnknownName`] with the names there are.
pub fn text(name: &str) -> Result<&'static str> {
    let found = ALL.iter().find(|(known, _)| *known == name);
    found.map(|(_, text)| *text).ok_or_else(|| Error::UnknownName {
        what: "scenario",
        expected: ALL.map(|(known, _)| known).join(", "),
        found: name.into(),
    })
}
