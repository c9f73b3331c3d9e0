//! The formats of recordings, and how they are told apart.

use crate::source::landmarks::{course, kf_slam_demo, victoria_park};
use crate::source::ranging::{labyrinth, plaza};
use crate::source::{laser_log, mrclam};
use crate::{Error, Result};
use std::io::{BufRead, Read};
use std::path::Path;

/// A format of recordings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
#[non_exhaustive]
pub enum Format {
    /// A folder of the UTIAS MRCLAM data set.
    Mrclam,
    /// A folder of ultra-wideband ranges in the format of libRSF.
    UwbLabyrinth,
    /// A folder of the Plaza recordings: radio ranges and odometry.
    Plaza,
    /// A folder of the Freiburg landmark course.
    LandmarkCourse,
    /// MRPT's demonstration of SLAM as text: its folder, or its file of observations.
    KfSlamDemo,
    /// A folder of Victoria Park.
    VictoriaPark,
    /// A CARMEN log.
    Carmen,
    /// A log of CMU's Wean Hall.
    Wean,
    /// A bag of ROS 1 or ROS 2, or an MCAP file.
    Ros,
}

/// First words of lines that only a CARMEN log has.
const CARMEN: [&str; 9] = [
    "PARAM",
    "ODOM",
    "FLASER",
    "RLASER",
    "ROBOTLASER1",
    "ROBOTLASER2",
    "RAWLASER1",
    "TRUEPOS",
    "SYNC",
];

/// The format of a recording, by its files or its first lines.
pub(in crate::cli) fn guess(log: &Path) -> Result<Format> {
    std::fs::metadata(log).map_err(loc_core::Error::io(log))?;
    if mrclam::is_mrclam(log) {
        return Ok(Format::Mrclam);
    }
    if labyrinth::is_labyrinth(log) {
        return Ok(Format::UwbLabyrinth);
    }
    if plaza::is_plaza(log) {
        return Ok(Format::Plaza);
    }
    if course::is_course(log) {
        return Ok(Format::LandmarkCourse);
    }
    if victoria_park::is_victoria_park(log) {
        return Ok(Format::VictoriaPark);
    }
    if kf_slam_demo::is_kf_slam_demo(log) {
        return Ok(Format::KfSlamDemo);
    }
    if loc_ros::is_bag(log)? {
        return Ok(Format::Ros);
    }
    if log.is_dir() {
        return Err(unknown(log, "a folder without any of these"));
    }
    // Comments and an odd message or two may stand before the first word that tells.
    for line in laser_log::open(log)?.take(1 << 20).split(b'\n').take(1000) {
        let line = line.map_err(loc_core::Error::io(log))?;
        let line = String::from_utf8_lossy(&line);
        match line.split_ascii_whitespace().next() {
            Some("O" | "L") => return Ok(Format::Wean),
            Some(word) if CARMEN.contains(&word) => return Ok(Format::Carmen),
            _ => {}
        }
    }
    Err(unknown(log, "a file of another kind"))
}

fn unknown(log: &Path, found: &str) -> Error {
    Error::Recording {
        path: log.to_owned(),
        expected: "a recording: a bag of ROS, an MCAP file, a folder with Barcodes.dat (mrclam), \
                   a file *_Input.txt (uwb-labyrinth), plaza1_ranges.csv (plaza), sensor_data.dat \
                   (landmark-course), *_bearing_range.csv (kf-slam-demo) or \
                   gtsam_landmark_obs.csv (victoria-park), a log of ODOM and FLASER lines \
                   (carmen), or of O and L lines (wean)"
            .into(),
        found: found.into(),
    }
}
