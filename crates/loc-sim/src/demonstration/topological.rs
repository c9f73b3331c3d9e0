//! Markov localization on a topological map (K1, C4): in which room is the robot?
//!
//! Rooms, corridors and doors are extracted from the grid of a building, and typical laser scans of
//! each are learned. Then the robot drives a tour from an unknown start. It measures the distance
//! travelled, not the direction, and scans. The belief is a probability for each place.

use super::{Demonstration, check_count};
use crate::Result;
use crate::config::field;
use crate::output::figures::FigureFile;
use crate::output::{Canvas, Illustration};
use crate::source::Source;
use crate::source::tour::{SimulatedTour, TourConfig, TourWorld};
use loc_core::Pose2;
use loc_core::error::{positive, probability};
use loc_core::random::{ChaCha8Rng, stream};
use loc_filters::histogram::{PlaceViews, TopologicalFilter};
use loc_maps::topological::{ExtractSettings, Place, PlaceKind};
use loc_maps::{Bounds, OccupancyGrid, TopologicalMap};
use loc_plot::color::{self, LIKELIHOOD};
use loc_plot::{Chart, Figure, Frames, Role, Scene};
use loc_sensors::event::{Control, Measurement, Payload};
use loc_sensors::laser::LaserScan;
use nalgebra::Point2;
use rand::RngExt;
use serde::Deserialize;
use serde_json::json;
use std::f64::consts::PI;
use std::sync::Arc;

/// The building, the tour, and how scans count.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TopologicalConfig {
    /// Building, robot and laser.
    pub tour: TourConfig,
    /// From how many spots the views of a place are learned.
    pub views: usize,
    /// Distance between two observations \[m\].
    pub look_every: f64,
    /// As which share of an independent scan each one counts.
    pub independence: f64,
    /// Probability of a scan that fits none of the places.
    pub surprise: f64,
}

/// Number of steps that are shown.
const FRAMES: usize = 9;
/// Radius of the ring around the robot, as a share of the map's larger side.
const RING: f64 = 0.03;

/// How often a spot is drawn anew that does not suit.
const TRIES: usize = 200;

/// How far spots of a door lie from its middle, along both axes \[m\].
const DOOR_DEPTH: f64 = 0.4;

/// Least width of a door in deciding whether the robot is in it \[m\].
const DOOR: f64 = 0.8;

/// The belief after one observation.
#[derive(Debug, Clone)]
pub struct TourStep {
    /// Since the start \[m\].
    pub distance: f64,
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
    /// The steps, the first one before any observation.
    pub steps: Vec<TourStep>,
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
        let scans = take_views(&map, &world, config, &mut stream(seed, "views"))?;
        let views = PlaceViews::new(&scans, config.independence, config.surprise)?;
        let filter = TopologicalFilter::new(map.clone())?;
        let mut drive =
            Drive { filter, views, steps: Vec::new(), distance: 0.0, distance_at_step: 0.0 };
        drive.follow(SimulatedTour::new("topological", &config.tour, seed)?, config.look_every)?;
        Ok(TopologicalTour { grid: world.grid().clone(), map, steps: drive.steps })
    }
}

impl Demonstration for TopologicalConfig {
    fn check(&self) -> Result<()> {
        check_count("demonstration.views", self.views, 10_000)?;
        positive("demonstration.look_every", self.look_every)?;
        positive("demonstration.independence", self.independence)?;
        probability("demonstration.surprise", self.surprise)?;
        Ok(())
    }

