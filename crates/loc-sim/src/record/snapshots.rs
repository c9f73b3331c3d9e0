//! A few of the many clouds and grids of a run, for figures.

use crate::localizer::Cloud;
use loc_core::Stamped;

/// What one method believed, such as its clouds: at most [`Snapshots::MAX`]. The first ones are
/// all kept, since that is when a method finds the robot, and so are those after a kidnapping; the
/// others lie at even distances over the rest of the run.
///
/// ```
/// use loc_core::Pose2;
/// use loc_sim::localizer::Cloud;
/// use loc_sim::record::Snapshots;
/// let mut snapshots = Snapshots::new(Some(500.0));
/// for k in 0..1000 {
///     let pose = Pose2::new(f64::from(k), 0.0, 0.0);
///     snapshots.offer(f64::from(k), Cloud { particles: vec![(pose, 1.0)], weighed: None });
/// }
/// assert!(snapshots.len() <= Snapshots::MAX);
/// let stamps: Vec<f64> = snapshots.iter().map(|snapshot| snapshot.stamp).collect();
/// assert_eq!(stamps[..3], [0.0, 1.0, 2.0]);
/// assert!(stamps.contains(&501.0) && stamps.last() > Some(&950.0));
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Snapshots<T = Cloud> {
    kept: Vec<Stamped<T>>,
    /// Beside each one its number among those that may be left out again.
    numbers: Vec<Option<usize>>,
    kidnapped_at: Option<f64>,
    /// The last one that was offered, to tell new ones from old ones.
    last: Option<T>,
    before_kidnap: usize,
    after_kidnap: usize,
    later: usize,
    /// Of the later ones every k-th is kept, k a power of 2.
    every: usize,
}

impl Snapshots {
    /// The most that are kept.
    pub const MAX: usize = 64;
    /// How many are kept whatever comes after them: at the start, and after a kidnapping.
    pub const FIRST: usize = 16;
}

impl<T: Clone + PartialEq> Snapshots<T> {
    /// None yet, of a robot that may be kidnapped \[s\].
    pub fn new(kidnapped_at: Option<f64>) -> Self {
        Snapshots {
            kept: Vec::new(),
            numbers: Vec::new(),
            kidnapped_at,
            last: None,
            before_kidnap: 0,
            after_kidnap: 0,
            later: 0,
            every: 1,
        }
    }

    /// Offers what there is at a time \[s\]; if it is the same as the last one, it is passed over.
    pub fn offer(&mut self, stamp: f64, value: T) {
        if self.last.as_ref() == Some(&value) {
            return;
        }
        self.last = Some(value.clone());
        let carried = self.kidnapped_at.is_some_and(|at| stamp >= at);
        let firsts = if carried { &mut self.after_kidnap } else { &mut self.before_kidnap };
        if *firsts < Snapshots::FIRST {
            *firsts += 1;
            self.keep(None, stamp, value);
            return;
        }
        let number = self.later;
        self.later += 1;
        if number.is_multiple_of(self.every.max(1)) {
            self.keep(Some(number), stamp, value);
        }
    }

    fn keep(&mut self, number: Option<usize>, stamp: f64, value: T) {
        self.kept.push(Stamped { stamp, value });
        self.numbers.push(number);
        if self.kept.len() > Snapshots::MAX {
            self.every = 2 * self.every.max(1);
            let every = self.every;
            let stays = |number: &Option<usize>| number.is_none_or(|n| n.is_multiple_of(every));
            let mut numbers = self.numbers.iter();
            self.kept.retain(|_| numbers.next().is_some_and(stays));
            self.numbers.retain(stays);
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.kept.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// All of them in order of time.
    pub fn iter(&self) -> std::slice::Iter<'_, Stamped<T>> {
        self.kept.iter()
    }
}
