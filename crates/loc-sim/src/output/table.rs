//! The tables that a run prints: errors of the methods, the lectures' comparison, final beliefs.

use crate::metrics::{Claims, MethodSummary, PlanarErrors, Summary};
use crate::record::{MethodRecord, Run};
use loc_core::kinematics::Kurt2Pose;

/// The columns with their widths.
pub(super) const COLUMNS: [(&str, usize); 8] = [
    ("ATE [m]", 8),
    ("max [m]", 8),
    ("end [m]", 8),
    ("head [deg]", 11),
    ("NEES", 8),
    ("lost", 6),
    ("used", 7),
    ("rejected", 9),
];

/// The least width of the column of the methods; the whole table has then 80 columns.
const METHOD: usize = 15;

/// Hypotheses with smaller shares are not counted in the table.
const LIKELY: f64 = 0.01;

/// How many doubtful spans of a method are printed.
const SPANS: usize = 3;

/// The methods with their errors, 80 columns wide but for methods with long names, without a line
/// break at its end.
pub fn table(summary: &Summary) -> String {
    let mut lines = vec![heading(summary)];
    let longest = summary.methods.iter().map(|(name, _)| name.len() + 1).max();
    let first = longest.unwrap_or(0).max(METHOD);
    let names = COLUMNS.map(|(name, width)| format!("{name:>width$}")).concat();
    lines.push(format!("{:<first$}{names}", "method"));
    lines.extend(summary.methods.iter().map(|(name, method)| row(name, first, method)));
    lines.extend(summary.methods.iter().filter_map(|(name, method)| map_line(name, method)));
    lines.extend(summary.methods.iter().filter_map(|(name, method)| fit_line(name, method)));
    lines.extend(summary.methods.iter().flat_map(|(name, method)| claim_lines(name, method)));
    lines.extend(summary.notes.iter().map(|note| format!("note: {note}")));
    lines.join("\n")
}

/// What was run, in a line.
pub(super) fn heading(summary: &Summary) -> String {
    format!(
        "{}: {}{:.1} s{}",
        summary.source,
        summary.distance_m.map_or(String::new(), |distance| format!("{distance:.1} m in ")),
        summary.duration_s,
        summary.seed.map_or(String::new(), |seed| format!(", seed {seed}")),
    )
}

/// The figures of a method, one for each column.
pub(super) fn cells(method: &MethodSummary) -> [String; COLUMNS.len()] {
    let errors = method.errors.as_ref();
    let cell = |digits: usize, figure: fn(&PlanarErrors) -> Option<f64>| {
        errors.and_then(figure).map_or("-".into(), |figure| format!("{figure:.digits$}"))
    };
    [
        cell(3, |errors| Some(errors.ate_rmse_m)),
        cell(3, |errors| Some(errors.ate_max_m)),
        cell(3, |errors| Some(errors.final_error_m)),
        cell(2, |errors| errors.heading_rmse_deg),
        nees(method),
        method.claims.lost_mean.map_or("-".into(), |lost| format!("{lost:.2}")),
        method.measurements_used.to_string(),
        method.measurements_rejected.to_string(),
    ]
}

/// The mean NEES.
pub(super) fn nees(method: &MethodSummary) -> String {
    method.nees_mean.map_or("-".into(), |nees| match nees {
        // A covariance far too small; its digits would push the columns apart.
        1e4.. => format!("{nees:.0e}"),
        _ => format!("{nees:.2}"),
    })
}

/// The map that a method has drawn, and how far off the robot is in it.
pub(super) fn map_line(name: &str, method: &MethodSummary) -> Option<String> {
    let map = method.landmarks?;
    let (Some(found), Some(extra)) = (map.found, map.extra) else {
        return Some(format!("{name} mapped {} landmarks", map.mapped));
    };
    let rmse = map.rmse_m.map_or(String::new(), |rmse| format!(", off by {rmse:.3} m RMSE"));
    let own = |rmse| format!("\n{name} in the frame of its own map: {rmse:.3} m off the true path");
    let path = map.path_rmse_m.map_or(String::new(), own);
    let extra = if extra > 0 { format!(", {extra} that are none") } else { String::new() };
    Some(format!("{name} found {found} landmarks{rmse}{extra}{path}"))
}

