//! Consistency of an estimator: whether its errors agree with the covariance that it reports.
//!
//! Three tests check this (Bar-Shalom, Li and Kirubarajan 2001, section 5.4):
//!
//! * **NEES**: the errors of the state, each normalised by the covariance that was claimed for it,
//!   are chi-square distributed. The truth must be known, so this is a test for simulations, best
//!   over many runs: [`NeesEnsemble`].
//! * **NIS**: so are the innovations, measurement by measurement, and these need no truth:
//!   [`ChiSquareTally`].
//! * **Whiteness**: the innovations of a consistent filter are not correlated in time:
//!   [`Whiteness`].
//!
//! ```
//! use loc_core::stats::consistency::NeesEnsemble;
//! // Two runs of three steps; each error squared has 3 degrees of freedom.
//! let mut ensemble = NeesEnsemble::new(0.95)?;
//! ensemble.push_run([(3, 2.0), (3, 3.5), (3, 2.5)].map(Some))?;
//! ensemble.push_run([(3, 4.0), (3, 3.1), (3, 30.0)].map(Some))?;
//! // The mean of the third step, 16.25, is more than chance explains.
//! assert_eq!(ensemble.share_in_band(), Some(2.0 / 3.0));
//! # Ok::<(), loc_core::Error>(())
//! ```

use super::chi_square::{check_confidence, chi_square_interval, mean_band};
use super::{RunningMoments, mean_interval};
use crate::error::{finite, non_negative, positive};
use crate::{Error, Gaussian, Normal, Result};
use nalgebra::{SMatrix, SVector};
use std::ops::RangeInclusive;

/// Normalised estimation error squared, `e^T P^-1 e`, of an error vector (angles wrapped) and the
/// covariance that the estimator claims. The same of an innovation and its covariance is the NIS.
///
/// Chi-square distributed with `N` degrees of freedom where the claim is right.
///
/// # Errors
/// [`Error::OutOfRange`] for an error that is not finite, [`Error::NotACovariance`] for a
/// covariance that is singular or not finite.
pub fn nees<const N: usize>(
    error: &SVector<f64, N>,
    covariance: &SMatrix<f64, N, N>,
) -> Result<f64> {
    for &value in error.iter() {
        finite("estimation error", value)?;
    }
    let claimed = Gaussian { mean: SVector::zeros(), covariance: *covariance };
    claimed.deviation_squared(error)
}

/// Autocorrelation of a sequence with itself `lag` elements later, in \[-1, 1\]:
/// `sum (x_t - m) (x_(t+lag) - m) / sum (x_t - m)^2` with the mean m.
///
/// The innovations of an optimal filter are white: at every lag above 0 this is 0 up to chance,
/// see [`whiteness_bound`]. That their mean is 0 is a test of its own.
///
/// # Errors
/// [`Error::Length`] where the sequence has no more than `lag` elements, [`Error::OutOfRange`] for
/// numbers that are not finite, and for a sequence that does not vary.
pub fn autocorrelation(sequence: &[f64], lag: usize) -> Result<f64> {
    if sequence.len() <= lag {
        return Err(Error::Length {
            what: "sequence",
            expected: "more elements than the lag",
            found: sequence.len(),
        });
    }
    let moments = RunningMoments::of(sequence.iter().copied())?;
    let mean = moments.mean().unwrap_or_default();
    let variance = moments.population_variance().unwrap_or_default();
    let sum_of_squares = positive("variance of the sequence", variance)? * sequence.len() as f64;
    let products = sequence.iter().zip(&sequence[lag..]);
    let sum: f64 = products.map(|(a, b)| (a - mean) * (b - mean)).sum();
    Ok(sum / sum_of_squares)
}

/// How far from 0 the [`autocorrelation`] of a white sequence of `count` elements lies at most,
/// with probability `confidence`: the normal quantile by `sqrt(count)`, good for `count` above
/// about 30.
///
/// # Errors
/// [`Error::Length`] for an empty sequence, [`Error::OutOfRange`] for a `confidence` outside
/// \[0, 1).
pub fn whiteness_bound(count: usize, confidence: f64) -> Result<f64> {
    let confidence = check_confidence(confidence)?;
    if count == 0 {
        return Err(Error::Length { what: "sequence", expected: "at least 1", found: 0 });
    }
    Ok(Normal::STANDARD.quantile(0.5 + 0.5 * confidence)? / (count as f64).sqrt())
}

