//! Images inside figures.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::{ExtendedColorType, ImageEncoder};

/// Colours (red, green, blue), row by row from the upper left, as the data URI of a PNG image.
pub(crate) fn rgb(pixels: &[[u8; 3]], width: usize) -> String {
    let height = pixels.len() / width.max(1);
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    let bytes = pixels.as_flattened();
    // Writing to memory cannot fail, and the sizes agree.
    let _ = encoder.write_image(bytes, width as u32, height as u32, ExtendedColorType::Rgb8);
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}
