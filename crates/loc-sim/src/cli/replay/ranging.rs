//! Replays of recordings with ranges to beacons.

use super::laser::parse_pose;
use super::{Format, Replay, ReplayArgs, SEED, refuse};
use crate::localizer::{Method, MethodSettings};
use crate::scenario::{RecordingConfig, recording};
use crate::source::laser_log::Scans;
use crate::source::ranging::{RangeRecording, RangingStart};
use std::path::Path;

pub(super) fn prepare(args: &ReplayArgs, log: &Path, format: Format) -> anyhow::Result<Replay> {
    let given = [
        ("--map", args.map.is_some()),
        ("--scans", args.scans != Scans::All),
        ("--kidnap", args.kidnap.is_some()),
        ("--reference", args.reference.is_some()),
    ];
    refuse(&given, "one of ranges")?;
    let changes = &args.output.changes;
    let config = match &args.config {
        Some(file) => RecordingConfig::read(file, changes)?,
        None => RecordingConfig::parse("settings for ranging", recording::RANGING, changes)?,
    };
    let pose =
        args.initial_pose.as_deref().map(|text| parse_pose("--initial-pose", text)).transpose()?;
    let start = RangingStart { pose, sigmas: config.start.sigmas()? };
    let source = match format {
        Format::Plaza => RangeRecording::plaza(log, args.robot, &start)?,
        _ => RangeRecording::labyrinth(log, &start)?,
    };
    let mut settings = MethodSettings { seed: SEED, ..config.settings()? };
    if config.filter.camera.is_none() {
        settings.landmark.observation_noise = source.noise();
    }
    let odometry = (!args.global_start && !config.filter.global).then_some(Method::DeadReckoning);
    Ok(Replay {
        source: Box::new(source),
        settings,
        methods: odometry.into_iter().chain([Method::Lateration, Method::Fusion]).collect(),
    })
}
