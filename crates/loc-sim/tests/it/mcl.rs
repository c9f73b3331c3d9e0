//! Monte Carlo localization: accuracy and consistency over many seeds, its scenarios, and its
//! optional parts. The tests over many seeds take minutes each, so they are ignored:
//! `cargo test --release -p loc-sim -- --ignored --nocapture 50_runs`

use loc_core::random::stream;
use loc_core::{Pose2, angle};
use loc_filters::RobotSettings;
use loc_filters::localizer::ParticleSet;
use loc_maps::LikelihoodField;
use loc_maps::grid::Occupancy;
use loc_pf::mcl::{FieldSettings, MountedScan, NoveltyFilter, SensorSettings, Update};
use loc_pf::novelty::{DistanceFilter, EntropyFilter};
use loc_pf::{Mcl, MclSettings};
use loc_sensors::event::{Control, Measurement, Payload};
use loc_sim::localizer::Method;
use loc_sim::metrics::{Alignment, Summary, ends_near, pose_nees};
use loc_sim::nav2::AmclParameters;
use loc_sim::output;
use loc_sim::probability_map::ProbabilityMap;
use loc_sim::record::{Run, Snapshots};
use loc_sim::scenario::{RecordingConfig, Scenario, recording};
use roxmltree::Document;

const SEEDS: std::ops::RangeInclusive<u64> = 1..=50;

fn runs(name: &str) -> impl Iterator<Item = (u64, Run)> {
    let scenario = Scenario::named(name, &[]).unwrap();
    SEEDS.map(move |seed| {
        (seed, scenario.run(Some(seed), Some(&[Method::Mcl]), &mut |_| {}).unwrap())
    })
}

#[test]
#[ignore = "50 runs"]
fn the_mean_nees_while_tracking_is_within_2_and_5_over_50_runs() {
    let (mut sum, mut count) = (0.0, 0.0);
    for (_, run) in runs("position-tracking") {
        for (estimate, truth) in run.methods[0].estimates.iter().zip(&run.truth) {
            sum += pose_nees(estimate, truth.value.pose).unwrap();
            count += 1.0;
        }
    }
    let mean = sum / count;
    println!("mean NEES of the pose over 50 runs: {mean:.3}");
    assert!((2.0..=5.0).contains(&mean), "{mean}");
}

#[test]
#[ignore = "50 runs"]
fn a_crowd_that_hides_40_percent_of_the_beams_loses_none_of_50_runs() {
    let mut lost = Vec::new();
    let mut worst = 0.0_f64;
    for (seed, run) in runs("crowded-museum") {
        let pairs = run.methods[0].estimates.iter().zip(&run.truth);
        let error = pairs.map(|(e, t)| e.pose.distance(t.value.pose)).fold(0.0, f64::max);
        worst = worst.max(error);
        if error > 1.0 || ends_near(&run, &run.methods[0]) != Some(true) {
            lost.push((seed, error));
        }
    }
    println!("lost: {lost:?}; largest error of all: {worst:.3} m");
    assert!(lost.is_empty(), "{lost:?}");
}

/// The longest sequence of updates at which `believes` reports convergence while the error is above
/// 0.5 m or 15 degrees.
struct Settled {
    believes: fn(&Mcl) -> bool,
    row: usize,
    longest: usize,
}

impl Settled {
    fn new(believes: fn(&Mcl) -> bool) -> Self {
        Settled { believes, row: 0, longest: 0 }
    }

    fn update(&mut self, mcl: &Mcl, truth: Pose2) {
        let turn = angle::difference(mcl.pose().theta, truth.theta).abs();
        let is_wrong = mcl.pose().distance(truth) > 0.5 || turn > 15_f64.to_radians();
        self.row = if is_wrong && (self.believes)(mcl) { self.row + 1 } else { 0 };
        self.longest = self.longest.max(self.row);
    }
}

/// By its own figure: delocalized with a probability below one in ten.
fn reports_localized(mcl: &Mcl) -> bool {
    mcl.lost() < 0.1
}

/// By the particle set: nearly all of it in one cluster, which lies within 0.5 m of its mean to 95 %.
fn is_one_cluster(mcl: &Mcl) -> bool {
    let covariance = mcl.last_estimate().belief.covariance;
    let deviation = (covariance[(0, 0)] + covariance[(1, 1)]).sqrt();
    mcl.last_estimate().share() > 0.95 && 2.45 * deviation < 0.5
}

