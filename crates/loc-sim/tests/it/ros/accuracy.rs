//! How good the replays of the recorded bags are, with nothing set but what a user must say. One
//! seed each; all of them: `cargo test --release -p loc-sim -- --ignored --nocapture ros::accuracy`

use loc_core::Pose2;
use loc_core::motion::VelocityNoise;
use loc_maps::grid::io;
use loc_ros::RecordingOptions;
use loc_sim::localizer::{Method, MethodSettings};
use loc_sim::metrics::{Alignment, MethodSummary, Summary};
use loc_sim::runner;
use loc_sim::source::laser_log::{ReplayOptions, Start};
use loc_sim::source::ros::{OdometryDelay, RosOptions, RosRecording};
use std::path::PathBuf;
use std::sync::Arc;

fn bags() -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("LOC_DATA_DIR") else {
        println!("skipped: LOC_DATA_DIR is not set");
        return None;
    };
    Some(PathBuf::from(folder).join("ros_bags"))
}

/// Figures of `mcl` on a bag in a map, as `loc-sim replay` runs it.
fn replayed(bag: &str, map: &str, start: Start, seed: u64, noise: bool) -> Option<MethodSummary> {
    let bags = bags()?;
    let map = Some(Arc::new(io::load(bags.join(map)).unwrap()));
    let global = matches!(start, Start::Anywhere);
    let start_sigmas = [0.2, 0.2, 5_f64.to_radians()];
    let options = ReplayOptions { map, start, start_sigmas, ..ReplayOptions::default() };
    // `--odom-noise 0.05,3,1`
    let drift = VelocityNoise::from_sigmas(0.05, 3_f64.to_radians(), 1_f64.to_radians()).unwrap();
    let ros = RosOptions {
        odometry_delay: OdometryDelay::Estimated,
        recording: RecordingOptions {
            odometry_noise: noise.then_some((drift, seed)),
            ..RecordingOptions::default()
        },
    };
    let mut source = RosRecording::open(&bags.join(bag), &options, &ros).unwrap();
    let settings = MethodSettings { seed, global, ..MethodSettings::default() };
    let run = runner::run(&mut source, &[Method::Mcl], &settings, &mut |_| {}).unwrap();
    let summary = Summary::of(&run, Some(seed), Alignment::None).unwrap();
    println!("{bag}, seed {seed}: {:?}", summary.notes);
    summary.methods.into_iter().next().map(|(_, figures)| figures)
}

fn turtlebot4(start: Start, seed: u64) -> Option<f64> {
    let map = "turtlebot4/mac_1st_floor_9_23.yaml";
    let fit = replayed("turtlebot4", map, start, seed, false)?.beam_fit_at_end;
    println!("seed {seed}: {fit:?} of the beams fit at the end");
    fit
}

fn pioneer(seed: u64) -> Option<f64> {
    let map = "pioneer/derived_map_trace0.yaml";
    let figures = replayed("pioneer/trace0.bag", map, Start::Reference, seed, false)?;
    let errors = figures.errors?;
    println!("seed {seed}: median {:.3} m, max {:.3} m", errors.ate_median_m, errors.ate_max_m);
    Some(errors.ate_median_m)
}

fn stage(seed: u64) -> Option<f64> {
    let map = "stage_sim/meeting_stage_frame.yaml";
    let figures = replayed("stage_sim/simpath2.bag", map, Start::Reference, seed, true)?;
    let rmse = figures.errors?.ate_rmse_m;
    println!("seed {seed}: RMSE {rmse:.4} m");
    Some(rmse)
}

#[test]
fn one_replay_of_each_bag_reaches_its_figure() {
    if bags().is_none() {
        return;
    }
    assert!(turtlebot4(Start::Anywhere, 1).unwrap() >= 0.9);
    assert!(pioneer(1).unwrap() <= 0.1);
    assert!(stage(1).unwrap() <= 0.05);
}

#[test]
#[ignore = "50 replays"]
fn ten_seeds_of_each_bag_reach_its_figure() {
    if bags().is_none() {
        return;
    }
    // Odometry's frame is close to the map's, and its first pose is not (0, 0, 0).
    let first = Pose2::new(6.54, -8.86, 1.705);
    for start in [Start::At(Pose2::IDENTITY), Start::At(first), Start::Anywhere] {
        let fits = |seed: &u64| turtlebot4(start, *seed).unwrap() >= 0.9;
        assert!((1..=10).filter(fits).count() >= 9);
    }
    for seed in 1..=10 {
        assert!(pioneer(seed).unwrap() <= 0.1);
        assert!(stage(seed).unwrap() <= 0.05);
    }
}
