//! Images of colours and depths.

use crate::output::ramp;
use crate::output::svg::{ColorBar, Picture};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::{ExtendedColorType, ImageEncoder};
use loc_sensors::rgbd::{ColorImage, DepthImage};
use loc_sensors::world::Rgb;

/// What has no depth.
const NOTHING: Rgb = [198, 200, 204];

/// The ramp from near to far: the map turbo (Mikhailov 2019) at nine places.
const RAMP: [Rgb; 9] = [
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

/// Pixels, row by row from the upper left.
#[derive(Debug, Clone)]
pub(super) struct Image {
    pub(super) width: usize,
    pub(super) pixels: Vec<Rgb>,
}

/// An image on its way into a figure.
pub(super) struct Shown {
    caption: String,
    data_uri: String,
    aspect: f64,
}

impl Image {
    fn height(&self) -> usize {
        self.pixels.len() / self.width.max(1)
    }

    /// The image as a PNG file.
    pub(super) fn png(&self) -> Vec<u8> {
        png(self.pixels.as_flattened(), (self.width, self.height()), ExtendedColorType::Rgb8)
    }
}

impl Shown {
    /// With colours that stand for depths from near to far \[m\].
    pub(super) fn with_bar(self, low: f64, high: f64) -> Picture {
        let strip: Vec<Rgb> = (0..256).map(|k| ramp::along(&RAMP, f64::from(k) / 255.0)).collect();
        let data_uri = uri(&Image { width: strip.len(), pixels: strip }.png());
        let bar = ColorBar { data_uri, low, high, name: "depth [m]".into() };
        Picture { bar: Some(bar), ..self.plain() }
    }

    pub(super) fn plain(self) -> Picture {
        let Shown { caption, data_uri, aspect } = self;
        Picture { caption, data_uri, aspect, bar: None }
    }
}

/// An image for a figure.
pub(super) fn shown(caption: &str, image: &Image) -> Shown {
    let aspect = image.width as f64 / image.height().max(1) as f64;
    Shown { caption: caption.into(), data_uri: uri(&image.png()), aspect }
}

/// Depths as colours from near to far \[m\].
pub(super) fn of_depths(depths: &DepthImage, (near, far): (f64, f64)) -> Image {
    let color = |depth: &f32| {
        let share = (f64::from(*depth) - near) / (far - near);
        if share.is_finite() { ramp::along(&RAMP, share) } else { NOTHING }
    };
    Image { width: depths.width(), pixels: depths.depths().iter().map(color).collect() }
}

/// The colour image as it is.
pub(super) fn of_colors(colors: &ColorImage) -> Image {
    Image { width: colors.width(), pixels: colors.colors().to_vec() }
}

/// Depths in whole millimetres as a PNG of 16 bits, 0 for nothing: the form of REP-118.
pub(super) fn millimetres(depths: &DepthImage) -> Vec<u8> {
    // The cast saturates, and turns NaN into 0.
    let bytes = depths.depths().iter().map(|depth| (1e3 * depth).round() as u16);
    let bytes: Vec<u8> = bytes.flat_map(u16::to_ne_bytes).collect();
    png(&bytes, (depths.width(), depths.height()), ExtendedColorType::L16)
}

fn png(bytes: &[u8], (width, height): (usize, usize), color: ExtendedColorType) -> Vec<u8> {
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    // Writing to memory cannot fail, and the sizes agree.
    let _ = encoder.write_image(bytes, width as u32, height as u32, color);
    png
}

fn uri(png: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png))
}
