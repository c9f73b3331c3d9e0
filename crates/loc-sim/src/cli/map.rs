//! `loc-sim map` shows maps, converts, builds and generates them.

use super::{Global, print};
use crate::source::carmen::{CarmenLaser, CarmenLog};
use crate::source::laser_log::Scans;
use anyhow::bail;
use loc_core::Pose2;
use loc_maps::convert::Surface;
use loc_maps::grid::io::{ImageFormat, Mode};
use loc_maps::grid::{Cell, Occupancy, io};
use loc_maps::mapping::{GridMapper, InverseSensorModel};
use loc_maps::worlds::WorldSettings;
use loc_maps::{Bounds, LineMap, MapPicture, OccupancyGrid, PointMap, TopologicalMap, worlds};
use loc_sensors::laser::LaserScan;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Show a map, convert it, build one from a log, or generate a world.
#[derive(Debug, Clone, clap::Args)]
pub struct MapArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Clone, clap::Subcommand)]
enum Command {
    Info(InfoArgs),
    Convert(ConvertArgs),
    Build(BuildArgs),
    Make(MakeArgs),
}

/// Does what the command line says.
///
/// # Errors
/// What is wrong with the map or the log.
pub fn map(args: &MapArgs, global: &Global) -> anyhow::Result<()> {
    match &args.command {
        Command::Info(args) => info(args, global),
        Command::Convert(args) => convert(args, global),
        Command::Build(args) => build(args, global),
        Command::Make(args) => make(args, global),
    }
}

/// A map of any kind that the command reads.
enum AnyMap {
    Grid(OccupancyGrid),
    Lines(LineMap),
    Points(PointMap),
}

/// Reads a map: a YAML file with its image, the map file of Wean Hall, or columns of lines
/// (x1 y1 x2 y2) or points (x y).
fn read(file: &Path) -> anyhow::Result<AnyMap> {
    // `wean.dat.gz` is named by what stands before its last ending.
    let stem = file.file_stem().map(Path::new).filter(|_| has_extension(file, &["gz"]));
    if has_extension(stem.unwrap_or(file), &["yaml", "yml", "dat"]) {
        return Ok(AnyMap::Grid(io::load(file)?));
    }
    let text = std::fs::read_to_string(file).map_err(loc_core::Error::io(file))?;
    let is_data = |line: &&str| !line.is_empty() && !line.starts_with(['#', 'x']);
    let columns = text
        .lines()
        .map(str::trim)
        .find(is_data)
        .map_or(0, |line| line.split([',', ' ', '\t']).filter(|word| !word.is_empty()).count());
    let points = columns == 2;
    Ok(if points {
        AnyMap::Points(PointMap::parse_csv(file, &text)?)
    } else {
        AnyMap::Lines(LineMap::parse_csv(file, &text)?)
    })
}

fn has_extension(file: &Path, extensions: &[&str]) -> bool {
    let extension = file.extension().map(|extension| extension.to_string_lossy().to_lowercase());
    extension.is_some_and(|extension| extensions.contains(&extension.as_str()))
}

/// Print size, resolution, origin and counts of a map, and a thumbnail.
#[derive(Debug, Clone, clap::Args)]
struct InfoArgs {
    /// A map_server YAML file, a map file of Wean Hall (.dat), or a CSV file of lines (x1,y1,x2,y2) or points (x,y).
    #[arg(value_name = "MAP")]
    pub map: PathBuf,
    /// Width of the thumbnail in characters; 0 for none.
    #[arg(long, default_value_t = 60)]
    pub width: usize,
}

fn info(args: &InfoArgs, global: &Global) -> anyhow::Result<()> {
    let map = read(&args.map)?;
    if global.quiet {
        return Ok(());
    }
    if global.json {
        return print(&serde_json::to_string_pretty(&figures(&map))?);
    }
    match &map {
        AnyMap::Grid(grid) => print_grid(grid, args.width),
        AnyMap::Lines(lines) => print(&format!("{} lines{}", lines.len(), box_of(lines.bounds()))),
        AnyMap::Points(points) => {
            print(&format!("{} points{}", points.len(), box_of(points.bounds())))
        }
    }
}

