//! What one column of the picture shows.
//!
//! The optical axis is level, so that all pixels of a column look along one planar ray, and every
//! wall it meets has one depth all the way up. Looking from the bottom of the picture up one sees
//! the floor, the nearest wall, over its edge the floor behind it, the next wall, and so on.

use crate::world::{Rgb, WallWorld};
use loc_core::Pose2;

/// What a stretch of a column shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Surface {
    /// A wall with its inverse depth \[1/m\].
    Wall {
        /// 1 / depth.
        inverse_depth: f64,
        /// Its colour.
        color: Rgb,
    },
    /// The floor, whose depth is that of the row.
    Floor,
    /// Nothing in reach.
    Nothing,
}

/// A column as stretches (first row, surface), read from the top of the picture down.
#[derive(Debug, Clone)]
pub(super) struct Column {
    /// The stretches that are still to come, the next one last.
    ahead: Vec<(usize, Surface)>,
    now: Surface,
}

impl Column {
    /// What a row shows; rows are asked for in order.
    pub(super) fn at(&mut self, row: usize) -> Surface {
        while let Some((_, surface)) = self.ahead.pop_if(|(from, _)| *from <= row) {
            self.now = surface;
        }
        self.now
    }
}

/// View of a level camera at height `height` \[m\].
pub(super) struct View<'a> {
    pub(super) pose: Pose2,
    pub(super) height: f64,
    pub(super) reach: f64,
    /// How far up the rays of each row go per metre of depth, from the upper edge on.
    pub(super) row_slopes: &'a [f64],
}

impl View<'_> {
    /// The column whose rays go `slope` to the left per metre of depth.
    pub(super) fn column(&self, world: &(impl WallWorld + ?Sized), slope: f64) -> Column {
        let direction = self.pose.theta + slope.atan();
        let secant = f64::hypot(1.0, slope);
        let mut ahead = Vec::with_capacity(4);
        // Rows from `free` on are taken.
        let mut free = self.row_slopes.len();
        let mut show = |from: usize, surface: Surface| {
            if from < free {
                ahead.push((from, surface));
                free = from;
            }
            free > 0
        };
        world.visit_walls(&self.pose.position(), direction, self.reach * secant, &mut |wall| {
            let inverse_depth = secant / wall.range;
            let foot = self.row_below(-self.height * inverse_depth);
            let top = self.row_below((wall.height - self.height) * inverse_depth);
            show(foot, Surface::Floor)
                && show(top, Surface::Wall { inverse_depth, color: wall.color })
        });
        show(self.row_below(0.0), Surface::Floor);
        show(0, Surface::Nothing);
        Column { ahead, now: Surface::Nothing }
    }

    /// The first row, from the top, that looks lower than `slope`.
    fn row_below(&self, slope: f64) -> usize {
        self.row_slopes.partition_point(|row| *row >= slope)
    }
}
