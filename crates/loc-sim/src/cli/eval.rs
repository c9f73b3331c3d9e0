//! `loc-sim eval` computes the errors of one TUM file against another.

use crate::metrics::evaluate;
use crate::metrics::{Alignment, EvalSettings, Evaluation, SpatialTrajectory, Statistics};
use std::path::PathBuf;

/// Compare an estimated trajectory with a reference, both TUM files.
///
/// Gives the absolute and the relative pose error, as evo_ape and evo_rpe do.
#[derive(Debug, Clone, clap::Args)]
pub struct EvalArgs {
    /// The estimated trajectory.
    #[arg(value_name = "ESTIMATE.tum")]
    pub estimate: PathBuf,
    /// The reference trajectory.
    #[arg(value_name = "REFERENCE.tum")]
    pub reference: PathBuf,
    /// How the estimate is aligned with the frame of the reference.
    #[arg(long, value_enum, default_value_t)]
    pub align: Alignment,
    /// Largest time difference of two paired poses, in seconds.
    #[arg(long, value_name = "S", default_value_t = EvalSettings::default().max_dt,
          value_parser = duration, allow_negative_numbers = true)]
    pub max_dt: f64,
}

/// Reads both files, compares them and prints the figures.
///
/// # Errors
/// Those of [`SpatialTrajectory::read_tum`] and [`evaluate`], and of standard output.
pub fn run(args: &EvalArgs, global: &super::Global) -> anyhow::Result<()> {
    let estimate = SpatialTrajectory::read_tum(&args.estimate)?;
    let reference = SpatialTrajectory::read_tum(&args.reference)?;
    let settings = EvalSettings { align: args.align, max_dt: args.max_dt };
    let evaluation = evaluate(&estimate, &reference, &settings)?;
    if global.quiet {
        return Ok(());
    }
    if global.json {
        super::print(&serde_json::to_string_pretty(&evaluation)?)
    } else {
        super::print(&table(&evaluation))
    }
}

fn duration(text: &str) -> Result<f64, String> {
    let seconds = text.parse::<f64>().map_err(|error| error.to_string())?;
    loc_core::error::non_negative("max-dt [s]", seconds).map_err(|error| error.to_string())
}

/// The figures as a small table, without a line break at its end.
fn table(evaluation: &Evaluation) -> String {
    let Evaluation { pairs, align, max_dt_s, .. } = evaluation;
    let rows = [
        ("ape", Some(&evaluation.ape)),
        ("ape_rot", Some(&evaluation.ape_rot)),
        ("rpe_trans", evaluation.rpe_trans.as_ref()),
        ("rpe_rot", evaluation.rpe_rot.as_ref()),
    ];
    let mut lines =
        vec![format!("{pairs} pairs within {max_dt_s} s, alignment {}", align.name()), heading()];
    lines.extend(rows.map(|(name, figures)| row(name, figures)));
    lines.join("\n")
}

fn heading() -> String {
    let names = ["rmse", "mean", "median", "std", "min", "max", "sse"];
    let cells = names.map(|name| format!(" {name:>12}")).concat();
    format!("{:<15}{cells}", "")
}

fn row(name: &str, figures: Option<&Statistics>) -> String {
    let Some(s) = figures else {
        return format!("{name:<15} {:>12}", "-");
    };
    let cells = [s.rmse, s.mean, s.median, s.std, s.min, s.max, s.sse]
        .map(|value| format!(" {value:>12.6}"))
        .concat();
    format!("{name:<9} {:<5}{cells}", s.unit.symbol())
}
