//! Writing a map: the image first, then the YAML file that names it.

use super::levels::grey_value;
use super::{MapDescription, Mode, pgm, picture, wrong};
use crate::Result;
use crate::grid::OccupancyGrid;
use loc_core::file::write_whole;
use std::path::Path;

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

/// Writes a map as a YAML file and, beside it, an image of the same name.
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
            return Ok(pgm::encode(width, height, &grey));
        }
        ImageFormat::Png => image::ImageFormat::Png,
        ImageFormat::Bmp => image::ImageFormat::Bmp,
    };
    let with_alpha = mode == Mode::Scale && format == image::ImageFormat::Png;
    let channels: Vec<u8> = if with_alpha {
        pixels.flat_map(|(grey, opaque)| [grey, if opaque { 255 } else { 0 }]).collect()
    } else {
        pixels.map(|(grey, _)| grey).collect()
    };
    picture::encode(file, (width, height), &channels, with_alpha, format)
}