#[test]
#[ignore = "50 runs"]
fn global_localization_never_settles_wrongly_for_more_than_5_updates_in_50_runs() {
    let scenario = Scenario::named("global-localization", &[]).unwrap();
    let mut longest = [0; 2];
    for seed in SEEDS {
        let mut source = scenario.source(seed).unwrap();
        let settings = scenario.settings().unwrap().mcl;
        let map = source.setup().map.clone().unwrap();
        let mut mcl = Mcl::new(&map, settings, stream(seed, "mcl")).unwrap();
        let mut rows = [Settled::new(reports_localized), Settled::new(is_one_cluster)];
        let (mut odometry, mut updated) = (Pose2::IDENTITY, false);
        while let Some(event) = source.next_event().unwrap() {
            match event.payload {
                Payload::Control(Control::Odometry(pose)) => {
                    mcl.odometry(pose).unwrap();
                    odometry = pose;
                }
                Payload::Measurement(Measurement::Scan { scan, mounting }) => {
                    let scan = MountedScan { scan: &scan, mounting };
                    let update = mcl.update(odometry, &[scan]).unwrap();
                    updated |= matches!(update, Update::Done(_));
                }
                Payload::Truth(truth) if updated => {
                    rows.iter_mut().for_each(|row| row.update(&mcl, truth.pose));
                    updated = false;
                }
                _ => {}
            }
        }
        println!("seed {seed}: {:?}", rows.each_ref().map(|row| row.longest));
        for (all, row) in longest.iter_mut().zip(&rows) {
            *all = (*all).max(row.longest);
        }
    }
    println!("longest at a wrong place, by its statement and by its cloud: {longest:?} updates");
    assert!(longest.iter().all(|&updates| updates <= 5), "{longest:?}");
}

fn run(name: &str, changes: &[&str]) -> Run {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    Scenario::named(name, &changes).unwrap().run(None, None, &mut |_| {}).unwrap()
}

/// Distances of a method's estimates from the truth, with their stamps.
fn errors(run: &Run, method: Method) -> Vec<(f64, f64)> {
    let record = run.methods.iter().find(|record| record.method == method).unwrap();
    let pairs = record.estimates.iter().zip(&run.truth);
    pairs.map(|(e, t)| (t.stamp, e.pose.distance(t.value.pose))).collect()
}

