//! Probabilities of poses: a layer of positions for each heading; and the moments of weighted poses.

use crate::Result;
use crate::histogram::Kernel;
use loc_core::{Gaussian, Pose2, angle};
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;
use std::ops::Range;

/// How many headings, rows and columns a stack has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Size {
    pub(super) headings: usize,
    pub(super) rows: usize,
    pub(super) columns: usize,
}

/// The rows and columns of a layer outside of which all is 0.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Extent {
    pub(super) rows: Range<usize>,
    pub(super) columns: Range<usize>,
}

/// A probability for every heading, row and column. It stores for each heading where there is
/// anything but 0, so that a belief in a few places costs little.
#[derive(Debug, Clone)]
pub(super) struct Stack {
    size: Size,
    mass: Vec<f64>,
    extents: Vec<Extent>,
}

/// How a layer moves: kernels along columns and rows.
#[derive(Debug, Clone)]
pub(super) struct LayerMove {
    pub(super) across: Kernel,
    pub(super) up: Kernel,
}

impl Size {
    pub(super) fn layer(&self) -> usize {
        self.rows * self.columns
    }

    pub(super) fn count(&self) -> usize {
        self.headings * self.layer()
    }
}

impl Extent {
    pub(super) fn is_empty(&self) -> bool {
        self.rows.is_empty() || self.columns.is_empty()
    }

    /// The smallest one around both.
    fn joined(&self, other: &Extent) -> Extent {
        if self.is_empty() {
            return other.clone();
        }
        if other.is_empty() {
            return self.clone();
        }
        let join = |a: &Range<usize>, b: &Range<usize>| a.start.min(b.start)..a.end.max(b.end);
        Extent { rows: join(&self.rows, &other.rows), columns: join(&self.columns, &other.columns) }
    }
}

impl Stack {
    /// Nothing anywhere.
    pub(super) fn new(size: Size) -> Self {
        let extents = vec![Extent::default(); size.headings];
        Stack { size, mass: vec![0.0; size.count()], extents }
    }

    pub(super) fn size(&self) -> Size {
        self.size
    }

    /// The probabilities of a heading, row by row.
    pub(super) fn layer(&self, heading: usize) -> &[f64] {
        let length = self.size.layer();
        self.mass.get(heading * length..(heading + 1) * length).unwrap_or_default()
    }

    /// Where there may be anything but 0.
    pub(super) fn extent(&self, heading: usize) -> &Extent {
        &self.extents[heading]
    }

    pub(super) fn get(&self, heading: usize, place: usize) -> f64 {
        self.mass[heading * self.size.layer() + place]
    }

    /// Adds probability to a cell, by its place in the layer.
    pub(super) fn add(&mut self, heading: usize, place: usize, mass: f64) {
        self.mass[heading * self.size.layer() + place] += mass;
        let (row, column) = (place / self.size.columns, place % self.size.columns);
        let one = Extent { rows: row..row + 1, columns: column..column + 1 };
        self.extents[heading] = self.extents[heading].joined(&one);
    }

