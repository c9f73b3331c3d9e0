//! What is to be known of one region: its middle, its width, its kind, the ways to its doors.

use super::clear::around;
use super::floor::Floor;
use super::outline;
use super::passages::Passage;
use super::regions::NONE;
use super::{ExtractSettings, PlaceKind};
use crate::grid::Cell;
use nalgebra::Point2;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

/// Steps from cell to cell and across a corner, in units whose ratio is the root of 2.
const STEPS: [u32; 2] = [70, 99];

/// What a cell far from all walls costs, and what the cells beside a wall cost more.
const PLAIN: u32 = 10;
const WALLS: u32 = 100;

/// Middles have at least this share of the greatest clearance of their region.
const ROOMY: f64 = 0.8;

/// A region, measured.
pub(super) struct Inside {
    /// A roomy cell near its middle.
    pub(super) center: Cell,
    /// The ways from there to its passages, by their numbers: points between both \[m\].
    pub(super) ways: HashMap<usize, Vec<Point2<f64>>>,
    pub(super) outline: Vec<Point2<f64>>,
    clearance: u32,
    /// Its length divided by its mean width.
    elongation: f64,
}

impl Inside {
    /// Diameter of the largest circle in it \[m\].
    pub(super) fn width(&self, floor: &Floor) -> f64 {
        (2.0 * floor.metres(self.clearance) - floor.frame.resolution()).max(0.0)
    }

    pub(super) fn kind(&self, settings: &ExtractSettings) -> PlaceKind {
        let leads_on = self.ways.len() >= 2;
        let long = self.elongation >= settings.elongation;
        if leads_on && long { PlaceKind::Corridor } else { PlaceKind::Room }
    }
}

/// Measures all regions.
pub(super) fn measure(floor: &Floor, labels: &[usize], passages: &[Passage]) -> Vec<Inside> {
    let mut cells: Vec<Vec<usize>> = Vec::new();
    for (index, &label) in labels.iter().enumerate().filter(|(_, label)| **label != NONE) {
        if label >= cells.len() {
            cells.resize(label + 1, Vec::new());
        }
        cells[label].push(index);
    }
    let mut far = vec![u32::MAX; labels.len()];
    let regions = cells.iter().enumerate();
    regions
        .map(|(region, cells)| inside(floor, labels, passages, region, cells, &mut far))
        .collect()
}

fn inside(
    floor: &Floor,
    labels: &[usize],
    passages: &[Passage],
    region: usize,
    cells: &[usize],
    far: &mut [u32],
) -> Inside {
    let width = floor.frame.width();
    let clearance = cells.iter().map(|&index| floor.clearance[index]).max().unwrap_or(0);
    let center = center(floor, cells, clearance);
    // Once along the middle of the floor, for ways that look like ways, then from the end that is
    // farthest straight, for the length.
    let farthest = |far: &[u32]| cells.iter().copied().max_by_key(|&index| (far[index], index));
    walk(floor, labels, region, center, WALLS, far);
    let own = passages.iter().enumerate().filter(|(_, p)| p.between.contains(&region));
    let ways = own.map(|(number, p)| (number, way(floor, labels, region, p.cell, far))).collect();
    let end = farthest(far).unwrap_or(center);
    cells.iter().for_each(|&index| far[index] = u32::MAX);
    walk(floor, labels, region, end, 0, far);
    let length = farthest(far).map_or(0.0, |index| f64::from(far[index]));
    let length = length / f64::from(STEPS[0] * PLAIN);
    Inside {
        center: Cell::new(center % width, center / width),
        ways,
        outline: outline::trace(floor, labels, region, cells),
        clearance,
        elongation: length * length / cells.len().max(1) as f64,
    }
}

/// The way from the middle of a region to the cell of a passage, down from step to step and then
/// turned round: the points between both.
fn way(
    floor: &Floor,
    labels: &[usize],
    region: usize,
    passage: Cell,
    far: &[u32],
) -> Vec<Point2<f64>> {
    let (width, height) = (floor.frame.width(), floor.frame.height());
    let place = |index: usize| Point2::new((index % width) as f64, (index / width) as f64);
    let mut at = passage.row * width + passage.column;
    let mut steps = if labels[at] == region { far[at] } else { u32::MAX };
    let mut cells = vec![place(at)];
    loop {
        let near = around(at, width, height).filter(|&other| labels[other] == region);
        let Some(next) = near.min_by_key(|&other| far[other]).filter(|&k| far[k] < steps) else {
            break;
        };
        (at, steps) = (next, far[next]);
        cells.push(place(at));
    }
    let mut way = outline::straightened(&cells);
    way.reverse();
    let between = way.len().saturating_sub(1).max(1);
    let centers = way.get(1..between).unwrap_or_default().iter();
    centers.map(|p| floor.frame.to_map(p.x + 0.5, p.y + 0.5)).collect()
}

/// The cell nearest to the mean of all cells, of those where a robot can stand, roomy ones first.
fn center(floor: &Floor, cells: &[usize], clearance: u32) -> usize {
    let place = |index: usize| {
        let width = floor.frame.width();
        Point2::new((index % width) as f64, (index / width) as f64)
    };
    let sum: nalgebra::Vector2<f64> = cells.iter().map(|&index| place(index).coords).sum();
    let mean = Point2::from(sum / cells.len().max(1) as f64);
    let roomy = f64::from(clearance) * ROOMY * ROOMY;
    let rank = |index: usize| {
        let stands = floor.furnished[index] > floor.robot;
        (!stands, f64::from(floor.clearance[index]) < roomy)
    };
    let off = |index: usize| nalgebra::distance_squared(&place(index), &mean);
    let order = |&&a: &&usize, &&b: &&usize| rank(a).cmp(&rank(b)).then(off(a).total_cmp(&off(b)));
    cells.iter().min_by(order).copied().unwrap_or(0)
}

/// The costs of the ways from one cell to all others of its region (Dijkstra): [`STEPS`] times
/// [`PLAIN`], and more near walls.
fn walk(floor: &Floor, labels: &[usize], region: usize, start: usize, walls: u32, far: &mut [u32]) {
    let (width, height) = (floor.frame.width(), floor.frame.height());
    let mut open = BinaryHeap::from([Reverse((0, start))]);
    far[start] = 0;
    while let Some(Reverse((steps, index))) = open.pop() {
        if steps > far[index] {
            continue;
        }
        for other in around(index, width, height).filter(|&other| labels[other] == region) {
            let across = other % width != index % width && other / width != index / width;
            let cost = PLAIN + walls_cost(walls, floor.furnished[other]);
            let steps = steps.saturating_add(STEPS[usize::from(across)] * cost);
            if steps < far[other] {
                far[other] = steps;
                open.push(Reverse((steps, other)));
            }
        }
    }
}

/// What a cell costs more: `walls` divided by its clearance, and a lot under furniture.
fn walls_cost(walls: u32, squared_clearance: u32) -> u32 {
    walls.checked_div(squared_clearance.isqrt()).unwrap_or(10 * walls)
}
