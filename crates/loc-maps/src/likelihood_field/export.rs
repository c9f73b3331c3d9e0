//! The bytes of the field, for searches that keep them in a layout of their own.

use super::LikelihoodField;
use super::build::off_map;
use super::codes::Codes;

impl LikelihoodField {
    /// The codes of all cells, row by row from the bottom: whole numbers, linear in the logarithm
    /// of the likelihood (see [`LikelihoodField::log_likelihood_of`]).
    pub fn cell_codes(&self) -> Vec<u8> {
        match &self.codes {
            Codes::Tiles(tiles) => {
                self.frame.cells().map(|cell| tiles.get(cell.column, cell.row)).collect()
            }
            Codes::Rows(codes) => codes.iter().copied().take(self.frame.cell_count()).collect(),
        }
    }

    /// The code of every place off the map.
    pub fn code_off_map(&self) -> u8 {
        self.scale.code(off_map(&self.settings))
    }

    /// What one code adds to the logarithm of the likelihood.
    pub fn code_step(&self) -> f64 {
        self.scale.step
    }

    /// The logarithm of the likelihood of `beams` beams whose codes add up to `sum`.
    pub fn log_likelihood_of(&self, sum: u64, beams: usize) -> f64 {
        beams as f64 * self.scale.lowest + self.scale.step * sum as f64
    }
}
