//! What lateration can be told.

use crate::Result;
use loc_core::error::in_range;

/// What a fix minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Cost {
    /// `sum ((|x - l_i| - d_i) / sigma_i)^2`: the most likely place under normal errors.
    #[default]
    Distances,
    /// `sum (|x - l_i|^2 - d_i^2)^2`, the SSE of the lectures (D2). Long distances weigh more than
    /// they deserve.
    Squares,
}

/// How much a residual of `u` standard deviations costs.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum Loss {
    /// `u^2`: right where all errors are normal.
    #[default]
    Quadratic,
    /// Huber's: `u^2` up to the given number of standard deviations, linear beyond.
    Huber(f64),
    /// Cauchy's: `k^2 ln(1 + u^2 / k^2)`; far outliers hardly count, at the price of local minima.
    Cauchy(f64),
}

impl Loss {
    /// Huber's loss with the bend at 1.345, which costs 5 % of the accuracy if all is normal
    /// (Holland and Welsch 1977).
    pub const HUBER: Loss = Loss::Huber(1.345);
    /// Cauchy's with 2.385, for the same 5 %.
    pub const CAUCHY: Loss = Loss::Cauchy(2.385);

    /// The loss of a residual of `u` standard deviations.
    pub fn cost(self, u: f64) -> f64 {
        match self {
            Loss::Quadratic => u * u,
            Loss::Huber(k) if u.abs() <= k => u * u,
            Loss::Huber(k) => k * (2.0 * u.abs() - k),
            Loss::Cauchy(k) => k * k * (u * u / (k * k)).ln_1p(),
        }
    }

    /// The weight of such a residual beside its weight in `u^2`, in (0, 1].
    pub fn weight(self, u: f64) -> f64 {
        match self {
            Loss::Quadratic => 1.0,
            Loss::Huber(k) => (k / u.abs()).min(1.0),
            Loss::Cauchy(k) => 1.0 / (1.0 + u * u / (k * k)),
        }
    }
}

/// How well the bias of the ranging sensor is known: standard deviations about scale 1 and offset
/// 0. One that is 0 is known, one that is infinite is an unknown like a coordinate.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct BiasPrior {
    /// Standard deviation of the scale.
    pub scale_sigma: f64,
    /// Standard deviation of the offset \[m\].
    pub offset_sigma: f64,
}

impl BiasPrior {
    /// The sensor is right.
    pub const KNOWN: BiasPrior = BiasPrior { scale_sigma: 0.0, offset_sigma: 0.0 };
    /// Nothing is known of its scale.
    pub const FREE_SCALE: BiasPrior = BiasPrior { scale_sigma: f64::INFINITY, offset_sigma: 0.0 };
    /// Nothing is known of its offset.
    pub const FREE_OFFSET: BiasPrior = BiasPrior { scale_sigma: 0.0, offset_sigma: f64::INFINITY };

    /// How many of the two have to be found from the ranges alone.
    pub(super) fn free(&self) -> usize {
        [self.scale_sigma, self.offset_sigma].iter().filter(|sigma| sigma.is_infinite()).count()
    }

    /// Checks both.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for negative ones and NaN.
    pub fn check(&self) -> Result<()> {
        let expected = "a number >= 0, infinity allowed";
        in_range("sigma of the range scale", expected, self.scale_sigma, |s| s >= 0.0)?;
        in_range("sigma of the range offset [m]", expected, self.offset_sigma, |s| s >= 0.0)?;
        Ok(())
    }
}

impl Default for BiasPrior {
    fn default() -> Self {
        BiasPrior::KNOWN
    }
}

/// All that lateration can be told. The default is the most likely place under normal errors, of a
/// sensor without bias.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields, default))]
pub struct LaterationSettings {
    /// What is minimised.
    pub cost: Cost,
    /// How much outliers cost.
    pub loss: Loss,
    /// What is known of the bias.
    pub bias: BiasPrior,
}

impl LaterationSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`].
    pub fn check(&self) -> Result<()> {
        if let Loss::Huber(k) | Loss::Cauchy(k) = self.loss {
            loc_core::error::positive("bend of the loss [standard deviations]", k)?;
        }
        self.bias.check()
    }
}
