//! `loc-sim map make`: a generated world.

use crate::cli::{Global, print};
use loc_maps::grid::io::{self, ImageFormat, Mode};
use loc_maps::worlds::{self, WorldSize};
use loc_maps::{LandmarkMap, OccupancyGrid};
use std::path::{Path, PathBuf};

/// Make a world to try robots in.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct MakeArgs {
    /// The world.
    #[arg(value_enum)]
    pub world: World,
    /// Number of columns and rows; the soccer field has its own proportions.
    #[arg(long, value_name = "CELLS", default_value_t = 1000)]
    pub size: usize,
    /// Side of a cell.
    #[arg(long, value_name = "M", default_value_t = 0.05, allow_negative_numbers = true)]
    pub resolution: f64,
    /// Seed of what stands where.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// The folder to write; out/WORLD where left out.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// A kind of world.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(super) enum World {
    /// Rooms along corridors, with furniture.
    Office,
    /// A long corridor.
    Corridor,
    /// A soccer field with landmarks at its edge.
    SoccerField,
    /// A hall that looks the same from two sides.
    HallOfMirrors,
}

impl World {
    fn name(self) -> &'static str {
        match self {
            World::Office => "office",
            World::Corridor => "corridor",
            World::SoccerField => "soccer-field",
            World::HallOfMirrors => "hall-of-mirrors",
        }
    }

    fn make(self, size: WorldSize, seed: u64) -> loc_maps::Result<(OccupancyGrid, LandmarkMap)> {
        let none = LandmarkMap::default();
        Ok(match self {
            World::Office => (worlds::office(size, seed)?, none),
            World::Corridor => (worlds::corridor(size, seed)?, none),
            World::SoccerField => worlds::soccer_field(size.resolution)?,
            World::HallOfMirrors => (worlds::hall_of_mirrors(size, seed)?, none),
        })
    }
}

pub(super) fn make(args: &MakeArgs, global: &Global) -> anyhow::Result<()> {
    let size = WorldSize { columns: args.size, rows: args.size, resolution: args.resolution };
    let (grid, landmarks) = args.world.make(size, args.seed)?;
    let name = args.world.name();
    let folder = args.out.clone().unwrap_or_else(|| Path::new("out").join(name));
    std::fs::create_dir_all(&folder).map_err(loc_core::Error::io(&folder))?;
    if !landmarks.is_empty() {
        loc_core::file::write_whole(folder.join("landmarks.csv"), landmarks.to_csv())?;
    }
    let yaml = folder.join(format!("{name}.yaml"));
    io::save(&grid, &yaml, ImageFormat::Pgm, Mode::Trinary)?;
    if global.quiet { Ok(()) } else { print(&format!("written to {}", yaml.display())) }
}
