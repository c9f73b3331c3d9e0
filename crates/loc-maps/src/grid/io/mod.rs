//! Reading and writing maps: ROS's map_server, a YAML file beside an image, and the map of the
//! Wean Hall recordings (`wean.dat`), which is only read.
//!
//! The image is the floor plan, dark where something stands, its top row the farthest from the
//! origin; the YAML file says how large a pixel is, where the lower-left corner of the image lies
//! in the map, and how grey values become occupancies. PGM, PNG and BMP are read and written, and
//! any of them may be gzipped (`map.pgm.gz`, named with or without the `.gz` in the YAML file).
//!
//! ```
//! use loc_core::Pose2;
//! use loc_maps::grid::io::{self, ImageFormat, Mode};
//! use loc_maps::grid::{Cell, GridFrame, OccupancyGrid};
//! let folder = tempfile::tempdir()?;
//! let frame = GridFrame::new(8, 5, 0.05, Pose2::new(-1.0, 2.0, 0.3))?;
//! let mut grid = OccupancyGrid::filled(frame, 0);
//! grid.set(Cell::new(2, 4), 100)?;
//! io::save(&grid, folder.path().join("room.yaml"), ImageFormat::Pgm, Mode::Trinary)?;
//! assert_eq!(io::load(folder.path().join("room.yaml"))?, grid);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod description;
mod levels;
mod pgm;
mod picture;
mod raster;
mod save;
mod wean;

pub use description::{MapDescription, Mode};
pub use save::{ImageFormat, save};

use super::{GridFrame, OccupancyGrid};
use crate::{Error, Result};
use raster::Raster;
use std::fmt::Display;
use std::io::Read;
use std::path::{Path, PathBuf};

/// Reads a map from its YAML file and the image that it names, or from the map file of the Wean
/// Hall recordings, gzipped or not; which of the two it is, is read off its beginning.
///
/// # Errors
/// With file and field: [`loc_core::Error::Io`] for a file that cannot be read, [`Error::Yaml`]
/// and [`Error::MapFile`] for contents that are not those of a map.
pub fn load(yaml: impl AsRef<Path>) -> Result<OccupancyGrid> {
    let yaml = yaml.as_ref();
    let (file, bytes) = read_plain_or_gzipped(yaml)?;
    if bytes.starts_with(wean::BEGINNING) {
        return wean::parse(&file, &text(&file, bytes)?);
    }
    let description = MapDescription::parse(yaml, &text(&file, bytes)?)?;
    let folder = yaml.parent().unwrap_or(Path::new(""));
    load_image(folder.join(&description.image), &description)
}

/// Reads an image as a map, with a description from elsewhere; its own `image` is passed over.
///
/// # Errors
/// As [`load`].
pub fn load_image(image: impl AsRef<Path>, description: &MapDescription) -> Result<OccupancyGrid> {
    let (image, bytes) = read_plain_or_gzipped(image.as_ref())?;
    let raster = Raster::decode(&image, bytes)?;
    let (width, height) = (raster.width, raster.height);
    let frame = GridFrame::new(width, height, description.resolution, description.origin)?;
    OccupancyGrid::new(frame, levels::occupancies(&raster, description))
}

fn text(file: &Path, bytes: Vec<u8>) -> Result<String> {
    let error = |error| std::io::Error::new(std::io::ErrorKind::InvalidData, error);
    let text = String::from_utf8(bytes).map_err(error);
    Ok(text.map_err(loc_core::Error::io(file))?)
}

/// The bytes of a file, unpacked where it is gzipped, and the path they came from.
fn read_plain_or_gzipped(path: &Path) -> Result<(PathBuf, Vec<u8>)> {
    let mut path = path.to_owned();
    let mut bytes = std::fs::read(&path);
    if bytes.as_ref().is_err_and(|error| error.kind() == std::io::ErrorKind::NotFound) {
        let mut gzipped = path.clone().into_os_string();
        gzipped.push(".gz");
        if let Ok(found) = std::fs::read(&gzipped) {
            (path, bytes) = (PathBuf::from(gzipped), Ok(found));
        }
    }
    let bytes = bytes.map_err(loc_core::Error::io(&path))?;
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok((path, bytes));
    }
    // Two bytes a cell, and room for a header: nothing larger could be used anyway.
    let limit = 2 * super::MAX_CELLS as u64 + 4096;
    let mut unpacked = Vec::new();
    let unpacking = flate2::read::MultiGzDecoder::new(bytes.as_slice());
    let read = unpacking.take(limit).read_to_end(&mut unpacked);
    read.map_err(loc_core::Error::io(&path))?;
    Ok((path, unpacked))
}

/// An error at a field of a map's file.
fn wrong(file: &Path, field: &'static str, expected: &str, found: &dyn Display) -> Error {
    let (expected, found) = (expected.to_owned(), found.to_string());
    Error::MapFile { file: file.to_owned(), field, expected, found }
}
