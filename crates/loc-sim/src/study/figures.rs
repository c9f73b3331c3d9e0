//! The figures of a study: accuracy and consistency over the values of each varied setting;
//! without any, over the runs and over time.

use super::{CONFIDENCE, Group, Results, Spread, Study};
use loc_core::stats::{RunningMoments, mean_interval, wilson_interval};
use loc_plot::{Chart, Figure, Role};

/// A figure, ready to be written.
pub(super) struct StudyFigure {
    pub(super) file: String,
    pub(super) caption: &'static str,
    pub(super) svg: String,
}

/// The figures that suit a study.
pub(super) fn all(study: &Study, results: &Results) -> Vec<StudyFigure> {
    let axes = study.grid().axes();
    if results.groups.len() <= study.records().len() {
        return by_run(results);
    }
    let varied = (0..axes.len()).filter(|&k| axes[k].values().len() > 1);
    varied.flat_map(|k| by_setting(study, results, k)).collect()
}

/// The figures over the values of the k-th setting.
fn by_setting(study: &Study, results: &Results, k: usize) -> Vec<StudyFigure> {
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
        &format!("Accuracy in {} over {short}", results.scenario),
        accuracy(&lines),
    )];
    if results.groups.iter().any(|group| group.consistency.nees_mean.is_some()) {
        figures.push(named(
            "consistency",
            "Consistency of the covariances over the values of a setting",
            &format!("Consistency of the covariances over {short}"),
            consistency(&lines),
        ));
    }
    figures
}

