//! One frame in its parent.

use crate::source::ros::messages::Stamp;
use loc_core::nalgebra::Isometry3;
use std::collections::VecDeque;

/// The most transforms that are kept of a frame: 100 a second over 10 minutes.
const MAX: usize = 60_000;

/// The transforms of one frame, in order of time.
#[derive(Debug, Clone)]
pub(super) struct Edge {
    pub(super) parent: String,
    fixed: Option<Isometry3<f64>>,
    moving: VecDeque<(Stamp, Isometry3<f64>)>,
}

impl Edge {
    pub(super) fn new(parent: &str) -> Self {
        Edge { parent: parent.into(), fixed: None, moving: VecDeque::new() }
    }

    pub(super) fn fix(&mut self, transform: Isometry3<f64>) {
        self.fixed = Some(transform);
    }

    /// Adds a transform and drops those more than `keep` seconds older than the newest.
    pub(super) fn push(&mut self, stamp: Stamp, transform: Isometry3<f64>, keep: f64) {
        let later = self.moving.iter().rev().take_while(|(known, _)| *known > stamp).count();
        let place = self.moving.len() - later;
        match place.checked_sub(1).and_then(|last| self.moving.get_mut(last)) {
            Some(same) if same.0 == stamp => same.1 = transform,
            _ => self.moving.insert(place, (stamp, transform)),
        }
        while let (Some((first, _)), Some((last, _))) = (self.moving.front(), self.moving.back()) {
            if last.seconds_since(*first) <= keep && self.moving.len() <= MAX {
                break;
            }
            self.moving.pop_front();
        }
    }

    /// The transform at a time.
    pub(super) fn at(
        &self,
        frame: &str,
        stamp: Stamp,
        hold: f64,
    ) -> Result<Isometry3<f64>, String> {
        if let Some(fixed) = self.fixed {
            return Ok(fixed);
        }
        let after = self.moving.partition_point(|(known, _)| *known < stamp);
        let before = after.checked_sub(1).and_then(|before| self.moving.get(before));
        match (before, self.moving.get(after)) {
            (_, Some((at, transform))) if *at == stamp => Ok(*transform),
            (Some((from, first)), Some((to, second))) => {
                let share = stamp.seconds_since(*from) / to.seconds_since(*from);
                Ok(interpolate(first, second, share))
            }
            (Some((at, transform)), None) | (None, Some((at, transform)))
                if stamp.seconds_since(*at).abs() <= hold =>
            {
                Ok(*transform)
            }
            _ => Err(match (self.moving.front(), self.moving.back()) {
                (Some((first, _)), Some((last, _))) => format!(
                    "{frame} is known in {} from {:.3} s to {:.3} s only",
                    self.parent,
                    first.seconds(),
                    last.seconds()
                ),
                _ => format!("{frame} has no transform yet"),
            }),
        }
    }
}

fn interpolate(a: &Isometry3<f64>, b: &Isometry3<f64>, share: f64) -> Isometry3<f64> {
    // Half a turn has no shortest way; either end is as good.
    a.try_lerp_slerp(b, share, 1e-9).unwrap_or(if share < 0.5 { *a } else { *b })
}
