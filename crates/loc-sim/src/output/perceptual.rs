//! The figures of a learned perceptual model: the surface `p(measured | expected)` as counted
//! beside the fitted one, and cuts through both.

use super::svg::{Chart, ColorBar, Figure, HeatMap, HeatMaps, Role};
use super::{png, ramp};
use crate::Result;
use crate::perceptual::Learned;
use loc_pf::sensor::beam::{BeamModel, RangeModel};

/// Pixels along the side of a surface.
const PIXELS: usize = 270;

/// The densities that the colours and the cuts show, as powers of ten \[1/m\].
const LOWEST: f64 = -4.0;
const HIGHEST: f64 = 1.0;

/// Expected ranges of the cuts \[m\].
const CUTS: [f64; 6] = [1.0, 2.0, 4.0, 8.0, 16.0, 32.0];

/// Fewer pairs make no curve.
const FEWEST: u64 = 500;

/// From low to high: the map viridis (van der Walt and Smith 2015) at seven places.
const RAMP: [[u8; 3]; 7] = [
    [68, 1, 84],
    [68, 57, 131],
    [49, 104, 142],
    [33, 145, 140],
    [53, 183, 121],
    [144, 215, 67],
    [253, 231, 37],
];

/// Both surfaces as heat maps over the same axes; the strip above is the probability of no return.
///
/// # Errors
/// [`loc_pf::Error`] where the fitted parameters make no model.
pub fn surfaces(learned: &Learned, title: &str) -> Result<String> {
    let counted = learned.histogram.model();
    let fitted = BeamModel::new(&learned.fit.settings)?;
    let reach = reach(learned);
    let width = learned.histogram.width();
    let map = |caption: &str, model: &dyn Fn(f64, f64) -> f64| {
        let at = |k: usize| (k as f64 + 0.5) * reach / PIXELS as f64;
        let rows = (0..PIXELS).rev();
        let pixels = rows.flat_map(|row| (0..PIXELS).map(move |column| (column, row)));
        let density = pixels.map(|(column, row)| color(model(at(column), at(row)) / 10_f64.ln()));
        // A probability is drawn as if spread over one bin.
        let none = |column| model(at(column), f64::INFINITY) - width.ln();
        let strip = (0..PIXELS).map(|column| color(none(column) / 10_f64.ln()));
        HeatMap {
            caption: caption.into(),
            data_uri: png::rgb(&density.collect::<Vec<_>>(), PIXELS),
            strip: Some(png::rgb(&strip.collect::<Vec<_>>(), PIXELS)),
        }
    };
    let bar: Vec<[u8; 3]> =
        (0..256).map(|k| color(LOWEST + (HIGHEST - LOWEST) * f64::from(k) / 255.0)).collect();
    let figure = HeatMaps {
        title: title.into(),
        subtitle: format!("{} beams of {} scans", learned.pairs.len(), learned.scans),
        x_label: "expected range [m]".into(),
        y_label: "measured range [m]".into(),
        x_range: (0.0, reach),
        y_range: (0.0, reach),
        strip_label: "none".into(),
        maps: vec![
            map("measured", &|expected, measured| counted.log_density(expected, measured)),
            map("fitted beam model", &|expected, measured| fitted.log_density(expected, measured)),
        ],
        bar: Some(ColorBar {
            data_uri: png::rgb(&bar, bar.len()),
            low: LOWEST,
            high: HIGHEST,
            name: "log10 of p [1/m]".into(),
        }),
    };
    Ok(figure.render())
}

/// Cuts through both surfaces at a few expected ranges.
///
/// # Errors
/// [`loc_pf::Error`] where the fitted parameters make no model.
pub fn cuts(learned: &Learned, title: &str) -> Result<String> {
    let counted = learned.histogram.model();
    let fitted = BeamModel::new(&learned.fit.settings)?;
    let (reach, width) = (reach(learned), learned.histogram.width());
    let mut figure = Figure::new(title)
        .subtitle("Densities of the measured range where the map lets expect a certain one")
        .x_label("measured range [m]");
    for expected in CUTS.into_iter().filter(|range| *range < reach) {
        let row = learned.histogram.bin(expected).map(|bin| learned.histogram.row(bin));
        let pairs: u64 = row.unwrap_or_default().iter().map(|count| u64::from(*count)).sum();
        if pairs < FEWEST {
            continue;
        }
        // In the middle of a bin there is nothing to interpolate.
        let middle = (expected / width).floor() * width + 0.5 * width;
        let curve = |model: &dyn RangeModel, step: f64| -> Vec<(f64, f64)> {
            let count = (reach / step) as usize;
            let at = |k: usize| (k as f64 + 0.5) * step;
            (0..count).map(|k| (at(k), model.log_density(middle, at(k)).exp())).collect()
        };
        let chart = Chart::new(format!("p [1/m], expected {middle:.2} m ({pairs} beams)"))
            .line(Role::Measurement, "measured", curve(&counted, width))
            .line(Role::Method(0), "fitted beam model", curve(&fitted, 0.2 * width))
            .log_y()
            .y_range(10_f64.powf(LOWEST), 2.0 * 10_f64.powf(HIGHEST));
        figure = figure.panel(chart);
    }
    Ok(figure.render())
}

/// A round range that nearly all pairs lie within \[m\].
fn reach(learned: &Learned) -> f64 {
    let pairs = learned.pairs.iter().map(|pair| pair.expected.min(pair.measured));
    let mut ranges: Vec<f64> = pairs.filter(|range| range.is_finite()).collect();
    let place = (0.99 * ranges.len() as f64) as usize;
    if place >= ranges.len() {
        return learned.histogram.max_range();
    }
    let (_, range, _) = ranges.select_nth_unstable_by(place, f64::total_cmp);
    range.ceil().clamp(1.0, learned.histogram.max_range().max(1.0))
}

/// The colour of a density's power of ten.
fn color(power: f64) -> [u8; 3] {
    ramp::along(&RAMP, (power - LOWEST) / (HIGHEST - LOWEST))
}
