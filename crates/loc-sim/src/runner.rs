//! Runs several methods side by side over one stream of events.

use crate::event::{Event, Payload, Truth};
use crate::localizer::{Localizer, Method, MethodSettings};
use crate::record::{MethodRecord, Run, Snapshots};
use crate::source::{Setup, Source};
use crate::{Error, Result};
use loc_core::Stamped;
use std::time::Instant;

/// Shortest time between two recorded truths \[s\].
const TRUTH_PERIOD: f64 = 0.1;

/// Rounding that a period of exactly [`TRUTH_PERIOD`] may have \[s\].
const ROUNDING: f64 = 1e-6;

/// Runs methods over a source to its end. `progress` is told the share that is done, in \[0, 1\],
/// at every recorded truth.
///
/// # Errors
/// What the source or a method reports; [`Error::NoTruth`] where there is nothing to judge by.
pub fn run(
    source: &mut dyn Source,
    methods: &[Method],
    settings: &MethodSettings,
    progress: &mut dyn FnMut(f64),
) -> Result<Run> {
    let setup = source.setup().clone();
    let mut runners = Vec::with_capacity(methods.len());
    for &method in methods {
        runners.push(Runner::new(method, &setup, settings)?);
    }
    let mut truth: Vec<Stamped<Truth>> = Vec::new();
    while let Some(event) = source.next_event()? {
        match event.payload {
            Payload::Truth(value) => {
                let due = truth.last().map_or(setup.start, |last| last.stamp + TRUTH_PERIOD);
                if event.stamp >= due - ROUNDING {
                    truth.push(Stamped { stamp: event.stamp, value });
                    runners.iter_mut().try_for_each(|runner| runner.estimate(event.stamp))?;
                    progress(share(setup.start, setup.end, event.stamp));
                }
            }
            Payload::Control(_) | Payload::Measurement(_) => {
                runners.iter_mut().try_for_each(|runner| runner.take(&event))?;
            }
        }
    }
    progress(1.0);
    if truth.is_empty() {
        return Err(Error::NoTruth { source_name: setup.name });
    }
    let notes = source.notes();
    let methods = runners.into_iter().map(|runner| runner.record).collect();
    Ok(Run { setup, settings: settings.clone(), truth, methods, notes })
}

/// One method with its record and its stopwatch.
struct Runner {
    localizer: Box<dyn Localizer>,
    record: MethodRecord,
}

impl Runner {
    fn new(method: Method, setup: &Setup, settings: &MethodSettings) -> Result<Self> {
        let localizer = method.start(setup, settings)?;
        let record = MethodRecord {
            method,
            estimates: Vec::new(),
            judgements: Vec::new(),
            snapshots: Snapshots::new(setup.kidnapped_at),
            updates: 0,
            runtime: 0.0,
        };
        let mut runner = Runner { localizer, record };
        runner.keep_cloud(setup.start);
        Ok(runner)
    }

    /// Keeps the method's particles for figures; this does not count as its time.
    fn keep_cloud(&mut self, stamp: f64) {
        if let Some(cloud) = self.localizer.cloud() {
            self.record.snapshots.offer(stamp, cloud);
        }
    }

    fn take(&mut self, event: &Event) -> Result<()> {
        let started = Instant::now();
        let stamp = event.stamp;
        match &event.payload {
            Payload::Control(control) => self.localizer.predict(stamp, control)?,
            Payload::Measurement(measurement) => {
                let judgements = self.localizer.correct(stamp, measurement)?;
                let stamped = judgements.into_iter().map(|value| Stamped { stamp, value });
                self.record.judgements.extend(stamped);
            }
            Payload::Truth(_) => return Ok(()),
        }
        self.record.updates += 1;
        self.record.runtime += started.elapsed().as_secs_f64();
        if matches!(event.payload, Payload::Measurement(_)) {
            self.keep_cloud(stamp);
        }
        Ok(())
    }

    fn estimate(&mut self, stamp: f64) -> Result<()> {
        let started = Instant::now();
        self.record.estimates.push(self.localizer.estimate(stamp)?);
        self.record.runtime += started.elapsed().as_secs_f64();
        Ok(())
    }
}

fn share(start: f64, end: f64, stamp: f64) -> f64 {
    if end > start { ((stamp - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 }
}
