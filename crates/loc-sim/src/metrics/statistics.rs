//! A list of errors, summed up.

use crate::Result;
use loc_core::Error;
use serde::ser::{Serialize, SerializeStruct, Serializer};

/// What errors are measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Lengths \[m\].
    Metre,
    /// Angles \[deg\].
    Degree,
}

impl Unit {
    /// The unit's sign.
    pub fn symbol(self) -> &'static str {
        match self {
            Unit::Metre => "m",
            Unit::Degree => "deg",
        }
    }
}

/// The figures of a list of errors, all in its unit (`sse` in the unit squared).
///
/// Serialized with the unit in every name: `rmse_m`, `rmse_deg`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Statistics {
    /// What the errors are measured in.
    pub unit: Unit,
    /// Number of errors.
    pub count: usize,
    /// Root of the mean square.
    pub rmse: f64,
    /// Mean.
    pub mean: f64,
    /// Median; of an even number of errors, the mean of the middle two.
    pub median: f64,
    /// Standard deviation about the mean, over the count (not the count less one).
    pub std: f64,
    /// Smallest error.
    pub min: f64,
    /// Largest error.
    pub max: f64,
    /// Sum of the squares.
    pub sse: f64,
}

impl Statistics {
    /// Sums up a list of errors.
    ///
    /// # Errors
    /// [`loc_core::Error::Length`] for an empty list, [`loc_core::Error::OutOfRange`] for errors
    /// that are not finite, or too large to be squared.
    pub fn of(unit: Unit, errors: &[f64]) -> Result<Self> {
        if errors.is_empty() {
            return Err(Error::Length {
                what: "errors to sum up",
                expected: "at least 1",
                found: 0,
            }
            .into());
        }
        let count = errors.len() as f64;
        let sse = errors.iter().map(|e| e * e).sum::<f64>();
        loc_core::error::finite("sum of the squared errors", sse)?;
        let mean = errors.iter().sum::<f64>() / count;
        let scatter = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>();

        let mut sorted = errors.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        Ok(Statistics {
            unit,
            count: errors.len(),
            rmse: (sse / count).sqrt(),
            mean,
            median: 0.5 * (sorted[(sorted.len() - 1) / 2] + sorted[sorted.len() / 2]),
            std: (scatter / count).sqrt(),
            min: sorted[0],
            max: sorted[sorted.len() - 1],
            sse,
        })
    }
}

impl Serialize for Statistics {
    fn serialize<S: Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let [rmse, mean, median, std, min, max, sse] = match self.unit {
            Unit::Metre => ["rmse_m", "mean_m", "median_m", "std_m", "min_m", "max_m", "sse_m2"],
            Unit::Degree => {
                ["rmse_deg", "mean_deg", "median_deg", "std_deg", "min_deg", "max_deg", "sse_deg2"]
            }
        };
        let mut object = serializer.serialize_struct("Statistics", 8)?;
        object.serialize_field("count", &self.count)?;
        object.serialize_field(rmse, &self.rmse)?;
        object.serialize_field(mean, &self.mean)?;
        object.serialize_field(median, &self.median)?;
        object.serialize_field(std, &self.std)?;
        object.serialize_field(min, &self.min)?;
        object.serialize_field(max, &self.max)?;
        object.serialize_field(sse, &self.sse)?;
        object.end()
    }
}
