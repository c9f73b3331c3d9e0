//! The likelihood field (C5): how likely a scan is at poses around the true one.

use loc_core::Pose2;
use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
use loc_maps::likelihood_field::{Endpoints, LikelihoodField, LikelihoodFieldSettings};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // 5 m x 5 m in cells of 5 cm, with a wall at x = 4 m.
    let mut grid = OccupancyGrid::filled(GridFrame::new(100, 100, 0.05, Pose2::IDENTITY)?, 0);
    (0..100).try_for_each(|row| grid.set(Cell::new(80, row), 100))?;
    let field = LikelihoodField::new(&grid, &LikelihoodFieldSettings::nav2())?;
    // Three beams of 2 m, straight ahead and 0.1 rad to both sides.
    let scan = Endpoints::from_scan(&[-0.1, 0.0, 0.1], &[2.0, 2.0, 2.0]);
    for x in [1.6, 1.8, 2.0, 2.2, 2.4] {
        let log_likelihood = field.log_likelihood(Pose2::new(x, 2.5, 0.0), &scan);
        println!("x = {x:.1} m: log-likelihood {log_likelihood:.2}");
    }
    Ok(())
}
