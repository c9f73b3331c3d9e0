//! Runs several methods side by side over one stream of events.

use crate::localizer::{Judgement, Localizer, Method, MethodSettings, smoothed};
use crate::metrics::BeamFit;
use crate::record::{LineMoments, MethodRecord, Run, Snapshots};
use crate::source::{Setup, Source};
use crate::{Error, Result};
use loc_core::{Pose2, Stamped};
use loc_sensors::event::{Event, Measurement, Payload, Truth};
use loc_sensors::laser::LaserScan;
use std::sync::Arc;
use std::time::Instant;

/// Shortest time between two estimates that are asked for \[s\].
const PERIOD: f64 = 0.1;

/// Rounding that a period of exactly [`PERIOD`] may have \[s\].
const ROUNDING: f64 = 1e-6;

/// Looks on while methods run: shows progress, keeps a film, writes a recording.
pub trait Watcher {
    /// The share of the run that is done, in \[0, 1\], after every estimate.
    fn progress(&mut self, share: f64);

    /// What is known before the first event, and the names of the methods that are to run.
    ///
    /// # Errors
    /// Whatever ends the run.
    fn started(&mut self, _setup: &Setup, _methods: &[String]) -> Result<()> {
        Ok(())
    }

    /// An event, before any method takes it in.
    ///
    /// # Errors
    /// Whatever ends the run.
    fn event(&mut self, _event: &Event) -> Result<()> {
        Ok(())
    }

    /// The methods after they were asked for their estimate of a time \[s\].
    ///
    /// # Errors
    /// Whatever ends the run.
    fn estimated(&mut self, _stamp: f64, _methods: &[&dyn Localizer]) -> Result<()> {
        Ok(())
    }
}

/// Two watchers, the second where there is one.
#[cfg(feature = "cli")]
pub(crate) struct Both<'a, A, B>(pub(crate) &'a mut A, pub(crate) &'a mut Option<B>);

#[cfg(feature = "cli")]
impl<A: Watcher, B: Watcher> Watcher for Both<'_, A, B> {
    fn progress(&mut self, share: f64) {
        self.0.progress(share);
    }

    fn started(&mut self, setup: &Setup, methods: &[String]) -> Result<()> {
        self.0.started(setup, methods)?;
        self.1.as_mut().map_or(Ok(()), |second| second.started(setup, methods))
    }

    fn event(&mut self, event: &Event) -> Result<()> {
        self.0.event(event)?;
        self.1.as_mut().map_or(Ok(()), |second| second.event(event))
    }

    fn estimated(&mut self, stamp: f64, methods: &[&dyn Localizer]) -> Result<()> {
        self.0.estimated(stamp, methods)?;
        self.1.as_mut().map_or(Ok(()), |second| second.estimated(stamp, methods))
    }
}

/// A watcher that shows progress alone.
pub(crate) struct Told<'a>(pub(crate) &'a mut dyn FnMut(f64));

impl Watcher for Told<'_> {
    fn progress(&mut self, share: f64) {
        (self.0)(share);
    }
}

/// Runs methods over a source to its end. `progress` is told the share that is done, in \[0, 1\],
/// at every estimate.
///
/// # Errors
/// As [`run_watched`].
pub fn run(
    source: &mut dyn Source,
    methods: &[Method],
    settings: &MethodSettings,
    progress: &mut dyn FnMut(f64),
) -> Result<Run> {
    run_watched(source, methods, settings, &mut Told(progress))
}

