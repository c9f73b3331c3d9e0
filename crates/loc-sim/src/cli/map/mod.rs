//! `loc-sim map`: look at maps, convert, build and make them.

mod build;
mod convert;
mod info;
mod make;
mod thumbnail;

use super::Global;
use loc_maps::grid::io;
use loc_maps::{LineMap, OccupancyGrid, PointMap};
use std::path::Path;

/// Look at a map, convert it, build one from a log, or make a world.
#[derive(Debug, Clone, clap::Args)]
pub struct MapArgs {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Clone, clap::Subcommand)]
enum Command {
    Info(info::InfoArgs),
    Convert(convert::ConvertArgs),
    Build(build::BuildArgs),
    Make(make::MakeArgs),
}

/// Does what the command line says.
///
/// # Errors
/// What is wrong with the map or the log.
pub fn map(args: &MapArgs, global: &Global) -> anyhow::Result<()> {
    match &args.command {
        Command::Info(args) => info::info(args, global),
        Command::Convert(args) => convert::convert(args, global),
        Command::Build(args) => build::build(args, global),
        Command::Make(args) => make::make(args, global),
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
