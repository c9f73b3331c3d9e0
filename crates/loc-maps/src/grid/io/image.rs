//! Image files of maps: PGM by code of this module, PNG, BMP and others by the crate `image`.
//!
//! Whatever the file, the result is one [`Raster`] of grey values.

use super::wrong;
use crate::grid::MAX_CELLS;
use crate::{Error, Result};
use image::{DynamicImage, ImageDecoder, ImageError, ImageFormat, ImageReader};
use std::io::Cursor;
use std::path::Path;

/// Largest ratio of an image to its file: deflate gives at most 1032 bytes for one.
const MAX_EXPANSION: usize = 1032;

/// Grey values, the top row first.
#[derive(Debug)]
pub(super) struct Raster {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) samples: Samples,
    /// The sample that means white.
    pub(super) white: u16,
    /// Whether each pixel is opaque; `None` where all are.
    pub(super) opaque: Option<Vec<bool>>,
}

/// The samples, in as few bytes as they need.
#[derive(Debug)]
pub(super) enum Samples {
    Bytes(Vec<u8>),
    Words(Vec<u16>),
}

impl Raster {
    /// Decodes the bytes of a file; what it is, is read off its beginning, not off its name.
    pub(super) fn decode(file: &Path, bytes: Vec<u8>) -> Result<Self> {
        match bytes.get(..2) {
            Some(b"P2" | b"P5") => decode_pgm(file, bytes),
            _ => decode_picture(file, &bytes),
        }
    }
}

/// Refuses sizes that cannot be a map or that `bytes` bytes of file cannot fill.
fn check_size(file: &Path, width: u64, height: u64, bytes: usize) -> Result<()> {
    let pixels = width.saturating_mul(height);
    let found = format!("{width} x {height}");
    if pixels == 0 || pixels > MAX_CELLS as u64 {
        return Err(wrong(file, "image size", "1 to 2^28 pixels", &found));
    }
    // A pixel takes at least one bit.
    if pixels / 8 > bytes.saturating_mul(MAX_EXPANSION) as u64 {
        return Err(too_short(file, &format!("the pixels of {found}"), bytes));
    }
    Ok(())
}

/// A file that ends before its pixels do.
fn too_short(file: &Path, expected: &str, bytes: usize) -> Error {
    wrong(file, "pixels", expected, &format!("a file of {bytes} bytes"))
}

/// The header of a PGM file: four words, then the pixels (netpbm's definition).
struct Header {
    binary: bool,
    width: u64,
    height: u64,
    white: u16,
    /// Where the pixels begin.
    length: usize,
}

/// Decodes a P2 (text) or P5 (binary) file with 8 or 16 bits a pixel.
fn decode_pgm(file: &Path, mut bytes: Vec<u8>) -> Result<Raster> {
    let header = header(file, &bytes)?;
    let (width, height) = (header.width, header.height);
    check_size(file, width, height, bytes.len())?;
    let pixels = (width * height) as usize;
    let expected = format!("{width} x {height} values of 0 to {}", header.white);
    let found = bytes.len();
    let samples = if header.binary {
        let bytes_each = if header.white > 255 { 2 } else { 1 };
        bytes.drain(..header.length.min(found));
        if bytes.len() < pixels * bytes_each {
            return Err(too_short(file, &expected, found));
        }
        bytes.truncate(pixels * bytes_each);
        binary(bytes, bytes_each)
    } else {
        let text = bytes.get(header.length..).unwrap_or_default();
        Samples::Words(text_samples(text, pixels).ok_or_else(|| too_short(file, &expected, found))?)
    };
    if brightest(&samples) > header.white {
        return Err(wrong(file, "pixels", &expected, &brightest(&samples)));
    }
    let (width, height) = (width as usize, height as usize);
    Ok(Raster { width, height, samples, white: header.white, opaque: None })
}

/// The bytes of a P5 file, from grey values with the top row first.
pub(super) fn encode_pgm(width: usize, height: usize, grey: &[u8]) -> Vec<u8> {
    let mut bytes = format!("P5\n{width} {height}\n255\n").into_bytes();
    bytes.extend_from_slice(grey);
    bytes
}

fn header(file: &Path, bytes: &[u8]) -> Result<Header> {
    let mut at = 2;
    let mut number = |field: &'static str| {
        let word = next_word(bytes, &mut at);
        let text = String::from_utf8_lossy(word.get(..word.len().min(20)).unwrap_or_default());
        text.parse::<u64>().map_err(|_| wrong(file, field, "a whole number", &format!("`{text}`")))
    };
    let (width, height, white) = (number("width")?, number("height")?, number("maxval")?);
    let white = u16::try_from(white).ok().filter(|&white| white > 0);
    let white = white.ok_or_else(|| {
        let mut at = 2;
        let words = [(); 3].map(|()| next_word(bytes, &mut at));
        let found = String::from_utf8_lossy(words[2]).into_owned();
        wrong(file, "maxval", "1 to 65535", &found)
    })?;
    // One white space ends the header; what follows are pixels, whatever they look like.
    Ok(Header { binary: bytes.get(1) == Some(&b'5'), width, height, white, length: at + 1 })
}

/// The next word after white space and comments, which run from `#` to the end of the line.
fn next_word<'a>(bytes: &'a [u8], at: &mut usize) -> &'a [u8] {
    let mut comment = false;
    while let Some(&byte) = bytes.get(*at) {
        comment = (comment && byte != b'\n') || byte == b'#';
        if !comment && !byte.is_ascii_whitespace() {
            break;
        }
        *at += 1;
    }
    let start = *at;
    while bytes.get(*at).is_some_and(|byte| !byte.is_ascii_whitespace() && *byte != b'#') {
        *at += 1;
    }
    bytes.get(start..*at).unwrap_or_default()
}

fn binary(bytes: Vec<u8>, bytes_each: usize) -> Samples {
    if bytes_each == 1 {
        return Samples::Bytes(bytes);
    }
    let words = bytes.as_chunks::<2>().0.iter();
    Samples::Words(words.map(|&pair| u16::from_be_bytes(pair)).collect())
}

fn text_samples(text: &[u8], pixels: usize) -> Option<Vec<u16>> {
    // A number and its separator take two bytes at least.
    if text.len() / 2 + 1 < pixels {
        return None;
    }
    let mut at = 0;
    let mut word = || std::str::from_utf8(next_word(text, &mut at)).ok()?.parse().ok();
    (0..pixels).map(|_| word()).collect()
}

fn brightest(samples: &Samples) -> u16 {
    match samples {
        Samples::Bytes(bytes) => bytes.iter().copied().max().map_or(0, u16::from),
        Samples::Words(words) => words.iter().copied().max().unwrap_or(0),
    }
}

/// Decodes PNG, BMP and the other netpbm images by the crate `image`; colours become the mean of
/// their three channels.
fn decode_picture(file: &Path, bytes: &[u8]) -> Result<Raster> {
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

/// The bytes of a PNG or BMP image with one channel, or with a second one for opacity.
pub(super) fn encode_picture(
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
