//! A method that calibrates its sensors on the way: what it promises while some of them are silent,
//! and what it believes about their errors.

use super::FigureFile;
use crate::output::svg::{Chart, Figure, Role};
use crate::record::{MethodRecord, Run};
use loc_core::angle;

/// Both figures of the last method that calibrates; none without such a method.
pub(super) fn fusion(run: &Run) -> Vec<FigureFile> {
    let calibrates = |(_, record): &(usize, &MethodRecord)| !record.sensor_errors.is_empty();
    let Some((k, record)) = run.methods.iter().enumerate().rfind(calibrates) else {
        return Vec::new();
    };
    let mut figures = vec![biases(run, k, record)];
    if !run.truth.is_empty() {
        figures.insert(0, errors(run, k, record));
    }
    figures
}

/// The error of each coordinate inside three standard deviations.
fn errors(run: &Run, k: usize, record: &MethodRecord) -> FigureFile {
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
    FigureFile {
        file: "fusion.svg".into(),
        caption: "Error of each coordinate inside three standard deviations, silent sensors shaded"
            .into(),
        svg: marked(run, figure).render(),
    }
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
    FigureFile {
        file: "biases.svg".into(),
        caption: "Errors of the sensors as the method finds them, with two standard deviations"
            .into(),
        svg: marked(run, figure).render(),
    }
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
fn marked(run: &Run, figure: Figure) -> Figure {
    let silences = run.sensor_truth.silences.iter();
    silences.fold(figure, |figure, silence| {
        figure.mark(silence.from - run.setup.start, format!("no {}", silence.sensor))
    })
}
