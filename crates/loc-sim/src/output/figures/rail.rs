//! The four plots of a vehicle on a rail (G3, G4): the drive, the densities at the end, and the
//! accuracy of position and speed with and without corrections.

use super::FigureFile;
use crate::localizer::Method;
use crate::record::{MethodRecord, Run};
use loc_core::{Gaussian, Normal};
use loc_filters::localizer::Estimate;
use loc_plot::{Chart, Figure, Role};
use loc_sensors::event::Measurement;

pub(super) fn all(run: &Run, title: &str) -> Vec<FigureFile> {
    vec![drive(run, title), density(run), accuracy(run)]
}

/// Position and speed over time, with two standard deviations.
fn drive(run: &Run, title: &str) -> FigureFile {
    let mut position = Chart::new("position [m]");
    let mut speed = Chart::new("speed [m/s]");
    for (k, record) in run.methods.iter().enumerate() {
        let (role, name) = (Role::Method(k), &record.name());
        position = position.band(role, name, band(run, record, 0));
        position = position.line(role, name, beliefs(run, record).map(|(t, b)| (t, b.mean.x)));
        speed = speed.band(role, name, band(run, record, 1));
        speed = speed.line(role, name, beliefs(run, record).map(|(t, b)| (t, b.mean.y)));
    }
    let truth = run.truth.iter();
    position =
        position.line(Role::Truth.dotted(), "truth", truth.map(|t| (t.stamp, t.value.pose.x)));
    let truth = run.truth.iter();
    let true_speed = truth.map(|t| (t.stamp, t.value.speed.unwrap_or(f64::NAN)));
    speed = speed.line(Role::Truth.dotted(), "truth", true_speed);
    let figure = Figure::new(title).subtitle("with 2 standard deviations").x_label("time [s]");
    FigureFile::new(
        "rail.svg",
        "Position and speed over time, with two standard deviations",
        figure.panel(position).panel(speed).render(),
    )
}

/// The densities of the position at the end: prediction, readings, corrected belief.
fn density(run: &Run) -> FigureFile {
    let mut chart = Chart::new("density [1/m]");
    let mut peak = 0.0_f64;
    let end = run.truth.last().map_or(0.0, |truth| truth.stamp);
    for (k, record) in run.methods.iter().enumerate() {
        let belief = record.estimates.last().and_then(|estimate| estimate.rail);
        if let Some(normal) = belief.and_then(|b| normal(b.mean.x, b.covariance.m11)) {
            peak = peak.max(normal.density(normal.mean()));
            chart = chart.line(Role::Method(k), &record.name(), bell(&normal));
        }
    }
    let upright = |at: f64| [(at, 0.0), (at, peak)];
    for reading in readings(run, end) {
        chart = chart.line(Role::Measurement, "reading", upright(reading));
    }
    if let Some(truth) = run.truth.last() {
        chart = chart.line(Role::Truth.dotted(), "true position", upright(truth.value.pose.x));
    }
    let figure = Figure::new(format!("Where the methods believe to be after {end:.1} s"));
    FigureFile::new(
        "density.svg",
        "Densities of the position at the end",
        figure.x_label("position [m]").panel(chart).render(),
    )
}

/// Standard deviations over time.
fn accuracy(run: &Run) -> FigureFile {
    let mut position = Chart::new("position, 1 sigma [m]");
    let mut speed = Chart::new("speed, 1 sigma [m/s]");
    for (k, record) in run.methods.iter().enumerate() {
        let (role, name) = (Role::Method(k), &record.name());
        let sigma = |b: &Gaussian<2>, i: usize| b.covariance[(i, i)].sqrt();
        position = position.line(role, name, beliefs(run, record).map(|(t, b)| (t, sigma(b, 0))));
        speed = speed.line(role, name, beliefs(run, record).map(|(t, b)| (t, sigma(b, 1))));
    }
    let always = corrected_at_every_step(run);
    let role = Role::Reference.dashed();
    let label = "corrected at every step";
    let line = |i: usize| always.iter().map(move |(t, b)| (*t, b.covariance[(i, i)].sqrt()));
    position = position.line(role, label, line(0));
    speed = speed.line(role, label, line(1));
    let figure = Figure::new("Accuracy with and without corrections").x_label("time [s]");
    FigureFile::new(
        "accuracy.svg",
        "Standard deviations of position and speed over time",
        figure.panel(position).panel(speed).render(),
    )
}

/// What the Kalman filter would believe if every sensor read at every step. Its covariance does
/// not depend on the readings, so that any will do.
fn corrected_at_every_step(run: &Run) -> Vec<(f64, Gaussian<2>)> {
    let mut beliefs = Vec::new();
    let Ok(mut kf) = Method::Kf.start(&run.setup, &run.settings) else { return beliefs };
    for truth in &run.truth {
        if truth.stamp > run.setup.start {
            for sensor in 0..run.settings.rail.sensor_sigmas.len() {
                let position = truth.value.pose.x;
                let reading = Measurement::RailPosition { sensor, position };
                if kf.correct(truth.stamp, &reading).is_err() {
                    return beliefs;
                }
            }
        }
        let belief = kf.estimate(truth.stamp).ok().and_then(|estimate| estimate.rail);
        beliefs.extend(belief.map(|belief| (truth.stamp, belief)));
    }
    beliefs
}

fn beliefs<'a>(
    run: &'a Run,
    record: &'a MethodRecord,
) -> impl Iterator<Item = (f64, &'a Gaussian<2>)> {
    let pairs = run.truth.iter().zip(&record.estimates);
    pairs.filter_map(|(truth, Estimate { rail, .. })| Some((truth.stamp, rail.as_ref()?)))
}

fn band(run: &Run, record: &MethodRecord, i: usize) -> Vec<(f64, f64, f64)> {
    let limits = |(t, b): (f64, &Gaussian<2>)| {
        let reach = 2.0 * b.covariance[(i, i)].sqrt();
        (t, b.mean[i] - reach, b.mean[i] + reach)
    };
    beliefs(run, record).map(limits).collect()
}

/// What the sensors read at the end.
fn readings(run: &Run, end: f64) -> Vec<f64> {
    let outcomes = run.methods.iter().map(|record| &record.outcomes);
    let most = outcomes.max_by_key(|outcomes| outcomes.len());
    let last = most.into_iter().flatten().filter(|outcome| outcome.stamp >= end);
    last.filter_map(|outcome| outcome.value.observed_at).map(|place| place.x).collect()
}

/// `None` for a belief that is certain and has no density.
fn normal(mean: f64, variance: f64) -> Option<Normal> {
    Normal::new(mean, variance.sqrt()).ok()
}

fn bell(normal: &Normal) -> Vec<(f64, f64)> {
    let points = -120..=120;
    let at = |k: i32| normal.mean() + normal.sigma() * f64::from(k) / 30.0;
    points.map(|k| (at(k), normal.density(at(k)))).collect()
}
