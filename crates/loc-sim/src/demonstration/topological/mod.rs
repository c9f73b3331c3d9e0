//! Markov localization on a topological map (K1, C4): in which room is the robot?
//!
//! Rooms, corridors and doors are found in the grid of a building, and the robot learns what each
//! of them looks like to its laser. Then it drives a tour, starting anywhere. It knows how far it
//! has driven, not in which direction, and what it sees. The belief is a probability for each
//! place.

mod figure;
mod views;

use crate::Result;
use crate::config::field;
use crate::output::Illustration;
use crate::source::Source;
use crate::source::tour::{SimulatedTour, TourConfig, TourWorld};
use loc_core::Pose2;
use loc_core::error::{positive, probability};
use loc_core::random::stream;
use loc_filters::histogram::{PlaceViews, TopologicalFilter};
use loc_maps::topological::{ExtractSettings, PlaceKind};
use loc_maps::{OccupancyGrid, TopologicalMap};
use loc_sensors::event::{Control, Measurement, Payload};
use loc_sensors::laser::LaserScan;
use nalgebra::Point2;
use serde::Deserialize;
use serde_json::json;
use std::sync::Arc;

/// The building, the tour, and how scans count.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TopologicalConfig {
    /// Building, robot and laser.
    pub tour: TourConfig,
    /// From how many spots the looks of a place are learned.
    pub views: usize,
    /// Way between two looks.
    pub look_every_m: f64,
    /// As which share of an independent scan each one counts.
    pub independence: f64,
    /// How often a scan looks like in none of the places.
    pub surprise: f64,
}

/// Doors are at least this wide when it is asked whether the robot is in one \[m\].
const DOOR: f64 = 0.8;

impl TopologicalConfig {
    pub(super) fn check(&self) -> Result<()> {
        super::count("demonstration.views", self.views, 10_000)?;
        positive("demonstration.look_every_m", self.look_every_m)?;
        positive("demonstration.independence", self.independence)?;
        probability("demonstration.surprise", self.surprise)?;
        Ok(())
    }
}

/// What is believed after one look.
#[derive(Debug, Clone)]
pub struct Look {
    /// Since the start \[m\].
    pub way: f64,
    /// Where the robot really is.
    pub truth: Pose2,
    /// In which place that is.
    pub place: usize,
    /// The probability of each place.
    pub belief: Vec<f64>,
}

/// A tour through a building, place by place.
#[derive(Debug, Clone)]
pub struct TopologicalTour {
    grid: Arc<OccupancyGrid>,
    map: TopologicalMap,
    /// The looks, the first one before anything was seen.
    pub looks: Vec<Look>,
}

impl TopologicalTour {
    /// Learns the places, drives and filters.
    ///
    /// # Errors
    /// Values out of range, and a building without places.
    pub fn new(config: &TopologicalConfig, seed: u64) -> Result<Self> {
        config.check()?;
        let world = TourWorld::open(config.tour.world.as_ref(), config.tour.map.as_deref())?;
        let map = TopologicalMap::from_grid(world.grid(), &ExtractSettings::default())?;
        if map.places().is_empty() {
            return Err(field("demonstration.tour", "a building with places", "one without"));
        }
        let scans = views::take(&map, &world, config, &mut stream(seed, "views"))?;
        let views = PlaceViews::new(&scans, config.independence, config.surprise)?;
        let filter = TopologicalFilter::new(map.clone())?;
        let mut drive = Drive { filter, views, looks: Vec::new(), way: 0.0, looked_at: 0.0 };
        drive
            .follow(SimulatedTour::new("topological", &config.tour, seed)?, config.look_every_m)?;
        Ok(TopologicalTour { grid: world.grid().clone(), map, looks: drive.looks })
    }

