//! How the methods fare over the values of one setting.

use super::StudyFigure;
use super::lines::{GroupLine, Ranged, lines, spread, success};
use crate::study::{Group, Results, Study};
use loc_plot::{Chart, Figure, Role};

/// The figures over the k-th setting.
pub(super) fn all(study: &Study, results: &Results, k: usize) -> Vec<StudyFigure> {
    let axis = &study.grid().axes()[k];
    let (lines, pooled) = lines(study, results, k);
    let named = |prefix: &str, caption: &'static str, title: &str, charts: Vec<Chart>| {
        let letter = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
        let file =
            format!("{prefix}-by-{}.svg", axis.key().chars().map(letter).collect::<String>());
        let mut figure = Figure::new(title).subtitle(subtitle(study, results, k, pooled));
        figure = figure.x_label(x_label(study, k));
        let svg = charts.into_iter().fold(figure, Figure::panel).render();
        StudyFigure { file, caption, svg }
    };
    let short = axis.short_name();
    let mut figures = vec![named(
        "accuracy",
        "Successes, error and time over the values of a setting, with 95 % ranges",
        &format!("How {} fares with {short}", results.scenario),
        accuracy(&lines),
    )];
    if results.groups.iter().any(|group| group.consistency.nees_mean.is_some()) {
        figures.push(named(
            "consistency",
            "Whether covariances are honest over the values of a setting",
            &format!("Whether covariances are honest, over {short}"),
            consistency(&lines),
        ));
    }
    figures
}

fn subtitle(study: &Study, results: &Results, k: usize, pooled: bool) -> String {
    let mut text = format!("{} seeds each, bands hold the truth at 95 %", results.seeds);
    if pooled {
        let axes = study.grid().axes().iter().enumerate().filter(|(j, _)| *j != k);
        let others: Vec<&str> = axes.map(|(_, axis)| axis.short_name()).collect();
        text += &format!("; over all {}", others.join(", "));
    }
    text
}

/// The key; of values that are no numbers also what the places stand for.
fn x_label(study: &Study, k: usize) -> String {
    let axis = &study.grid().axes()[k];
    if axis.numbers().is_some() {
        return axis.key().to_owned();
    }
    let values = axis.values().iter().enumerate().map(|(k, value)| format!("{} {value}", k + 1));
    format!("{}: {}", axis.key(), values.collect::<Vec<_>>().join(", "))
}

fn accuracy(lines: &[GroupLine<'_>]) -> Vec<Chart> {
    let successes = Chart::new("successes [%]");
    vec![
        drawn(successes, lines, success),
        drawn(Chart::new("ATE RMSE [m]"), lines, |groups| spread(groups, |g| g.ate_rmse_m)),
        drawn(Chart::new("time per run [ms]"), lines, |groups| {
            spread(groups, |g| g.runtime_s).scaled(1e3)
        }),
    ]
}

fn consistency(lines: &[GroupLine<'_>]) -> Vec<Chart> {
    let nees = Chart::new("NEES per degree").reference(1.0, "honest");
    let share = Chart::new("steps in band [%]").reference(95.0, "honest");
    let band = honest_nis(lines);
    let mut nis = Chart::new("NIS per degree").reference(1.0, "honest");
    if !band.is_empty() {
        nis = nis.band(Role::Reference, "honest, 95 %", band);
    }
    vec![
        drawn(nees, lines, |groups| {
            mean(groups, |g| {
                let [low, high] = g.consistency.nees_interval.unwrap_or([f64::NAN; 2]);
                Some(Ranged { value: g.consistency.nees_per_degree?, low, high })
            })
        }),
        drawn(share, lines, |groups| {
            mean(groups, |g| Some(alone(100.0 * g.consistency.nees_share_in_band?)))
        }),
        drawn(nis, lines, |groups| mean(groups, |g| Some(alone(g.consistency.nis_per_degree?)))),
    ]
}

/// The band of the first line with one: all have about as many measurements.
fn honest_nis(lines: &[GroupLine<'_>]) -> Vec<(f64, f64, f64)> {
    let bands = lines.iter().map(|line| {
        let points = line.points.iter().filter_map(|(x, groups)| match groups.as_slice() {
            [only] => only.consistency.nis_band.map(|[low, high]| (*x, low, high)),
            _ => None,
        });
        points.collect::<Vec<_>>()
    });
    bands.into_iter().find(|band| !band.is_empty()).unwrap_or_default()
}

fn alone(value: f64) -> Ranged {
    Ranged { value, low: f64::NAN, high: f64::NAN }
}

/// The mean over some groups; a range only where there is one group.
fn mean(groups: &[&Group], figure: impl Fn(&Group) -> Option<Ranged>) -> Ranged {
    let values: Vec<Ranged> = groups.iter().filter_map(|group| figure(group)).collect();
    match values.as_slice() {
        [] => Ranged::NONE,
        [one] => *one,
        several => alone(several.iter().map(|r| r.value).sum::<f64>() / several.len() as f64),
    }
}

/// The lines with their bands, and a dot at each value.
fn drawn(mut chart: Chart, lines: &[GroupLine<'_>], figure: impl Fn(&[&Group]) -> Ranged) -> Chart {
    for (k, line) in lines.iter().enumerate() {
        let points: Vec<(f64, Ranged)> =
            line.points.iter().map(|(x, groups)| (*x, figure(groups))).collect();
        let role = Role::Method(k);
        let band = points.iter().map(|(x, r)| (*x, r.low, r.high));
        chart = chart.band(role, &line.label, band);
        let means = || points.iter().map(|(x, r)| (*x, r.value));
        chart = chart.line(role, &line.label, means()).points(role, &line.label, means());
    }
    chart
}
