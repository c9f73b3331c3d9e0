//! Every ID of the lectures has a scenario and a figure.

use loc_sim::output::figures::NAMES;
use loc_sim::scenario::{Scenario, builtin, ids};
use std::collections::BTreeSet;

/// Numbers of the last ID of each letter; L has none.
const LAST: [(char, usize); 11] = [
    ('A', 3),
    ('B', 11),
    ('C', 6),
    ('D', 4),
    ('E', 8),
    ('F', 5),
    ('G', 5),
    ('H', 4),
    ('I', 4),
    ('K', 3),
    ('M', 12),
];

#[test]
fn no_id_is_missing() {
    let mut expected: Vec<String> = LAST
        .iter()
        .flat_map(|(letter, last)| (1..=*last).map(move |k| format!("{letter}{k}")))
        .collect();
    expected.push("L".into());
    let expected: BTreeSet<String> = expected.into_iter().collect();
    let found: BTreeSet<String> = ids::ALL.iter().map(|shown| shown.id.to_owned()).collect();
    assert_eq!(found, expected);
    assert_eq!(ids::ALL.len(), expected.len());
}

/// The scenario says that it shows the ID, and makes the figure that is named.
#[test]
fn scenarios_show_what_is_said_of_them() {
    for shown in ids::ALL {
        let scenario = Scenario::named(shown.scenario, &[]).unwrap();
        assert!(scenario.ids.iter().any(|id| id == shown.id), "{shown:?}: {:?}", scenario.ids);
        match scenario.illustrate(scenario.seed).unwrap() {
            Some(illustration) => {
                let mut files = illustration.figures.iter().map(|figure| &figure.file);
                assert!(files.any(|file| file == shown.figure), "{shown:?}");
                assert!(!illustration.lines.is_empty(), "{shown:?}");
            }
            None => assert!(NAMES.contains(&shown.figure), "{shown:?}"),
        }
    }
}

/// Nothing that a scenario claims to show is unknown to the table.
#[test]
fn scenarios_claim_known_ids() {
    for (name, _) in builtin::ALL {
        for id in Scenario::named(name, &[]).unwrap().ids {
            assert!(ids::ALL.iter().any(|shown| shown.id == id), "{name}: {id}");
        }
    }
}

#[test]
fn the_table_of_the_guide_is_this_one() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/ids.md");
    let text = std::fs::read_to_string(file).unwrap();
    let rows: Vec<&str> = text.lines().filter(|line| line.starts_with("| ")).skip(1).collect();
    let expected = ids::ALL.map(|ids::Shown { id, what, scenario, figure }| {
        format!("| {id} | {what} | `{scenario}` | `{figure}` |")
    });
    assert_eq!(rows, expected);
}
