//! Images and what their colours mean: ramps from a low to a high value, and PNG data.
//!
//! ```
//! use loc_plot::color::{Image, LIKELIHOOD, along};
//! let pixels = (0..6).map(|k| along(&LIKELIHOOD, f64::from(k) / 5.0)).collect();
//! let image = Image { width: 3, pixels };
//! assert_eq!((image.height(), image.pixels[5]), (2, [58, 9, 99]));
//! assert!(image.data_uri().starts_with("data:image/png;base64,"));
//! ```

use crate::pictures::ColorBar;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::{ExtendedColorType, ImageEncoder};

/// Red, green, blue.
pub type Rgb = [u8; 3];

/// From unlikely to likely: the map inferno (Smith and van der Walt 2015) upside down and without
/// its black, which is kept for walls.
pub const LIKELIHOOD: [Rgb; 6] =
    [[252, 252, 230], [249, 211, 110], [245, 139, 42], [207, 68, 70], [132, 32, 107], [58, 9, 99]];

/// From near to far: the map turbo (Mikhailov 2019) at nine places, upside down.
pub const DEPTH: [Rgb; 9] = [
    [122, 4, 3],
    [203, 42, 4],
    [250, 126, 33],
    [226, 220, 56],
    [164, 252, 60],
    [50, 241, 152],
    [40, 188, 235],
    [70, 107, 227],
    [48, 18, 59],
];

/// From a low to a high density: the map viridis (van der Walt and Smith 2015) at seven places.
pub const DENSITY: [Rgb; 7] = [
    [68, 1, 84],
    [68, 57, 131],
    [49, 104, 142],
    [33, 145, 140],
    [53, 183, 121],
    [144, 215, 67],
    [253, 231, 37],
];

/// Walls beside colours of [`LIKELIHOOD`].
pub const WALL: Rgb = [40, 44, 50];

/// Unknown space beside them.
pub const UNKNOWN: Rgb = [205, 205, 205];

/// The colour at a share (0 to 1) of a ramp of evenly spaced colours, at least two.
pub fn along<const N: usize>(ramp: &[Rgb; N], share: f64) -> Rgb {
    const { assert!(N >= 2) };
    let place = share.clamp(0.0, 1.0) * (N - 1) as f64;
    let index = (place as usize).min(N - 2);
    let (from, to) = (ramp[index], ramp[index + 1]);
    let rest = place - index as f64;
    std::array::from_fn(|k| {
        (f64::from(from[k]) + rest * (f64::from(to[k]) - f64::from(from[k]))).round() as u8
    })
}

/// What the colours of a whole ramp mean: `low` at its left end, `high` at its right end.
pub fn bar<const N: usize>(
    ramp: &[Rgb; N],
    low: f64,
    high: f64,
    name: impl Into<String>,
) -> ColorBar {
    let pixels = (0..256).map(|k| along(ramp, f64::from(k) / 255.0)).collect();
    ColorBar { data_uri: Image { width: 256, pixels }.data_uri(), low, high, name: name.into() }
}

/// Pixels, row by row from the upper left.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Image {
    /// Number of pixels in a row.
    pub width: usize,
    /// The colours.
    pub pixels: Vec<Rgb>,
}

impl Image {
    /// Number of rows.
    pub fn height(&self) -> usize {
        self.pixels.len() / self.width.max(1)
    }

    /// The image as a PNG file. Empty where the number of pixels is no multiple of the width.
    pub fn png(&self) -> Vec<u8> {
        encode(self.pixels.as_flattened(), self.width, self.height(), ExtendedColorType::Rgb8)
    }

    /// The image as a data URI.
    pub fn data_uri(&self) -> String {
        data_uri(&self.png())
    }
}

/// Shades of grey, 0 black to 255 white, row by row from the upper left, as a PNG file.
pub fn grey_png(shades: &[u8], width: usize) -> Vec<u8> {
    encode(shades, width, shades.len() / width.max(1), ExtendedColorType::L8)
}

/// Numbers of 16 bits, row by row from the upper left, as a PNG file of grey.
pub fn grey16_png(numbers: &[u16], width: usize) -> Vec<u8> {
    let bytes: Vec<u8> = numbers.iter().copied().flat_map(u16::to_ne_bytes).collect();
    encode(&bytes, width, numbers.len() / width.max(1), ExtendedColorType::L16)
}

/// A PNG file as a data URI.
pub fn data_uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}

fn encode(bytes: &[u8], width: usize, height: usize, color: ExtendedColorType) -> Vec<u8> {
    let size = width * height * usize::from(color.bits_per_pixel() / 8);
    let mut png = Vec::new();
    // The encoder panics where the sizes disagree; writing to memory cannot fail.
    if bytes.len() == size {
        let encoder = image::codecs::png::PngEncoder::new(&mut png);
        let _ = encoder.write_image(bytes, width as u32, height as u32, color);
    }
    png
}
