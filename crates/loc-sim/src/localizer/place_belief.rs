//! What a grid filter believes, as a picture of the places.

use loc_maps::grid::GridFrame;

/// The probability of each square of a map, whatever the heading.
#[derive(Debug, Clone, PartialEq)]
pub struct PlaceBelief {
    /// The squares.
    pub squares: GridFrame,
    /// Their probabilities, row by row from the bottom; they add up to 1.
    pub probabilities: Vec<f32>,
}

impl PlaceBelief {
    /// Mean \[m\] of the position, and its standard deviation over both axes \[m\]; anywhere in a
    /// square is equally likely.
    pub fn mean_and_spread(&self) -> ([f64; 2], f64) {
        let weighted = || {
            let centers = self.squares.cells().map(|cell| self.squares.center(cell));
            centers.zip(self.probabilities.iter().map(|&p| f64::from(p)))
        };
        let total: f64 = weighted().map(|(_, p)| p).sum();
        let mean = |of: &dyn Fn([f64; 2]) -> f64| {
            weighted().map(|(at, p)| p * of([at.x, at.y])).sum::<f64>() / total
        };
        let [x, y] = [mean(&|at| at[0]), mean(&|at| at[1])];
        let squared = mean(&|at| (at[0] - x).powi(2) + (at[1] - y).powi(2));
        ([x, y], (squared + self.squares.resolution().powi(2) / 6.0).sqrt())
    }
}
