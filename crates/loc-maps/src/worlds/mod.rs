//! Generated worlds to try robots in: an office, a corridor, a soccer field, a hall of mirrors.
//!
//! Each is hard in its own way. In the office many rooms look alike but none is like another; in
//! the corridor a robot hardly knows how far along it is; on the soccer field there are numbered
//! landmarks and no walls worth the name; in the hall of mirrors every place has a twin that no
//! laser can tell from it. The same seed gives the same world, everywhere.
//!
//! ```
//! use loc_maps::worlds::{self, WorldSize};
//! let size = WorldSize { columns: 600, rows: 400, resolution: 0.05 };
//! let office = worlds::office(size, 1)?;
//! assert_eq!(office.value_at(&[0.05, 0.05].into()), Some(100)); // the outer wall
//! assert_eq!(office, worlds::office(size, 1)?);
//! assert_ne!(office, worlds::office(size, 2)?);
//! # Ok::<(), loc_maps::Error>(())
//! ```

mod canvas;
mod corridor;
mod mirrors;
mod office;
mod soccer;

pub use corridor::corridor;
pub use mirrors::hall_of_mirrors;
pub use office::office;
pub use soccer::soccer_field;

/// How large a world is, and how finely it is drawn. Its lower-left corner is the map's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct WorldSize {
    /// Number of columns.
    pub columns: usize,
    /// Number of rows.
    pub rows: usize,
    /// Side of a cell \[m\].
    pub resolution: f64,
}
