//! The measurement: one sweep of ranges.

use crate::check::{count, in_range, reach};
use crate::{Error, Result};
use loc_core::error::{finite, non_negative};
use loc_core::{Pose2, Twist2};
use nalgebra::Point2;

/// One sweep of a laser scanner, with the meaning of the ROS message of that name: angles count
/// counter-clockwise from straight ahead, the stamp that goes with it is the time of beam 0.
///
/// A range is a measurement where `range_min <= range <= range_max`. Otherwise (REP-117) -inf says
/// too close, +inf nothing in reach, and NaN that the beam failed. All numbers are `f64`, into
/// which the message's `f32` go without loss, so that a beam's angle is exact for any number of
/// beams.
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(deny_unknown_fields))]
pub struct LaserScan {
    /// Angle of beam 0 \[rad\].
    pub angle_min: f64,
    /// Angle of the last beam \[rad\].
    pub angle_max: f64,
    /// Angle from one beam to the next \[rad\]; negative for a scanner that hangs upside down.
    pub angle_increment: f64,
    /// Time from one beam to the next \[s\].
    pub time_increment: f64,
    /// Time from one scan to the next \[s\].
    pub scan_time: f64,
    /// Shortest range that is a measurement \[m\].
    pub range_min: f64,
    /// Longest range that is a measurement \[m\].
    pub range_max: f64,
    /// Ranges in the order of the beams \[m\].
    pub ranges: Vec<f64>,
    /// Strengths of the returns in the device's own unit: one for each beam, or none at all.
    pub intensities: Vec<f64>,
}

/// A beam that measured something.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Beam {
    /// Its number in the scan.
    pub index: usize,
    /// Its direction from the scanner \[rad\].
    pub angle: f64,
    /// What it measured \[m\].
    pub range: f64,
}

impl Beam {
    /// Where the beam ended, in the scanner's frame \[m\].
    pub fn point(self) -> Point2<f64> {
        let (sin, cos) = self.angle.sin_cos();
        Point2::new(self.range * cos, self.range * sin)
    }
}

impl LaserScan {
    /// More beams than this no scanner has.
    pub const MAX_BEAMS: usize = 1_000_000;

    /// Checks that this can be a scan; messages and files are checked before use.
    ///
    /// # Errors
    /// [`Error::Length`] for no beams, more than [`Self::MAX_BEAMS`], a number of beams that
    /// does not fit the angles (one too few or too many are common and let through), or
    /// intensities for some beams only. [`Error::OutOfRange`] for an increment of 0, numbers that
    /// are not finite or limits in the wrong order, and for a scan in which every range is NaN.
    pub fn check(&self) -> Result<()> {
        count("ranges of a scan", "1 to 1000000 beams", Self::MAX_BEAMS, self.ranges.len())?;
        finite("angle_min of a scan [rad]", self.angle_min)?;
        finite("angle_max of a scan [rad]", self.angle_max)?;
        let turns = |increment: f64| increment.is_finite() && increment != 0.0;
        let expected = "a finite number other than 0";
        in_range("angle_increment of a scan [rad]", expected, self.angle_increment, turns)?;
        non_negative("time_increment of a scan [s]", self.time_increment)?;
        non_negative("scan_time of a scan [s]", self.scan_time)?;
        reach(self.range_min, self.range_max)?;
        self.check_lengths()?;
        if self.ranges.iter().all(|range| range.is_nan()) {
            let (what, expected) = ("ranges of a scan [m]", "at least one that is not NaN");
            return Err(Error::OutOfRange { what, expected, found: f64::NAN });
        }
        Ok(())
    }

    fn check_lengths(&self) -> Result<()> {
        let beams = self.ranges.len();
        let expected = (self.angle_max - self.angle_min) / self.angle_increment + 1.0;
        if (expected - beams as f64).abs() > 1.5 {
            let expected = "as many beams as lie from angle_min to angle_max";
            return Err(Error::Length { what: "ranges of a scan", expected, found: beams });
        }
        if !self.intensities.is_empty() && self.intensities.len() != beams {
            let found = self.intensities.len();
            let expected = "as many as ranges, or none";
            return Err(Error::Length { what: "intensities of a scan", expected, found });
        }
        Ok(())
    }

    /// Angle of beam `index` \[rad\].
    pub fn angle(&self, index: usize) -> f64 {
        self.angle_min + index as f64 * self.angle_increment
    }

    /// Whether a range is a measurement.
    pub fn is_valid(&self, range: f64) -> bool {
        (self.range_min..=self.range_max).contains(&range)
    }

    /// The beams that measured something, in order.
    pub fn beams(&self) -> impl Iterator<Item = Beam> + '_ {
        let beam = |(index, &range)| Beam { index, angle: self.angle(index), range };
        let valid = move |beam: &Beam| self.is_valid(beam.range);
        self.ranges.iter().enumerate().map(beam).filter(valid)
    }

    /// At most `count` of the beams that measured something, evenly spread over them; the first
    /// and the last are among them. Thinning comes after dropping, so that a scanner which sees
    /// only a few things keeps them.
    pub fn thinned(&self, count: usize) -> Vec<Beam> {
        let beams: Vec<Beam> = self.beams().collect();
        match count {
            _ if beams.len() <= count => beams,
            0 => Vec::new(),
            1 => vec![beams[beams.len() / 2]],
            _ => {
                let (gaps, last) = (count - 1, beams.len() - 1);
                (0..count).map(|k| beams[(k * last + gaps / 2) / gaps]).collect()
            }
        }
    }

    /// Where the valid beams ended, in a frame in which the scanner sits at `mounting`
    /// (`base_from_laser`; [`Pose2::IDENTITY`] for the scanner's own frame) \[m\].
    pub fn points(&self, mounting: Pose2) -> impl Iterator<Item = Point2<f64>> + '_ {
        self.beams().map(move |beam| {
            let (sin, cos) = (mounting.theta + beam.angle).sin_cos();
            Point2::new(mounting.x + beam.range * cos, mounting.y + beam.range * sin)
        })
    }

    /// Where the valid beams ended, in the robot's frame at the time of beam 0 \[m\], of a robot
    /// that moved with constant velocity during the sweep. The scanner sits at `mounting`
    /// (`base_from_laser`).
    ///
    /// At 1 m/s and 40 Hz the last beam is measured 2 cm from the place of the first one; in a
    /// quick turn the far end of a corridor moves by decimetres.
    pub fn points_of_moving(
        &self,
        mounting: Pose2,
        twist: Twist2,
    ) -> impl Iterator<Item = Point2<f64>> + '_ {
        self.beams().map(move |beam| {
            let time = beam.index as f64 * self.time_increment;
            let laser = Pose2::exp(&(twist.to_vector() * time)) * mounting;
            laser.transform(&beam.point())
        })
    }
}
