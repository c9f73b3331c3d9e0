//! Random numbers and what they are worth (F2 to F4).
//!
//! A computer draws evenly between 0 and 1. Four ways lead from there to other distributions: the
//! inverse of a cumulative distribution, the exact method of Box and Muller, and two quick
//! stand-ins for the normal distribution. Each is drawn many times and held against the density
//! that it should have; the shares within one, two and three standard deviations stand beside those
//! of the normal distribution. Two draws that share a part are correlated, and the sample shows by
//! how much.

use super::{Demonstration, check_count};
use crate::Result;
use crate::output::Illustration;
use crate::output::figures::FigureFile;
use loc_core::error::{positive, probability};
use loc_core::random::{ChaCha8Rng, stream};
use loc_core::sampling::{box_muller, inverse_cdf, triangular, twelve_rule};
use loc_plot::{Chart, Figure, Role};
use serde::Deserialize;
use serde_json::json;

/// How much is drawn.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SamplingConfig {
    /// Draws of each kind.
    pub draws: usize,
    /// Standard deviation of the normal distribution and its stand-ins.
    pub sigma: f64,
    /// Correlation of the pairs, in \[0, 1\].
    pub correlation: f64,
}

/// A way to draw, with what came of it.
#[derive(Debug, Clone)]
pub struct Drawn {
    /// Its name.
    pub name: &'static str,
    /// The draws.
    pub values: Vec<f64>,
    /// The density that they should have.
    density: Density,
}

/// Draws of every kind.
#[derive(Debug, Clone)]
pub struct Sampling {
    /// Each kind by itself.
    pub kinds: Vec<Drawn>,
    /// Pairs that share a part.
    pub pairs: Vec<(f64, f64)>,
}

/// Moments of a sample (F2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// Mean.
    pub mean: f64,
    /// Root of the variance.
    pub sigma: f64,
    /// Shares within 1, 2 and 3 standard deviations of the mean (F3).
    pub within: [f64; 3],
}

type Draw = fn(f64, &mut ChaCha8Rng) -> f64;
type Density = fn(f64, f64) -> f64;

/// The ways, by name; with the density at x for a standard deviation.
const KINDS: [(&str, Draw, Density); 4] = [
    ("Box-Muller", |sigma, rng| sigma * box_muller(rng).0, normal),
    ("twelve rule", |sigma, rng| twelve_rule(sigma, rng), normal),
    ("triangular", |sigma, rng| triangular(sigma, rng), triangle),
    ("inverse of the exponential", exponential, exponential_density),
];

fn exponential(sigma: f64, rng: &mut ChaCha8Rng) -> f64 {
    inverse_cdf(|p| -sigma * (-p).ln_1p(), rng)
}

fn exponential_density(x: f64, sigma: f64) -> f64 {
    if x < 0.0 { 0.0 } else { (-x / sigma).exp() / sigma }
}

fn normal(x: f64, sigma: f64) -> f64 {
    (-0.5 * (x / sigma).powi(2)).exp() / (sigma * std::f64::consts::TAU.sqrt())
}

/// The triangle over `+-sqrt(6) sigma`.
fn triangle(x: f64, sigma: f64) -> f64 {
    let half = 6_f64.sqrt() * sigma;
    (1.0 - x.abs() / half).max(0.0) / half
}

/// Bars over +-4 standard deviations.
const BARS: usize = 48;
const REACH: f64 = 4.0;

/// Pairs that are drawn.
const MAX_PAIRS: usize = 1500;

impl SamplingConfig {
    /// Draws everything.
    ///
    /// # Errors
    /// Values out of range.
    pub fn draw(&self, seed: u64) -> Result<Sampling> {
        self.check()?;
        let SamplingConfig { draws, sigma, correlation } = *self;
        let kinds = KINDS.map(|(name, draw, density)| {
            let mut rng = stream(seed, name);
            let values = (0..draws).map(|_| draw(sigma, &mut rng)).collect();
            Drawn { name, values, density }
        });
        let mut rng = stream(seed, "pairs");
        let own = (1.0 - correlation * correlation).sqrt();
        let pairs = (0..draws).map(|_| {
            let (a, b) = box_muller(&mut rng);
            (sigma * a, sigma * (correlation * a + own * b))
        });
        Ok(Sampling { kinds: kinds.into(), pairs: pairs.collect() })
    }

