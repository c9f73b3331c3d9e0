//! The report of a filmed run: what the player is given is what the run has.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use loc_sim::metrics::{Alignment, Summary};
use loc_sim::output::{Made, Report};
use loc_sim::record::{PlaybackRecorder, Run};
use loc_sim::scenario::Scenario;
use serde_json::Value;
use std::io::Read;

fn filmed(name: &str, changes: &[&str]) -> Run {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    let scenario = Scenario::named(name, &changes).unwrap();
    let mut reported = |_share| {};
    let mut playback = PlaybackRecorder::new(&mut reported);
    let mut run = scenario.run_observed(None, None, &mut playback).unwrap();
    run.playback = Some(playback.playback);
    run
}

fn made() -> Made<'static> {
    Made { command: "loc-sim run \"x\"", scenario: Some("name = \"<x>\"\nseed = 1\n") }
}

fn page(run: &Run) -> String {
    let summary = Summary::of(run, Some(1), Alignment::None).unwrap();
    let report = Report { run, summary: &summary, title: "A <title>", made: made() };
    report.html(&[])
}

fn player(html: &str) -> Value {
    let start = html.find("id=\"run\">").unwrap() + 9;
    let end = start + html[start..].find("</script>").unwrap();
    serde_json::from_str(&html[start..end]).unwrap()
}

fn numbers<const N: usize, T>(blob: &Value, from: fn([u8; N]) -> T) -> Vec<T> {
    let packed = STANDARD.decode(blob["data"].as_str().unwrap()).unwrap();
    let mut bytes = Vec::new();
    flate2::read::ZlibDecoder::new(packed.as_slice()).read_to_end(&mut bytes).unwrap();
    bytes.chunks_exact(N).map(|chunk| from(chunk.try_into().unwrap())).collect()
}

#[test]
fn the_player_has_the_poses_and_the_particles_of_the_run() {
    let run = filmed("overview", &["tour.duration=6.0"]);
    let html = page(&run);
    assert!(
        html.contains("<h1>A &lt;title&gt;</h1>") && html.contains("run &quot;x&quot;   # seed 1")
    );
    assert!(
        html.contains("<pre>name = &quot;&lt;x&gt;&quot;\nseed = 1</pre>"),
        "the scenario is there"
    );
    assert!(
        !html.contains("http://")
            || html.matches("http").count() == html.matches("http://www.w3.org").count()
    );
    let player = player(&html);
    let stamps = numbers(&player["stamps"], f32::from_le_bytes);
    assert_eq!(stamps.len(), run.stamps.len());
    let k = run.methods.iter().position(|record| record.name() == "mcl").unwrap();
    let record = &run.methods[k];
    let method = &player["methods"][k];
    assert_eq!(method["name"], "mcl");
    let x = numbers(&method["track"]["x"], f32::from_le_bytes);
    for (x, estimate) in x.iter().zip(&record.estimates) {
        assert!((f64::from(*x) - estimate.pose.x).abs() < 1e-5);
    }
    // Particles lie where the film has them, to a step of the screen.
    let film = run.playback.as_ref().unwrap();
    let kept: Vec<[f32; 3]> =
        film.frames.iter().flat_map(|frame| frame.methods[k].particles.clone()).collect();
    let xy = numbers(&method["particles"]["xy"], u16::from_le_bytes);
    assert!(kept.len() > 1000);
    assert_eq!(xy.len(), 2 * kept.len());
    let bounds: Vec<f64> =
        player["bounds"].as_array().unwrap().iter().map(|b| b.as_f64().unwrap()).collect();
    for (pair, particle) in xy.chunks(2).zip(&kept) {
        let x = bounds[0] + f64::from(pair[0]) / 65535.0 * (bounds[2] - bounds[0]);
        assert!((x - f64::from(particle[0])).abs() < 1e-3, "{x} {particle:?}");
    }
    let counts = numbers(&player["scan"]["counts"], u16::from_le_bytes);
    assert!(counts.iter().filter(|count| **count > 30).count() > 20);
}

/// A recording without true poses shows no true path.
#[test]
fn without_truth_there_is_no_true_path() {
    let scenario = Scenario::named("landmark-drive", &[]).unwrap();
    let mut run = scenario.run(None, None, &mut |_| {}).unwrap();
    let map = |run: &Run| loc_sim::output::figures::all(run, "A title")[0].svg.clone();
    assert!(map(&run).contains("true path"));
    run.truth.clear();
    assert!(!map(&run).contains("true path") && map(&run).contains("landmark as measured"));
}

#[test]
fn a_vehicle_on_a_rail_has_figures_without_a_player() {
    let html = page(&filmed("accelerated-vehicle", &[]));
    assert!(!html.contains("id=\"run\"") && html.contains("<table>"));
}
