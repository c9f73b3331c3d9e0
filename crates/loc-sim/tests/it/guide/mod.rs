//! The guide and the READMEs: what they link to, include, show and tell people to type is there.

mod commands;
mod pages;

use loc_sim::localizer::Method;
use loc_sim::scenario::builtin;
use pages::{Page, between, guide, pages, pages_and_readmes, root};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
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
    let reported = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{reported}");
    assert!(!reported.contains("WARN") && !reported.contains("ERROR"), "{reported}");
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

/// All figures together stay smaller than this \[bytes\].
const MAX: u64 = 3_000_000;

fn shown() -> BTreeSet<String> {
    let mut shown = BTreeSet::new();
    for page in pages() {
        for image in page.text.split("![").skip(1) {
            let (caption, rest) = image.split_once("](").unwrap();
            let (target, _) = rest.split_once(')').unwrap();
            assert!(caption.len() > 10, "{}: {target} has no caption", page.name());
            shown.insert(target.to_owned());
        }
    }
    shown
}

#[test]
fn every_figure_is_there_and_its_scenario_too() {
    let mut bytes = 0;
    for figure in shown() {
        let file = guide().join(&figure);
        let text = fs::read_to_string(&file).unwrap_or_else(|_| panic!("no figure {figure}"));
        roxmltree::Document::parse(&text).unwrap_or_else(|error| panic!("{figure}: {error}"));
        bytes += text.len() as u64;
        let run = figure.split('/').nth(1).unwrap();
        if run == "study" {
            continue;
        }
        let mut words = run.split('_');
        let scenario = words.next().unwrap();
        assert!(builtin::text(scenario).is_ok(), "{figure}: no scenario {scenario}");
        for word in words.filter(|word| *word != "smooth") {
            assert!(word.parse::<Method>().is_ok(), "{figure}: no method {word}");
        }
    }
    assert!(bytes < MAX, "{bytes} bytes of figures");
}

#[test]
fn no_figure_is_left_over() {
    let shown = shown();
    assert!(shown.len() >= 30, "{} figures", shown.len());
    for run in fs::read_dir(guide().join("figures")).unwrap() {
        let run = run.unwrap();
        for file in fs::read_dir(run.path()).unwrap() {
            let name = format!(
                "figures/{}/{}",
                run.file_name().to_string_lossy(),
                file.unwrap().file_name().to_string_lossy()
            );
            assert!(shown.contains(&name), "{name}: no page shows it; docs/scripts/figures.sh");
        }
    }
}

/// The figures that the lectures draw are in the guide.
#[test]
fn the_figures_of_the_lectures_are_shown() {
    let shown = shown();
    for id in ["E8", "G4", "H2", "H4", "K2", "M2", "M3", "M10", "M12"] {
        let entry = builtin::IDS.iter().find(|shown| shown.id == id).unwrap();
        let figure = format!("figures/{}/{}", entry.scenario, entry.figure);
        assert!(shown.contains(&figure), "{id}: {figure}");
    }
}
