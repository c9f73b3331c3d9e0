//! `loc-sim fit-beam` learns the parameters of the beam model from a log.

use super::{Global, print};
use crate::output::Folder;
use crate::perceptual::{LearnSettings, Learned, learn};
use crate::source::carmen::CarmenLog;
use crate::source::laser_log::Scans;
use crate::{Error, Result, perceptual};
use anyhow::Context;
use loc_core::Pose2;
use loc_maps::OccupancyGrid;
use loc_maps::grid::{Occupancy, io};
use loc_pf::sensor::BeamModelSettings;
use loc_sensors::laser::LaserScan;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Smallest share of the poses in free space; below it log and map do not belong together.
const IN_MAP: f64 = 0.5;

/// Smallest share of the ranges near the expected ones; below it the map does not fit the log.
const AGREE: f64 = 0.5;

/// Largest difference of a range that counts as near \[m\].
const NEAR: f64 = 0.5;

/// Learn the parameters of the beam model from a CARMEN log whose laser poses lie in a map.
#[derive(Debug, Clone, clap::Args)]
pub struct FitBeamArgs {
    /// The log; it may be gzipped.
    #[arg(value_name = "LOG")]
    pub log: PathBuf,
    /// The map of map_server in whose frame the log's laser poses are.
    #[arg(long, value_name = "MAP.yaml")]
    pub map: PathBuf,
    /// Which scans to use, counted from 0.
    #[arg(long, value_enum, default_value_t = Scans::All)]
    pub scans: Scans,
    /// Ranges from here on count as no return; the scanner's longest one where that is shorter.
    #[arg(long, value_name = "M", default_value_t = BeamModelSettings::default().max_range)]
    pub max_range: f64,
    /// Width of the histogram's bins.
    #[arg(long, value_name = "M", default_value_t = LearnSettings::default().bin)]
    pub bin: f64,
    /// The folder to write; out/fit-beam where left out.
    #[arg(long, value_name = "DIR", default_value = "out/fit-beam")]
    pub out: PathBuf,
}

/// Learns, writes the folder and prints the parameters.
///
/// # Errors
/// Errors of the log, the map or the settings, and a log that does not fit the map.
pub fn fit_beam(args: &FitBeamArgs, global: &Global) -> anyhow::Result<()> {
    let grid = io::load(&args.map)?;
    let lasers = CarmenLog::open(&args.log)?.lasers()?;
    let taken = lasers.into_iter().enumerate().filter(|(index, _)| args.scans.takes(*index));
    let scans: Vec<(Pose2, LaserScan)> =
        taken.map(|(_, laser)| (laser.laser, laser.scan)).collect();
    check_poses(args, &grid, &scans)?;
    let start = BeamModelSettings::default().max_range(args.max_range);
    let settings = LearnSettings { start, bin: args.bin, ..Default::default() };
    let learned = learn(&scans, &grid, &settings)?;
    check_ranges(args, &learned)?;

    let summary = summary(args, &learned);
    let title = format!("Perceptual model: {} in {}", name(&args.log), name(&args.map));
    let mut folder = Folder::default();
    folder.add("summary.json", format!("{summary:#}\n"));
    folder.add("beam_model.toml", toml::to_string(&learned.fit.settings)?);
    folder.add("surfaces.svg", perceptual::surfaces(&learned, &title)?);
    folder.add("cuts.svg", perceptual::cuts(&learned, &title)?);
    folder.write(&args.out).context("cannot write the model")?;
    if global.quiet {
        return Ok(());
    }
    if global.json {
        return print(&serde_json::to_string_pretty(&summary)?);
    }
    print(&table(&learned))?;
    print(&format!("written to {}", args.out.display()))
}

/// Checks that the poses lie in the map's free space.
fn check_poses(
    args: &FitBeamArgs,
    grid: &OccupancyGrid,
    scans: &[(Pose2, LaserScan)],
) -> Result<()> {
    let problem = |expected: String, found: String| {
        Err(Error::Recording { path: args.log.clone(), expected, found })
    };
    if scans.is_empty() {
        return problem("laser scans".into(), "none".into());
    }
    let free =
        |(pose, _): &&(Pose2, LaserScan)| grid.occupancy_at(&pose.position()) == Occupancy::Free;
    let inside = scans.iter().filter(free).count();
    if (inside as f64) < IN_MAP * scans.len() as f64 {
        return problem(
            format!("laser poses in the free space of {}", args.map.display()),
            format!("{inside} of {} there (raw odometry, or another map?)", scans.len()),
        );
    }
    Ok(())
}

/// Checks that the ranges agree with the map.
fn check_ranges(args: &FitBeamArgs, learned: &Learned) -> Result<()> {
    let share = learned.within(NEAR);
    if share >= AGREE {
        return Ok(());
    }
    let expected = format!(
        "at least {:.0} % of the ranges within {NEAR} m of what {} lets expect",
        100.0 * AGREE,
        args.map.display()
    );
    let found = format!("{:.1} %", 100.0 * share);
    Err(Error::Recording { path: args.log.clone(), expected, found })
}

fn summary(args: &FitBeamArgs, learned: &Learned) -> Value {
    let fit = &learned.fit;
    json!({
        "log": args.log.display().to_string(),
        "map": args.map.display().to_string(),
        "scans": learned.scans,
        "scans_outside": learned.outside,
        "beams": learned.pairs.len(),
        "beams_fitted": fit.pairs,
        "within_0.1_m": learned.within(0.1),
        "within_0.5_m": learned.within(NEAR),
        "offset_m": learned.offset(NEAR),
        "start": learned.start,
        "fitted": fit.settings,
        "steps": fit.log_likelihoods.len() - 1,
        "converged": fit.converged,
        "log_likelihoods": fit.log_likelihoods,
    })
}

/// The parameters before and after.
fn table(learned: &Learned) -> String {
    let fit = &learned.fit;
    let mut lines = vec![format!(
        "{} beams of {} scans ({} scans outside)",
        learned.pairs.len(),
        learned.scans,
        learned.outside,
    )];
    let offset = learned.offset(NEAR).unwrap_or(f64::NAN);
    let near = 100.0 * learned.within(0.1);
    lines.push(format!("{near:.1} % within 0.1 m of the map, {offset:+.3} m off in the median"));
    lines.push(format!("{:<20}{:>9}{:>9}", "", "start", "fitted"));
    let start = learned.start.normalized().unwrap_or(learned.start);
    for (name, of) in PARAMETERS {
        lines.push(format!("{name:<20}{:>9.4}{:>9.4}", of(&start), of(&fit.settings)));
    }
    let (first, last) = (fit.log_likelihoods.first(), fit.log_likelihoods.last());
    if let (Some(first), Some(last)) = (first, last) {
        lines.push(format!("{:<20}{first:>9.4}{last:>9.4}", "mean ln p"));
    }
    let steps = fit.log_likelihoods.len() - 1;
    let end = if fit.converged { "converged" } else { "not converged" };
    lines.push(format!("{end} after {steps} steps over {} beams", fit.pairs));
    lines.join("\n")
}

type Parameter = (&'static str, fn(&BeamModelSettings) -> f64);

const PARAMETERS: [Parameter; 7] = [
    ("z_hit", |s| s.z_hit),
    ("z_short", |s| s.z_short),
    ("z_max", |s| s.z_max),
    ("z_rand", |s| s.z_rand),
    ("sigma_hit [m]", |s| s.sigma_hit),
    ("lambda_short [1/m]", |s| s.lambda_short),
    ("max_range [m]", |s| s.max_range),
];

fn name(file: &Path) -> String {
    file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}
