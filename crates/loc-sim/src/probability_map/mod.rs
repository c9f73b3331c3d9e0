//! The probability map of a scan (M12): for each place, how likely the scan is there.
//!
//! A robot stands somewhere and takes one scan. How well does the scan fit at every other place of
//! the map? Two answers, as images: with the heading that fits best at each place, which is what a
//! robot can say that knows nothing, and with the true heading, which is what it can say that has
//! a compass. Rooms of the same shape light up together: that is why one scan may not be enough,
//! and why a particle filter keeps several clusters.
//!
//! ```
//! use loc_sim::scenario::Scenario;
//! let changes = ["probability_map.step_m=0.4".into(), "probability_map.headings=24".into()];
//! let scenario = Scenario::named("probability-map", &changes)?;
//! let illustration = scenario.illustrate(1)?.expect("it needs no method");
//! assert_eq!(illustration.figures[0].file, "probability.svg");
//! # Ok::<(), loc_sim::Error>(())
//! ```

mod config;
mod figure;

pub use config::ProbabilityMapConfig;

use crate::Result;
use crate::config::field;
use crate::output::Illustration;
use crate::source::tour::TourWorld;
use loc_core::Pose2;
use loc_core::random::stream;
use loc_maps::LikelihoodField;
use loc_maps::grid::{GridFrame, Occupancy, OccupancyGrid};
use loc_maps::likelihood_field::Endpoints;
use loc_sensors::laser::LaserScan;
use serde_json::json;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// How likely one scan is at every place of a map.
#[derive(Debug, Clone)]
pub struct ProbabilityMap {
    /// The map.
    pub map: Arc<OccupancyGrid>,
    /// The places that were looked at: the centres of these squares, in row-major order.
    pub frame: GridFrame,
    /// Logarithm of the likelihood with the best heading; NaN where no robot can be.
    pub any_heading: Vec<f64>,
    /// The same with the true heading.
    pub true_heading: Vec<f64>,
    /// Where the scan was taken.
    pub truth: Pose2,
    /// The most likely pose of all.
    pub best: Pose2,
    /// The scan.
    pub scan: LaserScan,
    /// Where the laser sits on the robot.
    pub mounting: Pose2,
    /// How many of its beams were used.
    pub beams: usize,
}

impl ProbabilityMap {
    /// Takes a scan and rates it everywhere.
    ///
    /// # Errors
    /// Values out of range, and a pose that is not in free space.
    pub fn new(config: &ProbabilityMapConfig, seed: u64) -> Result<Self> {
        config.check()?;
        let world = TourWorld::open(config.world.as_ref(), config.map.as_deref())?;
        let truth = config.pose.pose();
        if world.grid().occupancy_at(&truth.position()) != Occupancy::Free {
            let found = format!("{:.2}, {:.2}", truth.x, truth.y);
            return Err(field("probability_map.pose", "a place in free space", &found));
        }
        let scanner = config.laser.scanner()?;
        let scan = scanner.scan(world.walls(), truth, &mut stream(seed, "laser"));
        let beams = scan.thinned(config.beams);
        let ends = beams.iter().map(|beam| scanner.mounting.transform(&beam.point()));
        let ends: Endpoints = ends.map(|end| [end.x, end.y]).collect();
        let field = LikelihoodField::new(world.grid(), &config.field)?;
        let frame = squares(world.grid(), config.step_m)?;
        let headings: Vec<f64> =
            (0..config.headings).map(|k| TAU * k as f64 / config.headings as f64 - PI).collect();
        let mut map = ProbabilityMap {
            map: world.grid().clone(),
            frame,
            any_heading: Vec::with_capacity(frame.cell_count()),
            true_heading: Vec::with_capacity(frame.cell_count()),
            truth,
            best: truth,
            scan,
            mounting: scanner.mounting,
            beams: ends.len(),
        };
        map.rate(&field, &ends, &headings);
        Ok(map)
    }

    fn rate(&mut self, field: &LikelihoodField, ends: &Endpoints, headings: &[f64]) {
        let mut highest = f64::NEG_INFINITY;
        for cell in self.frame.cells() {
            let place = self.frame.center(cell);
            if self.map.occupancy_at(&place) != Occupancy::Free {
                self.any_heading.push(f64::NAN);
                self.true_heading.push(f64::NAN);
                continue;
            }
            let at = |heading| Pose2::new(place.x, place.y, heading);
            let likelihood = |heading| field.log_likelihood(at(heading), ends);
            let of_truth = likelihood(self.truth.theta);
            let rated = headings.iter().map(|&heading| (likelihood(heading), heading));
            let start = (of_truth, self.truth.theta);
            let (best, heading) = rated.fold(start, |a, b| if b.0 > a.0 { b } else { a });
            self.any_heading.push(best);
            self.true_heading.push(of_truth);
            if best > highest {
                (highest, self.best) = (best, at(heading));
            }
        }
    }

    /// The map as figures and numbers.
    pub fn illustrate(&self, title: &str, config: &ProbabilityMapConfig) -> Illustration {
        let pose = |pose: Pose2| {
            format!("({:.2} m, {:.2} m, {:.1} deg)", pose.x, pose.y, pose.theta.to_degrees())
        };
        let off = self.best.distance(self.truth);
        let turned = loc_core::angle::difference(self.best.theta, self.truth.theta).to_degrees();
        let lines = vec![
            format!("true pose         {}", pose(self.truth)),
            format!("most likely pose  {}, off by {off:.3} m", pose(self.best)),
            format!("beams used        {} of {}", self.beams, self.scan.ranges.len()),
        ];
        let numbers = |pose: Pose2| json!([pose.x, pose.y, pose.theta]);
        let summary = json!({
            "truth": numbers(self.truth),
            "most_likely": numbers(self.best),
            "error_m": off,
            "heading_error_deg": turned,
            "beams": self.beams,
            "places": self.any_heading.iter().filter(|value| value.is_finite()).count(),
            "headings": config.headings,
        });
        let figures = vec![figure::figure(self, title, config.decades)];
        Illustration::new(lines, summary, figures)
    }
}

/// Squares of about `step` \[m\] over the whole map.
fn squares(map: &OccupancyGrid, step: f64) -> Result<GridFrame> {
    let step = step.max(map.resolution());
    let across = |cells: usize| (cells as f64 * map.resolution() / step).ceil() as usize;
    let (width, height) = (across(map.width()), across(map.height()));
    Ok(GridFrame::new(width, height, step, map.origin())?)
}