/// Runs methods over a source to its end, with somebody looking on.
///
/// Estimates are asked for at every true pose or, from a source without any, after every scan, and
/// without a laser after every measurement.
///
/// # Errors
/// What the source or a method reports; [`Error::NoTruth`] where true poses were promised and
/// none came, or where there was no scan either.
pub fn run_watched(
    source: &mut dyn Source,
    methods: &[Method],
    settings: &MethodSettings,
    watcher: &mut dyn Watcher,
) -> Result<Run> {
    let setup = source.setup().clone();
    let mut tape = Tape::of(methods, settings);
    let mut runners = start(methods, &setup, settings)?;
    let names: Vec<String> =
        runners.iter().map(|runner| runner.record.name().into_owned()).collect();
    watcher.started(&setup, &names)?;
    let samples_at = match source.has_truth() {
        true => is_truth,
        false if setup.has_laser => is_scan,
        false => is_measurement,
    };
    let (mut stamps, mut truth): (Vec<f64>, Vec<Stamped<Truth>>) = Default::default();
    let mut last_scan = None;
    while let Some(event) = source.next_event()? {
        watcher.event(&event)?;
        tape.keep(&event);
        runners.iter_mut().try_for_each(|runner| runner.take(&event))?;
        if let Payload::Measurement(Measurement::Scan { scan, mounting }) = &event.payload {
            last_scan = Some((scan.clone(), *mounting));
        }
        let due = stamps.last().map_or(setup.start, |last| last + PERIOD);
        if !samples_at(&event) || event.stamp < due - ROUNDING {
            continue;
        }
        if let Payload::Truth(value) = event.payload {
            truth.push(Stamped { stamp: event.stamp, value });
        }
        stamps.push(event.stamp);
        runners.iter_mut().try_for_each(|runner| runner.estimate(event.stamp))?;
        let localizers: Vec<_> = runners.iter().map(|runner| runner.localizer.as_ref()).collect();
        watcher.estimated(event.stamp, &localizers)?;
        watcher.progress(share(setup.start, setup.end, event.stamp));
    }
    watcher.progress(1.0);
    if stamps.is_empty() {
        return Err(Error::NoTruth { source_name: setup.name });
    }
    let mut notes = source.notes();
    notes.extend(runners.iter().flat_map(Runner::notes));
    let last_scan = last_scan.map(|scan| LastScan::new(&setup, scan)).transpose()?.flatten();
    let finish = |runner: Runner| runner.finish(last_scan.as_ref());
    let mut methods: Vec<_> = runners.into_iter().map(finish).collect::<Result<_>>()?;
    methods.extend(tape.smoothed(&setup, settings, &stamps, &methods)?);
    Ok(Run {
        setup,
        settings: settings.clone(),
        stamps,
        truth,
        truth_has_heading: source.truth_has_heading(),
        methods,
        sensor_truth: source.sensor_truth(),
        odometry_timing: source.odometry_timing(),
        notes,
        film: None,
    })
}

/// The methods, and after them those that start a second time without a pose.
fn start(methods: &[Method], setup: &Setup, settings: &MethodSettings) -> Result<Vec<Runner>> {
    let mut runners = Vec::with_capacity(methods.len());
    for &method in methods {
        runners.push(Runner::new(method, setup, settings, false)?);
    }
    if settings.also_global && !settings.global {
        let untold = MethodSettings { global: true, ..settings.clone() };
        for &method in methods.iter().filter(|method| method.can_search()) {
            runners.push(Runner::new(method, setup, &untold, true)?);
        }
    }
    Ok(runners)
}

fn is_truth(event: &Event) -> bool {
    matches!(event.payload, Payload::Truth(_))
}

fn is_scan(event: &Event) -> bool {
    matches!(event.payload, Payload::Measurement(Measurement::Scan { .. }))
}

fn is_measurement(event: &Event) -> bool {
    matches!(event.payload, Payload::Measurement(_))
}

/// The last scan of a run, by which every method is judged.
struct LastScan {
    walls: BeamFit,
    scan: Arc<LaserScan>,
    mounting: Pose2,
}

impl LastScan {
    /// `None` without a map.
    fn new(setup: &Setup, (scan, mounting): (Arc<LaserScan>, Pose2)) -> Result<Option<Self>> {
        let walls = setup.map.as_ref().map(|map| BeamFit::new(map)).transpose()?;
        Ok(walls.map(|walls| LastScan { walls, scan, mounting }))
    }

    fn fit(&self, pose: Pose2) -> Option<f64> {
        self.walls.share(pose, &self.scan, self.mounting)
    }
}

/// The events that are kept for smoothing, where that is wanted.
struct Tape {
    methods: Vec<Method>,
    events: Vec<Event>,
}

impl Tape {
    fn of(methods: &[Method], settings: &MethodSettings) -> Self {
        let wanted =
            methods.iter().copied().filter(|method| settings.smooth && method.can_smooth());
        Tape { methods: wanted.collect(), events: Vec::new() }
    }