    fn run(&self, title: &str, seed: u64) -> Result<Illustration> {
        let tour = TopologicalTour::new(self, seed)?;
        let name = |place: usize| tour.map.places()[place].name.as_str();
        let share = |is: &dyn Fn(&TourStep) -> bool| {
            let seen = &tour.steps[1..];
            seen.iter().filter(|step| is(step)).count() as f64 / seen.len().max(1) as f64
        };
        let right = share(&|step| step.most_likely() == step.place);
        let near = share(&|step| step.is_near(&tour.map));
        let found = tour.steps.iter().position(|step| step.belief[step.place] > 0.5);
        let head =
            format!("{:>8}  {:<14}{:<14}{:>9}", "way [m]", "place", "most likely", "P(place)");
        let mut lines = vec![head];
        lines.extend(choose(tour.steps.len()).map(|k| {
            let step = &tour.steps[k];
            let (place, best) = (name(step.place), name(step.most_likely()));
            format!("{:>8.1}  {place:<14}{best:<14}{:>9.3}", step.distance, step.belief[step.place])
        }));
        lines.push(format!(
            "{} places, {} looks: the right place in {:.0} %, it or its neighbour in {:.0} %",
            tour.map.places().len(),
            tour.steps.len() - 1,
            100.0 * right,
            100.0 * near
        ));
        let summary = json!({
            "places": tour.map.places().len(),
            "looks": tour.steps.len() - 1,
            "right_share": right,
            "right_or_neighbour_share": near,
            "found_after_looks": found,
        });
        let figures = beliefs(&tour, title).into_iter().chain([along_the_path(&tour)]);
        Ok(Illustration::new(lines, summary, figures.collect()))
    }
}