/// Normalised squared errors (NIS, NEES) of any degrees of freedom, compared with the
/// chi-square distribution.
///
/// ```
/// use loc_core::stats::consistency::ChiSquareTally;
/// let mut nis = ChiSquareTally::new(0.95)?;
/// for (dof, value) in [(2, 1.4), (2, 3.1), (1, 0.2), (2, 12.0)] {
///     nis.push(dof, value)?;
/// }
/// assert_eq!(nis.mean_per_degree(), Some(16.7 / 7.0));
/// assert_eq!(nis.share_inside(), Some(0.75)); // 12 is too much for 2 numbers
/// # Ok::<(), loc_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct ChiSquareTally {
    confidence: f64,
    count: u64,
    freedom: u64,
    sum: f64,
    inside: u64,
    /// The interval of each number of degrees that has come.
    #[cfg_attr(feature = "serde", serde(skip))]
    intervals: Vec<(usize, RangeInclusive<f64>)>,
}

impl ChiSquareTally {
    /// An empty tally; single values are compared with the interval that holds the share
    /// `confidence` of them.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a `confidence` outside \[0, 1).
    pub fn new(confidence: f64) -> Result<Self> {
        let confidence = check_confidence(confidence)?;
        let intervals = Vec::new();
        Ok(ChiSquareTally { confidence, count: 0, freedom: 0, sum: 0.0, inside: 0, intervals })
    }

    /// Counts a value of `dof` degrees of freedom.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a value that is negative or not finite, and for a `dof`
    /// outside 1..=10^8; nothing is then counted.
    pub fn push(&mut self, dof: usize, value: f64) -> Result<()> {
        non_negative("normalised squared error", value)?;
        let inside = self.interval(dof)?.contains(&value);
        self.count += 1;
        self.freedom += dof as u64;
        self.sum += value;
        self.inside += u64::from(inside);
        Ok(())
    }

    /// Adds what `other` has counted. Each keeps to its own confidence.
    pub fn merge(&mut self, other: &ChiSquareTally) {
        self.count += other.count;
        self.freedom += other.freedom;
        self.sum += other.sum;
        self.inside += other.inside;
    }

    fn interval(&mut self, dof: usize) -> Result<&RangeInclusive<f64>> {
        let known = self.intervals.iter().position(|(known, _)| *known == dof);
        let index = match known {
            Some(index) => index,
            None => {
                self.intervals.push((dof, chi_square_interval(dof, self.confidence)?));
                self.intervals.len() - 1
            }
        };
        Ok(&self.intervals[index].1)
    }

    /// How many values there were.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their degrees of freedom together.
    pub fn degrees_of_freedom(&self) -> u64 {
        self.freedom
    }

    /// Their mean; `None` without values.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }

    /// Their sum by their degrees of freedom: 1 where the claims are right. `None` without values.
    pub fn mean_per_degree(&self) -> Option<f64> {
        (self.freedom > 0).then(|| self.sum / self.freedom as f64)
    }

    /// Where [`mean_per_degree`](Self::mean_per_degree) lies with the tally's confidence, if the
    /// values are independent, as innovations of a consistent filter are. `None` without values.
    pub fn band_per_degree(&self) -> Option<RangeInclusive<f64>> {
        mean_band(self.freedom, self.confidence)
    }

    /// The share of the values that lie within the interval that should hold the share
    /// `confidence` of them. `None` without values.
    pub fn share_inside(&self) -> Option<f64> {
        (self.count > 0).then(|| self.inside as f64 / self.count as f64)
    }
}

/// NEES over the steps of many runs of one experiment, each with other random numbers.
///
/// The errors of one run are correlated from step to step, so one run is weak evidence. The same
/// step of many runs gives independent values, and their mean must lie in a narrow band: the test
/// is the share of the steps at which it does.
#[derive(Debug, Clone, PartialEq)]
pub struct NeesEnsemble {
    confidence: f64,
    steps: Vec<NeesStep>,
    runs: RunningMoments,
    sum: f64,
    count: u64,
}

