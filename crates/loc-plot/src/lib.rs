#![doc = include_str!("../README.md")]

mod axis;
mod chart;
pub mod color;
mod figure;
mod frames;
mod header;
mod labels;
mod marks;
mod perspective;
mod pictures;
mod scene;
mod style;
mod text;
mod view;
mod writer;

pub use axis::{Tick, linear_ticks, log_ticks};
pub use chart::Chart;
pub use figure::Figure;
pub use frames::Frames;
pub use marks::{simplify, thin_columns};
pub use perspective::Perspective;
pub use pictures::{ColorBar, HeatMap, HeatMaps, Picture, Pictures};
pub use scene::{Backdrop, Scene};
pub use style::{Role, Style};

/// Width of every figure in its own pixels; the height follows from the content.
const WIDTH: f64 = 640.0;

/// Whether a number can be drawn: finite, and small enough that spans and squares stay finite.
fn drawable(value: f64) -> bool {
    value.abs() <= 1e100
}
