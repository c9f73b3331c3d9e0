//! The pages, and what stands in them.

use std::fs;
use std::path::{Path, PathBuf};

/// The root of the repository.
pub(super) fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// Where the pages of the guide are.
pub(super) fn guide() -> PathBuf {
    root().join("docs/src")
}

/// A page of the guide, or a README.
pub(super) struct Page {
    pub(super) path: PathBuf,
    pub(super) text: String,
}

impl Page {
    fn read(path: PathBuf) -> Self {
        let text = fs::read_to_string(&path).unwrap();
        Page { path, text }
    }

    /// The path from the root of the repository, for messages.
    pub(super) fn name(&self) -> String {
        self.path.strip_prefix(root()).unwrap_or(&self.path).display().to_string()
    }

    /// The text without fenced code.
    pub(super) fn prose(&self) -> String {
        let mut is_code = false;
        let lines = self.text.lines().filter(|line| {
            let is_fence = line.trim_start().starts_with("```");
            is_code ^= is_fence;
            !is_code && !is_fence
        });
        lines.collect::<Vec<_>>().join("\n")
    }

    /// The lines of fenced code, those that end in a backslash joined with the next.
    pub(super) fn code(&self) -> Vec<String> {
        let mut is_code = false;
        let lines = self.text.lines().filter(|line| {
            let is_fence = line.trim_start().starts_with("```");
            is_code ^= is_fence;
            is_code && !is_fence
        });
        let text = lines.collect::<Vec<_>>().join("\n").replace("\\\n", " ");
        text.lines().map(str::to_owned).collect()
    }

    /// The anchors of the headings, as mdBook makes them.
    pub(super) fn headings(&self) -> Vec<String> {
        let prose = self.prose();
        let titles =
            prose.lines().filter_map(|line| line.trim_start_matches('#').strip_prefix(' '));
        let heading = |title: &str| prose.contains(&format!("# {title}"));
        titles.filter(|title| heading(title)).map(slug).collect()
    }
}

fn slug(title: &str) -> String {
    let kept = title.trim().chars().filter_map(|c| match c {
        c if c.is_alphanumeric() || c == '_' || c == '-' => Some(c.to_ascii_lowercase()),
        c if c.is_whitespace() => Some('-'),
        _ => None,
    });
    kept.collect()
}

/// The pages of the guide, the list of them among them.
pub(super) fn pages() -> Vec<Page> {
    let mut paths: Vec<PathBuf> = fs::read_dir(guide())
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .collect();
    paths.sort();
    paths.into_iter().map(Page::read).collect()
}

/// The pages of the guide and the READMEs.
pub(super) fn pages_and_readmes() -> Vec<Page> {
    let mut pages = pages();
    pages.push(Page::read(root().join("README.md")));
    for entry in fs::read_dir(root().join("crates")).unwrap() {
        pages.push(Page::read(entry.unwrap().path().join("README.md")));
    }
    pages
}

/// What stands between `before` and `after`, again and again.
pub(super) fn between<'a>(text: &'a str, before: &str, after: &str) -> Vec<&'a str> {
    let parts = text.split(before).skip(1);
    parts.filter_map(|part| part.split_once(after).map(|(found, _)| found)).collect()
}
