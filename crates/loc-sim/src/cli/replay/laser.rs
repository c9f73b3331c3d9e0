//! Replays of recordings with a laser.

use super::{Format, Replay, ReplayArgs};
use crate::localizer::Method;
use crate::scenario::{RecordingConfig, recording};
use crate::source::LaserRecording;
use crate::source::carmen::CarmenLog;
use crate::source::laser_log::{Reference, ReplayOptions, Start};
use crate::source::wean::WeanLog;
use loc_core::Pose2;
use loc_maps::grid::io;
use std::path::Path;
use std::sync::Arc;

pub(super) fn prepare(args: &ReplayArgs, log: &Path, format: Format) -> anyhow::Result<Replay> {
    let changes = &args.output.changes;
    let config = match &args.config {
        Some(file) => RecordingConfig::read(file, changes)?,
        None => RecordingConfig::parse("settings for lasers", recording::LASER, changes)?,
    };
    let start = match &args.initial_pose {
        Some(text) => Start::At(parse_pose(text)?),
        None if args.global_start || config.filter.global => Start::Anywhere,
        None => Start::Reference,
    };
    let options = ReplayOptions {
        map: args.map.as_ref().map(io::load).transpose()?.map(Arc::new),
        scans: args.scans,
        start,
        start_sigmas: config.start.sigmas()?,
        kidnap: args.kidnap,
        reference: args.reference.as_deref().map(Reference::read).transpose()?,
    };
    let log = match format {
        Format::Wean => WeanLog::open(log)?.laser_log()?,
        _ => CarmenLog::open(log)?.laser_log()?,
    };
    let source = LaserRecording::new(log, &options)?;
    // Odometry alone has nowhere to start where nobody knows the pose.
    let odometry = source.start_is_known().then_some(Method::DeadReckoning);
    Ok(Replay {
        source: Box::new(source),
        settings: config.settings()?,
        methods: odometry.into_iter().chain([Method::Mcl]).collect(),
    })
}

fn parse_pose(text: &str) -> crate::Result<Pose2> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[x, y, yaw]) if x.is_finite() && y.is_finite() && yaw.is_finite() => {
            Ok(Pose2::new(x, y, yaw))
        }
        _ => Err(crate::config::field("--initial-pose", "three finite numbers x,y,yaw", text)),
    }
}
