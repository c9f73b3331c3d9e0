//! The mailbox and its flag (F5): diagnosis from cause to effect, then a Bayes filter over days.
//!
//! A mailbox is full or empty, and its flag is up or down. How often a flag is up on a full mailbox
//! is known; Bayes' rule turns that round into how likely a mailbox with its flag up is full. From
//! day to day the state changes, as mail comes and is taken out, and belief follows: a prediction
//! for the day that has passed, a correction for the flag that was seen.

use super::Demonstration;
use crate::Result;
use crate::config::field;
use crate::output::Illustration;
use crate::output::figures::FigureFile;
use loc_core::error::probability;
use loc_core::probability::{Discrete, bayes};
use loc_filters::histogram::DiscreteFilter;
use loc_plot::{Chart, Figure, Role};
use serde::Deserialize;
use serde_json::json;

/// Width of a bar \[days\].
const WIDTH: f64 = 0.36;

/// Where flags are drawn.
const FLAG: f64 = 1.07;

/// What is known about mailbox and mail, and what is observed.
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

/// What is observed on a day.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Flag {
    /// The flag is up.
    Up,
    /// It is down.
    Down,
    /// No observation.
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

/// The diagnosis, and the belief over the days.
#[derive(Debug, Clone)]
pub struct MailboxDiagnosis {
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

    /// Diagnoses the mailbox, and filters over its days.
    ///
    /// # Errors
    /// Values out of range, and impossible flags.
    pub fn diagnose(&self) -> Result<MailboxDiagnosis> {
        self.check()?;
        let start = self.start()?;
        let diagnose = |flag| bayes::posterior(&start, |state| self.likelihood(flag, *state));
        let (if_up, if_down) = (diagnose(Flag::Up)?, diagnose(Flag::Down)?);
        let mut filter = DiscreteFilter::new(start.clone());
        let mut days = Vec::with_capacity(self.flags.len());
        for (day, &flag) in self.flags.iter().enumerate() {
            if day > 0 {
                filter.predict(|from, to| self.transition(*from, *to))?;
            }
            let predicted = full(filter.belief());
            filter.correct(|state| self.likelihood(flag, *state))?;
            days.push(Day { predicted, flag, believed: full(filter.belief()) });
        }
        Ok(MailboxDiagnosis {
            up: if_up.evidence(),
            full_if_up: full(&if_up.distribution),
            full_if_down: full(&if_down.distribution),
            days,
        })
    }

    fn draw(&self, diagnosis: &MailboxDiagnosis, title: &str) -> FigureFile {
        let days = || diagnosis.days.iter().enumerate().map(|(k, day)| (k as f64 + 1.0, day));
        let predicted = days().map(|(x, day)| (x - 0.5 * WIDTH, day.predicted));
        let believed = days().map(|(x, day)| (x + 0.5 * WIDTH, day.believed));
        let seen = |flag: Flag| {
            let of_flag = days().filter(move |(_, day)| day.flag == flag);
            of_flag.map(|(x, _)| (x, FLAG))
        };
        let chart = Chart::new("P(full)").y_range(0.0, 1.15);
        let chart = chart
            .bars(Role::Method(0), "before the flag is seen", WIDTH, predicted)
            .bars(Role::Method(1), "after", WIDTH, believed)
            .points(Role::Truth.width(7.0), "flag up", seen(Flag::Up))
            .points(Role::Measurement.width(7.0), "flag down", seen(Flag::Down));
        let subtitle = format!(
            "P(full | up) = {:.3}, P(full | down) = {:.3} on the first day; without a flag the belief \
         drifts to {:.3}",
            diagnosis.full_if_up,
            diagnosis.full_if_down,
            self.stationary()
        );
        let svg = Figure::new(title).subtitle(subtitle).x_label("day").panel(chart).render();
        FigureFile::new("mailbox.svg", "Belief in a full mailbox, day by day", svg)
    }

    /// P(full) after many days without an observation.
    fn stationary(&self) -> f64 {
        let (comes, out) = (self.mail_comes, self.taken_out);
        if comes + out > 0.0 { comes / (comes + out) } else { self.full_at_first }
    }
}

impl Demonstration for MailboxConfig {
    fn check(&self) -> Result<()> {
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

    fn run(&self, title: &str, _seed: u64) -> Result<Illustration> {
        let diagnosis = self.diagnose()?;
        let MailboxDiagnosis { up, full_if_up, full_if_down, days } = &diagnosis;
        let MailboxConfig { full_at_first, flag_up_if_full, flag_up_if_empty, .. } = self;
        let mut lines = vec![
            format!(
                "P(full) = {full_at_first}, P(up | full) = {flag_up_if_full}, P(up | empty) = {flag_up_if_empty}"
            ),
            format!("P(up) = {up:.4}"),
            format!("P(full | up) = {full_if_up:.4}"),
            format!("P(full | down) = {full_if_down:.4}"),
            format!(
                "{:<5}{:>20}{:>10}{:>20}",
                "day", "P(full) predicted", "flag", "P(full) believed"
            ),
        ];
        lines.extend(days.iter().enumerate().map(|(k, day)| {
            let Day { predicted, flag, believed } = day;
            format!("{:<5}{predicted:>20.4}{:>10}{believed:>20.4}", k + 1, flag.name())
        }));
        let rows = days.iter().map(|day| {
            let Day { predicted, flag, believed } = *day;
            json!({"predicted_full": predicted, "flag": flag.name(), "believed_full": believed})
        });
        let summary = json!({
            "up": up,
            "full_if_up": full_if_up,
            "full_if_down": full_if_down,
            "days": rows.collect::<Vec<_>>(),
        });
        Ok(Illustration::new(lines, summary, vec![self.draw(&diagnosis, title)]))
    }
}

fn full(belief: &Discrete<Mailbox>) -> f64 {
    belief.probability(|state| *state == Mailbox::Full)
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
