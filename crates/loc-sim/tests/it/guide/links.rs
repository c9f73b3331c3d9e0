//! Links, to files and to headings.

use super::pages::{Page, between, guide, pages, pages_and_readmes};
use std::fs;

/// What a link of a page that leads somewhere in the repository has wrong.
fn wrong(page: &Page, target: &str, all: &[Page]) -> Option<String> {
    if target.starts_with("http://") || target.starts_with("https://") {
        return None;
    }
    let (file, heading) = target.split_once('#').map_or((target, None), |(f, h)| (f, Some(h)));
    let folder = page.path.parent().unwrap();
    let path = if file.is_empty() { page.path.clone() } else { folder.join(file) };
    let Ok(path) = path.canonicalize() else {
        return Some(format!("{}: no file {target}", page.name()));
    };
    let heading = heading?;
    let other = all.iter().find(|other| other.path.canonicalize().unwrap() == path);
    match other {
        Some(other) if other.headings().iter().any(|known| known == heading) => None,
        _ => Some(format!("{}: no heading {target}", page.name())),
    }
}

#[test]
fn every_link_leads_somewhere() {
    let all = pages_and_readmes();
    let mut count = 0;
    let mut mistakes = Vec::new();
    for page in &all {
        for target in between(&page.prose(), "](", ")") {
            count += 1;
            mistakes.extend(wrong(page, target, &all));
        }
    }
    assert!(mistakes.is_empty(), "{}", mistakes.join("\n"));
    assert!(count > 180, "{count} links are looked at");
}

#[test]
fn a_wrong_link_is_found() {
    let all = pages_and_readmes();
    let page = all.iter().find(|page| page.name() == "docs/src/comparison.md").unwrap();
    assert_eq!(wrong(page, "mcl.md#measured", &all), None);
    assert!(wrong(page, "mcl.md#guessed", &all).is_some());
    assert!(wrong(page, "nowhere.md", &all).is_some());
}

#[test]
fn the_summary_names_every_page_once() {
    let summary = fs::read_to_string(guide().join("SUMMARY.md")).unwrap();
    let mut named = between(&summary, "](", ")");
    named.sort_unstable();
    let names: Vec<String> = pages()
        .iter()
        .map(|page| page.path.file_name().unwrap().to_string_lossy().into_owned())
        .filter(|name| name != "SUMMARY.md")
        .collect();
    assert_eq!(named, names);
}
