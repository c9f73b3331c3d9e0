//! Markov localization (F5, K1).

mod discrete;
mod kernel;
mod line;
