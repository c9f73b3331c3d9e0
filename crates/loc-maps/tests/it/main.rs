//! Tests of `loc-maps` through its public face, one module per topic.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

mod grid;
mod landmark;
mod line;
mod point;
mod topological;

/// A folder of `LOC_DATA_DIR`, where that is set; else a test says that it is skipped.
pub(crate) fn recordings(folder: &str) -> Option<std::path::PathBuf> {
    let set = std::env::var_os("LOC_DATA_DIR").map(|data| std::path::Path::new(&data).join(folder));
    if set.is_none() {
        println!("skipped: LOC_DATA_DIR is not set, and {folder} is read from there");
    }
    set
}
