//! `histogram` in the office, on a recording, and where it cannot run (K1).

use crate::replay::{corrected, hall, open, uncorrected};
use loc_core::{Pose2, angle};
use loc_filters::histogram::{GridLocalizer, GridSettings};
use loc_maps::grid::io;
use loc_sensors::event::{Control, Measurement, Payload};
use loc_sim::localizer::{Method, MethodSettings};
use loc_sim::metrics::{Alignment, Summary};
use loc_sim::output;
use loc_sim::record::Run;
use loc_sim::scenario::Scenario;
use loc_sim::source::Source;
use loc_sim::source::carmen::CarmenLog;
use loc_sim::source::laser_log::{LaserRecording, ReplayOptions, Scans};
use loc_sim::{Error, runner};
use std::path::PathBuf;
use std::sync::Arc;

fn summary(run: &Run) -> Summary {
    Summary::of(run, None, Alignment::None).unwrap()
}

#[test]
fn in_the_office_it_finds_the_robot_and_draws_its_belief() {
    let changes = ["tour.duration=6.0", "tour.laser.max_range=20.0"].map(str::to_owned);
    let scenario = Scenario::named("grid-localization", &changes).unwrap();
    let run = scenario.run(None, None, &mut |_| {}).unwrap();
    let record = &run.methods[0];
    let pairs = || record.estimates.iter().zip(&run.truth);
    let off = |k: usize| pairs().nth(k).map(|(e, t)| e.pose.distance(t.value.pose)).unwrap();
    assert!(off(run.truth.len() - 1) < 0.2, "{}", off(run.truth.len() - 1));
    let spreads: Vec<f64> =
        record.beliefs.iter().map(|belief| belief.value.mean_and_spread().1).collect();
    assert!(spreads[0] > 5.0 && spreads[spreads.len() - 1] < 0.5, "{spreads:?}");
    for belief in record.beliefs.iter() {
        let sum: f32 = belief.value.probabilities.iter().sum();
        assert!((sum - 1.0).abs() < 1e-4, "{sum}");
    }
    let folder = output::files(&run, &summary(&run), "A title", "loc-sim").unwrap();
    let svg = folder.text("histogram.svg").unwrap();
    assert!(svg.contains("log10 of the probability of a square") && svg.contains(">robot<"));
    assert!(folder.text("errors.svg").unwrap().contains("spread of the position"));
    assert!(folder.text("report.html").unwrap().contains("What histogram believes"));
}

fn replayed(text: &str, options: &ReplayOptions, global: bool) -> loc_sim::Result<Run> {
    let settings = MethodSettings { global, ..Default::default() };
    let mut source = open(text, options)?;
    runner::run(&mut source, &[Method::Histogram], &settings, &mut |_| {})
}

fn in_hall() -> ReplayOptions {
    let start_sigmas = [0.2, 0.2, 0.1];
    ReplayOptions { map: Some(Arc::new(hall())), start_sigmas, ..Default::default() }
}

/// Without a start pose, and kidnapped during the tour.
#[test]
fn on_a_recording_it_searches_tracks_and_recovers() {
    let options = ReplayOptions { kidnap: Some(8.0), ..in_hall() };
    let run = replayed(&corrected(), &options, true).unwrap();
    let method = &summary(&run).methods[0].1;
    let errors = method.errors.unwrap();
    assert!(errors.ate_median_m < 0.06 && errors.final_error_m < 0.15, "{errors:?}");
    for updates in [method.converged_after_updates, method.recovered_after_updates] {
        assert!(updates.is_some_and(|updates| updates <= 5), "{updates:?}");
    }
}

#[test]
fn it_needs_a_map_and_a_start_in_it() {
    let error = replayed(&corrected(), &ReplayOptions::default(), true).map(|_| ()).unwrap_err();
    assert!(matches!(&error, Error::Unsuitable { method, .. } if method == "histogram"));
    assert!(error.to_string().contains("a map"), "{error}");
    // In the middle of a pillar.
    let start = loc_sim::source::laser_log::Start::At(Pose2::new(4.4, 3.2, 0.0));
    let options = ReplayOptions { start, start_sigmas: [0.01, 0.01, 0.02], ..in_hall() };
    let error = replayed(&uncorrected(), &options, false).map(|_| ()).unwrap_err();
    assert!(error.to_string().contains("expected a free place within reach"), "{error}");
    let bad = "filter.histogram={cell=-1.0}".to_owned();
    let error = Scenario::named("grid-localization", &[bad])
        .and_then(|scenario| scenario.run(None, None, &mut |_| {}).map(|_| ()))
        .unwrap_err();
    assert!(error.to_string().contains("GridSettings.cell"), "{error}");
}

