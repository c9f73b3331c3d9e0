//! Files that are whole or not there.

use loc_core::file::{write_beside, write_whole};
use std::fs;

#[test]
fn what_fails_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.txt");
    write_whole(&file, "first").unwrap();
    let failed: Result<(), loc_core::Error> = write_beside(&file, |part| {
        fs::write(part, "half").unwrap();
        Err(loc_core::Error::io(part)(std::io::Error::other("full")))
    });
    assert!(failed.is_err());
    assert_eq!(fs::read_to_string(&file).unwrap(), "first");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    let error = write_whole(folder.path(), "x").unwrap_err().to_string();
    assert!(error.starts_with(&folder.path().display().to_string()), "{error}");
}

/// A pipe stays one: its reader gets the bytes.
#[cfg(unix)]
#[test]
fn a_pipe_is_written_to_and_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let pipe = folder.path().join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    if !made.is_ok_and(|status| status.success()) {
        println!("skipped: no mkfifo");
        return;
    }
    let reader = std::thread::spawn({
        let pipe = pipe.clone();
        move || fs::read_to_string(pipe).unwrap()
    });
    write_whole(&pipe, "through").unwrap();
    assert_eq!(reader.join().unwrap(), "through");
    assert!(!fs::metadata(&pipe).unwrap().is_file());
}