    /// The looks as figures and numbers.
    pub fn illustrate(&self, title: &str) -> Illustration {
        let name = |place: usize| self.map.places()[place].name.as_str();
        let share = |is: &dyn Fn(&Look) -> bool| {
            let seen = &self.looks[1..];
            seen.iter().filter(|look| is(look)).count() as f64 / seen.len().max(1) as f64
        };
        let right = share(&|look| look.most_likely() == look.place);
        let near = share(&|look| look.is_near(&self.map));
        let found = self.looks.iter().position(|look| look.belief[look.place] > 0.5);
        let head =
            format!("{:>8}  {:<14}{:<14}{:>9}", "way [m]", "place", "most likely", "P(place)");
        let mut lines = vec![head];
        lines.extend(figure::choose(self.looks.len()).map(|k| {
            let look = &self.looks[k];
            let (place, best) = (name(look.place), name(look.most_likely()));
            format!("{:>8.1}  {place:<14}{best:<14}{:>9.3}", look.way, look.belief[look.place])
        }));
        lines.push(format!(
            "{} places, {} looks: the right place in {:.0} %, it or its neighbour in {:.0} %",
            self.map.places().len(),
            self.looks.len() - 1,
            100.0 * right,
            100.0 * near
        ));
        let summary = json!({
            "places": self.map.places().len(),
            "looks": self.looks.len() - 1,
            "right_share": right,
            "right_or_neighbour_share": near,
            "found_after_looks": found,
        });
        Illustration::new(lines, summary, figure::figures(self, title))
    }
}

impl Look {
    /// The likeliest place.
    pub fn most_likely(&self) -> usize {
        let better =
            |best: usize, k: usize| if self.belief[k] > self.belief[best] { k } else { best };
        (0..self.belief.len()).fold(0, better)
    }

    /// Whether that is the right place or a neighbour of it: in a door, one is nearly in the room.
    fn is_near(&self, map: &TopologicalMap) -> bool {
        let best = self.most_likely();
        best == self.place || map.neighbours(self.place).iter().any(|(next, _)| *next == best)
    }
}

/// In which place a point is: a door within half its width, else the place around it, else the
/// nearest one.
fn place_of(map: &TopologicalMap, point: &Point2<f64>) -> usize {
    let in_door = map.places().iter().position(|place| {
        let width = place.width.unwrap_or(DOOR).max(DOOR);
        let distance = nalgebra::distance(&place.position, point);
        place.kind == PlaceKind::Door && distance <= 0.5 * width
    });
    let around = || map.places_at(point).next();
    let nearest = || map.nearest(point).map_or(0, |(place, _)| place);
    in_door.or_else(around).unwrap_or_else(nearest)
}

/// A drive on the way.
struct Drive {
    filter: TopologicalFilter,
    views: PlaceViews,
    looks: Vec<Look>,
    way: f64,
    /// Way at the last look \[m\].
    looked_at: f64,
}

impl Drive {
    fn follow(&mut self, mut tour: SimulatedTour, every: f64) -> Result<()> {
        let mut odometry: Option<Pose2> = None;
        let mut scan: Option<Arc<LaserScan>> = None;
        while let Some(event) = tour.next_event()? {
            match event.payload {
                Payload::Control(Control::Odometry(pose)) => {
                    self.way += odometry.map_or(0.0, |before| before.distance(pose));
                    odometry = Some(pose);
                }
                Payload::Measurement(Measurement::Scan { scan: new, .. }) => scan = Some(new),
                Payload::Truth(truth) => {
                    if self.looks.is_empty() {
                        self.keep(truth.pose);
                    }
                    let due = self.looks.len() == 1 || self.way - self.looked_at >= every;
                    if let Some(scan) = scan.take().filter(|_| due) {
                        self.look(&scan, truth.pose)?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn look(&mut self, scan: &LaserScan, truth: Pose2) -> Result<()> {
        self.filter.predict(self.way - self.looked_at)?;
        self.looked_at = self.way;
        if let Some(likelihoods) = self.views.likelihoods(scan)? {
            self.filter.correct(&likelihoods)?;
        }
        self.keep(truth);
        Ok(())
    }

    fn keep(&mut self, truth: Pose2) {
        let belief = self.filter.belief().to_vec();
        let place = place_of(self.filter.map(), &truth.position());
        self.looks.push(Look { way: self.way, truth, place, belief });
    }
}
