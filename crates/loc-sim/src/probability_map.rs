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
//! let changes = ["probability_map.step=0.4".into(), "probability_map.headings=24".into()];
//! let scenario = Scenario::named("probability-map", &changes)?;
//! let illustration = scenario.illustrate(1)?.expect("it needs no method");
//! assert_eq!(illustration.figures[0].file, "probability.svg");
//! # Ok::<(), loc_sim::Error>(())
//! ```

use crate::Result;
use crate::config::field;
use crate::output::Illustration;
use crate::output::figures::FigureFile;
use crate::source::tour::{LaserConfig, TourWorld, WorldConfig};
use loc_core::Pose2;
use loc_core::error::positive;
use loc_core::random::stream;
use loc_maps::LikelihoodField;
use loc_maps::grid::{Cell, GridFrame, Occupancy, OccupancyGrid};
use loc_maps::likelihood_field::{Endpoints, LikelihoodFieldSettings};
use loc_plot::color::LIKELIHOOD;
use loc_plot::{Backdrop, Frames, Role, Scene, Style, color};
use loc_sensors::laser::LaserScan;
use nalgebra::Point2;
use serde::Deserialize;
use serde_json::json;
use std::f64::consts::{PI, TAU};
use std::path::PathBuf;
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
        let truth = config.pose;
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
        let frame = squares(world.grid(), config.step)?;
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
        let figures = vec![figure(self, title, config.decades)];
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

/// A scan to be rated everywhere.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ProbabilityMapConfig {
    /// A generated world. Either this or `map`.
    pub world: Option<WorldConfig>,
    /// A map of map_server, from the folder that the command runs in.
    pub map: Option<PathBuf>,
    /// Where the scan is taken.
    #[serde(with = "loc_core::settings::pose")]
    pub pose: Pose2,
    /// The laser; `every` has no meaning here.
    pub laser: LaserConfig,
    /// How likely a beam's end is near an obstacle.
    #[serde(default = "LikelihoodFieldSettings::nav2")]
    pub field: LikelihoodFieldSettings,
    /// Most beams of the scan that are used.
    #[serde(default = "beams")]
    pub beams: usize,
    /// Number of headings that are tried at each place, 1 to 3600.
    #[serde(default = "headings")]
    pub headings: usize,
    /// Distance between the places \[m\].
    #[serde(default = "step")]
    pub step: f64,
    /// The colours reach from the highest likelihood down to one that is so many powers of ten
    /// lower.
    #[serde(default = "decades")]
    pub decades: f64,
}

fn beams() -> usize {
    60
}

fn headings() -> usize {
    120
}

fn step() -> f64 {
    0.1
}

fn decades() -> f64 {
    20.0
}

impl ProbabilityMapConfig {
    /// Checks every value, as far as that is possible without the building.
    ///
    /// # Errors
    /// [`crate::Error::Config`] and [`loc_core::Error::OutOfRange`] with the key.
    pub(crate) fn check(&self) -> Result<()> {
        if let Some(world) = &self.world {
            world.settings()?;
        }
        self.pose.check()?;
        self.laser.scanner()?;
        self.field.check()?;
        if self.beams == 0 {
            return Err(field("probability_map.beams", "at least 1", "0"));
        }
        if !(1..=3600).contains(&self.headings) {
            let found = self.headings.to_string();
            return Err(field("probability_map.headings", "1 to 3600", &found));
        }
        positive("probability_map.step", self.step)?;
        positive("probability_map.decades", self.decades)?;
        Ok(())
    }
}

/// Radius of the ring around the robot \[m\].
const RING: f64 = 0.4;

/// Both images, with the scan as it was taken.
fn figure(map: &ProbabilityMap, title: &str, decades: f64) -> FigureFile {
    let bar =
        color::bar(&LIKELIHOOD, -decades, 0.0, "log10 of the likelihood, relative to the highest");
    let frames = Frames::new(title)
        .subtitle(format!("one scan, {} beams; darker places are more likely", map.beams))
        .columns(2)
        .frame("with the heading that fits best", scene(map, &map.any_heading, decades))
        .frame("with the true heading", scene(map, &map.true_heading, decades))
        .bar(bar);
    FigureFile::new(
        "probability.svg",
        "How likely the scan is at each place of the map",
        frames.render(),
    )
}

fn scene(map: &ProbabilityMap, log_likelihoods: &[f64], decades: f64) -> Scene {
    let laser = map.truth * map.mounting;
    let ends = map.scan.beams().map(|beam| {
        let end = laser.transform(&beam.point());
        (end.x, end.y)
    });
    Scene::new("")
        .backdrop(image(map, log_likelihoods, decades))
        .dots(Style::from(Role::Method(5)).width(1.8), "the scan", ends)
        .ring("robot", RING, map.truth)
}

/// Likelihoods as colours; walls dark, unknown space grey.
fn image(map: &ProbabilityMap, log_likelihoods: &[f64], decades: f64) -> Backdrop {
    let frame = &map.frame;
    let (columns, rows) = (frame.width(), frame.height());
    let highest = log_likelihoods.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let lowest = -decades * std::f64::consts::LN_10;
    let mut pixels = Vec::with_capacity(columns * rows);
    for row in (0..rows).rev() {
        for column in 0..columns {
            let value = log_likelihoods[row * columns + column];
            let share = 1.0 - (value - highest) / lowest;
            let wall = touches_wall(map, Cell::new(column, row));
            pixels.push(match value.is_finite() {
                _ if wall => color::WALL,
                true => color::along(&LIKELIHOOD, share),
                false => color::UNKNOWN,
            });
        }
    }
    // A turned map is drawn in its own frame.
    let (width, height) = (columns as f64 * frame.resolution(), rows as f64 * frame.resolution());
    let origin = frame.origin();
    Backdrop {
        min: (origin.x, origin.y),
        max: (origin.x + width, origin.y + height),
        data_uri: color::Image { width: columns, pixels }.data_uri(),
    }
}

/// Whether any of a few places within a square is a wall.
fn touches_wall(map: &ProbabilityMap, cell: Cell) -> bool {
    let samples = (map.frame.resolution() / map.map.resolution()).ceil().clamp(1.0, 4.0) as usize;
    let inside = |k: usize| (k as f64 + 0.5) / samples as f64;
    (0..samples * samples).any(|k| {
        let (u, v) = (inside(k % samples), inside(k / samples));
        let place: Point2<f64> = map.frame.to_map(cell.column as f64 + u, cell.row as f64 + v);
        map.map.occupancy_at(&place) == Occupancy::Occupied
    })
}
