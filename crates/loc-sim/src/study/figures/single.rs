//! The figures of a study that varies nothing but the seed.

use super::StudyFigure;
use crate::study::{CONFIDENCE, Results};
use loc_plot::{Chart, Figure, Role};

pub(super) fn all(results: &Results) -> Vec<StudyFigure> {
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
    chart = chart.band(Role::Reference, "honest, 95 %", band).reference(1.0, "");
    let figure = Figure::new(format!("Whether the covariances of {} are honest", results.scenario))
        .subtitle(format!("{} seeds; above the band is too sure, below too timid", results.seeds))
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
    let figure = Figure::new(format!("Whether the innovations of {} are white", results.scenario))
        .subtitle("what was expected wrongly should say nothing about what comes after")
        .x_label("measurements later");
    Some(StudyFigure {
        file: "whiteness.svg".into(),
        caption: "Autocorrelation of the innovations, with the 95 % bounds of white ones",
        svg: figure.panel(chart).render(),
    })
}
