//! Markov localization (F5, K1).

mod discrete;
mod grid;
mod grid_input;
mod kernel;
mod line;
mod robot;
mod topological;
