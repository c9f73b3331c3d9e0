//! Pairing of the poses of two trajectories by their stamps.
//!
//! Two recordings of one drive rarely tick at the same moments: the reference may come at 100 Hz,
//! the estimate at 7 Hz. Each pose of the shorter trajectory is paired with the one of the longer
//! that is nearest in time, unless even that is too far away.
//!
//! ```
//! use loc_sim::metrics::associate;
//! let (estimate, reference) = ([0.0, 1.004, 2.5], [0.0, 0.5, 1.0, 1.5, 2.0]);
//! assert_eq!(associate(&estimate, &reference, 0.01), [(0, 0), (1, 2)]);
//! ```

/// Two poses of one moment.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pair<P> {
    /// Where the estimate puts the robot.
    pub estimate: P,
    /// Where the reference puts it.
    pub reference: P,
}

impl<P> Pair<P> {
    /// A pair of poses.
    pub fn new(estimate: P, reference: P) -> Self {
        Pair { estimate, reference }
    }
}

/// The pairs (index of the estimate, index of the reference) of stamps that lie at most `max_dt`
/// \[s\] apart.
///
/// Both lists are in ascending order \[s\]. The rules are those of evo 1.38: the shorter list is
/// walked through (the estimate, where both are of one length), and each of its stamps takes the
/// nearest of the longer list. One stamp of the longer list may be taken several times. Of two
/// that are equally near, the earlier is taken; of several equal ones behind, the last, and of
/// several equal ones ahead, the first. (Older versions of evo, such as 1.31, take the first of equal
/// ones always, so their figures differ where the longer list repeats stamps.)
pub fn associate(estimate: &[f64], reference: &[f64], max_dt: f64) -> Vec<(usize, usize)> {
    if estimate.len() > reference.len() {
        let taken = |(i, &stamp)| Some((nearest(stamp, estimate, max_dt)?, i));
        reference.iter().enumerate().filter_map(taken).collect()
    } else {
        let taken = |(i, &stamp)| Some((i, nearest(stamp, reference, max_dt)?));
        estimate.iter().enumerate().filter_map(taken).collect()
    }
}

/// The index of the one of `stamps`, in ascending order, that is nearest to `stamp`.
fn nearest(stamp: f64, stamps: &[f64], max_dt: f64) -> Option<usize> {
    let (first, last) = (stamps.first()?, stamps.last()?);
    // Sums, where below there are differences: at the very limit the rounding decides.
    if stamp < first - max_dt || stamp > last + max_dt {
        return None;
    }
    let next = stamps.partition_point(|&other| other <= stamp);
    let next = next.min(stamps.len() - 1);
    let ahead = stamps[next] - stamp;
    let behind = match next.checked_sub(1) {
        Some(previous) => stamp - stamps[previous],
        None => f64::INFINITY,
    };
    if ahead < behind {
        (ahead <= max_dt).then_some(next)
    } else {
        (behind <= max_dt).then_some(next - 1)
    }
}