    /// The cells with probability above 0: heading, place in the layer, probability.
    pub(super) fn cells(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.size.headings).flat_map(move |heading| {
            let Extent { rows, columns } = self.extents[heading].clone();
            let layer = self.layer(heading);
            rows.flat_map(move |row| {
                let start = row * self.size.columns;
                let columns = columns.clone();
                columns.map(move |column| (heading, start + column, layer[start + column]))
            })
            .filter(|(_, _, mass)| *mass > 0.0)
        })
    }

    /// Changes each probability; `change` gets heading, place in the layer and probability.
    pub(super) fn change(&mut self, mut change: impl FnMut(usize, usize, f64) -> f64) {
        let Size { columns: width, .. } = self.size;
        let length = self.size.layer();
        for (heading, extent) in self.extents.iter().enumerate() {
            for row in extent.rows.clone() {
                let start = row * width;
                for place in start + extent.columns.start..start + extent.columns.end {
                    let mass = &mut self.mass[heading * length + place];
                    *mass = change(heading, place, *mass);
                }
            }
        }
    }

    pub(super) fn total(&self) -> f64 {
        self.cells().map(|(_, _, mass)| mass).sum()
    }

    /// Sets all cells and extents to empty.
    pub(super) fn clear(&mut self) {
        self.change(|_, _, _| 0.0);
        self.extents.fill(Extent::default());
    }

    /// Adds what becomes of `from`, times `share`, when its layers move by `layer_move` and turn by
    /// `turn` layers. Full turns lead back to where they began if `wraps`; otherwise what turns
    /// beyond the last heading is left out, like what moves beyond the edges.
    pub(super) fn add_moved(
        &mut self,
        from: &Stack,
        share: f64,
        layer_move: impl Fn(usize) -> Result<LayerMove>,
        turn: &Kernel,
        wraps: bool,
    ) -> Result<()> {
        let mut patch = Patch::default();
        for heading in 0..from.size.headings {
            if from.extents[heading].is_empty() {
                continue;
            }
            let by = layer_move(heading)?;
            patch.fill(from.layer(heading), &from.extents[heading], &self.size, &by);
            for (away, weight) in turn.iter() {
                let to = heading as isize + away;
                let count = self.size.headings as isize;
                let to = if wraps { to.rem_euclid(count) } else { to };
                if (0..count).contains(&to) {
                    self.add_patch(to as usize, &patch, share * weight);
                }
            }
        }
        Ok(())
    }

    fn add_patch(&mut self, heading: usize, patch: &Patch, weight: f64) {
        if patch.extent.is_empty() {
            return;
        }
        let Extent { rows, columns } = patch.extent.clone();
        let start = heading * self.size.layer();
        for (row, source) in rows.zip(patch.mass.chunks_exact(columns.len())) {
            let first = start + row * self.size.columns;
            let target = &mut self.mass[first + columns.start..first + columns.end];
            for (target, source) in target.iter_mut().zip(source) {
                *target += weight * source;
            }
        }
        self.extents[heading] = self.extents[heading].joined(&patch.extent);
    }
}

/// A layer that has moved, before it is turned.
#[derive(Default)]
struct Patch {
    extent: Extent,
    /// Row by row over the extent.
    mass: Vec<f64>,
    /// Moved along the columns only, over the rows of the source.
    across: Vec<f64>,
}

impl Patch {
    fn fill(&mut self, layer: &[f64], source: &Extent, size: &Size, by: &LayerMove) {
        let columns = reached(&source.columns, &by.across, size.columns);
        let rows = reached(&source.rows, &by.up, size.rows);
        self.extent = Extent { rows, columns };
        if self.extent.is_empty() {
            return;
        }
        let Extent { rows, columns } = &self.extent;
        let width = columns.len();
        self.across.clear();
        self.across.resize(source.rows.len() * width, 0.0);
        let offset = source.columns.start as isize - columns.start as isize;
        for (row, across) in source.rows.clone().zip(self.across.chunks_exact_mut(width)) {
            let first = row * size.columns;
            let from = &layer[first + source.columns.start..first + source.columns.end];
            by.across.spread(from, across, offset);
        }
        self.mass.clear();
        self.mass.resize(rows.len() * width, 0.0);
        let offset = source.rows.start as isize - rows.start as isize;
        for (row, across) in self.across.chunks_exact(width).enumerate() {
            for (away, weight) in by.up.iter() {
                let to = row as isize + offset + away;
                let Some(to) = usize::try_from(to).ok().filter(|to| *to < rows.len()) else {
                    continue;
                };
                let to = &mut self.mass[to * width..(to + 1) * width];
                to.iter_mut().zip(across).for_each(|(to, across)| *to += weight * across);
            }
        }
    }
}

