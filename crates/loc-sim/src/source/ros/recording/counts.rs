//! What was passed over.

use crate::Error;

/// What was passed over, and why.
#[derive(Debug, Default)]
pub(super) struct Counts {
    pub(super) scans: u64,
    pub(super) unreadable: u64,
    pub(super) why_unreadable: Option<String>,
    pub(super) without_odometry: u64,
    pub(super) without_transform: u64,
    pub(super) why_without_transform: Option<Error>,
    pub(super) without_measurement: u64,
    pub(super) out_of_order: u64,
    pub(super) zero_stamps: u64,
    pub(super) bad_transforms: usize,
}

impl Counts {
    /// A message that cannot be used.
    pub(super) fn unreadable(&mut self, why: String) {
        self.unreadable += 1;
        self.why_unreadable.get_or_insert(why);
    }

    /// Lines for the user.
    pub(super) fn notes(&self) -> Vec<String> {
        let first = |reason: Option<String>| {
            reason.map_or(String::new(), |reason| format!(", the first: {reason}"))
        };
        let why = first(self.why_unreadable.clone());
        let place = first(self.why_without_transform.as_ref().map(ToString::to_string));
        let counts = [
            (self.unreadable, format!("messages that cannot be used{why}")),
            (self.without_odometry, "scans without odometry before and after them".into()),
            (self.without_transform, format!("scans without the place of the laser{place}")),
            (
                self.without_measurement,
                "messages without a fix, or of half an inertial unit".into(),
            ),
            (self.out_of_order, "messages with a stamp not after the one before".into()),
            (self.zero_stamps, "messages with stamp 0, taken at the time of recording".into()),
            (self.bad_transforms as u64, "transforms that are no rigid motions".into()),
        ];
        let counts = counts.into_iter().filter(|(count, _)| *count > 0);
        counts.map(|(count, what)| format!("{count} {what}")).collect()
    }
}