/// What one step of all runs adds up to.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct NeesStep {
    /// Number of runs that have this step.
    pub runs: u64,
    /// Degrees of freedom of their values together.
    pub degrees_of_freedom: u64,
    /// Sum of their values.
    pub sum: f64,
}

impl NeesStep {
    /// The mean per degree of freedom; `None` without values.
    pub fn mean_per_degree(&self) -> Option<f64> {
        let freedom = self.degrees_of_freedom;
        (freedom > 0).then(|| self.sum / freedom as f64)
    }

    /// Where [`mean_per_degree`](NeesStep::mean_per_degree) lies with probability `confidence` if
    /// the covariances are right; `None` without values.
    pub fn band_per_degree(&self, confidence: f64) -> Option<RangeInclusive<f64>> {
        mean_band(self.degrees_of_freedom, confidence)
    }
}

impl NeesEnsemble {
    /// No runs yet; bands hold what is right with probability `confidence`.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a `confidence` outside \[0, 1).
    pub fn new(confidence: f64) -> Result<Self> {
        Ok(NeesEnsemble {
            confidence: check_confidence(confidence)?,
            steps: Vec::new(),
            runs: RunningMoments::new(),
            sum: 0.0,
            count: 0,
        })
    }

    /// Adds a run: for each step the degrees of freedom and the NEES, or `None` where there was
    /// no covariance. Runs may end early.
    ///
    /// # Errors
    /// [`crate::Error::OutOfRange`] for a value that is negative or not finite; the run is then
    /// left out.
    pub fn push_run(&mut self, nees: impl IntoIterator<Item = Option<(usize, f64)>>) -> Result<()> {
        let values: Vec<_> = nees.into_iter().collect();
        for (_, value) in values.iter().flatten() {
            non_negative("NEES", *value)?;
        }
        self.steps.resize(self.steps.len().max(values.len()), NeesStep::default());
        let mut run = NeesStep::default();
        for (step, value) in self.steps.iter_mut().zip(&values) {
            let Some((freedom, value)) = *value else { continue };
            for sums in [step, &mut run] {
                sums.runs += 1;
                sums.degrees_of_freedom += freedom as u64;
                sums.sum += value;
            }
        }
        self.sum += run.sum;
        self.count += run.runs;
        match run.mean_per_degree() {
            Some(mean) => self.runs.push(mean),
            None => Ok(()),
        }
    }

    /// How many runs had values.
    pub fn runs(&self) -> u64 {
        self.runs.count()
    }

    /// What each step of all runs adds up to.
    pub fn steps(&self) -> &[NeesStep] {
        &self.steps
    }

    /// The mean of all values; the dimension of the state where the covariances are right. `None`
    /// without values.
    pub fn mean(&self) -> Option<f64> {
        (self.count > 0).then(|| self.sum / self.count as f64)
    }

    /// The mean over the runs of their mean NEES per degree of freedom: 1 where the covariances
    /// are right. `None` without values.
    pub fn mean_per_degree(&self) -> Option<f64> {
        self.runs.mean()
    }

    /// Where the expected value of [`mean_per_degree`](NeesEnsemble::mean_per_degree) lies, by the
    /// scatter from run to run: consistent where this contains 1. `None` for fewer than two runs.
    ///
    /// The steps of a run are correlated in an unknown way, so the chi-square table does not apply.
    pub fn interval_per_degree(&self) -> Option<RangeInclusive<f64>> {
        mean_interval(&self.runs, self.confidence).ok().flatten()
    }

    /// The share of the steps at which the mean over the runs lies in its chi-square band. `None`
    /// without values.
    pub fn share_in_band(&self) -> Option<f64> {
        let (mut steps, mut inside) = (0_u64, 0_u64);
        for step in &self.steps {
            let band = step.band_per_degree(self.confidence);
            if let (Some(mean), Some(band)) = (step.mean_per_degree(), band) {
                steps += 1;
                inside += u64::from(band.contains(&mean));
            }
        }
        (steps > 0).then(|| inside as f64 / steps as f64)
    }
}

