//! Code that the guide takes from the sources.

use super::pages::{between, pages, root};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The lines between two anchors.
fn section(file: &Path, anchor: &str) -> Option<String> {
    let text = fs::read_to_string(file).ok()?;
    let begin = format!("// ANCHOR: {anchor}");
    let end = format!("// ANCHOR_END: {anchor}");
    let lines = text.lines().skip_while(|line| line.trim() != begin).skip(1);
    let found: Vec<&str> = lines.take_while(|line| line.trim() != end).collect();
    let is_closed = text.lines().any(|line| line.trim() == end);
    (is_closed && !found.is_empty()).then(|| found.join("\n"))
}

#[test]
fn every_include_is_there_and_every_anchor_is_used() {
    let mut used = BTreeSet::new();
    for page in pages() {
        for include in between(&page.text, "{{#include ", "}}") {
            let Some((file, anchor)) = include.split_once(':') else {
                let file = page.path.parent().unwrap().join(include);
                assert!(file.is_file(), "{}: no file {include}", page.name());
                continue;
            };
            let file = page.path.parent().unwrap().join(file).canonicalize();
            let file = file.unwrap_or_else(|_| panic!("{}: no file {include}", page.name()));
            let code = section(&file, anchor);
            let code = code.unwrap_or_else(|| panic!("{}: no anchor {include}", page.name()));
            assert!(code.lines().count() >= 3, "{}: {include} is empty", page.name());
            // A whole item, not a part of one.
            assert_eq!(code.matches('{').count(), code.matches('}').count(), "{include}");
            used.insert((file, anchor.to_owned()));
        }
    }
    assert!(used.len() >= 30, "{} includes", used.len());
    let mut sources = Vec::new();
    collect(&root().join("crates"), &mut sources);
    for source in sources {
        let text = fs::read_to_string(&source).unwrap();
        for anchor in between(&text, "// ANCHOR: ", "\n") {
            let is_used = used.contains(&(source.clone(), anchor.to_owned()));
            assert!(is_used, "{}: no page includes {anchor}", source.display());
        }
    }
}

fn collect(folder: &Path, sources: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() && path.file_name().is_some_and(|name| name != "tests") {
            collect(&path, sources);
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            sources.push(path);
        }
    }
}
