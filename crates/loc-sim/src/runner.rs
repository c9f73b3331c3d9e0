//! Runs several methods side by side over one stream of events.
//!
//! The path of a scan from file to pose:
//!
//! 1. a [`Source`] reads it and yields an [`Event`] ([`crate::source`]);
//! 2. [`run_observed`] passes the event to every method;
//! 3. the method's [`Localizer::correct`] updates the filter of `loc-filters` or `loc-pf` with it
//!    (for particles: beams are selected, weighted by their likelihood, and the set is resampled);
//! 4. its [`Outcome`]s go into the [`MethodRecord`];
//! 5. at the next sample time, [`Localizer::estimate`] gives the pose and its covariance.
//!
//! The finished [`Run`] holds all estimates with the truth at the same stamps;
//! [`Summary`](crate::metrics::Summary) computes the errors from it.

use crate::localizer::{Method, MethodSettings};
use crate::metrics::BeamFit;
use crate::record::{MethodRecord, Run};
use crate::source::{Setup, Source};
use crate::{Error, Result};
use loc_core::{Pose2, Stamped};
use loc_filters::localizer::{Localizer, Outcome};
use loc_sensors::event::{Event, Measurement, Payload, Truth};
use loc_sensors::laser::LaserScan;
use std::sync::Arc;
use std::time::Instant;

/// Shortest time between two sampled estimates \[s\].
const PERIOD: f64 = 0.1;

/// Rounding error that a period of exactly [`PERIOD`] may have \[s\].
const ROUNDING: f64 = 1e-6;

/// Runs methods over a source to its end. `progress` gets the share that is done, in \[0, 1\], at
/// every estimate.
///
/// # Errors
/// As [`run_observed`].
pub fn run(
    source: &mut dyn Source,
    methods: &[Method],
    settings: &MethodSettings,
    progress: &mut dyn FnMut(f64),
) -> Result<Run> {
    run_observed(source, methods, settings, &mut ProgressObserver(progress))
}

/// Runs methods over a source to its end and reports every step to an observer.
///
/// Estimates are sampled at the true poses or, from a source without any, after every scan, and
/// without a laser after every measurement.
///
/// # Errors
/// What the source or a method reports; [`Error::NoTruth`] if there was nothing to sample at: no
/// true pose of a source that has them, no scan, or no measurement.
pub fn run_observed(
    source: &mut dyn Source,
    methods: &[Method],
    settings: &MethodSettings,
    observer: &mut dyn Observer,
) -> Result<Run> {
    let setup = source.setup().clone();
    let mut smoothing = SmoothingInput::new(methods, settings);
    let mut runners = start(methods, &setup, settings)?;
    let names: Vec<String> =
        runners.iter().map(|runner| runner.record.name().into_owned()).collect();
    observer.started(&setup, &names)?;
    let is_sample = match source.has_truth() {
        true => is_truth,
        false if setup.has_laser => is_scan,
        false => is_measurement,
    };
    let (mut stamps, mut truth): (Vec<f64>, Vec<Stamped<Truth>>) = Default::default();
    let mut last_scan = None;
    while let Some(event) = source.next_event()? {
        observer.event(&event)?;
        smoothing.push(&event);
        runners.iter_mut().try_for_each(|runner| runner.update(&event))?;
        if let Payload::Measurement(Measurement::Scan { scan, mounting }) = &event.payload {
            last_scan = Some((scan.clone(), *mounting));
        }
        let due = stamps.last().map_or(setup.start, |last| last + PERIOD);
        if !is_sample(&event) || event.stamp < due - ROUNDING {
            continue;
        }
        if let Payload::Truth(value) = event.payload {
            truth.push(Stamped { stamp: event.stamp, value });
        }
        stamps.push(event.stamp);
        runners.iter_mut().try_for_each(|runner| runner.estimate(event.stamp))?;
        let localizers: Vec<_> = runners.iter().map(|runner| runner.localizer.as_ref()).collect();
        observer.estimated(event.stamp, &localizers)?;
        observer.progress(share(setup.start, setup.end, event.stamp));
    }
    observer.progress(1.0);
    if stamps.is_empty() {
        return Err(Error::NoTruth { source_name: setup.name });
    }
    let mut notes = source.notes();
    notes.extend(runners.iter().flat_map(Runner::notes));
    let last_scan = last_scan.map(|scan| LastScan::new(&setup, scan)).transpose()?.flatten();
    let finish = |runner: Runner| runner.finish(last_scan.as_ref());
    let mut methods: Vec<_> = runners.into_iter().map(finish).collect::<Result<_>>()?;
    methods.extend(smoothing.records(&setup, settings, &stamps, &methods)?);
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
        playback: None,
    })
}

