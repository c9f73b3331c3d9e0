//! A run as an MCAP file of ROS 2, for the viewers of the robotics world.
//!
//! The frames are those of REP-105: map -> odom is what the method estimates, odom -> base_link
//! what the odometry says, base_link -> laser the mounting. The first method that has particles,
//! or else the last one, is the one whose map -> odom is written.

use crate::Result;
use crate::runner::Observer;
use crate::source::OdometryIntegrator;
use crate::source::Setup;
use loc_core::{Pose2, Twist2};
use loc_filters::localizer::{Estimate, Localizer};
use loc_ros::McapWriter;
use loc_ros::messages::{
    Covariant, DiagnosticArray, DiagnosticStatus, Header, LaserScan, OccupancyGrid, Odometry,
    ParticleCloud, Path, PointCloud2, Pose, PoseArray, PoseStamped, PoseWithCovarianceStamped,
    Stamp, TfMessage, TransformStamped,
};
use loc_sensors::event::{Control, Event, Measurement, Payload};
use loc_sensors::laser;

const MAP: &str = "map";
const ODOM: &str = "odom";
const BASE: &str = "base_link";
const LASER: &str = "laser";

/// Writes what it sees of a run.
#[derive(Debug)]
pub struct McapRecorder {
    writer: McapWriter,
    methods: Vec<String>,
    driven: OdometryIntegrator,
    mounting: Option<Pose2>,
    truth: Path,
    /// True poses that were written; the path is written again when it has grown by half.
    written: usize,
}

impl McapRecorder {
    /// Makes the file.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`].
    pub fn create(path: &std::path::Path) -> Result<Self> {
        Ok(McapRecorder {
            writer: McapWriter::create(path)?,
            methods: Vec::new(),
            driven: OdometryIntegrator::default(),
            mounting: None,
            truth: Path { header: Header::new(Stamp::default(), MAP), poses: Vec::new() },
            written: 0,
        })
    }

    /// Writes the rest and the index; gives the number of messages.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`].
    pub fn finish(mut self) -> Result<u64> {
        self.write_truth()?;
        Ok(self.writer.finish()?)
    }

    fn write_truth(&mut self) -> Result<()> {
        let Some(last) = self.truth.poses.last() else { return Ok(()) };
        self.truth.header.stamp = last.header.stamp;
        self.written = self.truth.poses.len();
        Ok(self.writer.write("/ground_truth", last.header.stamp.0, &self.truth)?)
    }

    fn transform(&mut self, topic: &str, at: Stamp, frames: [&str; 2], pose: Pose2) -> Result<()> {
        let [parent, child] = frames;
        let transform = TransformStamped {
            header: Header::new(at, parent),
            child_frame_id: child.into(),
            transform: pose.into(),
        };
        Ok(self.writer.write(topic, at.0, &TfMessage { transforms: vec![transform] })?)
    }

    fn odometry(&mut self, at: Stamp, pose: Pose2, twist: Option<Twist2>) -> Result<()> {
        let mut message = Odometry { header: Header::new(at, ODOM), ..Odometry::default() };
        message.child_frame_id = BASE.into();
        message.pose.pose = pose.into();
        if let Some(twist) = twist {
            message.twist.pose.linear = [twist.vx, twist.vy, 0.0];
            message.twist.pose.angular = [0.0, 0.0, twist.omega];
        }
        self.writer.write("/odom", at.0, &message)?;
        self.transform("/tf", at, [ODOM, BASE], pose)
    }

    fn control(&mut self, stamp: f64, control: &Control) -> Result<()> {
        let Some(pose) = self.driven.pose(stamp, control) else { return Ok(()) };
        let twist = match control {
            Control::Velocity(twist) => Some(*twist),
            _ => None,
        };
        self.odometry(Stamp::from_seconds(stamp), pose, twist)
    }

    fn scan(&mut self, at: Stamp, scan: &laser::LaserScan, mounting: Pose2) -> Result<()> {
        if self.mounting != Some(mounting) {
            self.mounting = Some(mounting);
            self.transform("/tf_static", at, [BASE, LASER], mounting)?;
        }
        self.writer.write("/scan", at.0, &LaserScan::of(Header::new(at, LASER), scan))?;
        let points = scan.points(Pose2::IDENTITY).map(|p| [p.x as f32, p.y as f32, 0.0]);
        let cloud = PointCloud2::of(Header::new(at, LASER), &points.collect::<Vec<_>>());
        Ok(self.writer.write("/scan_points", at.0, &cloud)?)
    }