/// The odd scans of the Intel recording with the reference pose of each, and the map of the even
/// ones; `None` without recordings.
fn intel() -> Option<(LaserRecording, loc_maps::OccupancyGrid)> {
    let Some(folder) = std::env::var_os("LOC_DATA_DIR") else {
        println!("skipped: LOC_DATA_DIR is not set");
        return None;
    };
    let folder = PathBuf::from(folder).join("carmen");
    let map = io::load(folder.join("intel_even.yaml")).unwrap();
    let log = CarmenLog::open(folder.join("intel.log")).unwrap().laser_log().unwrap();
    let options =
        ReplayOptions { map: Some(Arc::new(map.clone())), scans: Scans::Odd, ..Default::default() };
    Some((LaserRecording::new(log, &options).unwrap(), map))
}

/// One scan with what is known of it.
struct Moment {
    odometry: Pose2,
    measurement: Measurement,
    truth: Pose2,
}

fn moments(mut source: LaserRecording) -> Vec<Moment> {
    let (mut odometry, mut scan, mut moments) = (Pose2::IDENTITY, None, Vec::new());
    while let Some(event) = source.next_event().unwrap() {
        match event.payload {
            Payload::Control(Control::Odometry(pose)) => odometry = pose,
            Payload::Measurement(measurement) => scan = Some(measurement),
            Payload::Truth(truth) => {
                if let Some(measurement) = scan.take() {
                    moments.push(Moment { odometry, measurement, truth: truth.pose });
                }
            }
            _ => {}
        }
    }
    moments
}

/// How many scans it takes from `first` on until the estimate lies in the right cell, 0.2 m x 5 deg
/// about the reference; `None` if more than ten.
fn scans_until_found(localizer: &mut GridLocalizer, moments: &[Moment]) -> Option<usize> {
    for (k, moment) in moments.iter().take(10).enumerate() {
        let Measurement::Scan { scan, mounting } = &moment.measurement else { continue };
        localizer.update(moment.odometry, scan, *mounting).unwrap();
        let off = moment.truth.between(localizer.belief().pose());
        let in_cell = |off: f64| off.abs() <= 0.1;
        if in_cell(off.x) && in_cell(off.y) && angle::wrap(off.theta).abs() <= 2.5_f64.to_radians()
        {
            return Some(k + 1);
        }
    }
    None
}

/// From no knowledge at many places, and carried from one to the other while it is sure of the
/// first.
fn intel_starts(every: usize) {
    let Some((source, map)) = intel() else { return };
    let moments = moments(source);
    let mut localizer = GridLocalizer::new(&map, GridSettings::default()).unwrap();
    let mut counts = [[0_usize; 11]; 2];
    let starts = (0..moments.len() - 10).step_by(every);
    for (k, start) in starts.enumerate() {
        localizer.start_anywhere();
        let found = scans_until_found(&mut localizer, &moments[start..]);
        counts[0][found.map_or(10, |found| found - 1)] += 1;
        // Elsewhere, with an odometry that has noticed nothing.
        let there = (start + moments.len() / 3 + 7 * k) % (moments.len() - 10);
        let Some(last) = moments.get(start + found.unwrap_or(10) - 1) else { continue };
        let carried: Vec<Moment> = moments[there..there + 10]
            .iter()
            .map(|moment| Moment {
                odometry: last.odometry * moments[there].odometry.between(moment.odometry),
                measurement: moment.measurement.clone(),
                truth: moment.truth,
            })
            .collect();
        // The first scan there is taken at rest, so it is the second that counts.
        let found = scans_until_found(&mut localizer, &carried);
        counts[1][found.map_or(10, |found| found - 1)] += 1;
    }
    println!("found after 1, 2, .. 10, more scans: {:?}", counts[0]);
    println!("found again after a kidnapping:      {:?}", counts[1]);
    for counts in counts {
        let all: usize = counts.iter().sum();
        let late: usize = counts[5..].iter().sum();
        assert!(late * 20 <= all, "{counts:?}");
    }
}

#[test]
fn on_intel_it_is_found_within_five_scans() {
    intel_starts(90);
}

#[test]
#[ignore = "a minute; run with --release"]
fn on_intel_it_is_found_from_every_third_scan() {
    intel_starts(3);
}

/// From no knowledge, over several seeds: mostly the right room.
#[test]
fn the_topological_map_gives_the_room() {
    for seed in [2, 3] {
        let changes = ["demonstration.views=150", "demonstration.tour.duration=80.0"];
        let changes = changes.map(str::to_owned);
        let scenario = Scenario::named("topological-localization", &changes).unwrap();
        let shown = scenario.illustrate(seed).unwrap().unwrap();
        let number = |key: &str| shown.summary[key].as_f64().unwrap();
        assert!(number("places") > 10.0 && number("looks") > 60.0);
        assert!(number("right_or_neighbour_share") > 0.7, "{}", shown.summary);
        let files: Vec<_> = shown.figures.iter().map(|figure| figure.file.to_string()).collect();
        assert_eq!(files, ["topological.svg", "places.svg"]);
    }
    let error = |change: &str| {
        let scenario = Scenario::named("topological-localization", &[change.to_owned()]);
        scenario.and_then(|s| s.illustrate(1).map(|_| ())).unwrap_err().to_string()
    };
    assert!(error("demonstration.views=0").contains("demonstration.views"));
    assert!(error("demonstration.look_every=-1.0").contains("demonstration.look_every"));
}