/// Sums from which the autocorrelation of innovations follows, over any number of sequences.
///
/// For each lag l from 1 on, `rho(l) = (sum x_t x_(t+l) / n_l) / (sum x_t^2 / n)`. The mean is not
/// subtracted: innovations of a consistent filter have mean 0, and a filter with a constant bias is
/// detected as well. Each number of a measurement (range, bearing) of
/// each run is a sequence of its own.
///
/// ```
/// use loc_core::stats::consistency::Whiteness;
/// let mut whiteness = Whiteness::new(2)?;
/// whiteness.push(&[1.0, -1.0, 1.0, -1.0])?;
/// assert_eq!(whiteness.correlation(1), Some(-1.0));
/// assert_eq!(whiteness.correlation(2), Some(1.0));
/// # Ok::<(), loc_core::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Whiteness {
    /// Sum of the squares, and how many.
    squares: f64,
    count: u64,
    /// For each lag the sum of the products, and how many.
    products: Vec<f64>,
    pairs: Vec<u64>,
}

impl Whiteness {
    /// No sequence yet, for the lags 1 to `lags`.
    ///
    /// # Errors
    /// [`Error::Length`] for no lag.
    pub fn new(lags: usize) -> Result<Self> {
        if lags == 0 {
            return Err(Error::Length { what: "lags", expected: "at least 1", found: 0 });
        }
        let (products, pairs) = (vec![0.0; lags], vec![0; lags]);
        Ok(Whiteness { squares: 0.0, count: 0, products, pairs })
    }

    /// Adds a sequence of innovations, each by its standard deviation (whitened).
    ///
    /// # Errors
    /// [`Error::OutOfRange`] for numbers that are not finite, and for some that are too large to be
    /// multiplied; the sequence is then left out.
    pub fn push(&mut self, sequence: &[f64]) -> Result<()> {
        let squares: f64 = sequence.iter().map(|value| value * value).sum();
        // No product of two of them is larger than the sum of the squares.
        self.squares += finite("sum of squared innovations", squares)?;
        self.count += sequence.len() as u64;
        let lags = self.products.iter_mut().zip(&mut self.pairs);
        for (lag, (products, pairs)) in (1..).zip(lags) {
            let later = sequence.get(lag..).unwrap_or_default();
            *products += sequence.iter().zip(later).map(|(a, b)| a * b).sum::<f64>();
            *pairs += later.len() as u64;
        }
        Ok(())
    }

    /// Adds the sums of `other`, at the lags that both have.
    pub fn merge(&mut self, other: &Whiteness) {
        self.squares += other.squares;
        self.count += other.count;
        let others = other.products.iter().zip(&other.pairs);
        let ours = self.products.iter_mut().zip(&mut self.pairs);
        for ((products, pairs), (other_products, other_pairs)) in ours.zip(others) {
            *products += other_products;
            *pairs += other_pairs;
        }
    }

    /// The largest lag.
    pub fn lags(&self) -> usize {
        self.products.len()
    }

    /// The autocorrelation at a lag of 1 or more; `None` for other lags, without so long a
    /// sequence, and where all innovations are 0.
    pub fn correlation(&self, lag: usize) -> Option<f64> {
        let index = lag.checked_sub(1)?;
        let (products, pairs) = (*self.products.get(index)?, *self.pairs.get(index)?);
        let power = self.squares / self.count as f64;
        (pairs > 0 && power > 0.0).then(|| products / pairs as f64 / power)
    }

    /// How far from 0 the autocorrelation of white innovations lies at most, with probability
    /// `confidence`; `None` where there is none, and for a `confidence` outside \[0, 1).
    pub fn bound(&self, lag: usize, confidence: f64) -> Option<f64> {
        let pairs = *self.pairs.get(lag.checked_sub(1)?)?;
        whiteness_bound(usize::try_from(pairs).ok()?, confidence).ok()
    }

    /// The share of the lags whose autocorrelation lies within its bound; `None` without any.
    pub fn share_within(&self, confidence: f64) -> Option<f64> {
        let lags = (1..=self.lags())
            .filter_map(|lag| Some((self.correlation(lag)?, self.bound(lag, confidence)?)));
        let within: Vec<bool> = lags.map(|(rho, bound)| rho.abs() <= bound).collect();
        let count = within.iter().filter(|within| **within).count();
        (!within.is_empty()).then(|| count as f64 / within.len() as f64)
    }
}
