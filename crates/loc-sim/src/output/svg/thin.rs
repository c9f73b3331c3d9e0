//! Fewer points, same picture.
//!
//! A recording has a hundred thousand poses, a figure some hundred pixels. Points are left out
//! only where the eye cannot tell: [`simplify`] for shapes, [`thin_columns`] for curves that swing
//! faster than pixels follow.

/// Points per block of [`simplify`]; its time is at worst this many times the number of points.
const BLOCK: usize = 1024;

/// The points of a polyline that matter: each point left out lies within `tolerance` of the
/// segment that replaces it.
///
/// The algorithm is that of Ramer (1972), Douglas and Peucker (1973): keep the point farthest
/// from the segment between the ends, and go on on both sides of it, until none is farther than
/// `tolerance`. It runs over blocks of 1024 points, whose ends are always kept, so that it stays
/// linear for any input. Distances are taken to the segment, not to its line: a path that turns
/// back keeps its tip. The points must be finite.
pub fn simplify(points: &[(f64, f64)], tolerance: f64) -> Vec<(f64, f64)> {
    if points.len() < 3 {
        return points.to_vec();
    }
    let last = points.len() - 1;
    let mut keep = vec![false; points.len()];
    let mut open: Vec<(usize, usize)> =
        (0..last).step_by(BLOCK).map(|start| (start, (start + BLOCK).min(last))).collect();
    for &(start, end) in &open {
        (keep[start], keep[end]) = (true, true);
    }
    while let Some((start, end)) = open.pop() {
        if let Some((index, distance)) = farthest(points, start, end)
            && distance > tolerance
        {
            keep[index] = true;
            open.push((start, index));
            open.push((index, end));
        }
    }
    points.iter().zip(keep).filter_map(|(&point, kept)| kept.then_some(point)).collect()
}

/// The inner point farthest from the segment between two points, with its distance.
fn farthest(points: &[(f64, f64)], start: usize, end: usize) -> Option<(usize, f64)> {
    (start + 1..end)
        .map(|index| {
            let distance = distance_to_segment(points[index], points[start], points[end]);
            (index, distance)
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

fn distance_to_segment(point: (f64, f64), from: (f64, f64), to: (f64, f64)) -> f64 {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let (px, py) = (point.0 - from.0, point.1 - from.1);
    let length_squared = dx * dx + dy * dy;
    let share = if length_squared > 0.0 {
        ((px * dx + py * dy) / length_squared).clamp(0.0, 1.0)
    } else {
        0.0
    };
    f64::hypot(px - share * dx, py - share * dy)
}

/// A curve over x with at most four points per column of the given `width`: of each run of points
/// in one column the first, the lowest, the highest and the last.
///
/// This is M4 of Jugel et al. (2014): the vertical stroke that a column shows stays exactly the
/// same. The points must be finite, the width positive.
pub fn thin_columns(points: &[(f64, f64)], width: f64) -> Vec<(f64, f64)> {
    let column = |point: &(f64, f64)| (point.0 / width).floor();
    points
        .chunk_by(|a, b| column(a).total_cmp(&column(b)).is_eq())
        .flat_map(|run| {
            let by_y = |a: &usize, b: &usize| run[*a].1.total_cmp(&run[*b].1);
            let lowest = (0..run.len()).min_by(by_y).unwrap_or(0);
            let highest = (0..run.len()).max_by(by_y).unwrap_or(0);
            let mut kept = vec![0, lowest, highest, run.len() - 1];
            kept.sort_unstable();
            kept.dedup();
            kept.into_iter().map(|index| run[index])
        })
        .collect()
}
