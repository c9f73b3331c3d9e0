//! The YAML file of a map: the position of the image, and the conversion between its grey values
//! and occupancies.
//!
//! ```
//! use loc_maps::grid::io::{MapDescription, Mode};
//! let text = "image: room.pgm\nresolution: 0.05\norigin: [-1.0, 2.0, 0.0]\n\
//!             occupied_thresh: 0.65\nfree_thresh: 0.196\nnegate: 0\n";
//! let description = MapDescription::parse("room.yaml", text)?;
//! assert_eq!(description.mode, Mode::Trinary);
//! # Ok::<(), loc_maps::Error>(())
//! ```

use super::image::{Raster, Samples};
use super::wrong;
use crate::grid::{Occupancy, UNKNOWN};
use crate::{Error, Result};
use loc_core::Pose2;
use std::fmt;
use std::path::{Path, PathBuf};

/// The content of the YAML file of a map.
#[derive(Debug, Clone, PartialEq)]
pub struct MapDescription {
    /// The image, relative to the folder of the YAML file.
    pub image: PathBuf,
    /// Side of a pixel \[m\].
    pub resolution: f64,
    /// Pose of the image's lower-left corner in the map.
    pub origin: Pose2,
    /// From this occupancy on a pixel is occupied (inclusive), 0 to 1.
    pub occupied_thresh: f64,
    /// Up to this occupancy a pixel is free (inclusive), 0 to 1.
    pub free_thresh: f64,
    /// Whether white is occupied and black free.
    pub negate: bool,
    /// How grey values become occupancies.
    pub mode: Mode,
}

/// How grey values become occupancies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Mode {
    /// Free, occupied, unknown, by the two thresholds.
    #[default]
    Trinary,
    /// Linear between the two thresholds.
    Scale,
    /// The grey value itself (255 less it when negated) is the occupancy in percent; above 100
    /// unknown.
    Raw,
}

/// The file as it stands, before it is checked.
#[derive(serde::Deserialize)]
struct Text {
    image: Option<String>,
    resolution: Option<f64>,
    origin: Option<Vec<f64>>,
    occupied_thresh: Option<f64>,
    free_thresh: Option<f64>,
    negate: Option<Flag>,
    mode: Option<String>,
}

/// Yes or no, written as a boolean or as a number.
#[derive(serde::Deserialize)]
#[serde(untagged, expecting = "expected a boolean or a whole number")]
enum Flag {
    Bool(bool),
    Number(i64),
}

impl MapDescription {
    /// Reads a YAML file.
    ///
    /// # Errors
    /// [`loc_core::Error::Io`] where it cannot be read, else as [`MapDescription::parse`].
    pub fn read(file: impl AsRef<Path>) -> Result<Self> {
        let file = file.as_ref();
        let text = std::fs::read_to_string(file).map_err(loc_core::Error::io(file))?;
        MapDescription::parse(file, &text)
    }

    /// The same from a text; `file` is only named in errors.
    ///
    /// # Errors
    /// [`Error::Yaml`] with the line for what is no YAML or has the wrong type, and
    /// [`Error::MapFile`] for fields that are missing or out of range.
    pub fn parse(file: impl AsRef<Path>, text: &str) -> Result<Self> {
        let file = file.as_ref();
        let parsed = serde_saphyr::from_str(text);
        let text: Text = parsed.map_err(|error| yaml_error(file, text, &error))?;
        let missing = |field| move || wrong(file, field, "a value", &"none");
        let fraction = |field: &'static str, value: Option<f64>| {
            let value = value.ok_or_else(missing(field))?;
            let allowed = (0.0..=1.0).contains(&value);
            allowed.then_some(value).ok_or_else(|| wrong(file, field, "0 to 1", &value))
        };
        let resolution = text.resolution.ok_or_else(missing("resolution"))?;
        if !(resolution.is_finite() && resolution > 0.0) {
            return Err(wrong(file, "resolution", "a finite number > 0", &resolution));
        }
        let occupied_thresh = fraction("occupied_thresh", text.occupied_thresh)?;
        let free_thresh = fraction("free_thresh", text.free_thresh)?;
        Ok(MapDescription {
            image: text.image.ok_or_else(missing("image"))?.into(),
            resolution,
            origin: origin(file, &text.origin.ok_or_else(missing("origin"))?)?,
            occupied_thresh,
            free_thresh,
            negate: match text.negate.ok_or_else(missing("negate"))? {
                Flag::Bool(flag) => flag,
                Flag::Number(number) => number != 0,
            },
            mode: text.mode.map_or(Ok(Mode::default()), |name| Mode::parse(file, &name))?,
        })
    }

    /// The text of the YAML file, every number to its last digit.
    pub fn to_yaml(&self) -> String {
        let Pose2 { x, y, theta } = self.origin;
        format!(
            "image: {}\nmode: {}\nresolution: {:?}\norigin: [{x:?}, {y:?}, {theta:?}]\n\
             negate: {}\noccupied_thresh: {:?}\nfree_thresh: {:?}\n",
            quoted(&self.image.to_string_lossy()),
            self.mode,
            self.resolution,
            u8::from(self.negate),
            self.occupied_thresh,
            self.free_thresh,
        )
    }
}

