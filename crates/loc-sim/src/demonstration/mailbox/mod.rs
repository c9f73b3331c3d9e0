//! The mailbox and its flag (F5): diagnosis from cause to effect, then a Bayes filter over days.
//!
//! A mailbox is full or empty, and its flag is up or down. How often a flag is up on a full mailbox
//! is known; Bayes' rule turns that round into how likely a mailbox with its flag up is full. From
//! day to day the state changes, as mail comes and is taken out, and belief follows: a prediction
//! for the day that has passed, a correction for the flag that was seen.

mod figure;

use crate::Result;
use crate::config::field;
use crate::output::Illustration;
use loc_core::error::probability;
use loc_core::probability::{Discrete, bayes};
use loc_filters::histogram::DiscreteFilter;
use serde::Deserialize;
use serde_json::json;

/// What is known about mailbox and mail, and what is seen.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MailboxConfig {
    /// P(full) before anything was seen.
    pub full_at_first: f64,
    /// P(flag up | full).
    pub flag_up_if_full: f64,
    /// P(flag up | empty).
    pub flag_up_if_empty: f64,
    /// P(full | was empty) over a day.
    pub mail_comes: f64,
    /// P(empty | was full) over a day.
    pub taken_out: f64,
    /// What is seen day by day.
    pub flags: Vec<Flag>,
}

/// What somebody who passes by sees.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Flag {
    /// The flag is up.
    Up,
    /// It is down.
    Down,
    /// Nobody passes by.
    Unseen,
}

/// The state of the mailbox.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mailbox {
    Full,
    Empty,
}

/// One day.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Day {
    /// P(full) before the flag was seen.
    pub predicted: f64,
    /// What was seen.
    pub flag: Flag,
    /// P(full) after that.
    pub believed: f64,
}

/// The mailbox, diagnosed and watched.
#[derive(Debug, Clone)]
pub struct MailboxDiagnosis {
    config: MailboxConfig,
    /// P(flag up) before anything was seen.
    pub up: f64,
    /// P(full | flag up).
    pub full_if_up: f64,
    /// P(full | flag down).
    pub full_if_down: f64,
    /// The days, the first one without a prediction.
    pub days: Vec<Day>,
}

impl MailboxConfig {
    pub(super) fn check(&self) -> Result<()> {
        probability("demonstration.full_at_first", self.full_at_first)?;
        probability("demonstration.flag_up_if_full", self.flag_up_if_full)?;
        probability("demonstration.flag_up_if_empty", self.flag_up_if_empty)?;
        probability("demonstration.mail_comes", self.mail_comes)?;
        probability("demonstration.taken_out", self.taken_out)?;
        match self.flags.len() {
            1..=366 => Ok(()),
            days => Err(field("demonstration.flags", "1 to 366 days", &days.to_string())),
        }
    }

    fn start(&self) -> Result<Discrete<Mailbox>> {
        let full = self.full_at_first;
        Ok(Discrete::new([(Mailbox::Full, full), (Mailbox::Empty, 1.0 - full)])?)
    }

    /// P(flag | state).
    fn likelihood(&self, flag: Flag, state: Mailbox) -> f64 {
        let up = match state {
            Mailbox::Full => self.flag_up_if_full,
            Mailbox::Empty => self.flag_up_if_empty,
        };
        match flag {
            Flag::Up => up,
            Flag::Down => 1.0 - up,
            Flag::Unseen => 1.0,
        }
    }

    /// P(to | from) over a day.
    fn transition(&self, from: Mailbox, to: Mailbox) -> f64 {
        match (from, to) {
            (Mailbox::Empty, Mailbox::Full) => self.mail_comes,
            (Mailbox::Empty, Mailbox::Empty) => 1.0 - self.mail_comes,
            (Mailbox::Full, Mailbox::Empty) => self.taken_out,
            (Mailbox::Full, Mailbox::Full) => 1.0 - self.taken_out,
        }
    }
}

fn full(belief: &Discrete<Mailbox>) -> f64 {
    belief.probability(|state| *state == Mailbox::Full)
}

impl MailboxDiagnosis {
    /// Diagnoses and watches the mailbox.
    ///
    /// # Errors
    /// Values out of range, and flags that cannot be.
    pub fn new(config: &MailboxConfig) -> Result<Self> {
        config.check()?;
        let start = config.start()?;
        let diagnose = |flag| bayes::posterior(&start, |state| config.likelihood(flag, *state));
        let (if_up, if_down) = (diagnose(Flag::Up)?, diagnose(Flag::Down)?);
        let mut filter = DiscreteFilter::new(start.clone());
        let mut days = Vec::with_capacity(config.flags.len());
        for (day, &flag) in config.flags.iter().enumerate() {
            if day > 0 {
                filter.predict(|from, to| config.transition(*from, *to))?;
            }
            let predicted = full(filter.belief());
            filter.correct(|state| config.likelihood(flag, *state))?;
            days.push(Day { predicted, flag, believed: full(filter.belief()) });
        }
        Ok(MailboxDiagnosis {
            config: config.clone(),
            up: if_up.evidence(),
            full_if_up: full(&if_up.distribution),
            full_if_down: full(&if_down.distribution),
            days,
        })
    }

    /// The diagnosis as a figure and numbers.
    pub fn illustrate(&self, title: &str) -> Illustration {
        let MailboxConfig { full_at_first, flag_up_if_full, flag_up_if_empty, .. } = self.config;
        let mut lines = vec![
            format!(
                "P(full) = {full_at_first}, P(up | full) = {flag_up_if_full}, P(up | empty) = {flag_up_if_empty}"
            ),
            format!("P(up) = {:.4}", self.up),
            format!("P(full | up) = {:.4}", self.full_if_up),
            format!("P(full | down) = {:.4}", self.full_if_down),
            format!(
                "{:<5}{:>20}{:>10}{:>20}",
                "day", "P(full) predicted", "flag", "P(full) believed"
            ),
        ];
        lines.extend(self.days.iter().enumerate().map(|(k, day)| {
            let Day { predicted, flag, believed } = day;
            format!("{:<5}{predicted:>20.4}{:>10}{believed:>20.4}", k + 1, flag.name())
        }));
        let days = self.days.iter().map(|day| {
            let Day { predicted, flag, believed } = *day;
            json!({"predicted_full": predicted, "flag": flag.name(), "believed_full": believed})
        });
        let summary = json!({
            "up": self.up,
            "full_if_up": self.full_if_up,
            "full_if_down": self.full_if_down,
            "days": days.collect::<Vec<_>>(),
        });
        Illustration::new(lines, summary, vec![figure::figure(self, title)])
    }
}

impl Flag {
    /// The word that stands for it in files.
    pub fn name(self) -> &'static str {
        match self {
            Flag::Up => "up",
            Flag::Down => "down",
            Flag::Unseen => "unseen",
        }
    }
}
