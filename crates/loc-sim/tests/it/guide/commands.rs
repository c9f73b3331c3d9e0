//! Commands that the guide and the READMEs tell people to type.

use super::pages::{Page, pages_and_readmes, root};
use clap::Parser;
use loc_sim::cli::Cli;
use loc_sim::scenario::Scenario;
use loc_sim::study::Axis;
use std::fs;
use std::path::Path;

const CARGO_RUN: &str = "cargo run --release -p loc-sim --";

/// The commands of a page: lines of code, and words in backquotes.
fn commands(page: &Page) -> Vec<String> {
    let prose = page.prose();
    // What stands between two quoted texts is not quoted.
    let quoted = prose.split('`').skip(1).step_by(2).map(|text| text.replace('\n', " "));
    page.code().into_iter().chain(quoted).collect()
}

/// The words of a command of `loc-sim`, without what the page says about it; `None` for another.
fn words(command: &str) -> Option<Vec<String>> {
    let command = command.trim().trim_start_matches("$ ");
    let command = command.strip_prefix(CARGO_RUN).unwrap_or(command).trim_start();
    let command = command.strip_prefix("loc-sim ").map_or_else(
        || {
            ["run ", "replay ", "study "]
                .iter()
                .any(|verb| command.starts_with(verb))
                .then_some(command)
        },
        Some,
    )?;
    let command = command.split(" > ").next()?.split("  #").next()?;
    let reported = command.match_indices("  ").find(|(at, _)| {
        let rest = command[*at..].trim_start();
        !rest.starts_with("--")
    });
    let command = reported.map_or(command, |(at, _)| &command[..at]);
    Some(shell_words(command))
}

/// Words as a shell takes them, quotes included; a single capital letter stands for a number.
fn shell_words(command: &str) -> Vec<String> {
    let (mut words, mut word, mut quote) = (Vec::new(), String::new(), None);
    for c in command.chars().chain([' ']) {
        match (c, quote) {
            (c, Some(q)) if c == q => quote = None,
            ('\'' | '"', None) => quote = Some(c),
            (' ', None) if word.is_empty() => {}
            (' ', None) => words.push(std::mem::take(&mut word)),
            _ => word.push(c),
        }
    }
    let is_letter = |word: &str| word.len() == 1 && word.chars().all(char::is_uppercase);
    words.into_iter().map(|word| if is_letter(&word) { "1".into() } else { word }).collect()
}

/// The error of a command of `loc-sim`.
fn wrong(words: &[String]) -> Option<String> {
    let arguments = std::iter::once("loc-sim").chain(words.iter().map(String::as_str));
    if let Err(error) = Cli::try_parse_from(arguments) {
        return error.use_stderr().then(|| error.to_string());
    }
    let values = |option: &str| -> Vec<String> {
        let pairs = words.windows(2).filter(|pair| pair[0] == option);
        pairs.map(|pair| pair[1].clone()).collect()
    };
    for axis in values("--vary") {
        if let Err(error) = axis.parse::<Axis>() {
            return Some(error.to_string());
        }
    }
    let (verb, scenario) = (words.first()?, words.get(1)?);
    let is_named =
        scenario.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-')
            && !scenario.starts_with('-');
    if (verb != "run" && verb != "study") || !is_named {
        return None;
    }
    Scenario::named(scenario, &values("--set")).err().map(|error| error.to_string())
}

#[test]
fn commands_of_loc_sim_are_understood() {
    let mut count = 0;
    let mut mistakes = Vec::new();
    for page in pages_and_readmes() {
        for command in commands(&page) {
            let Some(words) = words(&command) else { continue };
            // The name of a subcommand alone, or the form of one.
            if words.len() < 2 || words.iter().any(|word| word.contains("..") || word.contains('|'))
            {
                continue;
            }
            count += 1;
            let wrong = wrong(&words).map(|wrong| format!("{}: {command}: {wrong}", page.name()));
            mistakes.extend(wrong);
        }
    }
    assert!(mistakes.is_empty(), "{}", mistakes.join("\n"));
    assert!(count > 100, "{count} commands are looked at");
}

#[test]
fn a_wrong_command_is_found() {
    let check = |command: &str| wrong(&words(command).unwrap());
    assert_eq!(check("loc-sim run circle-drive --seed N   a circle"), None);
    assert!(check("loc-sim run triangle-drive").is_some());
    assert!(check("loc-sim run circle-drive --speed 3").is_some());
    assert!(check("loc-sim run circle-drive --set drive.wheels=3").is_some());
    assert!(check("loc-sim study landmark-drive --vary filter.particles").is_some());
    assert!(check("loc-sim run circle-drive --method psychic").is_some());
}

#[test]
fn benches_and_tests_that_are_named_exist() {
    let benches = fs::read_to_string(root().join("benches/Cargo.toml")).unwrap();
    for page in pages_and_readmes() {
        for command in commands(&page) {
            let words = shell_words(&command);
            let after = |option: &str| {
                let at = words.iter().position(|word| word == option)?;
                words.get(at + 1).cloned()
            };
            if words.first().is_none_or(|word| word != "cargo") {
                continue;
            }
            if let Some(bench) = after("--bench") {
                let line = format!("name = \"{bench}\"");
                assert!(benches.contains(&line), "{}: no bench {bench}", page.name());
            }
            let (Some(package), Some("test")) = (after("-p"), words.get(1).map(String::as_str))
            else {
                continue;
            };
            let at = words.iter().position(|word| word == "it");
            let names = words.iter().skip(at.map_or(words.len(), |at| at + 1));
            for name in names.filter(|name| !name.starts_with("--")) {
                let tests = root().join("crates").join(&package).join("tests/it");
                assert!(mentions(&tests, name), "{}: no test {name}", page.name());
            }
        }
    }
}

/// Whether a file of tests is named so, or has such a test.
fn mentions(folder: &Path, name: &str) -> bool {
    fs::read_dir(folder).unwrap().any(|entry| {
        let path = entry.unwrap().path();
        if path.file_stem().is_some_and(|stem| stem.to_string_lossy().contains(name)) {
            return true;
        }
        if path.is_dir() {
            return mentions(&path, name);
        }
        let text = fs::read_to_string(&path).unwrap();
        // Names are filters: a part of one is enough.
        text.lines().any(|line| line.trim_start().starts_with("fn ") && line.contains(name))
    })
}