    fn primary(&mut self, at: Stamp, name: &str, estimate: &Estimate) -> Result<()> {
        let map_from_odom = estimate.pose * self.driven.last().inverse();
        self.transform("/tf", at, [MAP, ODOM], map_from_odom)?;
        self.writer.write("/amcl_pose", at.0, &pose_message(at, estimate))?;
        let mut values = vec![("map_from_odom".to_owned(), map_from_odom.to_string())];
        if let Some(covariance) = estimate.covariance {
            let sigma = |axis| f64::max(0.0, covariance[(axis, axis)]).sqrt();
            values.push(("sigma_x_m".into(), format!("{:.4}", sigma(0))));
            values.push(("sigma_y_m".into(), format!("{:.4}", sigma(1))));
            values.push(("sigma_yaw_rad".into(), format!("{:.4}", sigma(2))));
        }
        let status = DiagnosticStatus {
            name: format!("localization: {name}"),
            message: "running".into(),
            values,
            ..DiagnosticStatus::default()
        };
        let message = DiagnosticArray { header: Header::new(at, ""), status: vec![status] };
        Ok(self.writer.write("/diagnostics", at.0, &message)?)
    }

    fn particles(&mut self, at: Stamp, particles: &[(Pose2, f64)]) -> Result<()> {
        let header = Header::new(at, MAP);
        let particles: Vec<(Pose, f64)> =
            particles.iter().map(|(pose, weight)| ((*pose).into(), *weight)).collect();
        let poses = particles.iter().map(|(pose, _)| *pose).collect();
        let array = PoseArray { header: header.clone(), poses };
        self.writer.write("/particle_cloud", at.0, &ParticleCloud { header, particles })?;
        Ok(self.writer.write("/particle_poses", at.0, &array)?)
    }
}

impl Observer for McapRecorder {
    fn progress(&mut self, _share: f64) {}

    fn started(&mut self, setup: &Setup, methods: &[String]) -> Result<()> {
        self.methods = methods.to_vec();
        let at = Stamp::from_seconds(setup.start);
        if let Some(map) = &setup.map {
            let grid = OccupancyGrid::of(Header::new(at, MAP), map);
            self.writer.write("/map", at.0, &grid)?;
        }
        if !setup.landmarks.is_empty() {
            let place = |landmark: &loc_maps::Landmark| {
                Pose2::new(landmark.position.x, landmark.position.y, 0.0).into()
            };
            let poses = setup.landmarks.iter().map(place).collect();
            let array = PoseArray { header: Header::new(at, MAP), poses };
            self.writer.write("/landmarks", at.0, &array)?;
        }
        Ok(())
    }

    fn event(&mut self, event: &Event) -> Result<()> {
        let at = Stamp::from_seconds(event.stamp);
        match &event.payload {
            Payload::Control(control) => self.control(event.stamp, control),
            Payload::Measurement(Measurement::Scan { scan, mounting }) => {
                self.scan(at, scan, *mounting)
            }
            Payload::Measurement(_) => Ok(()),
            Payload::Truth(truth) => {
                let pose = truth.pose.into();
                self.truth.poses.push(PoseStamped { header: Header::new(at, MAP), pose });
                let due = self.written + self.written / 2 + 10;
                if self.truth.poses.len() >= due { self.write_truth() } else { Ok(()) }
            }
        }
    }

    fn estimated(&mut self, stamp: f64, localizers: &[&dyn Localizer]) -> Result<()> {
        let at = Stamp::from_seconds(stamp);
        self.driven.integrate_to(stamp);
        let clouds: Vec<_> = localizers
            .iter()
            .map(|localizer| localizer.particle_set(crate::record::MAX_PARTICLES))
            .collect();
        let primary = clouds.iter().position(Option::is_some);
        let primary = primary.unwrap_or(localizers.len().saturating_sub(1));
        for (index, localizer) in localizers.iter().enumerate() {
            let estimate = localizer.estimate(stamp)?;
            let name = self.methods.get(index).cloned().unwrap_or_default();
            if index == primary {
                self.primary(at, &name, &estimate)?;
            } else {
                let topic = format!("/{}/pose", name.replace('-', "_"));
                self.writer.write(&topic, at.0, &pose_message(at, &estimate))?;
            }
        }
        match clouds.get(primary) {
            Some(Some(cloud)) => self.particles(at, &cloud.particles),
            _ => Ok(()),
        }
    }
}

fn pose_message(at: Stamp, estimate: &Estimate) -> PoseWithCovarianceStamped {
    let pose = Covariant::planar(estimate.pose, estimate.covariance);
    PoseWithCovarianceStamped { header: Header::new(at, MAP), pose }
}
