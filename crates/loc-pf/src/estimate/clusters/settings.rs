//! How clusters are told apart.

use crate::Result;
use loc_core::error::{in_range, positive, probability};
use std::f64::consts::TAU;

/// Settings of a [`Clusterer`](super::Clusterer).
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct ClusterSettings {
    /// Side of a cell over x and y \[m\]: modes less than two cells apart are one.
    pub cell: f64,
    /// Width of a cell over the heading \[rad\], from a 64th of a turn to a third; rounded so that
    /// a whole number of cells fills a turn.
    pub heading_cell: f64,
    /// Two peaks stay apart where the highest way between them falls to this share of the lower
    /// one, in \[0, 1\]. With 0, only gaps part clusters.
    pub valley: f64,
    /// What the reported pose is taken from.
    pub pose: PoseSource,
}

/// What a robot takes as its pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
pub enum PoseSource {
    /// Mean and covariance of the heaviest cluster, as in amcl: a place where the robot may be.
    #[default]
    HeaviestCluster,
    /// Mean and covariance of all particles: least squared error, but between two rooms it lies in
    /// the wall.
    WholeCloud,
}

impl Default for ClusterSettings {
    fn default() -> Self {
        ClusterSettings {
            cell: 0.5,
            heading_cell: TAU / 24.0,
            valley: 0.25,
            pose: PoseSource::default(),
        }
    }
}

impl ClusterSettings {
    /// Checks every number.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] naming the first that is not allowed.
    pub fn validate(&self) -> Result<()> {
        positive("cell of clusters [m]", self.cell)?;
        let allowed = |width: f64| (TAU / 64.5..=TAU / 2.5).contains(&width);
        let what = "heading_cell of clusters [rad]";
        in_range(what, "from 1/64 to 1/3 of a turn", self.heading_cell, allowed)?;
        probability("valley of clusters", self.valley)?;
        Ok(())
    }
}