impl Mode {
    fn parse(file: &Path, name: &str) -> Result<Self> {
        match name.to_ascii_lowercase().as_str() {
            "trinary" => Ok(Mode::Trinary),
            "scale" => Ok(Mode::Scale),
            "raw" => Ok(Mode::Raw),
            _ => Err(wrong(file, "mode", "trinary, scale or raw", &format!("`{name}`"))),
        }
    }
}

impl fmt::Display for Mode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Mode::Trinary => "trinary",
            Mode::Scale => "scale",
            Mode::Raw => "raw",
        })
    }
}

fn origin(file: &Path, values: &[f64]) -> Result<Pose2> {
    match *values {
        [x, y, yaw] if x.is_finite() && y.is_finite() && yaw.is_finite() => {
            Ok(Pose2::new(x, y, yaw))
        }
        _ => {
            Err(wrong(file, "origin", "[x, y, yaw], three finite numbers", &format!("{values:?}")))
        }
    }
}

fn yaml_error(file: &Path, text: &str, error: &serde_saphyr::Error) -> Error {
    let line = error.location().map_or(0, |location| location.line());
    let content = usize::try_from(line).ok().and_then(|line| text.lines().nth(line.max(1) - 1));
    let key = content.and_then(|content| content.split_once(':')).map(|(key, _)| key.trim());
    let said = error.without_snippet().to_string();
    let message = key.map_or(said.clone(), |key| format!("{key}: {said}"));
    Error::Yaml { file: file.to_owned(), line, message }
}

/// A text as YAML reads it back whatever it holds.
fn quoted(text: &str) -> String {
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// The occupancies of an image, bottom row first.
pub(super) fn occupancies(raster: &Raster, description: &MapDescription) -> Vec<i8> {
    // Every grey value is converted once; the pixels are looked up.
    let table: Vec<i8> =
        (0..=raster.white).map(|sample| occupancy(sample, raster.white, description)).collect();
    let look_up = |sample: usize| table.get(sample).copied().unwrap_or(UNKNOWN);
    let mut cells = Vec::with_capacity(raster.width * raster.height);
    match &raster.samples {
        Samples::Bytes(bytes) => {
            let whole: [i8; 256] = std::array::from_fn(look_up);
            for row in bytes.chunks_exact(raster.width).rev() {
                cells.extend(row.iter().map(|&sample| whole[usize::from(sample)]));
            }
        }
        Samples::Words(words) => {
            for row in words.chunks_exact(raster.width).rev() {
                cells.extend(row.iter().map(|&sample| look_up(usize::from(sample))));
            }
        }
    }
    if let (Some(opaque), Mode::Trinary | Mode::Scale) = (&raster.opaque, description.mode) {
        let opaque = opaque.chunks_exact(raster.width).rev().flatten();
        for (cell, _) in cells.iter_mut().zip(opaque).filter(|(_, opaque)| !**opaque) {
            *cell = UNKNOWN;
        }
    }
    cells
}

/// The occupancy of one grey value.
fn occupancy(sample: u16, white: u16, description: &MapDescription) -> i8 {
    let brightness = f64::from(sample) / f64::from(white);
    let darkness = f64::from(white - sample) / f64::from(white);
    let (free, occupied) = match description.negate {
        true => (darkness, brightness),
        false => (brightness, 1.0 - brightness),
    };
    let (from, to) = (description.free_thresh, description.occupied_thresh);
    match description.mode {
        Mode::Raw => match (255.0 * free).round() {
            percent if percent <= 100.0 => percent as i8,
            _ => UNKNOWN,
        },
        _ if occupied >= to => 100,
        _ if occupied <= from => 0,
        Mode::Trinary => UNKNOWN,
        Mode::Scale => (100.0 * (occupied - from) / (to - from)).round() as i8,
    }
}

/// The grey value that a cell is written as, and whether it is opaque.
pub(super) fn grey_value(value: i8, mode: Mode) -> (u8, bool) {
    match (mode, value) {
        (Mode::Trinary, _) => match Occupancy::of(value) {
            Occupancy::Free => (254, true),
            Occupancy::Occupied => (0, true),
            Occupancy::Unknown => (205, true),
        },
        (Mode::Scale, 0..=100) => ((2.55 * f64::from(100 - value)).round() as u8, true),
        (Mode::Scale, _) => (128, false),
        (Mode::Raw, 0..=100) => (value.unsigned_abs(), true),
        (Mode::Raw, _) => (255, true),
    }
}
