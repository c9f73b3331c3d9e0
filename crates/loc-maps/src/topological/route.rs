//! The shortest way between two places (Dijkstra 1959).

use super::TopologicalMap;

/// A way through a [`TopologicalMap`].
#[derive(Debug, Clone, PartialEq)]
pub struct Route {
    /// The places from start to goal, both included.
    pub places: Vec<usize>,
    /// Its length \[m\].
    pub length: f64,
}

impl TopologicalMap {
    /// The shortest way from one place to another, `None` where there is none.
    ///
    /// Buildings have at most some thousand places, so the next nearest one is simply looked for
    /// among all.
    pub fn shortest_path(&self, from: usize, to: usize) -> Option<Route> {
        let count = self.places().len();
        if from >= count || to >= count {
            return None;
        }
        let mut length = vec![f64::INFINITY; count];
        let mut before = vec![from; count];
        let mut open: Vec<usize> = (0..count).collect();
        length[from] = 0.0;
        while let Some(nearest) = take_nearest(&mut open, &length) {
            if nearest == to || length[nearest].is_infinite() {
                break;
            }
            for &(next, step) in self.neighbours(nearest) {
                if length[nearest] + step < length[next] {
                    length[next] = length[nearest] + step;
                    before[next] = nearest;
                }
            }
        }
        length[to]
            .is_finite()
            .then(|| Route { places: trace(&before, from, to), length: length[to] })
    }
}

/// Takes the open place with the shortest way so far.
fn take_nearest(open: &mut Vec<usize>, length: &[f64]) -> Option<usize> {
    let by_length = |a: &usize, b: &usize| length[open[*a]].total_cmp(&length[open[*b]]);
    let place = (0..open.len()).min_by(by_length)?;
    Some(open.swap_remove(place))
}

fn trace(before: &[usize], from: usize, to: usize) -> Vec<usize> {
    let mut places = vec![to];
    let mut at = to;
    while at != from {
        at = before[at];
        places.push(at);
    }
    places.reverse();
    places
}