/// How well the last scan fits where the method believes to be, the judge of a recording without
/// true poses.
fn fit_line(name: &str, method: &MethodSummary) -> Option<String> {
    let share = 100.0 * method.beam_fit_at_end?;
    Some(format!("{name}: {share:.1} % of the last scan's beams end within 12 cm of a wall"))
}

/// When a method doubted its own estimate, and whether it was sure of a wrong one.
fn claim_lines(name: &str, method: &MethodSummary) -> Vec<String> {
    let Claims { doubtful_s: doubtful, sure_and_wrong_s: wrong, hypotheses, .. } = &method.claims;
    let mut lines = Vec::new();
    let spans: Vec<String> =
        doubtful.iter().take(SPANS).map(|[from, to]| format!("{from:.1} to {to:.1} s")).collect();
    if !spans.is_empty() {
        let more = doubtful.len() - spans.len();
        let more = match more {
            0 => String::new(),
            1 => " and once later".into(),
            more => format!(" and {more} times later"),
        };
        lines.push(format!("{name}: doubtful from {}{more}", spans.join(", ")));
    }
    let shares: Vec<f64> = hypotheses.iter().map(|hypothesis| hypothesis.share).collect();
    if let [first, second, ..] = shares[..]
        && second >= LIKELY
    {
        let count = shares.iter().filter(|share| **share >= LIKELY).count();
        let shown = if count > 2 { ", .." } else { "" };
        let shares = format!("{first:.2}, {second:.2}{shown}");
        lines.push(format!("{name}: {count} hypotheses at the end, with shares {shares}"));
    }
    if let Some(wrong) = wrong.filter(|wrong| *wrong > 0.0) {
        lines.push(format!("{name}: sure and wrong for {wrong:.1} s"));
    }
    lines
}

fn row(name: &str, first: usize, method: &MethodSummary) -> String {
    let cells = COLUMNS.iter().zip(cells(method));
    let cells: String = cells.map(|((_, width), cell)| format!("{cell:>width$}")).collect();
    format!("{name:<first$}{cells}")
}

/// What the methods believe at the end, a line each: for vehicles on a rail, and in the frame of
/// KURT2 where a scenario asks for it.
pub fn final_beliefs(run: &Run, also_in_frame: Option<&str>) -> Vec<String> {
    let mut lines = Vec::new();
    for record in &run.methods {
        let Some(last) = record.estimates.last() else { continue };
        let method = record.name();
        if let Some(belief) = &last.rail {
            let (x, s) = (belief.mean, belief.covariance);
            lines.push(format!(
                "{method} ends at x = {:.4} m, v = {:.4} m/s, S = [[{:.7}, {:.7}], [., {:.7}]]",
                x.x, x.y, s.m11, s.m12, s.m22
            ));
        } else if also_in_frame == Some("kurt2") {
            let pose = Kurt2Pose::from(last.pose);
            let (x, z) = (100.0 * pose.x, 100.0 * pose.z);
            let theta = pose.theta;
            lines
                .push(format!("{method} ends at x = {x:.2} cm, z = {z:.2} cm, theta = {theta:.3}"));
        }
    }
    lines
}

/// What each method needs and how well it did, at most 80 columns wide, without a line break at its
/// end. Of a method without a start pose, errors count from when it has found the
/// robot.
pub fn comparison(run: &Run, summary: &Summary) -> String {
    let mut lines = vec![heading(summary)];
    lines.push(format!(
        "{:<19}{:<8}{:>9}{:>9}{:>7}  {:<8}{}",
        "method", "start", "found [s]", "ATE [m]", "NEES", "sensor", "map"
    ));
    let rows = run.methods.iter().zip(&summary.methods);
    lines.extend(rows.map(|(record, (name, figures))| comparison_row(run, record, name, figures)));
    lines.extend(summary.methods.iter().filter_map(|(name, method)| map_line(name, method)));
    lines.push("Every method has odometry as well. NEES: 3 where the covariance is honest.".into());
    lines.extend(summary.notes.iter().map(|note| format!("note: {note}")));
    lines.join("\n")
}

fn comparison_row(run: &Run, record: &MethodRecord, name: &str, figures: &MethodSummary) -> String {
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
