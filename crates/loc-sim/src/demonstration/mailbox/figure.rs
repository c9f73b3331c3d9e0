//! The belief in a full mailbox, two bars a day.

use super::super::bars;
use super::{Flag, MailboxDiagnosis};
use crate::output::figures::FigureFile;
use loc_plot::{Chart, Figure, Role};

/// Width of a bar \[days\].
const WIDTH: f64 = 0.36;

/// Where flags are drawn.
const FLAG: f64 = 1.07;

pub(super) fn figure(diagnosis: &MailboxDiagnosis, title: &str) -> FigureFile {
    let days = || diagnosis.days.iter().enumerate().map(|(k, day)| (k as f64 + 1.0, day));
    let predicted = days().map(|(x, day)| (x - 0.5 * WIDTH, day.predicted));
    let believed = days().map(|(x, day)| (x + 0.5 * WIDTH, day.believed));
    let seen = |flag: Flag| {
        let of_flag = days().filter(move |(_, day)| day.flag == flag);
        of_flag.map(|(x, _)| (x, FLAG))
    };
    let chart = Chart::new("P(full)").y_range(0.0, 1.15);
    let chart = bars(chart, Role::Method(0), "before the flag is seen", WIDTH, predicted);
    let chart = bars(chart, Role::Method(1), "after", WIDTH, believed)
        .points(Role::Truth.width(7.0), "flag up", seen(Flag::Up))
        .points(Role::Measurement.width(7.0), "flag down", seen(Flag::Down));
    let subtitle = format!(
        "P(full | up) = {:.3}, P(full | down) = {:.3} on the first day; without a flag the belief \
         drifts to {:.3}",
        diagnosis.full_if_up,
        diagnosis.full_if_down,
        stationary(diagnosis)
    );
    let svg = Figure::new(title).subtitle(subtitle).x_label("day").panel(chart).render();
    FigureFile {
        file: "mailbox.svg".into(),
        caption: "Belief in a full mailbox, day by day".into(),
        svg,
    }
}

/// P(full) of a mailbox at which nobody has looked for long.
fn stationary(diagnosis: &MailboxDiagnosis) -> f64 {
    let (comes, out) = (diagnosis.config.mail_comes, diagnosis.config.taken_out);
    if comes + out > 0.0 { comes / (comes + out) } else { diagnosis.config.full_at_first }
}