fn rmse(errors: &[(f64, f64)]) -> f64 {
    (errors.iter().map(|(_, e)| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

fn figures(run: &Run) -> output::Folder {
    let summary = Summary::of(run, Some(1), Alignment::None).unwrap();
    let folder = output::files(run, &summary, "A title", "loc-sim").unwrap();
    for name in folder.names().filter(|name| name.ends_with(".svg")) {
        assert!(Document::parse(folder.text(name).unwrap()).is_ok(), "{name}");
    }
    folder
}

/// A1.
#[test]
fn position_tracking_follows_where_odometry_drifts_away() {
    let run = run("position-tracking", &["tour.duration=60.0"]);
    let (mcl, odometry) = (errors(&run, Method::Mcl), errors(&run, Method::DeadReckoning));
    assert!(rmse(&mcl) < 0.1, "{}", rmse(&mcl));
    assert!(rmse(&odometry) > 1.0, "{}", rmse(&odometry));
    let folder = figures(&run);
    assert!(folder.text("map.svg").unwrap().contains("<image"));
    assert!(folder.text("errors.svg").unwrap().contains("spread of the position"));
}

/// A2, M3: the particle set starts all over the map and converges to the truth.
#[test]
fn global_localization_ends_at_the_truth() {
    let run = run("global-localization", &["tour.duration=25.0"]);
    let errors = errors(&run, Method::Mcl);
    let (first, last) = (errors[0].1, errors[errors.len() - 1].1);
    assert!(first > 1.0 && last < 0.2, "{first} {last}");
    let spread = |cloud: &ParticleSet| {
        let of = |k: fn(&Pose2) -> f64| {
            let values = || cloud.particles.iter().map(|(pose, _)| k(pose));
            values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
        };
        f64::hypot(of(|pose| pose.x), of(|pose| pose.y))
    };
    let clouds: Vec<_> = run.methods[0].snapshots.iter().collect();
    assert!(clouds.len() <= Snapshots::MAX && clouds[0].stamp == 0.0);
    assert!(clouds.iter().all(|cloud| cloud.value.particles.len() <= 500));
    assert!(spread(&clouds[0].value) > 20.0);
    let end = spread(&clouds[clouds.len() - 1].value);
    assert!(end < 3.0, "{end}");
    // Twelve frames, of one image.
    let folder = figures(&run);
    let svg = folder.text("clouds.svg").unwrap();
    assert_eq!((svg.matches("<use").count(), svg.matches("<image").count()), (12, 1));
    let summary = Summary::of(&run, Some(1), Alignment::None).unwrap();
    assert!(summary.methods[0].1.converged_at_s.is_some());
}

/// A3: relocalized after a kidnapping, whose jump is not part of the distance travelled.
#[test]
fn a_kidnapping_is_seen_in_errors_and_figures() {
    let run = run("kidnapped-robot", &["tour.kidnap.at=10.0", "tour.duration=20.0"]);
    let of_mcl = errors(&run, Method::Mcl);
    let before = of_mcl.iter().filter(|(stamp, _)| *stamp < 9.95);
    assert!(before.clone().all(|(_, error)| *error < 0.6), "{before:?}");
    assert!(of_mcl[of_mcl.len() - 1].1 < 0.3, "{:?}", of_mcl[of_mcl.len() - 1]);
    let odometry = errors(&run, Method::DeadReckoning);
    assert!(odometry[100].1 - odometry[99].1 > 2.0);
    assert!(run.distance().unwrap() < 20.0 * 0.7);
    let folder = figures(&run);
    let texts = |name: &str| folder.text(name).unwrap().to_owned();
    assert!(texts("errors.svg").contains(">kidnapped<"));
    assert!(texts("map.svg").contains(">put down<"));
    assert!(texts("clouds.svg").contains(", kidnapped<"));
}

#[test]
fn the_seed_of_a_run_reaches_the_particles() {
    let short = ["tour.duration=5.0"].map(str::to_owned);
    let scenario = Scenario::named("position-tracking", &short).unwrap();
    let run = |seed| scenario.run(Some(seed), Some(&[Method::Mcl]), &mut |_| {}).unwrap();
    let (first, again, other) = (run(4), run(4), run(5));
    assert_eq!(first.methods[0].estimates, again.methods[0].estimates);
    assert_eq!(first.methods[0].snapshots, again.methods[0].snapshots);
    assert_ne!(first.methods[0].estimates, other.methods[0].estimates);
    assert_eq!(other.settings.seed, 5);
}

/// M12: the highest likelihood is where the scan was taken, and the sums are those of its beams.
#[test]
fn the_probability_map_is_highest_at_the_truth() {
    let changes = ["step=0.2", "headings=36"].map(|c| format!("probability_map.{c}"));
    let config = Scenario::named("probability-map", &changes).unwrap().probability_map.unwrap();
    let map = ProbabilityMap::new(&config, 1).unwrap();
    let turned = loc_core::angle::difference(map.best.theta, map.truth.theta);
    assert!(map.best.distance(map.truth) < 0.25 && turned.abs() < 0.1, "{:?}", map.best);
    let field = LikelihoodField::new(&map.map, &config.field).unwrap();
    let ends: Vec<_> =
        map.scan.thinned(60).iter().map(|b| map.mounting.transform(&b.point())).collect();
    let mut looked_at = 0;
    for (index, cell) in map.frame.cells().enumerate().step_by(97) {
        let place = map.frame.center(cell);
        let free = map.map.occupancy_at(&place) == Occupancy::Free;
        assert_eq!(map.true_heading[index].is_finite(), free);
        if !free {
            continue;
        }
        let pose = Pose2::new(place.x, place.y, map.truth.theta);
        let one_by_one: f64 =
            ends.iter().map(|end| field.log_likelihood_at(&pose.transform(end))).sum();
        // A beam's end that lies on the edge of a cell may count for either.
        assert!((map.true_heading[index] - one_by_one).abs() < 0.3);
        assert!(map.any_heading[index] >= map.true_heading[index]);
        looked_at += 1;
    }
    assert!(looked_at > 30, "{looked_at}");
}

#[test]
fn a_scenario_without_a_robot_that_moves_is_an_illustration() {
    let scenario = Scenario::named("probability-map", &["probability_map.step=0.5".into()]);
    let scenario = scenario.unwrap();
    let illustration = scenario.illustrate(1).unwrap().unwrap();
    let folder = illustration.files(&scenario.title, "loc-sim run probability-map").unwrap();
    let names: Vec<&str> = folder.names().collect();
    assert_eq!(names, ["summary.json", "report.html", "probability.svg"]);
    assert!(Document::parse(folder.text("probability.svg").unwrap()).is_ok());
    assert!(folder.text("report.html").unwrap().contains("most likely pose"));
    assert!(scenario.run(None, Some(&[Method::Mcl]), &mut |_| {}).is_err());
    let drive = Scenario::named("landmark-drive", &[]).unwrap();
    assert!(drive.illustrate(1).unwrap().is_none());
    for (change, message) in [
        ("probability_map.pose.x=500.0", "probability_map.pose: expected a place in free space"),
        ("probability_map.headings=0", "probability_map.headings: expected 1 to 3600"),
        ("probability_map.beams=0", "probability_map.beams: expected at least 1"),
    ] {
        let scenario = Scenario::named("probability-map", &[change.into()]);
        let error = scenario.and_then(|scenario| scenario.illustrate(1)).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

/// The settings of the filter after changes on the command line.
fn settings(changes: &[&str]) -> Result<MclSettings, String> {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    let scenario = Scenario::named("position-tracking", &changes);
    let settings = scenario.and_then(|scenario| scenario.settings());
    Ok(settings.map_err(|error| error.to_string())?.mcl)
}

#[test]
fn parts_of_the_filter_are_switched_off_and_on_by_name() {
    let own = settings(&[]).unwrap();
    assert!(own.tempering.is_some() && own.recovery.suspicion.is_some());
    for off in ["false", "off", "\"off\""] {
        let set = |key: &str| settings(&[&format!("filter.mcl.{key}={off}")]).unwrap();
        assert_eq!(set("tempering"), own.clone().tempering(None));
        assert_eq!(set("recovery.suspicion").recovery.suspicion, None);
        assert_eq!(set("recovery.augmented"), own);
        assert_eq!(set("novelty"), own);
    }
    assert_eq!(settings(&["filter.mcl.tempering=true"]).unwrap(), own);
    let crowd = settings(&["filter.mcl.novelty=on"]).unwrap();
    assert_eq!(crowd.novelty, Some(NoveltyFilter::Distance(DistanceFilter::default())));
    let entropy = settings(&["filter.mcl.novelty.entropy.tolerance=0.02"]).unwrap();
    let filter = EntropyFilter::default().tolerance(0.02);
    assert_eq!(entropy.novelty, Some(NoveltyFilter::Entropy(filter)));
    assert!(settings(&["filter.mcl.recovery.search=false"]).is_ok_and(|mcl| !mcl.recovery.search));
}

#[test]
fn what_is_neither_settings_nor_a_switch_is_refused() {
    for (change, message) in [
        ("tempering=0", "integer `0`, expected a table of settings, false (off) or true"),
        ("tempering=maybe", "string \"maybe\", expected a table of settings"),
        ("tempering.stages=3", "unknown field `stages`, expected `effective_share`"),
        ("novelty.people=1", "unknown variant `people`"),
        ("recovery.suspicion=[1]", "invalid type: sequence, expected a table of settings"),
    ] {
        let error = settings(&[&format!("filter.mcl.{change}")]).unwrap_err();
        assert!(error.contains(message), "{error}");
    }
}

/// Settings that are written and read again are the same, whatever is switched off.
#[test]
fn written_settings_are_read_as_they_were() {
    let mut all_off = MclSettings::default().tempering(None).novelty(None);
    (all_off.recovery.suspicion, all_off.recovery.augmented) = (None, None);
    let mut all_on = MclSettings::default().novelty(Some(NoveltyFilter::default()));
    all_on.recovery.augmented = Some(Default::default());
    let skip = Some(Default::default());
    all_on.sensor = SensorSettings::LikelihoodField(FieldSettings::default().beam_skip(skip));
    for settings in [MclSettings::default(), all_off, all_on] {
        let text = toml::to_string(&settings).unwrap();
        assert_eq!(toml::from_str::<MclSettings>(&text).unwrap(), settings, "{text}");
        let json = serde_json::to_string(&settings).unwrap();
        assert_eq!(serde_json::from_str::<MclSettings>(&json).unwrap(), settings, "{json}");
    }
}

/// A part stays off through the file of a replay, and beside a parameter file of nav2_amcl.
#[test]
fn a_part_that_is_off_stays_off() {
    let off = ["filter.mcl.tempering=false".to_owned()];
    let config = RecordingConfig::parse("laser", recording::LASER, &off).unwrap();
    assert_eq!(config.settings(RobotSettings::default()).unwrap().mcl.tempering, None);
    let text = "amcl:\n  ros__parameters:\n    max_particles: 800\n";
    let mut mcl = AmclParameters::parse("amcl.yaml", text).unwrap().mcl;
    mcl.tempering = None;
    let read: MclSettings = toml::Value::try_from(&mcl).unwrap().try_into().unwrap();
    assert_eq!(read, mcl);
}

#[test]
fn the_plain_filter_tracks_too() {
    let changes = ["filter.mcl.tempering=false", "tour.duration=10.0"].map(str::to_owned);
    let plain = Scenario::named("position-tracking", &changes).unwrap();
    let tempered = Scenario::named("position-tracking", &changes[1..]).unwrap();
    let run = |scenario: Scenario| {
        let mut run = scenario.run(None, Some(&[Method::Mcl]), &mut |_| {}).unwrap();
        let end = run.truth.last().unwrap().value.pose;
        let estimates = run.methods.remove(0).estimates;
        assert!(estimates.last().unwrap().pose.distance(end) < 0.2);
        estimates
    };
    assert_ne!(run(plain), run(tempered));
}
