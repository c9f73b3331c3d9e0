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
    thinned(scan.ranges.iter().enumerate().filter(tells).map(|(beam, _)| beam).collect(), count)
}

/// At most `count` of the beams, evenly spread; the first and the last are among them.
pub(crate) fn thinned(beams: Vec<usize>, count: usize) -> Vec<usize> {
    match count {
        _ if beams.len() <= count => beams,
        0 => Vec::new(),
        1 => vec![beams[beams.len() / 2]],
        _ => {
            let (gaps, last) = (count - 1, beams.len() - 1);
            (0..count).map(|k| beams[(k * last + gaps / 2) / gaps]).collect()
        }
    }
}

/// What a beam measured \[m\], +inf for no return; `None` for what says nothing.
pub(crate) fn reading(scan: &LaserScan, beam: usize, max_range: f64) -> Option<f64> {
    let range = *scan.ranges.get(beam).filter(|range| **range >= scan.range_min)?;
    let in_reach = range <= scan.range_max && range < max_range;
    Some(if in_reach { range } else { f64::INFINITY })
}
