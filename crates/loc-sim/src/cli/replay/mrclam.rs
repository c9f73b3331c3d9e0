//! Replays of MRCLAM recordings.

use super::{Replay, ReplayArgs, SEED, refuse};
use crate::localizer::{Method, MethodSettings};
use crate::scenario::{RecordingConfig, recording};
use crate::source::laser_log::Scans;
use crate::source::{Calibrated, Mrclam};
use std::path::Path;

pub(super) fn prepare(args: &ReplayArgs, log: &Path) -> anyhow::Result<Replay> {
    let given = [
        ("--map", args.map.is_some()),
        ("--lines", args.lines.is_some()),
        ("--scans", args.scans != Scans::All),
        ("--initial-pose", args.initial_pose.is_some()),
        ("--kidnap", args.kidnap.is_some()),
        ("--reference", args.reference.is_some()),
    ];
    refuse(&given, "one of MRCLAM")?;
    let changes = &args.output.changes;
    let config = match &args.config {
        Some(file) => RecordingConfig::read(file, changes)?,
        None => RecordingConfig::parse("settings for mrclam", recording::MRCLAM, changes)?,
    };
    let source = Mrclam::open(log, args.robot)?;
    let source =
        Calibrated::new(source, config.odometry_calibration(), config.camera_calibration())?;
    Ok(Replay {
        source: Box::new(source),
        settings: MethodSettings { seed: SEED, ..config.settings()? },
        methods: vec![Method::DeadReckoning, Method::Ekf],
    })
}
