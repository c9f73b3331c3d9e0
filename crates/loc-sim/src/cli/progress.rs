//! A progress bar for work that lasts, on a terminal only.

use super::Global;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

const STEPS: u64 = 1000;

/// Shows the share of a work that is done, from its second second on.
pub(super) struct Progress {
    bar: Option<ProgressBar>,
    started: Instant,
    position: u64,
    what: String,
    wanted: bool,
}

impl Progress {
    pub(super) fn new(what: &str, global: &Global) -> Self {
        let wanted = !global.quiet && std::io::stderr().is_terminal();
        Progress { bar: None, started: Instant::now(), position: 0, what: what.into(), wanted }
    }

    /// The share of the work that is done, in \[0, 1\].
    pub(super) fn tell(&mut self, share: f64) {
        let position = (share * STEPS as f64) as u64;
        if !self.wanted || position == self.position {
            return;
        }
        self.position = position;
        let elapsed = self.started.elapsed();
        if elapsed < Duration::from_secs(1) {
            return;
        }
        let bar = self.bar.get_or_insert_with(|| {
            let style = ProgressStyle::with_template("{msg} {wide_bar} {percent:>3} % {prefix}");
            let bar = ProgressBar::new(STEPS).with_message(self.what.clone());
            bar.with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        let left = elapsed.as_secs_f64() * (1.0 - share) / share;
        bar.set_prefix(format!("{left:.0} s left"));
        bar.set_position(position);
    }

    pub(super) fn finish(self) {
        if let Some(bar) = self.bar {
            bar.finish_and_clear();
        }
    }
}
