//! Global search: what it refuses and what it does not find.

use loc_core::Pose2;
use loc_maps::OccupancyGrid;
use loc_maps::grid::GridFrame;
use loc_maps::likelihood_field::{Endpoints, LikelihoodField, LikelihoodFieldSettings};
use loc_maps::worlds::{self, WorldSettings};
use loc_maps::{Error, GlobalSearch, SearchSettings};

fn field(map: &OccupancyGrid) -> LikelihoodField {
    LikelihoodField::new(map, &LikelihoodFieldSettings::nav2()).unwrap()
}

fn search(map: &OccupancyGrid, settings: SearchSettings) -> GlobalSearch {
    GlobalSearch::new(map, field(map), settings).unwrap()
}

#[test]
fn bad_input_is_refused() {
    let size = WorldSettings { width: 60, height: 40, ..Default::default() };
    let map = worlds::office(&size).unwrap().grid;
    let settings = SearchSettings { angle_step: 0.2, ..Default::default() };
    let search = search(&map, settings.clone());
    assert!(matches!(search.search(&Endpoints::default()), Err(Error::Core(_))));
    assert!(matches!(search.search_many(&[]), Err(Error::Core(_))));
    let scan: Endpoints = [[1.0, 0.0], [0.0, 1e30], [-1e30, f64::MAX]].into_iter().collect();
    assert!(!search.search(&scan).unwrap().is_empty());
    let nowhere = Pose2 { x: f64::NAN, y: 0.0, theta: 0.0 };
    assert!(search.search_many(&[(nowhere, &scan)]).is_err());
    let far = Pose2::new(1e300, 0.0, 0.0);
    assert!(search.search_many(&[(far, &scan)]).is_err(), "no end is left");

    let solid = OccupancyGrid::filled(*map.frame(), 100);
    let refused = GlobalSearch::new(&solid, field(&solid), settings.clone());
    assert!(matches!(refused, Err(Error::NoFreeSpace { .. })));
    let other = GridFrame::new(60, 40, 0.1, Pose2::IDENTITY).unwrap();
    let other = field(&OccupancyGrid::filled(other, 0));
    assert!(matches!(GlobalSearch::new(&map, other, settings.clone()), Err(Error::OtherFrame)));
    for bad in [
        SearchSettings { angle_step: 0.0, ..settings.clone() },
        SearchSettings { angle_step: f64::NAN, ..settings.clone() },
        SearchSettings { candidates: 0, ..settings.clone() },
        SearchSettings { separation_distance: -1.0, ..settings.clone() },
        SearchSettings { separation_angle: f64::INFINITY, ..settings.clone() },
        SearchSettings { within: f64::NAN, ..settings.clone() },
        SearchSettings { least: Some(f64::INFINITY), ..settings.clone() },
    ] {
        assert!(GlobalSearch::new(&map, field(&map), bad).is_err());
    }
}

#[test]
fn where_nothing_is_good_enough_nothing_is_found() {
    let size = WorldSettings { width: 60, height: 40, ..Default::default() };
    let map = worlds::office(&size).unwrap().grid;
    let least = Some(0.03);
    let search = search(&map, SearchSettings { least, ..Default::default() });
    let scan: Endpoints = (0..20).map(|k| [f64::from(k) * 0.7, 0.1]).collect();
    assert_eq!(search.search(&scan).unwrap(), []);
}