fn subtitle(study: &Study, results: &Results, k: usize, pooled: bool) -> String {
    let mut text = format!("{} seeds each, 95 % confidence bands", results.seeds);
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
    let nees = Chart::new("NEES per degree").reference(1.0, "consistent");
    let share = Chart::new("steps in band [%]").reference(95.0, "consistent");
    let band = nis_band(lines);
    let mut nis = Chart::new("NIS per degree").reference(1.0, "consistent");
    if !band.is_empty() {
        nis = nis.band(Role::Reference, "consistent, 95 %", band);
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
fn nis_band(lines: &[GroupLine<'_>]) -> Vec<(f64, f64, f64)> {
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

/// Largest number of lines in a chart; beyond it the other settings are pooled.
const MAX_LINES: usize = 6;

/// One line: its label and the groups at each value of the setting.
struct GroupLine<'a> {
    label: String,
    points: Vec<(f64, Vec<&'a Group>)>,
}

/// The lines over the k-th setting, and whether the other settings had to be pooled.
fn lines<'a>(study: &Study, results: &'a Results, k: usize) -> (Vec<GroupLine<'a>>, bool) {
    let (axes, methods) = (study.grid().axes(), study.records().len());
    let others: usize = study.grid().cells() / axes[k].values().len();
    let pooled = others > 1 && others * methods > MAX_LINES;
    let xs = positions(study, k);
    let mut lines: Vec<GroupLine<'a>> = Vec::new();
    for (index, group) in results.groups.iter().enumerate() {
        let place = study.grid().place(index / methods);
        let mut label = group.method.clone();
        if !pooled {
            for (j, axis) in
                axes.iter().enumerate().filter(|(j, axis)| *j != k && axis.values().len() > 1)
            {
                label += &format!(", {} {}", axis.short_name(), axis.values()[place[j]]);
            }
        }
        let known = lines.iter().position(|line| line.label == label);
        let at = known.unwrap_or_else(|| {
            let points = xs.iter().map(|&x| (x, Vec::new())).collect();
            lines.push(GroupLine { label, points });
            lines.len() - 1
        });
        lines[at].points[place[k]].1.push(group);
    }
    // Values may come in any order; a line runs from left to right.
    for line in &mut lines {
        line.points.sort_by(|a, b| a.0.total_cmp(&b.0));
    }
    (lines, pooled)
}

/// Where the values of the k-th setting stand: at their numbers, or one after the other.
fn positions(study: &Study, k: usize) -> Vec<f64> {
    let axis = &study.grid().axes()[k];
    axis.numbers().unwrap_or_else(|| (1..=axis.values().len()).map(|k| k as f64).collect())
}

/// A value with the range that holds the truth.
#[derive(Clone, Copy)]
struct Ranged {
    value: f64,
    low: f64,
    high: f64,
}

impl Ranged {
    const NONE: Ranged = Ranged { value: f64::NAN, low: f64::NAN, high: f64::NAN };

    /// A mean that cannot be negative, with its interval.
    fn mean(moments: &RunningMoments) -> Self {
        let Some(value) = moments.mean() else { return Ranged::NONE };
        match mean_interval(moments, CONFIDENCE) {
            Ok(Some(i)) => Ranged { value, low: i.start().max(0.0), high: *i.end() },
            _ => Ranged { value, low: value, high: value },
        }
    }

    fn scaled(self, factor: f64) -> Self {
        Ranged { value: factor * self.value, low: factor * self.low, high: factor * self.high }
    }
}

/// The share of successes, in percent.
fn success(groups: &[&Group]) -> Ranged {
    let judged = || groups.iter().filter(|group| group.success_rate.is_some());
    let successes: u64 = judged().map(|group| group.successes).sum();
    let runs: u64 = judged().map(|group| group.judged).sum();
    match wilson_interval(successes, runs, CONFIDENCE) {
        Ok(interval) => {
            let value = successes as f64 / runs as f64;
            Ranged { value, low: *interval.start(), high: *interval.end() }.scaled(100.0)
        }
        Err(_) => Ranged::NONE,
    }
}

/// The mean of a figure over all runs of some groups.
fn spread(groups: &[&Group], figure: fn(&Group) -> Option<Spread>) -> Ranged {
    let mut moments = RunningMoments::new();
    for spread in groups.iter().filter_map(|group| figure(group)) {
        moments.merge(&spread.moments);
    }
    Ranged::mean(&moments)
}

/// The figures of a study that varies only the seed.
fn by_run(results: &Results) -> Vec<StudyFigure> {
    let mut figures: Vec<_> = distribution(results).into_iter().collect();
    figures.extend(nees(results));
    figures.extend(whiteness(results));
    figures
}

/// The share of the runs below each error, with the band of Dvoretzky, Kiefer and Wolfowitz
/// (Massart 1990): all of the true curve lies within it at 95 %.
fn distribution(results: &Results) -> Option<StudyFigure> {
    let mut chart = Chart::new("runs below [%]").y_range(0.0, 100.0);
    let mut any = false;
    for (k, group) in results.groups.iter().enumerate() {
        let mut errors = group.errors.clone();
        errors.sort_by(f64::total_cmp);
        let count = errors.len() as f64;
        let reach = 100.0 * ((2.0 / (1.0 - CONFIDENCE)).ln() / (2.0 * count)).sqrt();
        let mut steps = Vec::with_capacity(2 * errors.len());
        for (below, error) in errors.iter().enumerate() {
            let share = |runs: usize| 100.0 * runs as f64 / count;
            steps.extend([(*error, share(below)), (*error, share(below + 1))]);
        }
        any |= !steps.is_empty();
        let limit = |share: f64| share.clamp(0.0, 100.0);
        let band = steps.iter().map(|(x, y)| (*x, limit(y - reach), limit(y + reach)));
        let role = Role::Method(k);
        chart = chart.band(role, &group.method, band.collect::<Vec<_>>());
        chart = chart.line(role, &group.method, steps);
    }
    let figure =
        Figure::new(format!("Errors of {} over {} seeds", results.scenario, results.seeds))
            .subtitle("share of the runs with an error below, with its 95 % band")
            .x_label("ATE RMSE of a run [m]");
    any.then(|| StudyFigure {
        file: "distribution.svg".into(),
        caption: "Share of the runs with a root mean square error below each value",
        svg: figure.panel(chart).render(),
    })
}

/// The mean NEES over time.
fn nees(results: &Results) -> Option<StudyFigure> {
    let mut chart = Chart::new("mean NEES per degree of freedom");
    let mut band = Vec::new();
    for (k, group) in results.groups.iter().enumerate() {
        let Some(tests) = &group.tests else { continue };
        let steps = tests.nees().steps();
        let last = steps.len().saturating_sub(1).max(1) as f64;
        let time = |step: usize| results.duration_s.unwrap_or(last) * step as f64 / last;
        let means = steps.iter().map(|step| step.mean_per_degree().unwrap_or(f64::NAN));
        let line: Vec<(f64, f64)> = means.enumerate().map(|(k, mean)| (time(k), mean)).collect();
        if line.iter().all(|(_, mean)| mean.is_nan()) {
            continue;
        }
        if band.is_empty() {
            band = steps
                .iter()
                .enumerate()
                .filter_map(|(k, step)| Some((time(k), step.band_per_degree(CONFIDENCE)?)))
                .map(|(time, range)| (time, *range.start(), *range.end()))
                .collect();
        }
        chart = chart.line(Role::Method(k), &group.method, line);
    }
    let any = !band.is_empty();
    chart = chart.band(Role::Reference, "consistent, 95 %", band).reference(1.0, "");
    let figure = Figure::new(format!("Consistency of the covariances in {}", results.scenario))
        .subtitle(format!(
            "{} seeds; above the band is overconfident, below underconfident",
            results.seeds
        ))
        .x_label("time [s]");
    any.then(|| StudyFigure {
        file: "nees.svg".into(),
        caption: "Mean normalised estimation error squared over time, with its 95 % band",
        svg: figure.panel(chart).render(),
    })
}

/// The autocorrelation of the innovations.
fn whiteness(results: &Results) -> Option<StudyFigure> {
    let mut chart = Chart::new("autocorrelation").reference(0.0, "");
    let mut bound: Option<f64> = None;
    for (k, group) in results.groups.iter().enumerate() {
        let rho = &group.consistency.autocorrelation;
        if rho.iter().all(Option::is_none) {
            continue;
        }
        bound = bound.or(group.consistency.whiteness_bound);
        let lags = || rho.iter().enumerate();
        let at = |(lag, rho): (usize, &Option<f64>)| ((lag + 1) as f64, rho.unwrap_or(f64::NAN));
        let role = Role::Method(k);
        chart = chart.points(role.width(7.0), &group.method, lags().map(at));
        chart = chart.line(role.dotted(), "", lags().map(at));
    }
    let bound = bound?;
    let lags = crate::metrics::consistency::LAGS as f64;
    let band = [0.5, lags + 0.5].map(|lag| (lag, -bound, bound));
    chart = chart.band(Role::Reference, "white, 95 %", band);
    let figure = Figure::new(format!("Whiteness of the innovations in {}", results.scenario))
        .subtitle("innovations of a consistent filter are uncorrelated over time")
        .x_label("measurements later");
    Some(StudyFigure {
        file: "whiteness.svg".into(),
        caption: "Autocorrelation of the innovations, with the 95 % bounds of white ones",
        svg: figure.panel(chart).render(),
    })
}
