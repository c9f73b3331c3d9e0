//! Small files of every format that is read, written here: what fuzzing starts from.
//!
//! `LOC_FUZZ_CORPUS=$PWD/crates/loc-ros/fuzz/corpus cargo test -p loc-sim --test it seeds` puts
//! them where `cargo fuzz` looks; without it they go into a folder that is deleted. Each is read
//! here by the parser it is for, so that none of them becomes stale.

mod bags;
mod messages;
mod texts;

use std::path::PathBuf;
use tempfile::TempDir;

/// Where the seeds of a target go.
struct Corpus {
    folder: PathBuf,
    _temporary: Option<TempDir>,
}

impl Corpus {
    fn of(target: &str) -> Self {
        let temporary =
            std::env::var_os("LOC_FUZZ_CORPUS").is_none().then(|| TempDir::new().unwrap());
        let root = match &temporary {
            Some(folder) => folder.path().to_owned(),
            None => PathBuf::from(std::env::var_os("LOC_FUZZ_CORPUS").unwrap()),
        };
        let folder = root.join(target);
        std::fs::create_dir_all(&folder).unwrap();
        Corpus { folder, _temporary: temporary }
    }

    /// Writes a seed; gives its path.
    fn put(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.folder.join(format!("seed-{name}"));
        std::fs::write(&path, bytes).unwrap();
        path
    }

    /// The same for several files in one input, zero bytes between them.
    fn put_files(&self, name: &str, kind: &[u8], files: &[&str]) {
        let joined = files.join("\0");
        assert_eq!(joined.matches('\0').count() + 1, files.len(), "{name}");
        self.put(name, &[kind, joined.as_bytes()].concat());
    }
}
