//! Where no further answer is wanted: close to the answers there are.

use super::SearchSettings;
use loc_maps::grid::GridFrame;

/// The answers, best first, each with its surroundings in position and heading.
#[derive(Debug)]
pub(super) struct Zones {
    answers: Vec<Answer>,
    headings: u32,
    /// Squared distance \[cells^2\] and turn \[headings\] at which poses are apart.
    distance: f64,
    turn: f64,
}

/// An answer on the search's grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Answer {
    pub(super) heading: u32,
    pub(super) column: u32,
    pub(super) row: u32,
    pub(super) sum: u32,
}

impl Zones {
    pub(super) fn new(settings: &SearchSettings, frame: &GridFrame, headings: usize) -> Self {
        let distance = (settings.separation_distance / frame.resolution()).powi(2);
        let turn = settings.separation_angle * headings as f64 / std::f64::consts::TAU;
        Zones { answers: Vec::new(), headings: headings as u32, distance, turn }
    }

    /// No fewer poses than lie in a zone.
    pub(super) fn poses(&self) -> usize {
        let span = |reach: f64| (2.0 * reach.floor() + 1.0).min(1e9) as usize;
        let turns = span(self.turn).min(self.headings as usize);
        span(self.distance.sqrt()).saturating_pow(2).saturating_mul(turns)
    }

    /// Whether all poses at a heading in the `side` x `side` cells from (column, row) on lie in
    /// one zone.
    pub(super) fn cover(&self, heading: u32, [column, row]: [u32; 2], side: u32) -> bool {
        let farthest = |from: u32, to: u32| to.abs_diff(from).max((to + side - 1).abs_diff(from));
        self.answers.iter().any(|answer| {
            let turn = answer.heading.abs_diff(heading);
            let [x, y] =
                [farthest(answer.column, column), farthest(answer.row, row)].map(f64::from);
            f64::from(turn.min(self.headings - turn)) < self.turn && x * x + y * y < self.distance
        })
    }

    pub(super) fn push(&mut self, answer: Answer) {
        self.answers.push(answer);
    }

    pub(super) fn answers(&self) -> &[Answer] {
        &self.answers
    }
}
