//! Connected pieces of occupied cells.

use super::occupied;
use crate::grid::OccupancyGrid;

/// Which body each cell belongs to, and how large the bodies are.
#[derive(Debug, Clone)]
pub(super) struct Bodies {
    /// 0 for no body, else its number, from 1.
    labels: Vec<u32>,
    /// Diagonal of the box around each body \[cells\].
    extents: Vec<f64>,
}

impl Bodies {
    pub(super) fn of(grid: &OccupancyGrid) -> Self {
        let mut bodies = Bodies { labels: vec![0; grid.values().len()], extents: Vec::new() };
        for (start, &value) in grid.values().iter().enumerate() {
            if occupied(value) && bodies.labels[start] == 0 {
                let extent = bodies.fill(grid, start);
                bodies.extents.push(extent);
            }
        }
        bodies
    }

    /// The body of the cell at a place of the row-major grid.
    pub(super) fn at(&self, index: usize) -> Option<u32> {
        self.labels.get(index).copied().filter(|label| *label > 0)
    }

    /// Diagonal of the box around a body \[cells\].
    pub(super) fn extent(&self, body: u32) -> f64 {
        self.extents.get(body as usize - 1).copied().unwrap_or(0.0)
    }

    /// Labels all that is connected to a cell, over corners too; returns the diagonal.
    fn fill(&mut self, grid: &OccupancyGrid, start: usize) -> f64 {
        let width = grid.width();
        let label = self.extents.len() as u32 + 1;
        let (mut low, mut high) = ([usize::MAX; 2], [0; 2]);
        let mut waiting = vec![start];
        self.labels[start] = label;
        while let Some(index) = waiting.pop() {
            let place = [index % width, index / width];
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
            for row in place[1].saturating_sub(1)..=(place[1] + 1).min(grid.height() - 1) {
                for column in place[0].saturating_sub(1)..=(place[0] + 1).min(width - 1) {
                    let next = row * width + column;
                    if self.labels[next] == 0 && occupied(grid.values()[next]) {
                        self.labels[next] = label;
                        waiting.push(next);
                    }
                }
            }
        }
        f64::hypot((high[0] - low[0] + 1) as f64, (high[1] - low[1] + 1) as f64)
    }
}
