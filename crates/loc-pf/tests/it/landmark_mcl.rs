//! Monte Carlo localization with landmarks.
