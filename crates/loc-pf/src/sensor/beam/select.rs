//! Which beams of a scan say something.

use loc_sensors::laser::LaserScan;

/// Numbers of at most `count` beams of a scan, evenly spread over those that say something: the
/// measured ranges, and those where nothing returned (longer than the longest range, +inf).
/// Failed beams (NaN) and those too near are dropped, before thinning.
pub fn telling_beams(scan: &LaserScan, count: usize) -> Vec<usize> {
    telling_beams_from(scan, scan.range_min, count)
}

/// The same with `nearest` \[m\] as the shortest range that says something.
pub(crate) fn telling_beams_from(scan: &LaserScan, nearest: f64, count: usize) -> Vec<usize> {
    // Written so that NaN says nothing.
    let tells = |(_, range): &(usize, &f64)| **range >= nearest;
    let all: Vec<usize> = scan.ranges.iter().enumerate().filter(tells).map(|(k, _)| k).collect();
    match count {
        _ if all.len() <= count => all,
        0 => Vec::new(),
        1 => vec![all[all.len() / 2]],
        _ => {
            let (gaps, last) = (count - 1, all.len() - 1);
            (0..count).map(|k| all[(k * last + gaps / 2) / gaps]).collect()
        }
    }
}

/// What a beam measured \[m\], +inf for no return; `None` for what says nothing.
pub(crate) fn reading(scan: &LaserScan, beam: usize, max_range: f64) -> Option<f64> {
    let range = *scan.ranges.get(beam).filter(|range| **range >= scan.range_min)?;
    let in_reach = range <= scan.range_max && range < max_range;
    Some(if in_reach { range } else { f64::INFINITY })
}
