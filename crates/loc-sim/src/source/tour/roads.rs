//! Where a robot can drive, and the way from one place to another.
//!
//! The map is looked at in squares of about 10 cm. Those with room for the robot are joined to
//! their eight neighbours; the largest part that hangs together is where tours lead. Ways are
//! found by A* (Hart, Nilsson and Raphael, 1968), and squares near walls cost more, so that they
//! lead through the middle of doors.

use super::world::TourWorld;
use crate::Result;
use crate::config::field;
use loc_core::random::ChaCha8Rng;
use loc_maps::grid::GridFrame;
use nalgebra::Point2;
use rand::RngExt;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Side of the squares \[m\], as far as the map's cells allow.
const SQUARE: f64 = 0.1;
/// With this much more room than the robot needs, more makes no difference \[m\].
const COMFORT: f64 = 0.4;
/// How many times longer a way along a wall counts.
const RELUCTANCE: f64 = 4.0;
/// A place that somebody names may lie this far from where the robot can be \[m\].
const SNAP: f64 = 1.0;
const DIAGONAL: f64 = std::f64::consts::SQRT_2;

/// The squares that a robot can drive on.
#[derive(Debug)]
pub(super) struct Roads {
    frame: GridFrame,
    /// Factor by which a way over a square counts; 0 where the robot does not fit.
    cost: Vec<f32>,
    /// The squares of the largest part.
    places: Vec<u32>,
}

impl Roads {
    /// The roads for a robot that keeps `radius` \[m\] from walls.
    pub(super) fn new(world: &TourWorld, radius: f64) -> Result<Self> {
        let map = world.grid.frame();
        let square = SQUARE.max(map.resolution());
        let across = |cells: usize| (cells as f64 * map.resolution() / square).ceil() as usize;
        let (width, height) = (across(map.width()), across(map.height()));
        let frame = GridFrame::new(width, height, square, map.origin())?;
        let room = frame.cells().map(|cell| world.clearance(&frame.center(cell)));
        let cost = room.map(|room| match room - radius {
            spare if spare < 0.0 => 0.0,
            spare => (1.0 + RELUCTANCE * (1.0 - spare / COMFORT).max(0.0)) as f32,
        });
        let mut roads = Roads { frame, cost: cost.collect(), places: Vec::new() };
        roads.places = roads.largest_part();
        if roads.places.is_empty() {
            let expected = format!("free space for a robot of radius {radius} m");
            return Err(field("tour.world", &expected, "none"));
        }
        Ok(roads)
    }

    /// A place drawn evenly from the roads.
    pub(super) fn draw(&self, rng: &mut ChaCha8Rng) -> Point2<f64> {
        self.center(self.places[rng.random_range(0..self.places.len())])
    }

    /// The nearest place on the roads.
    ///
    /// # Errors
    /// [`crate::Error::Config`] where that is farther than 1 m.
    pub(super) fn nearest(&self, key: &str, point: Point2<f64>) -> Result<Point2<f64>> {
        let centers = self.places.iter().map(|&square| self.center(square));
        let far = |place: &Point2<f64>| nalgebra::distance(place, &point);
        let nearest = centers.min_by(|a, b| far(a).total_cmp(&far(b)));
        nearest.filter(|place| far(place) < SNAP).ok_or_else(|| {
            let found = format!("{:.2}, {:.2}", point.x, point.y);
            field(key, "a place within 1 m of where the robot can drive", &found)
        })
    }

    /// The cheapest way from one place on the roads to another, square by square; `None` where
    /// one of them is not on the roads.
    pub(super) fn way(&self, from: Point2<f64>, to: Point2<f64>) -> Option<Vec<Point2<f64>>> {
        let (start, goal) = (self.square_at(from)?, self.square_at(to)?);
        let mut best = vec![f32::INFINITY; self.cost.len()];
        let mut came_from = vec![start; self.cost.len()];
        let mut open = BinaryHeap::new();
        best[start as usize] = 0.0;
        open.push(Reverse((0_u32, start)));
        while let Some(Reverse((_, square))) = open.pop() {
            if square == goal {
                return Some(self.trace(&came_from, start, goal));
            }
            let so_far = best[square as usize];
            for (next, length) in self.neighbours(square) {
                let mean = 0.5 * (self.cost[square as usize] + self.cost[next as usize]);
                let cost = so_far + mean * length as f32;
                if cost < best[next as usize] {
                    best[next as usize] = cost;
                    came_from[next as usize] = square;
                    let estimate = f64::from(cost) + self.steps_between(next, goal);
                    // Thousandths of a square are fine enough to order by.
                    open.push(Reverse(((1e3 * estimate) as u32, next)));
                }
            }
        }
        None
    }

    fn trace(&self, came_from: &[u32], start: u32, goal: u32) -> Vec<Point2<f64>> {
        let mut way = vec![self.center(goal)];
        let mut square = goal;
        while square != start {
            square = came_from[square as usize];
            way.push(self.center(square));
        }
        way.reverse();
        way
    }

    fn largest_part(&self) -> Vec<u32> {
        let mut seen = vec![false; self.cost.len()];
        let mut largest = Vec::new();
        for first in 0..self.cost.len() {
            if seen[first] || self.cost[first] <= 0.0 {
                continue;
            }
            // A grid has at most 2^28 cells.
            let mut part = vec![first as u32];
            seen[first] = true;
            let mut done = 0;
            while let Some(&square) = part.get(done) {
                done += 1;
                for (next, _) in self.neighbours(square) {
                    if !std::mem::replace(&mut seen[next as usize], true) {
                        part.push(next);
                    }
                }
            }
            if part.len() > largest.len() {
                largest = part;
            }
        }
        largest
    }

    /// The squares beside one that have room, with their distances \[squares\].
    fn neighbours(&self, square: u32) -> impl Iterator<Item = (u32, f64)> + '_ {
        let (column, row) = self.column_row(square);
        let (width, height) = (self.frame.width() as i64, self.frame.height() as i64);
        let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
        around.filter(|&step| step != (0, 0)).filter_map(move |(dx, dy)| {
            let (x, y) = (column + dx, row + dy);
            let inside = (0..width).contains(&x) && (0..height).contains(&y);
            let next = inside.then_some((y * width + x) as u32)?;
            let length = if dx != 0 && dy != 0 { DIAGONAL } else { 1.0 };
            (self.cost[next as usize] > 0.0).then_some((next, length))
        })
    }

    fn steps_between(&self, a: u32, b: u32) -> f64 {
        let ((ax, ay), (bx, by)) = (self.column_row(a), self.column_row(b));
        ((ax - bx) as f64).hypot((ay - by) as f64)
    }

    fn column_row(&self, square: u32) -> (i64, i64) {
        let width = self.frame.width() as i64;
        (i64::from(square) % width, i64::from(square) / width)
    }

    fn center(&self, square: u32) -> Point2<f64> {
        let (column, row) = self.column_row(square);
        self.frame.to_map(column as f64 + 0.5, row as f64 + 0.5)
    }

    /// The square of a point, or the nearest one with room: a robot that follows a way is never
    /// exactly on it.
    fn square_at(&self, point: Point2<f64>) -> Option<u32> {
        let cell = self.frame.cell_at(&point)?;
        let square = self.frame.index(cell)? as u32;
        if self.cost[square as usize] > 0.0 {
            return Some(square);
        }
        let far = |next: &u32| nalgebra::distance(&self.center(*next), &point);
        self.places.iter().copied().min_by(|a, b| far(a).total_cmp(&far(b)))
    }
}
