//! Replays of recordings with landmarks to be mapped.

use super::{Format, Replay, ReplayArgs, SEED, refuse};
use crate::Result;
use crate::localizer::{Method, MethodSettings};
use crate::scenario::{RecordingConfig, recording};
use crate::source::LandmarkRecording;
use crate::source::landmarks::Trees;
use crate::source::laser_log::Scans;
use loc_filters::slam::Identities;
use std::path::Path;

pub(super) fn prepare(args: &ReplayArgs, log: &Path, format: Format) -> anyhow::Result<Replay> {
    let given = [
        ("--map", args.map.is_some()),
        ("--lines", args.lines.is_some()),
        ("--scans", args.scans != Scans::All),
        ("--initial-pose", args.initial_pose.is_some()),
        ("--kidnap", args.kidnap.is_some()),
        ("--reference", args.reference.is_some()),
    ];
    refuse(&given, "one of landmarks")?;
    let changes = &args.output.changes;
    let parse = |text| RecordingConfig::parse("settings for landmarks", text, changes);
    let config = match &args.config {
        Some(file) => RecordingConfig::read(file, changes)?,
        None => match parse(defaults(format))? {
            config if format == Format::VictoriaPark && without_numbers(&config) => {
                parse(recording::VICTORIA_PARK_DETECTIONS)?
            }
            config => config,
        },
    };
    let mut settings = MethodSettings { seed: SEED, ..config.settings()? };
    let source = open(log, format, settings.slam.identities, config.start.sigmas()?)?;
    settings.landmark.mounting = source.mounting();
    Ok(Replay {
        source: Box::new(source),
        settings,
        methods: vec![Method::DeadReckoning, Method::EkfSlam],
    })
}

fn without_numbers(config: &RecordingConfig) -> bool {
    config.filter.slam.identities == Identities::Unknown
}

/// The settings that suit a format.
pub(super) fn defaults(format: Format) -> &'static str {
    match format {
        Format::LandmarkCourse => recording::LANDMARK_COURSE,
        Format::KfSlamDemo => recording::KF_SLAM_DEMO,
        _ => recording::VICTORIA_PARK,
    }
}

/// Opens a recording of one of these formats; of Victoria Park, the reading that suits.
pub(in crate::cli) fn open(
    log: &Path,
    format: Format,
    identities: Identities,
    sigmas: [f64; 3],
) -> Result<LandmarkRecording> {
    let trees = match identities {
        Identities::Known => Trees::Numbered,
        Identities::Unknown => Trees::Detected,
    };
    match format {
        Format::LandmarkCourse => LandmarkRecording::course(log, sigmas),
        Format::KfSlamDemo => LandmarkRecording::kf_slam_demo(log, sigmas),
        _ => LandmarkRecording::victoria_park(log, trees, sigmas),
    }
}
