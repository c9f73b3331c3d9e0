//! `loc-sim map convert`: from one kind of map to another.

use super::{AnyMap, has_extension, read};
use crate::cli::{Global, print};
use anyhow::bail;
use loc_maps::convert::Surface;
use loc_maps::grid::io::{self, ImageFormat, Mode};
use loc_maps::{LineMap, MapPicture, OccupancyGrid, PointMap, TopologicalMap};
use std::path::PathBuf;

/// Convert a map; the ending of OUT says into what.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct ConvertArgs {
    /// A map_server YAML file, a map file of Wean Hall (.dat), or a CSV file of lines or points.
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// A .yaml file (grid, with its image), .csv (lines or points), .toml (places), or .svg.
    #[arg(value_name = "OUT")]
    pub output: PathBuf,
    /// What a .csv file is to hold.
    #[arg(long = "to", value_name = "KIND", value_enum, default_value_t = Kind::Lines)]
    pub kind: Kind,
    /// Image beside a .yaml file.
    #[arg(long, value_enum, default_value_t = Image::Pgm)]
    pub image: Image,
    /// Draw the rooms, corridors and doors of a grid over it, in an .svg file.
    #[arg(long)]
    pub places: bool,
    /// Cell size of a grid made of lines or points.
    #[arg(long, value_name = "M", default_value_t = 0.05, allow_negative_numbers = true)]
    pub resolution: f64,
}

/// What a CSV file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Kind {
    /// x1,y1,x2,y2
    Lines,
    /// x,y
    Points,
}

/// A kind of image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum Image {
    /// Plain grey.
    Pgm,
    /// Compressed.
    Png,
    /// Windows bitmap.
    Bmp,
}

/// Free space around a grid made of lines or points \[m\].
const MARGIN: f64 = 0.5;

pub(super) fn convert(args: &ConvertArgs, global: &Global) -> anyhow::Result<()> {
    let map = read(&args.input)?;
    let out = args.output.as_path();
    if has_extension(out, &["yaml", "yml"]) {
        let format = match args.image {
            Image::Pgm => ImageFormat::Pgm,
            Image::Png => ImageFormat::Png,
            Image::Bmp => ImageFormat::Bmp,
        };
        io::save(&as_grid(map, args.resolution)?, out, format, Mode::Trinary)?;
    } else if has_extension(out, &["csv"]) {
        let text = match args.kind {
            Kind::Lines => as_lines(map)?.to_csv(),
            Kind::Points => as_points(map, args.resolution)?.to_csv(),
        };
        loc_core::file::write_whole(out, text)?;
    } else if has_extension(out, &["toml"]) {
        let grid = as_grid(map, args.resolution)?;
        let places = TopologicalMap::from_grid(&grid, &Default::default())?;
        loc_core::file::write_whole(out, places.to_toml())?;
    } else if has_extension(out, &["svg"]) {
        loc_core::file::write_whole(out, picture(&map, args.places)?.to_svg())?;
    } else {
        bail!("{}: expected an ending .yaml, .csv, .toml or .svg, got another", out.display());
    }
    if global.quiet { Ok(()) } else { print(&format!("written to {}", out.display())) }
}

fn as_grid(map: AnyMap, resolution: f64) -> anyhow::Result<OccupancyGrid> {
    Ok(match map {
        AnyMap::Grid(grid) => grid,
        AnyMap::Lines(lines) => lines.to_grid(resolution, MARGIN)?,
        AnyMap::Points(points) => points.to_grid(resolution, MARGIN)?,
    })
}

fn as_lines(map: AnyMap) -> anyhow::Result<LineMap> {
    Ok(match map {
        AnyMap::Grid(grid) => LineMap::from_grid(&grid, &Default::default())?,
        AnyMap::Lines(lines) => lines,
        AnyMap::Points(_) => bail!("lines cannot be made of points: convert them to a grid first"),
    })
}

fn as_points(map: AnyMap, spacing: f64) -> anyhow::Result<PointMap> {
    Ok(match map {
        AnyMap::Grid(grid) => PointMap::from_grid(&grid, Surface::Boundary)?,
        AnyMap::Lines(lines) => PointMap::from_lines(&lines, spacing)?,
        AnyMap::Points(points) => points,
    })
}

fn picture(map: &AnyMap, places: bool) -> anyhow::Result<MapPicture> {
    Ok(match map {
        AnyMap::Grid(grid) if places => {
            let places = TopologicalMap::from_grid(grid, &Default::default())?;
            MapPicture::new().grid(grid).places(&places)
        }
        AnyMap::Grid(grid) => MapPicture::new().grid(grid),
        AnyMap::Lines(lines) => MapPicture::new().lines(lines),
        AnyMap::Points(points) => MapPicture::new().points(points),
    })
}