    fn figures(&self, sampling: &Sampling, title: &str) -> Vec<FigureFile> {
        let mut figure = Figure::new(title)
            .subtitle(format!(
                "{} draws of each kind; bars counted, lines as they should be",
                self.draws
            ))
            .x_label("x");
        for kind in &sampling.kinds {
            figure = figure.panel(histogram(kind, self.sigma));
        }
        let pairs = sampling.pairs.iter().take(MAX_PAIRS).copied();
        let given = self.correlation;
        let chart = Chart::new("y").points(Role::Method(0).width(2.5), "", pairs);
        let pairs = Figure::new("Two random numbers that share a part")
            .subtitle(format!(
                "Correlation {:.3} in the sample, {given} in the draw",
                sampling.correlation()
            ))
            .x_label("x")
            .panel(chart);
        let caption = "Histograms of four ways to draw, under the densities they should have";
        vec![
            FigureFile::new("sampling.svg", caption, figure.render()),
            FigureFile::new("correlation.svg", "Pairs of correlated draws", pairs.render()),
        ]
    }
}

impl Demonstration for SamplingConfig {
    fn check(&self) -> Result<()> {
        check_count("demonstration.draws", self.draws, 10_000_000)?;
        positive("demonstration.sigma", self.sigma)?;
        probability("demonstration.correlation", self.correlation)?;
        Ok(())
    }

    fn run(&self, title: &str, seed: u64) -> Result<Illustration> {
        let sampling = self.draw(seed)?;
        let mut lines = vec![format!(
            "{:<28}{:>10}{:>10}{:>9}{:>9}{:>9}",
            "", "mean", "sigma", "within 1", "2", "3 sigma"
        )];
        let exact = Moments { mean: 0.0, sigma: self.sigma, within: [0.6827, 0.9545, 0.9973] };
        lines.push(exact.line("normal distribution"));
        lines.extend(sampling.kinds.iter().map(|kind| kind.moments().line(kind.name)));
        let correlation = sampling.correlation();
        let given = self.correlation;
        lines.push(format!("correlation of the pairs: {correlation:.4}, drawn with {given}"));
        let kinds = sampling.kinds.iter().map(|kind| {
            let Moments { mean, sigma, within } = kind.moments();
            json!({"name": kind.name, "mean": mean, "sigma": sigma, "within": within})
        });
        let kinds: Vec<_> = kinds.collect();
        let summary = json!({"draws": self.draws, "kinds": kinds, "correlation": correlation});
        Ok(Illustration::new(lines, summary, self.figures(&sampling, title)))
    }
}

impl Sampling {
    /// The correlation of the pairs (F2).
    pub fn correlation(&self) -> f64 {
        let count = self.pairs.len() as f64;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| self.pairs.iter().map(of).sum::<f64>() / count;
        let (x, y) = (mean(&|pair| pair.0), mean(&|pair| pair.1));
        let covariance = mean(&|pair| (pair.0 - x) * (pair.1 - y));
        let variances = mean(&|pair| (pair.0 - x).powi(2)) * mean(&|pair| (pair.1 - y).powi(2));
        covariance / variances.sqrt()
    }
}

impl Drawn {
    /// Mean, deviation and shares.
    pub fn moments(&self) -> Moments {
        let count = self.values.len() as f64;
        let mean = self.values.iter().sum::<f64>() / count;
        let square = self.values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / count;
        let sigma = square.sqrt();
        let share = |times: f64| {
            let near = self.values.iter().filter(|x| (**x - mean).abs() <= times * sigma);
            near.count() as f64 / count
        };
        Moments { mean, sigma, within: [share(1.0), share(2.0), share(3.0)] }
    }
}

impl Moments {
    fn line(&self, name: &str) -> String {
        let [one, two, three] = self.within;
        let Moments { mean, sigma, .. } = self;
        format!("{name:<28}{mean:>10.4}{sigma:>10.4}{one:>9.4}{two:>9.4}{three:>9.4}")
    }
}

fn histogram(kind: &Drawn, sigma: f64) -> Chart {
    let width = 2.0 * REACH * sigma / BARS as f64;
    let middle = |bar: usize| (bar as f64 + 0.5) * width - REACH * sigma;
    let mut counts = [0_u32; BARS];
    for value in &kind.values {
        let place = ((value + REACH * sigma) / width).floor();
        if (0.0..BARS as f64).contains(&place) {
            counts[place as usize] += 1;
        }
    }
    let scale = 1.0 / (width * kind.values.len() as f64);
    let counted = (0..BARS).map(|bar| (middle(bar), f64::from(counts[bar]) * scale));
    let chart = Chart::new(format!("density, {}", kind.name));
    let chart = chart.bars(Role::Method(0), "", width, counted);
    let points = (0..=400).map(|k| (f64::from(k) / 200.0 - 1.0) * REACH * sigma);
    let density = kind.density;
    chart.line(Role::Truth, "", points.map(|x| (x, density(x, sigma))))
}
