//! Colours from unlikely to likely.

use super::png;
use super::svg::ColorBar;

/// Red, green, blue.
pub(crate) type Rgb = [u8; 3];

/// The map inferno (Smith and van der Walt 2015) upside down and without its black, which is kept
/// for walls.
const RAMP: [Rgb; 6] =
    [[252, 252, 230], [249, 211, 110], [245, 139, 42], [207, 68, 70], [132, 32, 107], [58, 9, 99]];
/// Walls under such colours.
pub(crate) const WALL: Rgb = [40, 44, 50];
/// Unknown space beside them.
pub(crate) const UNKNOWN: Rgb = [205, 205, 205];

/// The colour at a share of the ramp.
pub(crate) fn color(share: f64) -> Rgb {
    along(&RAMP, share)
}

/// The colour at a share of the way through colours that are evenly spaced.
pub(crate) fn along<const N: usize>(colors: &[Rgb; N], share: f64) -> Rgb {
    let place = share.clamp(0.0, 1.0) * (N - 1) as f64;
    let index = (place as usize).min(N - 2);
    let (from, to) = (colors[index], colors[index + 1]);
    let rest = place - index as f64;
    std::array::from_fn(|k| {
        (f64::from(from[k]) + rest * (f64::from(to[k]) - f64::from(from[k]))).round() as u8
    })
}

/// What the colours of the whole ramp mean.
pub(crate) fn bar(low: f64, high: f64, name: impl Into<String>) -> ColorBar {
    let strip: Vec<Rgb> = (0..256).map(|k| color(f64::from(k) / 255.0)).collect();
    ColorBar { data_uri: png::rgb(&strip, 256), low, high, name: name.into() }
}
