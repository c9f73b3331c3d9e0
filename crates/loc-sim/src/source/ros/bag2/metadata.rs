//! `metadata.yaml`, and folders without it.

use crate::{Error, Result};
use serde::Deserialize;
use std::path::{Path, PathBuf};

/// What is read of `metadata.yaml`.
#[derive(Debug, Deserialize)]
struct File {
    rosbag2_bagfile_information: Information,
}

#[derive(Debug, Deserialize)]
struct Information {
    #[serde(default)]
    relative_file_paths: Vec<String>,
    #[serde(default)]
    compression_format: String,
    #[serde(default)]
    compression_mode: String,
}

/// The files of a bag.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Metadata {
    pub(super) files: Vec<PathBuf>,
    /// Whether every message is packed by zstd.
    pub(super) packed: bool,
    pub(super) notes: Vec<String>,
}

impl Metadata {
    pub(super) fn of(folder: &Path) -> Result<Self> {
        let file = folder.join("metadata.yaml");
        if !file.is_file() {
            let files = files_in(folder)?;
            if files.is_empty() {
                return Err(error(folder, "metadata.yaml, or files .db3 or .mcap", "neither"));
            }
            let notes = vec!["has no metadata.yaml: its files are taken in order of name".into()];
            return Ok(Metadata { files, packed: false, notes });
        }
        let text = std::fs::read_to_string(&file).map_err(loc_core::Error::io(&file))?;
        Metadata::parse(folder, &file, &text)
    }

    fn parse(folder: &Path, file: &Path, text: &str) -> Result<Self> {
        let parsed: File = serde_saphyr::from_str(text).map_err(|cause| {
            let cause = cause.to_string();
            let cause = cause.lines().next().unwrap_or_default();
            error(file, "rosbag2_bagfile_information with relative_file_paths", cause)
        })?;
        let information = parsed.rosbag2_bagfile_information;
        let mode = information.compression_mode.to_uppercase();
        let format = information.compression_format;
        let packed = match (mode.as_str(), format.as_str()) {
            ("" | "NONE", _) => false,
            ("MESSAGE", "zstd") => true,
            ("FILE", _) => {
                let expected = "files that are not packed as a whole (unpack them with `zstd -d` \
                                and take the ending off in metadata.yaml)";
                return Err(error(file, expected, format!("files packed by {format}")));
            }
            _ => {
                let found = format!("mode {mode}, format {format}");
                return Err(error(file, "messages packed by zstd", found));
            }
        };
        // Some recorders write the folder's name in front.
        let place = |name: &String| {
            let direct = folder.join(name);
            match direct.is_file() {
                true => direct,
                false => folder.join(Path::new(name).file_name().unwrap_or_default()),
            }
        };
        let files: Vec<PathBuf> = information.relative_file_paths.iter().map(place).collect();
        if files.is_empty() {
            return Err(error(file, "relative_file_paths with at least one file", "none"));
        }
        Ok(Metadata { files, packed, notes: Vec::new() })
    }
}

/// The files of a folder that can be part of a bag, `_2` before `_10`.
pub(super) fn files_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let io = || loc_core::Error::io(folder);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(io())? {
        let path = entry.map_err(io())?.path();
        if path.extension().is_some_and(|ending| ending == "db3" || ending == "mcap") {
            files.push(path);
        }
    }
    files.sort_by_key(|path| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let number = stem.rsplit('_').next().and_then(|digits| digits.parse::<u64>().ok());
        (number, stem)
    });
    Ok(files)
}

fn error(path: &Path, expected: &str, found: impl Into<String>) -> Error {
    Error::Recording { path: path.to_owned(), expected: expected.into(), found: found.into() }
}