    fn keep(&mut self, event: &Event) {
        if !self.methods.is_empty() && smoothed::is_input(event) {
            self.events.push(event.clone());
        }
    }

    /// A further record for each method that can be smoothed. Its measurements are those of the
    /// filter's, whose innovations are no longer its own.
    fn smoothed(
        &self,
        setup: &Setup,
        settings: &MethodSettings,
        stamps: &[f64],
        records: &[MethodRecord],
    ) -> Result<Vec<MethodRecord>> {
        let mut all = Vec::with_capacity(self.methods.len());
        for &method in &self.methods {
            let started = Instant::now();
            let estimates = smoothed::smoothed(method, setup, settings, &self.events, stamps)?;
            let runtime = started.elapsed().as_secs_f64();
            let filter = records.iter().find(|record| record.method == method);
            let judged = filter.into_iter().flat_map(|record| &record.judgements);
            let judgements = judged.map(|judgement| Stamped {
                stamp: judgement.stamp,
                value: Judgement { accepted: judgement.value.accepted, ..Judgement::REFUSED },
            });
            all.push(MethodRecord {
                method,
                global: false,
                smoothed: true,
                estimates,
                judgements: judgements.collect(),
                sensor_errors: Vec::new(),
                snapshots: Snapshots::new(setup.kidnapped_at),
                beliefs: Snapshots::new(setup.kidnapped_at),
                lines: LineMoments::new(setup.start, setup.end),
                map: None,
                beam_fit: None,
                updates: self.events.len(),
                runtime,
            });
        }
        Ok(all)
    }
}

/// One method with its record and its stopwatch.
struct Runner {
    localizer: Box<dyn Localizer>,
    record: MethodRecord,
    /// The pose at the last scan.
    at_scan: Option<Pose2>,
}

impl Runner {
    fn new(method: Method, setup: &Setup, settings: &MethodSettings, global: bool) -> Result<Self> {
        let localizer = method.start(setup, settings)?;
        let record = MethodRecord {
            method,
            global,
            smoothed: false,
            estimates: Vec::new(),
            judgements: Vec::new(),
            sensor_errors: Vec::new(),
            snapshots: Snapshots::new(setup.kidnapped_at),
            beliefs: Snapshots::new(setup.kidnapped_at),
            lines: LineMoments::new(setup.start, setup.end),
            map: None,
            beam_fit: None,
            updates: 0,
            runtime: 0.0,
        };
        let mut runner = Runner { localizer, record, at_scan: None };
        runner.keep_belief(setup.start);
        Ok(runner)
    }

    /// Keeps the method's particles or grid for figures; this does not count as its time.
    fn keep_belief(&mut self, stamp: f64) {
        if let Some(belief) = self.localizer.place_belief() {
            self.record.beliefs.offer(stamp, belief);
        }
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
            self.keep_belief(stamp);
        }
        if is_scan(event) {
            self.at_scan = Some(self.localizer.estimate(stamp)?.pose);
        }
        if let Some(update) = self.localizer.lines().filter(|_| is_scan(event)) {
            self.record.lines.offer(stamp, update);
        }
        Ok(())
    }

    /// What the method has to say, with its name.
    fn notes(&self) -> Vec<String> {
        let name = self.record.name();
        self.localizer.notes().into_iter().map(|note| format!("{name}: {note}")).collect()
    }

    fn finish(self, last: Option<&LastScan>) -> Result<MethodRecord> {
        let map = self.localizer.map()?;
        let beam_fit = last.zip(self.at_scan).and_then(|(last, pose)| last.fit(pose));
        Ok(MethodRecord { map, beam_fit, ..self.record })
    }

    fn estimate(&mut self, stamp: f64) -> Result<()> {
        let started = Instant::now();
        self.record.estimates.push(self.localizer.estimate(stamp)?);
        self.record.runtime += started.elapsed().as_secs_f64();
        let errors = self.localizer.sensor_errors(stamp)?;
        // A sensor may be heard for the first time at any moment; methods without errors keep none.
        if !errors.is_empty() {
            self.record.sensor_errors.resize(self.record.estimates.len() - 1, Vec::new());
            self.record.sensor_errors.push(errors);
        }
        Ok(())
    }
}

fn share(start: f64, end: f64, stamp: f64) -> f64 {
    if end > start { ((stamp - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 }
}
