//! The autocorrelation of innovations over many runs.

use super::whiteness_bound;
use crate::error::finite;
use crate::{Error, Result};

/// Sums from which the autocorrelation of innovations follows, over any number of sequences.
///
/// For each lag l from 1 on, `rho(l) = (sum x_t x_(t+l) / n_l) / (sum x_t^2 / n)`. The mean is not
/// taken off: innovations of an honest filter have none, and a filter that is wrong in the same
/// direction all the time is found out here too. Each number of a measurement (range, bearing) of
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

    /// Adds what `other` has seen, at the lags that both have.
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
