//! Lateration: closed forms, Newton, least squares, and what to do where they have no answer.

mod bad_input;
mod circles;
mod locate;
mod sliding;
mod statistics;

use loc_filters::lateration::{LaterationSettings, Range, Solution, locate};

/// Exact distances from a place to landmarks, good to 0.1 m.
fn seen<const D: usize>(from: [f64; D], landmarks: &[[f64; D]]) -> Vec<Range<D>> {
    let distance = |landmark: &[f64; D]| {
        from.iter().zip(landmark).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
    };
    landmarks.iter().map(|landmark| Range::new(*landmark, distance(landmark), 0.1)).collect()
}

fn solve<const D: usize>(ranges: &[Range<D>]) -> Solution<D> {
    locate(ranges, None, &LaterationSettings::default()).unwrap()
}
