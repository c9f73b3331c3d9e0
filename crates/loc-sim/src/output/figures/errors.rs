//! Errors over time, alone and beside what the covariances promise.

use super::FigureFile;
use crate::output::svg::{Chart, Figure, Role};
use crate::record::{MethodRecord, Run};
use loc_core::{angle, stats};

/// Lines of more methods than this are drawn as means over windows: single values hide each other.
const FEW: usize = 4;

/// Windows over a run of many methods.
const WINDOWS: usize = 150;

/// Position error, heading error and NEES of every method; of particles and grids also the spread.
pub(super) fn errors(run: &Run) -> FigureFile {
    let window = if run.methods.len() > FEW { run.truth.len().div_ceil(WINDOWS) } else { 1 };
    let searches = |r: &MethodRecord| !r.snapshots.is_empty() || !r.beliefs.is_empty();
    let searching = run.methods.iter().any(searches);
    // A method that searches is first lost by many metres, then right by centimetres.
    let chart = |name: &str| if searching { Chart::new(name).log_y() } else { Chart::new(name) };
    let mut position = chart("position error [m]");
    let mut heading = chart("heading error [deg]");
    let mut spread = chart("spread of the position, 1 sigma [m]");
    let mut nees = Chart::new("NEES").log_y();
    for (k, record) in run.methods.iter().enumerate() {
        let (role, name) = (Role::Method(k), &record.name());
        let means = |value: &dyn Fn(usize) -> Option<f64>, power: f64| -> Vec<(f64, f64)> {
            let windows = (0..run.truth.len()).step_by(window);
            let indices = |from: usize| from..(from + window).min(run.truth.len());
            let value = |i: usize| value(i).unwrap_or(f64::NAN);
            windows.map(|from| (time(run, from), mean(indices(from).map(value), power))).collect()
        };
        // Root mean squares, but of what is a square already.
        let over_time = |value: &dyn Fn(usize) -> Option<f64>| means(value, 2.0);
        let truth = |i: usize| run.truth[i].value.pose;
        let estimate = |i: usize| record.estimates[i];
        let distance = |i: usize| Some(estimate(i).pose.distance(truth(i)));
        position = position.line(role, name, over_time(&distance));
        let turn = |i: usize| {
            let turn = angle::difference(estimate(i).pose.theta, truth(i).theta).to_degrees();
            // A logarithm needs a size, and something to show of 0.
            Some(if searching { turn.abs().max(0.01) } else { turn })
        };
        heading = heading.line(role, name, over_time(&turn));
        let sigma =
            |i: usize| Some((estimate(i).covariance?.fixed_view::<2, 2>(0, 0).trace()).sqrt());
        spread = spread.line(role, name, over_time(&sigma));
        let squared =
            |i: usize| Some(run.nees(&estimate(i), truth(i))?.1).filter(|nees| *nees > 1e-6);
        nees = nees.line(role, name, means(&squared, 1.0));
    }
    if !searching {
        heading = heading.reference(0.0, "");
    }
    if let Ok(limit) = stats::chi_square_quantile(if run.truth_has_heading { 3 } else { 2 }, 0.95) {
        nees = nees.reference(limit, "95 % of honest ones are below");
    }
    let of_what = match window {
        1 => run.setup.name.clone(),
        _ => format!("{}, means over windows of {:.1} s", run.setup.name, time(run, window)),
    };
    let mut figure = Figure::new("Errors over time").subtitle(of_what);
    figure = figure.x_label("time [s]").panel(position);
    if run.truth_has_heading {
        figure = figure.panel(heading);
    }
    if searching {
        figure = figure.panel(spread);
    }
    FigureFile {
        file: "errors.svg".into(),
        caption: "Position error, heading error and NEES over time".into(),
        svg: with_kidnapping(run, figure.panel(nees)).render(),
    }
}