fn print_grid(grid: &OccupancyGrid, width: usize) -> anyhow::Result<()> {
    let resolution = grid.resolution();
    let size = |cells: usize| cells as f64 * resolution;
    let (w, h) = (grid.width(), grid.height());
    print(&format!("size        {w} x {h} cells, {:.2} m x {:.2} m", size(w), size(h)))?;
    print(&format!("resolution  {resolution} m"))?;
    let origin = grid.origin();
    let yaw = origin.theta.to_degrees();
    print(&format!("origin      ({:.3} m, {:.3} m), turned {yaw:.2} deg", origin.x, origin.y))?;
    let counts = grid.counts();
    let share = |count: usize| 100.0 * count as f64 / (w * h) as f64;
    for (name, count) in
        [("free", counts.free), ("occupied", counts.occupied), ("unknown", counts.unknown)]
    {
        print(&format!("{name:<11} {count} cells, {:.1} %", share(count)))?;
    }
    if width > 0 {
        print(&thumbnail(grid, width).join("\n"))?;
    }
    Ok(())
}

fn box_of(bounds: Option<Bounds>) -> String {
    bounds.map_or(String::new(), |b| {
        format!(", from ({:.2}, {:.2}) to ({:.2}, {:.2}) m", b.min.x, b.min.y, b.max.x, b.max.y)
    })
}

fn figures(map: &AnyMap) -> Value {
    let corners = |bounds: Option<Bounds>| {
        bounds.map(|b| json!({"min": [b.min.x, b.min.y], "max": [b.max.x, b.max.y]}))
    };
    match map {
        AnyMap::Grid(grid) => {
            let (counts, origin) = (grid.counts(), grid.origin());
            json!({
                "kind": "grid",
                "width": grid.width(),
                "height": grid.height(),
                "resolution_m": grid.resolution(),
                "origin": [origin.x, origin.y, origin.theta],
                "free": counts.free,
                "occupied": counts.occupied,
                "unknown": counts.unknown,
            })
        }
        AnyMap::Lines(map) => {
            json!({"kind": "lines", "count": map.len(), "bounds": corners(map.bounds())})
        }
        AnyMap::Points(map) => {
            json!({"kind": "points", "count": map.len(), "bounds": corners(map.bounds())})
        }
    }
}

/// From free to all wall.
const SHADES: [char; 5] = [' ', '░', '▒', '▓', '█'];

/// The shares of free, occupied and unknown cells in a part of the map.
#[derive(Default)]
struct Part {
    free: usize,
    occupied: usize,
    unknown: usize,
}

impl Part {
    fn symbol(&self) -> char {
        let known = self.free + self.occupied;
        if known == 0 || self.occupied == 0 && self.unknown > self.free {
            return '·';
        }
        // Walls are thin: a wall across the part fills a tenth of it.
        let share = self.occupied as f64 / (known + self.unknown) as f64;
        match share {
            0.0 => SHADES[0],
            s if s < 0.06 => SHADES[1],
            s if s < 0.15 => SHADES[2],
            s if s < 0.4 => SHADES[3],
            _ => SHADES[4],
        }
    }
}

/// The known part of a grid in lines of at most `width` characters: the darker, the more wall;
/// dots are unknown.
fn thumbnail(grid: &OccupancyGrid, width: usize) -> Vec<String> {
    let Some((columns, rows)) = known(grid) else {
        return vec!["nothing known".into()];
    };
    let (w, h) = (columns.1 - columns.0, rows.1 - rows.0);
    let across = width.min(w).max(1);
    // A character is about twice as high as it is wide.
    let down = (h * across).div_ceil(2 * w).max(1);
    let slice = |k: usize, of: usize, (start, end): (usize, usize)| {
        let from = start + k * (end - start) / of;
        (from, (start + (k + 1) * (end - start) / of).clamp(from + 1, end.max(from + 1)))
    };
    let line = |row: usize| -> String {
        let rows = slice(row, down, rows);
        (0..across).map(|k| part(grid, slice(k, across, columns), rows).symbol()).collect()
    };
    (0..down).rev().map(line).collect()
}

