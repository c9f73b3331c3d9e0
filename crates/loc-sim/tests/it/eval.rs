//! The command `loc-sim eval`.

use crate::evo;
use serde_json::Value;
use std::process::{Command, Output};
use tempfile::TempDir;

/// A folder with `estimate.tum`, `reference.tum` and `empty.tum`.
fn folder() -> TempDir {
    let folder = TempDir::new().unwrap();
    let recording = evo::planar();
    std::fs::write(folder.path().join("estimate.tum"), recording.estimate).unwrap();
    std::fs::write(folder.path().join("reference.tum"), recording.reference).unwrap();
    std::fs::write(folder.path().join("empty.tum"), "# nothing\n").unwrap();
    folder
}

fn eval(arguments: &[&str]) -> Output {
    let folder = folder();
    Command::new(env!("CARGO_BIN_EXE_loc-sim"))
        .current_dir(&folder)
        .arg("eval")
        .args(arguments)
        .output()
        .unwrap()
}

fn stdout(output: &Output) -> String {
    assert!(output.status.success(), "{output:?}");
    String::from_utf8(output.stdout.clone()).unwrap()
}

/// The one line that a failure leaves, with its exit code.
fn failure(output: &Output) -> (i32, String) {
    assert!(output.stdout.is_empty());
    let text = String::from_utf8(output.stderr.clone()).unwrap();
    (output.status.code().unwrap(), text)
}

#[test]
fn json_holds_every_figure_with_its_unit() {
    let output = eval(&["estimate.tum", "reference.tum", "--json", "--align", "se2"]);
    let json: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(json["pairs"], 16);
    assert_eq!(json["align"], "se2");
    assert_eq!(json["max_dt_s"], 0.01);
    for (block, unit) in [("ape", "m"), ("ape_rot", "deg"), ("rpe_trans", "m"), ("rpe_rot", "deg")]
    {
        for name in ["rmse", "mean", "median", "std", "min", "max"] {
            assert!(json[block][format!("{name}_{unit}")].is_f64(), "{block} {name}");
        }
        assert!(json[block][format!("sse_{unit}2")].is_f64());
    }
    let rmse = json["ape"]["rmse_m"].as_f64().unwrap();
    assert!((rmse - 0.0882307006964704).abs() < 1e-9);
}

#[test]
fn the_table_has_a_line_for_each_figure() {
    let text = stdout(&eval(&["estimate.tum", "reference.tum"]));
    assert!(text.starts_with("16 pairs within 0.01 s, alignment none\n"));
    for name in ["ape ", "ape_rot ", "rpe_trans ", "rpe_rot "] {
        assert_eq!(text.lines().filter(|line| line.starts_with(name)).count(), 1);
    }
    assert!(text.contains("1.300093"));
}

#[test]
fn the_largest_difference_in_time_is_a_choice() {
    let output = eval(&["estimate.tum", "reference.tum", "--json", "--max-dt", "0.1"]);
    let json: Value = serde_json::from_str(&stdout(&output)).unwrap();
    assert_eq!(json["pairs"], 56);
}

#[test]
fn failures_are_one_line_with_the_file_and_exit_code_1() {
    for (arguments, expected) in [
        (["estimate.tum", "missing.tum"], "error: missing.tum: No such file"),
        (["estimate.tum", "empty.tum"], "error: empty.tum: poses"),
    ] {
        let (code, text) = failure(&eval(&arguments));
        assert_eq!(code, 1);
        assert!(text.starts_with(expected), "{text}");
        assert_eq!(text.lines().count(), 1, "{text}");
        assert_eq!(text.matches("(os error 2)").count() + text.matches("holds none").count(), 1);
    }
}

#[test]
fn wrong_usage_has_exit_code_2() {
    for arguments in [
        &["estimate.tum"][..],
        &["estimate.tum", "reference.tum", "--align", "sim3"],
        &["estimate.tum", "reference.tum", "--max-dt", "-1"],
        &["estimate.tum", "reference.tum", "--max-dt", "nan"],
    ] {
        assert_eq!(failure(&eval(arguments)).0, 2, "{arguments:?}");
    }
}
