//! A study from code: one scenario under two settings and many seeds, with confidence intervals.
//!
//! `cargo run --release -p loc-sim --example 02_study`

use loc_sim::localizer::Method;
use loc_sim::study::{Study, StudyOptions, StudySource, table};
use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let source = StudySource::named("landmark-drive", &["camera.range_sigma=0.2".into()])?;
    let options = StudyOptions {
        runs: 40,
        // Each combination runs under the same seeds.
        vary: vec!["filter.robot.gate_probability=0.9,0.999".parse()?],
        methods: vec![Method::DeadReckoning, Method::Ekf, Method::Mcl],
        ..StudyOptions::default()
    };
    let study = Study::new(source, options)?;

    // Finished runs are kept in the folder: an interrupted study goes on where it was.
    let folder = std::env::temp_dir().join(format!("loc-sim-study-{}", std::process::id()));
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    study.run(&folder, threads, &mut |progress| {
        eprint!("\r{} of {} runs", progress.done, progress.total);
        true
    })?;
    eprintln!();
    let results = study.results(&folder)?;
    println!("{}", table(&results));
    for group in &results.groups {
        println!("{:?} {}: {} successes", group.settings, group.method, group.successes);
    }
    std::fs::remove_dir_all(&folder)?;
    Ok(())
}
