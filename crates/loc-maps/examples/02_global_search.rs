//! Global search (A2): where in an office was this scan made?

use loc_core::{Pose2, random::stream};
use loc_maps::LikelihoodField;
use loc_maps::likelihood_field::{Endpoints, LikelihoodFieldSettings};
use loc_maps::search::{GlobalSearch, SearchSettings};
use loc_maps::worlds::{self, WorldSettings};
use loc_sensors::laser::{Beam, LaserScanner, LaserSpec};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let settings = WorldSettings { width: 200, height: 200, ..Default::default() };
    let map = worlds::office(&settings)?.grid;
    let field = LikelihoodField::new(&map, &LikelihoodFieldSettings::nav2())?;
    let search = GlobalSearch::new(&map, field, SearchSettings::default())?;

    let truth = Pose2::new(3.0, 2.5, 1.2);
    let scan =
        LaserScanner::new(LaserSpec::sick_lms100())?.scan(&map, truth, &mut stream(1, "laser"));
    let beams = scan.thinned(60).into_iter().map(Beam::point);
    let ends: Endpoints = beams.map(|end| [end.x, end.y]).collect();
    for candidate in search.search(&ends)?.iter().take(3) {
        let distance = candidate.pose.distance(truth);
        println!("{}: {distance:.2} m from the true pose", candidate.pose);
    }
    Ok(())
}