/// The cells of `count` that a kernel leads to from a range.
fn reached(from: &Range<usize>, kernel: &Kernel, count: usize) -> Range<usize> {
    let last = kernel.first() + kernel.weights().len() as isize - 1;
    let clip = |end: isize| end.clamp(0, count as isize) as usize;
    let start = clip(from.start as isize + kernel.first());
    start..clip(from.end as isize + last).max(start)
}

/// Variance of a heading that may be anything, about whatever mean \[rad^2\].
const ANY_HEADING: f64 = PI * PI / 3.0;

/// Sums over weighted poses, from which mean and covariance follow.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Sums {
    weight: f64,
    x: f64,
    y: f64,
    cos: f64,
    sin: f64,
}

impl Sums {
    pub(super) fn add(&mut self, pose: Pose2, weight: f64) {
        self.add_any_heading([pose.x, pose.y], weight);
        let (sin, cos) = pose.theta.sin_cos();
        self.cos += weight * cos;
        self.sin += weight * sin;
    }

    /// Adds a place of which all headings are equally likely.
    pub(super) fn add_any_heading(&mut self, [x, y]: [f64; 2], weight: f64) {
        self.weight += weight;
        self.x += weight * x;
        self.y += weight * y;
    }

    /// The mean; headings are averaged as directions. `None` without weight.
    fn mean(&self) -> Option<Pose2> {
        let Sums { weight, x, y, cos, sin } = *self;
        let any = weight > 0.0 && weight.is_finite();
        any.then(|| Pose2 { x: x / weight, y: y / weight, theta: angle::wrap(sin.atan2(cos)) })
    }

    /// The deviations from the mean, to be filled with the same poses again; `None` without
    /// weight.
    pub(super) fn spread(&self) -> Option<Spread> {
        Some(Spread { mean: self.mean()?, weight: self.weight, covariance: Matrix3::zeros() })
    }

    /// Mean and covariance over (x, y, theta) of poses which each stand for a cell with this side
    /// \[m\] and sector \[rad\]; `None` without weight.
    pub(super) fn gaussian<I: Iterator<Item = (Pose2, f64)>>(
        poses: impl Fn() -> I,
        cell: f64,
        sector: f64,
    ) -> Option<(f64, Gaussian<3>)> {
        let mut sums = Sums::default();
        poses().for_each(|(pose, weight)| sums.add(pose, weight));
        let mut spread = sums.spread()?;
        poses().for_each(|(pose, weight)| spread.add(pose, weight));
        Some((sums.weight, spread.gaussian(cell, sector)))
    }
}

/// Deviations from a mean.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spread {
    mean: Pose2,
    weight: f64,
    covariance: Matrix3<f64>,
}

impl Spread {
    pub(super) fn add(&mut self, pose: Pose2, weight: f64) {
        let turned = angle::difference(pose.theta, self.mean.theta);
        self.add_deviation(
            Vector3::new(pose.x - self.mean.x, pose.y - self.mean.y, turned),
            weight,
        );
    }

    pub(super) fn add_any_heading(&mut self, [x, y]: [f64; 2], weight: f64) {
        self.add_deviation(Vector3::new(x - self.mean.x, y - self.mean.y, 0.0), weight);
        self.covariance[(2, 2)] += weight / self.weight * ANY_HEADING;
    }

    fn add_deviation(&mut self, off: Vector3<f64>, weight: f64) {
        self.covariance += off * off.transpose() * (weight / self.weight);
    }

    /// With the variance of a pose within its cell \[m\] and sector \[rad\], which is as likely in
    /// all of their extent.
    pub(super) fn gaussian(&self, cell: f64, sector: f64) -> Gaussian<3> {
        let of_cell = Vector3::new(cell * cell, cell * cell, sector * sector) / 12.0;
        let covariance = self.covariance + Matrix3::from_diagonal(&of_cell);
        Gaussian { mean: self.mean.to_vector(), covariance }
    }
}
