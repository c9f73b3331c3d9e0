//! Errors over time, alone and beside what the covariances promise; for a method that calibrates its
//! sensors also while some of them are silent, with its estimates of their errors.

use super::FigureFile;
use crate::record::{MethodRecord, Run};
use loc_core::{angle, stats};
use loc_plot::{Chart, Figure, Role};

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
    FigureFile::new(
        "errors.svg",
        "Position error, heading error and NEES over time",
        with_kidnapping(run, figure.panel(nees)).render(),
    )
}

/// The mean of powers, as a value; a single value stays as it is, sign included.
fn mean(mut values: impl ExactSizeIterator<Item = f64>, power: f64) -> f64 {
    let count = values.len() as f64;
    if values.len() == 1 {
        return values.next().unwrap_or(f64::NAN);
    }
    let known = values.filter(|value| value.is_finite());
    let (sum, known) = known.fold((0.0, 0.0), |(s, n), v| (s + v.abs().powf(power), n + 1.0));
    // A window that is mostly unknown has no mean.
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
    Some(FigureFile::new(
        "consistency.svg",
        "Error of each coordinate inside two standard deviations",
        with_kidnapping(run, figure).render(),
    ))
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

/// Both figures of the last method that calibrates; none without such a method.
pub(super) fn fusion(run: &Run) -> Vec<FigureFile> {
    let calibrates = |(_, record): &(usize, &MethodRecord)| !record.sensor_errors.is_empty();
    let Some((k, record)) = run.methods.iter().enumerate().rfind(calibrates) else {
        return Vec::new();
    };
    let mut figures = vec![biases(run, k, record)];
    if !run.truth.is_empty() {
        figures.insert(0, fusion_errors(run, k, record));
    }
    figures
}

/// The error of each coordinate inside three standard deviations.
fn fusion_errors(run: &Run, k: usize, record: &MethodRecord) -> FigureFile {
    let mut figure = Figure::new(format!("{} while sensors fall silent", record.name()))
        .subtitle("errors inside 3 standard deviations")
        .x_label("time [s]");
    let names = ["x error [m]", "y error [m]", "heading error [deg]"];
    let shown = if run.truth_has_heading { 3 } else { 2 };
    for (i, name) in names.into_iter().enumerate().take(shown) {
        let unit = if i == 2 { 1_f64.to_degrees() } else { 1.0 };
        let (mut error, mut band) = (Vec::new(), Vec::new());
        for (truth, estimate) in run.truth.iter().zip(&record.estimates) {
            let time = truth.stamp - run.setup.start;
            let mut off = estimate.pose.to_vector() - truth.value.pose.to_vector();
            off.z = angle::wrap(off.z);
            let sigma = estimate.covariance.map_or(f64::NAN, |s| s[(i, i)].max(0.0).sqrt());
            error.push((time, unit * off[i]));
            band.push((time, -3.0 * unit * sigma, 3.0 * unit * sigma));
        }
        // The first moments, when little is known, would leave no room for all others.
        let settled = band.iter().skip(band.len() / 20).map(|(.., high)| *high);
        let sizes = error.iter().skip(error.len() / 20).map(|(_, error)| error.abs());
        let most = 1.1 * settled.chain(sizes).filter(|v| v.is_finite()).fold(1e-6, f64::max);
        let chart = silent(run, Chart::new(name).y_range(-most, most), -most, most);
        let chart = chart.band(Role::Method(k), "3 sigma", band).reference(0.0, "");
        figure = figure.panel(chart.line(Role::Method(k), &record.name(), error));
    }
    FigureFile::new(
        "fusion.svg",
        "Error of each coordinate inside three standard deviations, silent sensors shaded",
        with_silences(run, figure).render(),
    )
}

/// What the method believes about each error, inside two standard deviations.
fn biases(run: &Run, k: usize, record: &MethodRecord) -> FigureFile {
    let mut figure = Figure::new("Errors of the sensors, found on the way")
        .subtitle("with 2 standard deviations")
        .x_label("time [s]");
    let all = record.sensor_errors.iter().max_by_key(|errors| errors.len());
    for known in all.into_iter().flatten() {
        let (mut line, mut band) = (Vec::new(), Vec::new());
        for (stamp, errors) in run.stamps.iter().zip(&record.sensor_errors) {
            let time = stamp - run.setup.start;
            let found = errors.iter().find(|error| error.name == known.name);
            let Some(error) = found else { continue };
            line.push((time, error.mean));
            band.push((time, error.mean - 2.0 * error.sigma, error.mean + 2.0 * error.sigma));
        }
        let chart = Chart::new(known.name).band(Role::Method(k), "2 sigma", band);
        let mut chart = chart.line(Role::Method(k), &record.name(), line);
        let truth = run.sensor_truth.errors.iter().find(|error| error.name == known.name);
        if let Some(truth) = truth {
            let start = run.setup.start;
            let values = truth.values.iter().map(|(stamp, value)| (stamp - start, *value));
            chart = chart.line(Role::Truth.dotted(), "truth", values);
        }
        figure = figure.panel(chart);
    }
    FigureFile::new(
        "biases.svg",
        "Errors of the sensors as the method finds them, with two standard deviations",
        with_silences(run, figure).render(),
    )
}

/// The longest silence, shaded.
fn silent(run: &Run, chart: Chart, low: f64, high: f64) -> Chart {
    let length = |silence: &&crate::source::Silence| silence.to - silence.from;
    let silences = run.sensor_truth.silences.iter();
    let Some(longest) = silences.max_by(|a, b| length(a).total_cmp(&length(b))) else {
        return chart;
    };
    let start = run.setup.start;
    let band = [longest.from, longest.to].map(|stamp| (stamp - start, low, high));
    chart.band(Role::Reference, &format!("no {}", longest.sensor), band)
}

/// The begin of every silence, marked.
fn with_silences(run: &Run, figure: Figure) -> Figure {
    let silences = run.sensor_truth.silences.iter();
    silences.fold(figure, |figure, silence| {
        figure.mark(silence.from - run.setup.start, format!("no {}", silence.sensor))
    })
}