impl TourStep {
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

/// A drive with its filter.
struct Drive {
    filter: TopologicalFilter,
    views: PlaceViews,
    steps: Vec<TourStep>,
    distance: f64,
    /// Distance at the last step \[m\].
    distance_at_step: f64,
}

impl Drive {
    fn follow(&mut self, mut tour: SimulatedTour, every: f64) -> Result<()> {
        let mut odometry: Option<Pose2> = None;
        let mut scan: Option<Arc<LaserScan>> = None;
        while let Some(event) = tour.next_event()? {
            match event.payload {
                Payload::Control(Control::Odometry(pose)) => {
                    self.distance += odometry.map_or(0.0, |before| before.distance(pose));
                    odometry = Some(pose);
                }
                Payload::Measurement(Measurement::Scan { scan: new, .. }) => scan = Some(new),
                Payload::Truth(truth) => {
                    if self.steps.is_empty() {
                        self.keep(truth.pose);
                    }
                    let due =
                        self.steps.len() == 1 || self.distance - self.distance_at_step >= every;
                    if let Some(scan) = scan.take().filter(|_| due) {
                        self.observe(&scan, truth.pose)?;
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn observe(&mut self, scan: &LaserScan, truth: Pose2) -> Result<()> {
        self.filter.predict(self.distance - self.distance_at_step)?;
        self.distance_at_step = self.distance;
        if let Some(likelihoods) = self.views.likelihoods(scan)? {
            self.filter.correct(&likelihoods)?;
        }
        self.keep(truth);
        Ok(())
    }

    fn keep(&mut self, truth: Pose2) {
        let belief = self.filter.belief().to_vec();
        let place = place_of(self.filter.map(), &truth.position());
        self.steps.push(TourStep { distance: self.distance, truth, place, belief });
    }
}

/// For each place of the map so many scans.
fn take_views(
    map: &TopologicalMap,
    world: &TourWorld,
    config: &TopologicalConfig,
    rng: &mut ChaCha8Rng,
) -> Result<Vec<Vec<LaserScan>>> {
    let scanner = config.tour.laser.scanner()?;
    let radius = config.tour.robot.radius;
    let mut places = Vec::with_capacity(map.places().len());
    for (index, place) in map.places().iter().enumerate() {
        let suits =
            |spot: &Point2<f64>| world.clearance(spot) >= radius && place_of(map, spot) == index;
        let mut scans = Vec::with_capacity(config.views);
        for _ in 0..config.views {
            let spot = draw(place, &suits, rng);
            let robot = Pose2::new(spot.x, spot.y, rng.random_range(-PI..PI));
            scans.push(scanner.scan(world.walls(), robot, rng));
        }
        places.push(scans);
    }
    Ok(places)
}

/// A spot of a place; its middle where none suits.
fn draw(place: &Place, suits: &impl Fn(&Point2<f64>) -> bool, rng: &mut ChaCha8Rng) -> Point2<f64> {
    let around = Bounds::around(place.outline.iter().copied());
    let [low, high] = around.map_or_else(
        || {
            [-DOOR_DEPTH, DOOR_DEPTH]
                .map(|off| Point2::new(place.position.x + off, place.position.y + off))
        },
        |bounds| [bounds.min, bounds.max],
    );
    for _ in 0..TRIES {
        let mut between = |low: f64, high: f64| low + (high - low) * rng.random::<f64>();
        let spot = Point2::new(between(low.x, high.x), between(low.y, high.y));
        if suits(&spot) {
            return spot;
        }
    }
    place.position
}

/// Which of so many steps are shown: the first ones densely, the last one too.
fn choose(count: usize) -> impl Iterator<Item = usize> {
    let last = count.saturating_sub(1);
    let wanted = (0..FRAMES).map(move |k| {
        let share = k as f64 / (FRAMES - 1) as f64;
        ((last as f64 * share * share).round() as usize).max(k).min(last)
    });
    let mut shown: Vec<usize> = wanted.collect();
    shown.dedup();
    shown.into_iter()
}

fn beliefs(tour: &TopologicalTour, title: &str) -> Option<FigureFile> {
    let canvas = Canvas::new(&tour.grid)?;
    let places: Vec<usize> = canvas.places().map(|point| place_of(&tour.map, &point)).collect();
    let links = tour.map.edges().iter().flat_map(|edge| {
        let [from, to] = edge.between.map(|place| tour.map.places()[place].position);
        let points: Vec<_> =
            [from].into_iter().chain(edge.via.iter().copied()).chain([to]).collect();
        let pair =
            |pair: &[nalgebra::Point2<f64>]| ((pair[0].x, pair[0].y), (pair[1].x, pair[1].y));
        points.windows(2).map(pair).collect::<Vec<_>>()
    });
    let links: Vec<_> = links.collect();
    let mut frames = Frames::new(title)
        .subtitle("each place in the colour of its probability")
        .bar(color::bar(&LIKELIHOOD, 0.0, 1.0, "probability of a place"));
    for step in choose(tour.steps.len()).map(|k| &tour.steps[k]) {
        let image = canvas
            .paint(&tour.grid, |pixel, _| color::along(&LIKELIHOOD, step.belief[places[pixel]]));
        let scene = Scene::new("")
            .backdrop(image)
            .segments(Role::Map.width(0.8), "ways of the map", links.iter().copied())
            .ring("robot", RING * canvas.larger_side(), step.truth);
        frames = frames.frame(caption(tour, step), scene);
    }
    Some(FigureFile::new(
        "topological.svg",
        "The probability of each room, corridor and door, along a tour",
        frames.render(),
    ))
}

fn caption(tour: &TopologicalTour, step: &TourStep) -> String {
    let best = step.most_likely();
    let name = &tour.map.places()[best].name;
    format!("{:.1} m: {name}, {:.0} %", step.distance, 100.0 * step.belief[best])
}

fn along_the_path(tour: &TopologicalTour) -> FigureFile {
    let steps = || tour.steps.iter();
    let of_truth = steps().map(|step| (step.distance, step.belief[step.place]));
    let nearby = steps().map(|step| {
        let next = tour.map.neighbours(step.place).iter().map(|(next, _)| step.belief[*next]);
        (step.distance, step.belief[step.place] + next.sum::<f64>())
    });
    let chart = Chart::new("probability")
        .y_range(0.0, 1.05)
        .line(Role::Method(1), "the right place or one next to it", nearby)
        .line(Role::Method(0), "the right place", of_truth);
    let svg = Figure::new("How sure the robot is of the right place")
        .x_label("way [m]")
        .panel(chart)
        .render();
    FigureFile::new("places.svg", "Probability of the right place along the tour", svg)
}
