//! `loc-sim sense` simulates one sensor and draws its measurements.

use super::Global;
use super::console::uninterrupted;
use crate::sense::{Request, SENSORS, recorded_scan, sense as simulate};
use anyhow::{Context, bail};
use loc_core::Pose2;
use std::path::{Path, PathBuf};

/// Simulate a sensor in a map and draw its measurements.
#[derive(Debug, Clone, clap::Args)]
pub struct SenseArgs {
    /// The sensor; `--list` names them.
    #[arg(value_name = "SENSOR", required_unless_present = "list")]
    pub sensor: Option<String>,
    /// Print the sensors and their presets.
    #[arg(long)]
    pub list: bool,
    /// Data sheet of the sensor; its first preset where left out.
    #[arg(long, value_name = "NAME")]
    pub preset: Option<String>,
    /// A map of map_server to stand in.
    #[arg(long, value_name = "MAP.yaml", conflicts_with = "world")]
    pub map: Option<PathBuf>,
    /// A built-in world to stand in.
    #[arg(long, value_name = "NAME")]
    pub world: Option<String>,
    /// A CARMEN log to take a laser scan from, instead of simulating one.
    #[arg(long, value_name = "LOG", conflicts_with_all = ["preset", "world", "pose", "changes"])]
    pub log: Option<PathBuf>,
    /// Which scan of the log, counted from 0.
    #[arg(long, value_name = "K", default_value_t = 0, requires = "log")]
    pub scan: usize,
    /// Where the robot stands or starts, in metres and degrees; a place with a view where left out.
    #[arg(long, value_name = "X,Y,DEG", allow_hyphen_values = true)]
    pub pose: Option<String>,
    /// Seed of all random draws.
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,
    /// A setting of the sensor to change; may be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<String>,
    /// The folder to write; out/sense-SENSOR where left out.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// Simulates a sensor, writes its folder and prints its figures.
///
/// # Errors
/// Errors of the names, the map, the pose or the settings, and of writing.
pub fn sense(args: &SenseArgs, global: &Global) -> anyhow::Result<()> {
    let Some(sensor) = args.sensor.as_deref().filter(|_| !args.list) else {
        return list(global);
    };
    let request = Request {
        sensor: sensor.into(),
        preset: args.preset.clone(),
        map: args.map.clone(),
        world: args.world.clone(),
        pose: args.pose.as_deref().map(parse_pose).transpose()?,
        seed: args.seed,
        changes: args.changes.clone(),
    };
    let reading = match &args.log {
        Some(_) if sensor != "laser" => bail!("--log: expected the sensor laser, got {sensor}"),
        Some(log) => recorded_scan(log, args.scan, args.map.as_deref())?,
        None => simulate(&request)?,
    };
    let folder = args.out.clone().unwrap_or_else(|| {
        let name = format!("sense-{sensor}");
        Path::new("out").join(name)
    });
    uninterrupted(|| reading.folder.write(&folder)).context("cannot write the reading")?;
    if global.quiet {
        return Ok(());
    }
    if global.json {
        return super::print(&serde_json::to_string_pretty(&reading.summary)?);
    }
    super::print(&reading.lines().join("\n"))?;
    super::print(&format!("written to {}", folder.display()))
}

fn list(global: &Global) -> anyhow::Result<()> {
    if global.json {
        let preset =
            |(name, about): &(&str, &str)| serde_json::json!({"name": name, "about": about});
        let sensors: Vec<_> = SENSORS
            .iter()
            .map(|sensor| {
                let presets: Vec<_> = sensor.presets.iter().map(preset).collect();
                serde_json::json!({"name": sensor.name, "about": sensor.about, "presets": presets})
            })
            .collect();
        return super::print(&serde_json::to_string_pretty(&sensors)?);
    }
    for sensor in &SENSORS {
        super::print(&format!("{:<15} {}", sensor.name, sensor.about))?;
        for (name, about) in sensor.presets {
            super::print(&format!("  {name:<19} {about}"))?;
        }
    }
    Ok(())
}

fn parse_pose(text: &str) -> crate::Result<Pose2> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, degrees]) if x.is_finite() && y.is_finite() && degrees.is_finite() => {
            Ok(Pose2::new(x, y, degrees.to_radians()))
        }
        _ => Err(crate::config::field("--pose", "three finite numbers x,y,deg", text)),
    }
}
