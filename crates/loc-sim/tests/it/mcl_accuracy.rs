//! How good and how honest Monte Carlo localization is, over many seeds. Minutes each, so ignored:
//! `cargo test --release -p loc-sim -- --ignored --nocapture mcl_accuracy`

use loc_core::random::stream;
use loc_core::{Pose2, angle};
use loc_pf::Mcl;
use loc_pf::mcl::{MountedScan, Update};
use loc_sensors::event::{Control, Measurement, Payload};
use loc_sim::localizer::Method;
use loc_sim::metrics::{ends_near, pose_nees};
use loc_sim::record::Run;
use loc_sim::scenario::Scenario;

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

/// The longest row of updates at which `believes` says that the filter has settled while it is
/// off by more than 0.5 m or 15 degrees.
struct Settled {
    believes: fn(&Mcl) -> bool,
    row: usize,
    longest: usize,
}

impl Settled {
    fn new(believes: fn(&Mcl) -> bool) -> Self {
        Settled { believes, row: 0, longest: 0 }
    }

    fn look(&mut self, mcl: &Mcl, truth: Pose2) {
        let turn = angle::difference(mcl.pose().theta, truth.theta).abs();
        let is_wrong = mcl.pose().distance(truth) > 0.5 || turn > 15_f64.to_radians();
        self.row = if is_wrong && (self.believes)(mcl) { self.row + 1 } else { 0 };
        self.longest = self.longest.max(self.row);
    }
}

/// By its own statement: lost with a probability below one in ten.
fn says_so(mcl: &Mcl) -> bool {
    mcl.lost() < 0.1
}

/// By the cloud: nearly all of it in one heap, which lies within 0.5 m of its mean to 95 %.
fn is_one_heap(mcl: &Mcl) -> bool {
    let covariance = mcl.estimate().belief.covariance;
    let deviation = (covariance[(0, 0)] + covariance[(1, 1)]).sqrt();
    mcl.estimate().share() > 0.95 && 2.45 * deviation < 0.5
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
        let mut rows = [Settled::new(says_so), Settled::new(is_one_heap)];
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
                    rows.iter_mut().for_each(|row| row.look(&mcl, truth.pose));
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
