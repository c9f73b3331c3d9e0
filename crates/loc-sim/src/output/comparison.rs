//! The lectures' table of methods, with measured figures.

use super::table::{heading, map_line, nees};
use crate::metrics::{MethodSummary, Summary};
use crate::record::{MethodRecord, Run};

/// What each method needs and how well it did, at most 80 columns wide, without a line break at its
/// end. Of a method that was not told where it starts, errors count from when it has found the
/// robot.
pub fn comparison(run: &Run, summary: &Summary) -> String {
    let mut lines = vec![heading(summary)];
    lines.push(format!(
        "{:<19}{:<8}{:>9}{:>9}{:>7}  {:<8}{}",
        "method", "start", "found [s]", "ATE [m]", "NEES", "sensor", "map"
    ));
    let rows = run.methods.iter().zip(&summary.methods);
    lines.extend(rows.map(|(record, (name, figures))| row(run, record, name, figures)));
    lines.extend(summary.methods.iter().filter_map(|(name, method)| map_line(name, method)));
    lines.push("Every method has odometry as well. NEES: 3 where the covariance is honest.".into());
    lines.extend(summary.notes.iter().map(|note| format!("note: {note}")));
    lines.join("\n")
}

fn row(run: &Run, record: &MethodRecord, name: &str, figures: &MethodSummary) -> String {
    let needs = record.method.needs(&run.setup);
    let (start, found, error) = match record.global {
        false => ("known", None, figures.errors.as_ref().map(|errors| errors.ate_rmse_m)),
        true => ("unknown", figures.converged_at_s, figures.ate_since_converged_m),
    };
    let number = |value: Option<f64>, digits: usize| {
        value.map_or("-".to_owned(), |value| format!("{value:.digits$}"))
    };
    let found = if record.global && found.is_none() { "never".into() } else { number(found, 1) };
    let (error, nees) = (number(error, 3), nees(figures));
    let sensor = needs.sensors;
    format!("{name:<19}{start:<8}{found:>9}{error:>9}{nees:>7}  {sensor:<8}{}", needs.map)
}
