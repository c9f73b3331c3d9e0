use loc_maps::{Error, Landmark, LandmarkMap};
use loc_sensors::world::LandmarkWorld;

#[test]
fn csv_round_trip_to_the_bit() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("map.csv");
    let mut high = Landmark::planar(3, 0.1 + 0.2, -1e-17);
    high.position.z = 2.5;
    let map = LandmarkMap::new([high, Landmark::planar(1, 1.0 / 3.0, 1e6)]).unwrap();
    loc_core::file::write_whole(&file, map.to_csv()).unwrap();
    assert_eq!(LandmarkMap::read_csv(&file).unwrap(), map);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no neighbour left behind");
}

#[test]
fn csv_may_be_untidy() {
    let text = "\u{feff}id,x,y\r\n# measured by hand\r\n\r\n7, 1.5 ,-2\r\n";
    let map = LandmarkMap::parse_csv("map.csv", text).unwrap();
    assert_eq!(map.iter().copied().collect::<Vec<_>>(), [Landmark::planar(7, 1.5, -2.0)]);
}

#[test]
fn bad_csv_says_where_and_why() {
    for (text, message) in [
        ("1,2,3\n2,a,3\n", "map.csv:2: x: expected a finite number, got `a`"),
        ("1,NaN,3\n", "map.csv:1: x: expected a finite number, got `NaN`"),
        ("1,2\n", "map.csv:1: y: expected a value, got the end of the line after 2 columns"),
        ("-1,2,3\n", "map.csv:1: id: expected a whole number >= 0, got `-1`"),
        ("4,2,3\n4,0,0\n", "map.csv:2: id: expected a number that no other landmark has, got `4`"),
        ("", "map.csv: landmarks: the file holds none"),
    ] {
        let error = LandmarkMap::parse_csv("map.csv", text).unwrap_err();
        assert_eq!(error.to_string(), message);
    }
    let missing = LandmarkMap::read_csv("nowhere.csv").unwrap_err().to_string();
    assert!(missing.starts_with("nowhere.csv: "), "{missing}");
}

#[test]
fn numbers_are_unique_and_positions_finite() {
    let twice = [Landmark::planar(2, 0.0, 0.0), Landmark::planar(2, 1.0, 0.0)];
    assert!(matches!(LandmarkMap::new(twice), Err(Error::DuplicateLandmark { id: 2 })));
    assert!(LandmarkMap::new([Landmark::planar(2, f64::NAN, 0.0)]).is_err());
}

#[test]
fn queries_agree_with_brute_force() {
    let places = (0..50).map(|k: u32| {
        let a = f64::from(k);
        Landmark::planar(100 - k, (a * 1.7).sin() * 5.0, (a * 2.3).cos() * 5.0)
    });
    let map = LandmarkMap::new(places).unwrap();
    let center = [0.5, -0.7].into();
    let distance = |l: &Landmark| (l.position.x - 0.5).hypot(l.position.y + 0.7);
    let (nearest, far) = map.nearest(&center).unwrap();
    assert!(map.iter().all(|l| distance(l) >= far) && distance(nearest) == far);
    let mut seen = Vec::new();
    map.visit_landmarks(&center, 3.0, &mut |id, _| seen.push(id));
    let expected: Vec<u32> = map.iter().filter(|l| distance(l) <= 3.0).map(|l| l.id).collect();
    assert!(!seen.is_empty() && seen == expected);
    assert_eq!(map.get(77).unwrap().id, 77);
    assert!(map.get(1000).is_none() && LandmarkMap::default().nearest(&center).is_none());
}