/// The methods, and after them those that run a second time without a start pose.
fn start(methods: &[Method], setup: &Setup, settings: &MethodSettings) -> Result<Vec<Runner>> {
    let mut runners = Vec::with_capacity(methods.len());
    for &method in methods {
        runners.push(Runner::new(method, setup, settings, false)?);
    }
    if settings.also_global && !settings.global {
        let global = MethodSettings { global: true, ..settings.clone() };
        for &method in methods.iter().filter(|method| method.can_search()) {
            runners.push(Runner::new(method, setup, &global, true)?);
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

fn share(start: f64, end: f64, stamp: f64) -> f64 {
    if end > start { ((stamp - start) / (end - start)).clamp(0.0, 1.0) } else { 0.0 }
}

/// One method with its record and its computing time.
struct Runner {
    localizer: Box<dyn Localizer>,
    record: MethodRecord,
    /// The estimated pose at the last scan.
    pose_at_scan: Option<Pose2>,
}

impl Runner {
    fn new(method: Method, setup: &Setup, settings: &MethodSettings, global: bool) -> Result<Self> {
        let localizer = method.start(setup, settings)?;
        let record = MethodRecord { global, ..MethodRecord::new(method, setup) };
        let mut runner = Runner { localizer, record, pose_at_scan: None };
        runner.record_belief(setup.start);
        Ok(runner)
    }

    /// Predicts with a control, corrects with a measurement; the truth is not passed on.
    fn update(&mut self, event: &Event) -> Result<()> {
        let started = Instant::now();
        let stamp = event.stamp;
        match &event.payload {
            Payload::Control(control) => self.localizer.predict(stamp, control)?,
            Payload::Measurement(measurement) => {
                let outcomes = self.localizer.correct(stamp, measurement)?;
                let stamped = outcomes.into_iter().map(|value| Stamped { stamp, value });
                self.record.outcomes.extend(stamped);
            }
            Payload::Truth(_) => return Ok(()),
        }
        self.record.updates += 1;
        self.record.runtime += started.elapsed().as_secs_f64();
        if is_measurement(event) {
            self.record_belief(stamp);
        }
        if is_scan(event) {
            self.pose_at_scan = Some(self.localizer.estimate(stamp)?.pose);
        }
        if let Some(update) = self.localizer.line_matches().filter(|_| is_scan(event)) {
            self.record.lines.offer(stamp, update);
        }
        Ok(())
    }

    /// Samples the estimate, and the estimated errors of sensors.
    fn estimate(&mut self, stamp: f64) -> Result<()> {
        let started = Instant::now();
        self.record.estimates.push(self.localizer.estimate(stamp)?);
        self.record.runtime += started.elapsed().as_secs_f64();
        let errors = self.localizer.sensor_errors(stamp)?;
        // The list stays empty for methods without such errors; the first one may come at any time.
        if !errors.is_empty() {
            self.record.sensor_errors.resize(self.record.estimates.len() - 1, Vec::new());
            self.record.sensor_errors.push(errors);
        }
        Ok(())
    }

    /// Records particles or grid for figures; this does not count as computing time.
    fn record_belief(&mut self, stamp: f64) {
        if let Some(belief) = self.localizer.grid_belief() {
            self.record.beliefs.offer(stamp, belief);
        }
        if let Some(cloud) = self.localizer.particle_set(crate::record::MAX_PARTICLES) {
            self.record.snapshots.offer(stamp, cloud);
        }
    }

    /// The notes of the method, each with its name.
    fn notes(&self) -> Vec<String> {
        let name = self.record.name();
        self.localizer.notes().into_iter().map(|note| format!("{name}: {note}")).collect()
    }

    fn finish(self, last: Option<&LastScan>) -> Result<MethodRecord> {
        let map = self.localizer.map()?;
        let beam_fit = last.zip(self.pose_at_scan).and_then(|(last, pose)| last.fit(pose));
        let hypotheses = self.localizer.hypotheses();
        Ok(MethodRecord { map, beam_fit, hypotheses, ..self.record })
    }
}

/// The last scan of a run, whose fit to the map is evaluated at the estimated pose of every method.
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

/// The methods to be smoothed after the run, and the events for that.
struct SmoothingInput {
    methods: Vec<Method>,
    events: Vec<Event>,
}

impl SmoothingInput {
    fn new(methods: &[Method], settings: &MethodSettings) -> Self {
        let smoothed =
            methods.iter().copied().filter(|method| settings.smooth && method.can_smooth());
        SmoothingInput { methods: smoothed.collect(), events: Vec::new() }
    }

    fn push(&mut self, event: &Event) {
        if !self.methods.is_empty() && !matches!(event.payload, Payload::Truth(_)) {
            self.events.push(event.clone());
        }
    }

    /// A further record for each smoothed method. It repeats which measurements the filter
    /// accepted; their innovations do not apply to smoothed estimates and are left out.
    fn records(
        &self,
        setup: &Setup,
        settings: &MethodSettings,
        stamps: &[f64],
        records: &[MethodRecord],
    ) -> Result<Vec<MethodRecord>> {
        let mut all = Vec::with_capacity(self.methods.len());
        for &method in &self.methods {
            let started = Instant::now();
            let estimates = method.smooth(setup, settings, &self.events, stamps)?;
            let runtime = started.elapsed().as_secs_f64();
            let filter = records.iter().find(|record| record.method == method);
            let of_filter = filter.into_iter().flat_map(|record| &record.outcomes);
            let outcomes = of_filter.map(|outcome| Stamped {
                stamp: outcome.stamp,
                value: Outcome::of(outcome.value.decision),
            });
            all.push(MethodRecord {
                smoothed: true,
                estimates,
                outcomes: outcomes.collect(),
                updates: self.events.len(),
                runtime,
                ..MethodRecord::new(method, setup)
            });
        }
        Ok(all)
    }
}

/// Observes a run: progress bar, playback of the report, recording to a file.
pub trait Observer {
    /// The share of the run that is done, in \[0, 1\], after every estimate.
    fn progress(&mut self, share: f64);

    /// What is known before the first event, and the names of the methods that run.
    ///
    /// # Errors
    /// Any error ends the run.
    fn started(&mut self, _setup: &Setup, _methods: &[String]) -> Result<()> {
        Ok(())
    }

    /// An event, before it is passed to the methods.
    ///
    /// # Errors
    /// Any error ends the run.
    fn event(&mut self, _event: &Event) -> Result<()> {
        Ok(())
    }

    /// The methods after their estimates of a time \[s\] were sampled.
    ///
    /// # Errors
    /// Any error ends the run.
    fn estimated(&mut self, _stamp: f64, _methods: &[&dyn Localizer]) -> Result<()> {
        Ok(())
    }
}

/// An observer of the progress alone.
pub(crate) struct ProgressObserver<'a>(pub(crate) &'a mut dyn FnMut(f64));

impl Observer for ProgressObserver<'_> {
    fn progress(&mut self, share: f64) {
        (self.0)(share);
    }
}

/// Two observers, the second one optional.
#[cfg(feature = "cli")]
pub(crate) struct Observers<'a, A, B>(pub(crate) &'a mut A, pub(crate) &'a mut Option<B>);

#[cfg(feature = "cli")]
impl<A: Observer, B: Observer> Observer for Observers<'_, A, B> {
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
