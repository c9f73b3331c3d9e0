//! Figures of the guide: `figures/SCENARIO[_METHOD]../FILE.svg`, and `figures/study/`.

use super::pages::{guide, pages};
use loc_sim::localizer::Method;
use loc_sim::scenario::{builtin, ids};
use std::collections::BTreeSet;
use std::fs;

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
        let entry = ids::ALL.iter().find(|shown| shown.id == id).unwrap();
        let figure = format!("figures/{}/{}", entry.scenario, entry.figure);
        assert!(shown.contains(&figure), "{id}: {figure}");
    }
}
