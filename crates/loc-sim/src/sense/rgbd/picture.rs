//! Images of colours and depths.

use loc_plot::Picture;
use loc_plot::color::{self, DEPTH, Image};
use loc_sensors::rgbd::{ColorImage, DepthImage};
use loc_sensors::world::Rgb;

/// What has no depth.
const NOTHING: Rgb = [198, 200, 204];

/// An image on its way into a figure.
pub(super) struct Shown {
    caption: String,
    data_uri: String,
    aspect: f64,
}

impl Shown {
    /// With colours that stand for depths from near to far \[m\].
    pub(super) fn with_bar(self, low: f64, high: f64) -> Picture {
        let bar = color::bar(&DEPTH, low, high, "depth [m]");
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
    Shown { caption: caption.into(), data_uri: image.data_uri(), aspect }
}

/// Depths as colours from near to far \[m\].
pub(super) fn of_depths(depths: &DepthImage, (near, far): (f64, f64)) -> Image {
    let color = |depth: &f32| {
        let share = (f64::from(*depth) - near) / (far - near);
        if share.is_finite() { color::along(&DEPTH, share) } else { NOTHING }
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
    let numbers = depths.depths().iter().map(|depth| (1e3 * depth).round() as u16);
    color::grey16_png(&numbers.collect::<Vec<_>>(), depths.width())
}
