//! `loc-sim map build`: maps from a log whose poses are known.

use crate::cli::{Global, print};
use crate::source::carmen::{CarmenLaser, CarmenLog};
use crate::source::laser_log::Scans;
use anyhow::bail;
use loc_core::Pose2;
use loc_maps::grid::io::{self, ImageFormat, Mode};
use loc_maps::mapping::{GridMapper, InverseSensorModel};
use loc_maps::{MapPicture, OccupancyGrid, PointMap};
use loc_sensors::laser::LaserScan;
use std::path::PathBuf;

/// Build an occupancy grid and a scan map from a CARMEN log, at the laser poses that it holds.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct BuildArgs {
    /// The log; it may be gzipped.
    #[arg(value_name = "LOG")]
    pub log: PathBuf,
    /// The folder to write.
    #[arg(long, value_name = "DIR")]
    pub out: PathBuf,
    /// Which scans to use, counted from 0.
    #[arg(long, value_enum, default_value_t = Scans::All)]
    pub scans: Scans,
    /// Side of a cell.
    #[arg(long, value_name = "M", default_value_t = 0.05, allow_negative_numbers = true)]
    pub resolution: f64,
    /// A map whose frame the grid is to have.
    #[arg(long, value_name = "MAP.yaml")]
    pub like: Option<PathBuf>,
    /// The scan map keeps one point in squares of this side.
    #[arg(long, value_name = "M", default_value_t = 0.05, allow_negative_numbers = true)]
    pub thin: f64,
    /// Beams are followed no farther than this.
    #[arg(long, value_name = "M", default_value_t = InverseSensorModel::default().max_range)]
    pub max_range: f64,
}

pub(super) fn build(args: &BuildArgs, global: &Global) -> anyhow::Result<()> {
    let lasers = CarmenLog::open(&args.log)?.lasers()?;
    let taken = lasers.into_iter().enumerate().filter(|(index, _)| args.scans.takes(*index));
    let scans: Vec<(Pose2, LaserScan)> =
        taken.map(|(_, CarmenLaser { laser, scan, .. })| (laser, scan)).collect();
    if scans.is_empty() {
        bail!("{}: expected laser scans, got none", args.log.display());
    }
    let grid = occupancy(args, &scans)?;
    let points = scan_map(args, &scans)?;

    let folder = &args.out;
    loc_core::file::in_folder(folder, |folder| {
        loc_core::file::write_whole(folder.join("scan_map.csv"), points.to_csv())?;
        let picture = MapPicture::new().grid(&grid).to_svg();
        loc_core::file::write_whole(folder.join("map.svg"), picture)?;
        io::save(&grid, folder.join("map.yaml"), ImageFormat::Pgm, Mode::Trinary)?;
        Ok::<_, anyhow::Error>(())
    })?;
    if global.quiet {
        return Ok(());
    }
    let (w, h) = (grid.width(), grid.height());
    print(&format!("{} scans, {w} x {h} cells, {} points", scans.len(), points.len()))?;
    print(&format!("written to {}", folder.display()))
}

fn occupancy(args: &BuildArgs, scans: &[(Pose2, LaserScan)]) -> anyhow::Result<OccupancyGrid> {
    let model = InverseSensorModel { max_range: args.max_range, ..InverseSensorModel::default() };
    let Some(like) = &args.like else {
        return Ok(GridMapper::map(scans, args.resolution, model)?);
    };
    let mut mapper = GridMapper::new(*io::load(like)?.frame(), model)?;
    for (pose, scan) in scans {
        mapper.add(*pose, scan)?;
    }
    Ok(mapper.grid())
}

fn scan_map(args: &BuildArgs, scans: &[(Pose2, LaserScan)]) -> anyhow::Result<PointMap> {
    let ends: Vec<(Pose2, Vec<_>)> = scans
        .iter()
        .map(|(pose, scan)| {
            let near = scan.beams().filter(|beam| beam.range <= args.max_range);
            (*pose, near.map(loc_sensors::laser::Beam::point).collect())
        })
        .collect();
    let slices = ends.iter().map(|(pose, points)| (*pose, points.as_slice()));
    Ok(PointMap::from_scans(slices, args.thin)?)
}
