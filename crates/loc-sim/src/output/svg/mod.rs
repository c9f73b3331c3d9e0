//! Figures as SVG files: the map view [`Scene`] and the charts of a [`Figure`].
//!
//! A picture tells at a glance what a table of errors hides: where a robot was lost, whether an
//! estimate is as certain as it claims, which landmark misled it. A [`Scene`] looks at the plane
//! from above, in metres and with equal scales; a [`Figure`] stacks [`Chart`]s over one shared
//! axis, mostly time; [`Frames`] shows one place at several times, [`Pictures`] puts images side
//! by side, [`HeatMaps`] surfaces over the same axes. What a thing is decides how it looks:
//! everything drawn has a [`Role`], so that a method keeps its colour through all figures of a run.
//!
//! ```
//! use loc_sim::output::svg::{Chart, Figure, Role, Scene};
//! let truth = (0..100).map(|k| (f64::from(k) * 0.1, (f64::from(k) * 0.1).sin()));
//! let scene = Scene::new("A drive")
//!     .path(Role::Truth.dotted(), "true path", truth)
//!     .crosses(Role::Landmark, "landmarks", [((2.0, 1.5), "7"), ((6.0, -1.2), "8")])
//!     .render();
//! assert!(scene.starts_with("<svg") && scene.contains("true path"));
//!
//! let error = (0..100).map(|k| (f64::from(k) * 0.1, 0.02 * f64::from(k % 7)));
//! let chart = Chart::new("position error [m]")
//!     .line(Role::Method(0), "ekf", error)
//!     .reference(0.1, "goal");
//! let figure = Figure::new("Errors").x_label("time [s]").panel(chart).render();
//! assert!(figure.contains("position error [m]"));
//! ```
//!
//! The files stand alone: no scripts, no fonts, nothing from the network. Colours are the light
//! ones as plain attributes, which every renderer understands; a style sheet replaces them where
//! the viewer asks for dark (`prefers-color-scheme`). Equal input gives equal bytes.
//!
//! Both kinds share one small writer instead of a chart library: kuva 0.6 and plotters 0.3 write
//! fixed colours without classes, so that one file could not serve light and dark. Kuva also writes
//! every point of a long line, NaN included (1.9 MB for a sine of 100 000 points that thinning
//! writes in 9 kB), and plotters rounds all points to whole pixels.

mod axis;
mod chart;
mod frame;
mod header;
mod heat_maps;
mod marks;
mod pictures;
mod room;
mod scene;
mod style;
mod text;
mod thin;
mod ticks;
mod writer;

pub use chart::{Chart, Figure};
pub use heat_maps::{HeatMap, HeatMaps};
pub use pictures::{ColorBar, Picture, Pictures};
pub use scene::{Backdrop, Frames, Scene};
pub use style::{Role, Style};
pub use thin::{simplify, thin_columns};
pub use ticks::{Tick, linear_ticks, log_ticks};

/// Width of every figure in its own pixels; the height follows from the content.
const WIDTH: f64 = 640.0;

/// Whether a number can be drawn: finite, and small enough that spans and squares stay finite.
fn drawable(value: f64) -> bool {
    value.abs() <= 1e100
}
