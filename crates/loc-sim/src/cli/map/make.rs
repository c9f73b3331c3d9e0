//! `loc-sim map make`: a generated world.

use crate::cli::{Global, print};
use loc_maps::grid::io::{self, ImageFormat, Mode};
use loc_maps::worlds::{self, WorldSettings};
use std::path::{Path, PathBuf};

/// Make a world to try robots in.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct MakeArgs {
    /// The world: office, corridor, soccer-field or hall-of-mirrors.
    pub world: String,
    /// Number of columns and of rows; a size that suits the world where left out.
    #[arg(long, value_name = "CELLS")]
    pub size: Option<usize>,
    /// Side of a cell; one that suits the world where left out.
    #[arg(long, value_name = "M", allow_negative_numbers = true)]
    pub resolution: Option<f64>,
    /// Seed of what stands where.
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// The folder to write; out/WORLD where left out.
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

pub(super) fn make(args: &MakeArgs, global: &Global) -> anyhow::Result<()> {
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
