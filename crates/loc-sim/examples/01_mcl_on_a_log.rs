//! Monte Carlo localization on a recording: events go into the filter one by one.
//!
//! `cargo run --release -p loc-sim --example 01_mcl_on_a_log -- intel.log intel.yaml` replays a CARMEN log
//! in a map of map_server; without arguments a simulated drive takes their place.

use loc_core::random::stream;
use loc_filters::Localizer;
use loc_maps::grid::io;
use loc_pf::{Mcl, MclSettings};
use loc_sensors::event::Payload;
use loc_sim::scenario::Scenario;
use loc_sim::source::carmen::CarmenLog;
use loc_sim::source::laser_log::ReplayOptions;
use loc_sim::source::{LaserRecording, Source};
use std::error::Error;
use std::path::Path;
use std::sync::Arc;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let mut source: Box<dyn Source> = match arguments.as_slice() {
        [log, map] => {
            let map = Some(Arc::new(io::load(map)?));
            let start_sigmas = [0.2, 0.2, 0.1];
            let options = ReplayOptions { map, start_sigmas, ..ReplayOptions::default() };
            let log = CarmenLog::open(Path::new(log))?.laser_log()?;
            Box::new(LaserRecording::new(log, &options)?)
        }
        _ => Scenario::named("position-tracking", &["tour.duration=20".into()])?.source(1)?,
    };

    let setup = source.setup().clone();
    let map = setup.map.ok_or("the recording has no map")?;
    let mut mcl = Mcl::new(&map, MclSettings::default().beams(90), stream(1, "mcl"))?;
    mcl.start_at(&setup.start_belief)?;

    let (mut errors, mut updates) = (Vec::new(), 0);
    while let Some(event) = source.next_event()? {
        match &event.payload {
            Payload::Control(control) => mcl.predict(event.stamp, control)?,
            // An outcome for each scan that was used; none where the robot has hardly moved.
            Payload::Measurement(scan) => updates += mcl.correct(event.stamp, scan)?.len(),
            // The truth of a simulation, the reference of a log.
            Payload::Truth(truth) => errors.push(mcl.pose().distance(truth.pose)),
        }
    }
    errors.sort_by(f64::total_cmp);
    println!("{updates} updates, probability of being lost {:.4}", mcl.lost());
    if let Some(median) = errors.get(errors.len() / 2) {
        println!("median error {median:.3} m over {} poses", errors.len());
    }
    let sigmas = mcl.belief().covariance.diagonal().map(f64::sqrt);
    println!("pose {} +- ({:.3} m, {:.3} m, {:.3} rad)", mcl.pose(), sigmas.x, sigmas.y, sigmas.z);
    Ok(())
}
