//! PNG, BMP and the other netpbm images, by way of the crate `image`.

use super::raster::{Raster, Samples, check_size};
use super::wrong;
use crate::{Error, Result};
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};
use std::io::Cursor;
use std::path::Path;

/// Decodes a picture; colours become the mean of their three channels.
pub(super) fn decode(file: &Path, bytes: &[u8]) -> Result<Raster> {
    let broken = |error: ImageError| undecodable(file, &error);
    let format = image::guess_format(bytes).map_err(broken)?;
    let decoder = ImageReader::with_format(Cursor::new(bytes), format);
    let decoder = decoder.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    check_size(file, u64::from(width), u64::from(height), bytes.len())?;
    let picture = DynamicImage::from_decoder(decoder).map_err(broken)?;
    let (samples, white, opaque) = grey(picture);
    let (width, height) = (width as usize, height as usize);
    Ok(Raster { width, height, samples, white, opaque })
}

/// The bytes of a picture with one channel, or with a second one for opacity.
pub(super) fn encode(
    file: &Path,
    size: (usize, usize),
    channels: &[u8],
    with_alpha: bool,
    format: ImageFormat,
) -> Result<Vec<u8>> {
    let color = if with_alpha { image::ColorType::La8 } else { image::ColorType::L8 };
    let mut bytes = Cursor::new(Vec::new());
    let (width, height) = (size.0 as u32, size.1 as u32);
    image::write_buffer_with_format(&mut bytes, channels, width, height, color, format)
        .map_err(|error| undecodable(file, &error))?;
    Ok(bytes.into_inner())
}

type Grey = (Samples, u16, Option<Vec<bool>>);

fn grey(picture: DynamicImage) -> Grey {
    match picture {
        DynamicImage::ImageLuma8(image) => (Samples::Bytes(image.into_raw()), 255, None),
        DynamicImage::ImageLuma16(image) => (Samples::Words(image.into_raw()), u16::MAX, None),
        DynamicImage::ImageLumaA8(image) => {
            let luma = image.pixels().map(|pixel| pixel.0[0]).collect();
            let opaque = image.pixels().map(|pixel| pixel.0[1] == u8::MAX).collect();
            (Samples::Bytes(luma), 255, Some(opaque))
        }
        DynamicImage::ImageLumaA16(image) => {
            let luma = image.pixels().map(|pixel| pixel.0[0]).collect();
            let opaque = image.pixels().map(|pixel| pixel.0[1] == u16::MAX).collect();
            (Samples::Words(luma), u16::MAX, Some(opaque))
        }
        // Of colours the sum of the channels, so that their mean needs no rounding.
        DynamicImage::ImageRgb8(image) => {
            let sums = image.pixels().map(|pixel| sum(pixel.0)).collect();
            (Samples::Words(sums), 3 * 255, None)
        }
        colored => {
            let image = colored.into_rgba8();
            let of_colors = |[r, g, b, _]: [u8; 4]| sum([r, g, b]);
            let sums = image.pixels().map(|pixel| of_colors(pixel.0)).collect();
            let opaque = image.pixels().map(|pixel| pixel.0[3] == u8::MAX).collect();
            (Samples::Words(sums), 3 * 255, Some(opaque))
        }
    }
}

fn sum([red, green, blue]: [u8; 3]) -> u16 {
    u16::from(red) + u16::from(green) + u16::from(blue)
}

fn undecodable(file: &Path, error: &ImageError) -> Error {
    wrong(file, "image", "a PGM, PNG or BMP image", error)
}
