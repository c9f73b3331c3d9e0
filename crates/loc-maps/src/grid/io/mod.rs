//! Reading and writing maps: ROS's map_server, a YAML file beside an image, and the map of the
//! Wean Hall recordings (`wean.dat`), which is only read.
//!
//! The image is the floor plan, dark where obstacles are, its top row the farthest from the
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
mod image;
mod wean;

pub use description::{MapDescription, Mode};

use super::{GridFrame, OccupancyGrid};
use crate::{Error, Result};
use description::grey_value;
use image::{Raster, encode_pgm, encode_picture};
use loc_core::file::write_whole;
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
    OccupancyGrid::new(frame, description::occupancies(&raster, description))
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

/// The kind of image to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ImageFormat {
    /// The plain grey image, which every ROS tool reads.
    #[default]
    Pgm,
    /// Compressed, and the only one that keeps unknown cells in [`Mode::Scale`].
    Png,
    /// Windows bitmap.
    Bmp,
}

impl ImageFormat {
    /// The ending of the file's name.
    pub fn extension(self) -> &'static str {
        match self {
            ImageFormat::Pgm => "pgm",
            ImageFormat::Png => "png",
            ImageFormat::Bmp => "bmp",
        }
    }
}

/// Writes a map: first an image, then beside it the YAML file of the same name.
///
/// [`Mode::Trinary`] keeps only the class of each cell (254 free, 0 occupied, 205 unknown);
/// [`Mode::Scale`] and [`Mode::Raw`] keep every value. The thresholds are 0.65 and 0.196, in
/// [`Mode::Scale`] 1 and 0, without which values beyond the thresholds would be lost.
///
/// # Errors
/// [`loc_core::Error::Io`] where a file cannot be written, and [`crate::Error::MapFile`] for
/// unknown cells in [`Mode::Scale`], which needs PNG's transparency for them.
pub fn save(
    grid: &OccupancyGrid,
    yaml: impl AsRef<Path>,
    format: ImageFormat,
    mode: Mode,
) -> Result<()> {
    let yaml = yaml.as_ref();
    let image = yaml.with_extension(format.extension());
    write_whole(&image, encode(grid, &image, format, mode)?)?;
    let (occupied_thresh, free_thresh) = match mode {
        Mode::Scale => (1.0, 0.0),
        Mode::Trinary | Mode::Raw => (0.65, 0.196),
    };
    let description = MapDescription {
        image: image.file_name().unwrap_or_default().into(),
        resolution: grid.resolution(),
        origin: grid.origin(),
        occupied_thresh,
        free_thresh,
        negate: false,
        mode,
    };
    Ok(write_whole(yaml, description.to_yaml())?)
}

fn encode(grid: &OccupancyGrid, file: &Path, format: ImageFormat, mode: Mode) -> Result<Vec<u8>> {
    let (width, height) = (grid.width(), grid.height());
    let rows = grid.values().chunks_exact(width).rev();
    let pixels = rows.flatten().map(|&value| grey_value(value, mode));
    let format = match format {
        ImageFormat::Pgm | ImageFormat::Bmp if pixels.clone().any(|(_, opaque)| !opaque) => {
            let found = format!("a map with some, as {}", format.extension());
            return Err(wrong(file, "mode", "PNG, or no unknown cells, for mode scale", &found));
        }
        ImageFormat::Pgm => {
            let grey: Vec<u8> = pixels.map(|(grey, _)| grey).collect();
            return Ok(encode_pgm(width, height, &grey));
        }
        ImageFormat::Png => ::image::ImageFormat::Png,
        ImageFormat::Bmp => ::image::ImageFormat::Bmp,
    };
    let with_alpha = mode == Mode::Scale && format == ::image::ImageFormat::Png;
    let channels: Vec<u8> = if with_alpha {
        pixels.flat_map(|(grey, opaque)| [grey, if opaque { 255 } else { 0 }]).collect()
    } else {
        pixels.map(|(grey, _)| grey).collect()
    };
    encode_picture(file, (width, height), &channels, with_alpha, format)
}
