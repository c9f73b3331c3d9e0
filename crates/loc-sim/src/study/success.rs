//! When a run counts as a success.

use super::{MethodOutcome, RunOutcome};
use crate::{Error, Result};
use std::fmt;

/// What a method must reach in a run.
///
/// ```
/// use loc_sim::study::Success;
/// let success: Success = "ate_rmse_m<0.1".parse()?;
/// assert_eq!(success.to_string(), "ate_rmse_m < 0.1");
/// # Ok::<(), loc_sim::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Success {
    /// At the end its estimates lie within 0.5 m and 10 deg of the truth, see
    /// [`ends_near`](crate::metrics::ends_near).
    #[default]
    EndsNear,
    /// A figure of `summary.json` lies below a limit.
    Below {
        /// The figure's name.
        figure: String,
        /// The limit.
        limit: f64,
    },
}

impl Success {
    /// Whether a method reached it; `None` where the figure has no meaning.
    ///
    /// # Errors
    /// [`Error::UnknownName`] for a figure that there is not.
    pub fn of(&self, run: &RunOutcome, method: &MethodOutcome) -> Result<Option<bool>> {
        let Success::Below { figure, limit } = self else { return Ok(method.ends_near) };
        let figures = || method.figures.iter().chain(&run.figures);
        match figures().find(|(name, _)| name == figure) {
            Some((_, value)) => Ok(value.map(|value| value < *limit)),
            None => Err(Error::UnknownName {
                what: "--success",
                expected: figures().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", "),
                found: figure.clone(),
            }),
        }
    }
}

impl std::str::FromStr for Success {
    type Err = Error;

    /// `FIGURE<LIMIT`.
    fn from_str(text: &str) -> Result<Self> {
        let parts = text.split_once('<').map(|(figure, limit)| (figure.trim(), limit.trim()));
        match parts.map(|(figure, limit)| (figure, limit.parse::<f64>())) {
            Some((figure, Ok(limit))) if !figure.is_empty() && limit.is_finite() => {
                Ok(Success::Below { figure: figure.into(), limit })
            }
            _ => Err(crate::config::field("--success", "FIGURE<LIMIT, as ate_rmse_m<0.1", text)),
        }
    }
}

impl fmt::Display for Success {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Success::EndsNear => f.write_str("within 0.5 m and 10 deg of the truth at the end"),
            Success::Below { figure, limit } => write!(f, "{figure} < {limit}"),
        }
    }
}
