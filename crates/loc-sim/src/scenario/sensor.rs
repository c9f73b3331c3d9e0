//! A sensor that measures once, or along a drive.

use crate::Result;
use crate::output::Illustration;
use crate::output::figures::FigureFile;
use crate::sense::{Request, sense};
use serde::Deserialize;

/// A sensor in a world; see [`crate::sense`].
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SensorConfig {
    /// Its name, as `loc-sim sense --list` gives it.
    pub name: String,
    /// Its data sheet; the first one where left out.
    pub preset: Option<String>,
    /// The world that it stands in; the first one where left out.
    pub world: Option<String>,
}

impl SensorConfig {
    /// Checks the names.
    ///
    /// # Errors
    /// [`crate::Error::UnknownName`].
    pub(super) fn check(&self) -> Result<()> {
        self.request(1).check()
    }

    fn request(&self, seed: u64) -> Request {
        Request {
            sensor: self.name.clone(),
            preset: self.preset.clone(),
            world: self.world.clone(),
            seed,
            ..Request::default()
        }
    }

    /// What it reads, with its figures and tables.
    pub(super) fn illustrate(&self, seed: u64) -> Result<Illustration> {
        let reading = sense(&self.request(seed))?;
        let svg = |name: &&str| name.ends_with(".svg");
        let figures = reading.folder.names().filter(svg).map(|name| FigureFile {
            file: name.to_owned().into(),
            caption: reading.title.clone().into(),
            svg: reading.folder.text(name).unwrap_or_default().to_owned(),
        });
        let figures = figures.collect();
        let lines = reading.lines();
        Ok(Illustration { lines, summary: reading.summary, figures, data: reading.folder })
    }
}
