//! The book is made, where mdbook is installed.

use super::pages::{pages, root};
use std::process::Command;

#[test]
fn mdbook_makes_the_book() {
    if Command::new("mdbook").arg("--version").output().is_err() {
        println!("skipped: mdbook is not installed");
        return;
    }
    let folder = tempfile::TempDir::new().unwrap();
    let output = Command::new("mdbook")
        .args(["build", "--dest-dir"])
        .arg(folder.path())
        .arg(root().join("docs"))
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{told}");
    assert!(!told.contains("WARN") && !told.contains("ERROR"), "{told}");
    for page in pages() {
        let name = page.path.file_stem().unwrap().to_string_lossy().into_owned();
        if name == "SUMMARY" {
            continue;
        }
        let html = std::fs::read_to_string(folder.path().join(format!("{name}.html"))).unwrap();
        assert!(!html.contains("{{#include"), "{name}: an include is left");
        // The page that explains anchors names them.
        let is_left = html.contains("ANCHOR") && name != "adding";
        assert!(!is_left, "{name}: an anchor is left");
    }
}