fn part(grid: &OccupancyGrid, columns: (usize, usize), rows: (usize, usize)) -> Part {
    let mut part = Part::default();
    for row in rows.0..rows.1 {
        for column in columns.0..columns.1 {
            match grid.occupancy(Cell::new(column, row)) {
                Occupancy::Occupied => part.occupied += 1,
                Occupancy::Free => part.free += 1,
                Occupancy::Unknown => part.unknown += 1,
            }
        }
    }
    part
}

/// The columns and rows, from and to, of the bounding box of the known cells.
fn known(grid: &OccupancyGrid) -> Option<((usize, usize), (usize, usize))> {
    let mut around: Option<((usize, usize), (usize, usize))> = None;
    for (cell, value) in grid.iter() {
        if Occupancy::of(value) == Occupancy::Unknown {
            continue;
        }
        let ((left, right), (bottom, top)) =
            around.unwrap_or(((cell.column, cell.column), (cell.row, cell.row)));
        around = Some((
            (left.min(cell.column), right.max(cell.column + 1)),
            (bottom.min(cell.row), top.max(cell.row + 1)),
        ));
    }
    around
}

/// Convert a map; the ending of OUT names the format.
#[derive(Debug, Clone, clap::Args)]
struct ConvertArgs {
    /// A map_server YAML file, a map file of Wean Hall (.dat), or a CSV file of lines or points.
    #[arg(value_name = "IN")]
    pub input: PathBuf,
    /// A .yaml file (grid, with its image), .csv (lines or points), .toml (places), or .svg.
    #[arg(value_name = "OUT")]
    pub output: PathBuf,
    /// Content of a .csv file.
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

/// The content of a CSV file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Kind {
    /// x1,y1,x2,y2
    Lines,
    /// x,y
    Points,
}

/// A kind of image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Image {
    /// Plain grey.
    Pgm,
    /// Compressed.
    Png,
    /// Windows bitmap.
    Bmp,
}

/// Free space around a grid made of lines or points \[m\].
const MARGIN: f64 = 0.5;

fn convert(args: &ConvertArgs, global: &Global) -> anyhow::Result<()> {
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

/// Build an occupancy grid and a scan map from a CARMEN log, at the laser poses that it holds.
#[derive(Debug, Clone, clap::Args)]
struct BuildArgs {
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
    /// A map whose frame the grid gets.
    #[arg(long, value_name = "MAP.yaml")]
    pub like: Option<PathBuf>,
    /// The scan map keeps one point in squares of this side.
    #[arg(long, value_name = "M", default_value_t = 0.05, allow_negative_numbers = true)]
    pub thin: f64,
    /// Longest range that is used.
    #[arg(long, value_name = "M", default_value_t = InverseSensorModel::default().max_range)]
    pub max_range: f64,
}

fn build(args: &BuildArgs, global: &Global) -> anyhow::Result<()> {
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

/// Generate a world.
#[derive(Debug, Clone, clap::Args)]
struct MakeArgs {
    /// The world: office, corridor, soccer-field or hall-of-mirrors.
    pub world: String,
    /// Number of columns and of rows; a size that suits the world where left out.
    #[arg(long, value_name = "CELLS")]
    pub size: Option<usize>,
    /// Side of a cell; one that suits the world where left out.
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub resolution: Option<f64>,
    /// Seed of the layout.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// The folder to write; out/WORLD where left out.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

fn make(args: &MakeArgs, global: &Global) -> anyhow::Result<()> {
    let suited = WorldSettings::suited_to(&args.world)?;
    let settings = WorldSettings {
        width: args.size.unwrap_or(suited.width),
        height: args.size.unwrap_or(suited.height),
        resolution: args.resolution.unwrap_or(suited.resolution),
        seed: args.seed,
    };
    let world = worlds::by_name(&args.world, &settings)?;
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(world.name));
    let yaml = folder.join(format!("{}.yaml", world.name));
    loc_core::file::in_folder(&folder, |folder| {
        io::save(&world.grid, &yaml, ImageFormat::Pgm, Mode::Trinary)?;
        if !world.landmarks.is_empty() {
            loc_core::file::write_whole(folder.join("landmarks.csv"), world.landmarks.to_csv())?;
        }
        Ok::<_, anyhow::Error>(())
    })?;
    if global.quiet { Ok(()) } else { print(&format!("written to {}", yaml.display())) }
}