/// The mean of powers, as a value; a single value stays as it is, sign included.
fn mean(mut values: impl ExactSizeIterator<Item = f64>, power: f64) -> f64 {
    let count = values.len() as f64;
    if values.len() == 1 {
        return values.next().unwrap_or(f64::NAN);
    }
    let known = values.filter(|value| value.is_finite());
    let (sum, known) = known.fold((0.0, 0.0), |(s, n), v| (s + v.abs().powf(power), n + 1.0));
    // Of a window that is mostly unknown nothing is told.
    if 2.0 * known < count { f64::NAN } else { (sum / known).powf(1.0 / power) }
}

/// The moment of a kidnapping, marked.
fn with_kidnapping(run: &Run, figure: Figure) -> Figure {
    match run.setup.kidnapped_at {
        Some(at) => figure.mark(at - run.setup.start, "kidnapped"),
        None => figure,
    }
}

/// The error of each coordinate of the last method, inside the band of two standard deviations.
pub(super) fn consistency(run: &Run) -> Option<FigureFile> {
    let (k, record) = run.methods.iter().enumerate().next_back()?;
    record.estimates.first()?.covariance?;
    let mut figure = Figure::new(format!("What {} promises, and what it keeps", record.name()))
        .subtitle("errors inside 2 standard deviations")
        .x_label("time [s]");
    for (coordinate, label) in
        ["x error [m]", "y error [m]", "heading error [deg]"].iter().enumerate()
    {
        if coordinate == 2 && !run.truth_has_heading {
            continue;
        }
        let unit = if coordinate == 2 { 1_f64.to_degrees() } else { 1.0 };
        let role = Role::Method(k);
        let (band, error) =
            (band(run, record, coordinate, unit), error(run, record, coordinate, unit));
        let mut chart = Chart::new(*label).reference(0.0, "");
        if let Some(limit) = usual(&band, &error) {
            chart = chart.y_range(-limit, limit);
        }
        chart = chart.band(role, "2 sigma", band).line(role, &record.name(), error);
        figure = figure.panel(chart);
    }
    Some(FigureFile {
        file: "consistency.svg".into(),
        caption: "Error of each coordinate inside two standard deviations".into(),
        svg: with_kidnapping(run, figure).render(),
    })
}

/// The range to show, where a few moments of a lost robot would leave no room for all others: a
/// little more than what nine of ten moments need.
fn usual(band: &[(f64, f64, f64)], error: &[(f64, f64)]) -> Option<f64> {
    let pairs = band.iter().zip(error);
    let mut sizes: Vec<f64> = pairs.map(|(band, error)| band.2.max(error.1.abs())).collect();
    sizes.retain(|size| size.is_finite());
    sizes.sort_by(f64::total_cmp);
    let (most, usual) = (sizes.last()?, sizes[sizes.len() * 9 / 10]);
    (*most > 4.0 * usual && usual > 0.0).then_some(1.3 * usual)
}

fn band(run: &Run, record: &MethodRecord, i: usize, unit: f64) -> Vec<(f64, f64, f64)> {
    let sigma = |k: usize| record.estimates[k].covariance.map_or(f64::NAN, |s| s[(i, i)].sqrt());
    let triple = |k| (time(run, k), -2.0 * unit * sigma(k), 2.0 * unit * sigma(k));
    (0..run.truth.len()).map(triple).collect()
}

fn error(run: &Run, record: &MethodRecord, i: usize, unit: f64) -> Vec<(f64, f64)> {
    let deviation = |k: usize| {
        let (estimate, truth) = (record.estimates[k].pose, run.truth[k].value.pose);
        let mut deviation = estimate.to_vector() - truth.to_vector();
        deviation.z = angle::wrap(deviation.z);
        unit * deviation[i]
    };
    (0..run.truth.len()).map(|k| (time(run, k), deviation(k))).collect()
}

/// Time since the start of the run \[s\].
fn time(run: &Run, index: usize) -> f64 {
    run.truth[index].stamp - run.setup.start
}
