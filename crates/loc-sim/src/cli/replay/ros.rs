//! What the command line says about a bag.

use super::Format;
use super::laser::parse_pose;
use crate::source::ros::{OdometryDelay, RosOptions};
use crate::{Result, config};
use anyhow::bail;
use loc_core::error::finite;
use loc_core::motion::VelocityNoise;
use loc_ros::{RecordingOptions, RosNames};

/// What is not found in a bag by itself.
#[derive(Debug, Clone, Default, clap::Args)]
pub struct RosArgs {
    /// The topic with the scans, in a bag with several.
    #[arg(long, value_name = "TOPIC")]
    pub scan_topic: Option<String>,
    /// The topic with the odometry, in a bag with several.
    #[arg(long, value_name = "TOPIC")]
    pub odom_topic: Option<String>,
    /// The topic of a bag with true poses; `/tf` for the recorded transform from map, `none` for
    /// no reference. Found by its name where left out.
    #[arg(long, value_name = "TOPIC")]
    pub reference_topic: Option<String>,
    /// The topic of the inertial unit, in a bag with several; `none` to leave it out.
    #[arg(long, value_name = "TOPIC")]
    pub imu_topic: Option<String>,
    /// The topic of the satellite receiver, in a bag with several; `none` to leave it out.
    #[arg(long, value_name = "TOPIC")]
    pub fix_topic: Option<String>,
    /// Where the laser sits on the robot, in metres and radians, in place of what a bag says.
    #[arg(long, value_name = "X,Y,YAW", allow_hyphen_values = true)]
    pub laser_mounting: Option<String>,
    /// How much later than its stamp the robot was where its odometry says, in seconds; negative
    /// for an odometry that comes late, 0 for stamps as they are. Estimated from the turns of the
    /// scans where left out.
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    pub odom_delay: Option<f64>,
    /// Noise to add to the odometry of a bag, as standard deviations: of the distance \[m\] after
    /// 1 m, of the heading \[deg\] after a full turn, and of the heading \[deg\] after 1 m.
    #[arg(long, value_name = "DISTANCE,TURN,DRIFT")]
    pub odom_noise: Option<String>,
}

impl RosArgs {
    /// The library's form.
    pub(in crate::cli) fn options(&self, seed: u64) -> Result<RosOptions> {
        let pose = |text: &String| parse_pose("--laser-mounting", text);
        let known = self.odom_delay.map(|delay| finite("--odom-delay [s]", delay)).transpose()?;
        let noise = |text: &String| Ok::<_, crate::Error>((parse_noise(text)?, seed));
        let recording = RecordingOptions {
            scan_topic: self.scan_topic.clone(),
            odom_topic: self.odom_topic.clone(),
            reference_topic: self.reference_topic.clone(),
            names: RosNames::default(),
            imu_topic: self.imu_topic.clone(),
            fix_topic: self.fix_topic.clone(),
            mounting: self.laser_mounting.as_ref().map(pose).transpose()?,
            odometry_delay: known.unwrap_or(0.0),
            odometry_noise: self.odom_noise.as_ref().map(noise).transpose()?,
        };
        let delay = if known.is_some() { OdometryDelay::Known } else { OdometryDelay::Estimated };
        Ok(RosOptions { recording, odometry_delay: delay })
    }

    /// The library's form, with stamps as they are unless something else is said.
    pub(in crate::cli) fn as_it_is(&self, seed: u64) -> Result<RosOptions> {
        let options = self.options(seed)?;
        Ok(RosOptions { odometry_delay: OdometryDelay::Known, ..options })
    }

    /// Refuses what only a bag can have.
    pub(in crate::cli) fn refuse_unless(&self, format: Format) -> anyhow::Result<()> {
        let options = [
            ("--scan-topic", self.scan_topic.is_some()),
            ("--odom-topic", self.odom_topic.is_some()),
            ("--reference-topic", self.reference_topic.is_some()),
            ("--imu-topic", self.imu_topic.is_some()),
            ("--fix-topic", self.fix_topic.is_some()),
            ("--laser-mounting", self.laser_mounting.is_some()),
            ("--odom-delay", self.odom_delay.is_some()),
            ("--odom-noise", self.odom_noise.is_some()),
        ];
        match options.iter().find(|(_, given)| *given) {
            Some((option, _)) if format != Format::Ros => {
                bail!("{option}: expected a bag of ROS, got another recording")
            }
            _ => Ok(()),
        }
    }
}

fn parse_noise(text: &str) -> Result<VelocityNoise> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|part| part.trim().parse()).collect();
    match numbers.as_deref() {
        Ok(&[distance, turn, drift]) => {
            Ok(VelocityNoise::from_sigmas(distance, turn.to_radians(), drift.to_radians())?)
        }
        _ => Err(config::field("--odom-noise", "three numbers distance,turn,drift", text)),
    }
}
