use loc_maps::topological::{Edge, Place, PlaceKind};
use loc_maps::{Error, TopologicalMap};
use proptest::prelude::*;

const FLAT: &str = r#"# measured by hand
[[place]]
name = "kitchen"
kind = "room"
position = [1.0, 2.0]
outline = [[0.0, 0.0], [3.0, 0.0], [3.0, 4.0], [0, 4]]

[[place]]
name = "door \"A\""
kind = "door"
position = [3.0, 2.0]
width = 0.9

[[place]]
name = "hall"
kind = "corridor"
position = [4.0, 2]

[[edge]]
between = ["kitchen", "door \"A\""]

[[edge]]
between = ["door \"A\"", "hall"]
length = 3.5
"#;

#[test]
fn toml_is_read_and_written_to_the_bit() {
    let map = TopologicalMap::parse_toml("flat.toml", FLAT).unwrap();
    assert_eq!((map.places().len(), map.edges().len()), (3, 2));
    assert_eq!(map.places()[1].width, Some(0.9));
    assert_eq!(map.edges()[0], Edge::new(0, 1, 2.0));
    assert_eq!(map.neighbours(1), [(0, 2.0), (2, 3.5)]);
    assert!(map.neighbours(9).is_empty());
    assert_eq!(map.find("hall"), Some(2));
    let again = TopologicalMap::parse_toml("again.toml", &map.to_toml()).unwrap();
    assert_eq!(again, map);

    let route = map.shortest_path(0, 2).unwrap();
    assert_eq!((route.places, route.length), (vec![0, 1, 2], 5.5));
    assert_eq!(map.shortest_path(1, 1).unwrap().places, [1]);
    assert_eq!(map.shortest_path(0, 7), None);
    assert_eq!(map.places_at(&[2.9, 3.9].into()).collect::<Vec<_>>(), [0]);
    assert_eq!(map.places_at(&[3.1, 3.9].into()).count(), 0);
    assert_eq!(map.nearest(&[4.5, 2.0].into()), Some((2, 0.5)));
    assert_eq!(map.bounds().unwrap().width(), 4.0);
}

#[test]
fn bad_toml_says_where_and_why() {
    for (from, to, message) in [
        ("[1.0, 2.0]", "[1.0, nan]", "flat.toml:5: position [m]: expected a finite number"),
        ("[1.0, 2.0]", "[1.0]", "flat.toml:5: invalid length 1, expected an array of length 2"),
        ("[1.0, 2.0]", "\"here\"", "flat.toml:5: invalid type: string \"here\", expected"),
        (
            "kind = \"room\"",
            "kind = \"cave\"",
            "flat.toml:4: unknown variant `cave`, expected one of",
        ),
        ("position = [1.0, 2.0]\n", "", "flat.toml:2: missing field `position`"),
        ("width = 0.9", "wide = 0.9", "flat.toml:12: unknown field `wide`, expected one of"),
        ("width = 0.9", "width = -1", "flat.toml:12: width [m]: expected a finite number >= 0"),
        ("\"hall\"\n", "\"kitchen\"\n", "flat.toml:15: name: expected one place called `kitchen`"),
        (
            "\", \"hall\"]",
            "\", \"hell\"]",
            "flat.toml:23: between: expected the name of a place, got `hell`",
        ),
        (
            "\", \"hall\"]",
            "\", \"kitchen\"]",
            "flat.toml:23: between: expected two different places",
        ),
        ("[0, 4]]", "[0, 4e9]]", "flat.toml:6: outline [m]: expected"),
        ("3.5", "inf", "flat.toml:24: length [m]: expected a finite number >= 0, got inf"),
        ("[[edge]]", "[[edge", "flat.toml:19: "),
    ] {
        assert!(FLAT.contains(from), "{from}");
        let error = TopologicalMap::parse_toml("flat.toml", &FLAT.replace(from, to)).unwrap_err();
        assert!(error.to_string().starts_with(message), "{error}\nexpected {message}");
        assert!(!error.to_string().contains('\n'), "{error}");
    }
    let empty = TopologicalMap::parse_toml("flat.toml", "# nothing\n").unwrap_err();
    assert_eq!(empty.to_string(), "flat.toml: places: the file holds none");
    assert!(
        TopologicalMap::read_toml("nowhere.toml").unwrap_err().to_string().starts_with("nowhere")
    );
}

#[test]
fn graphs_that_cannot_be_are_refused() {
    let places = || ["a", "b"].map(|name| Place::new(name, PlaceKind::Room, 0.0, 0.0));
    let edge = Edge::new;
    let new = |edges: &[Edge]| TopologicalMap::new(places(), edges.iter().cloned());
    assert!(new(&[edge(0, 1, 1.0)]).is_ok());
    assert!(matches!(new(&[edge(0, 2, 1.0)]), Err(Error::UnknownPlace { found: 2, .. })));
    assert!(matches!(new(&[edge(1, 1, 1.0)]), Err(Error::UselessEdge { .. })));
    let twice = [edge(0, 1, 1.0), edge(1, 0, 2.0)];
    assert!(matches!(new(&twice), Err(Error::UselessEdge { edge: 1, .. })));
    for length in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(new(&[edge(0, 1, length)]).is_err());
    }
    let same = ["a", "a"].map(|name| Place::new(name, PlaceKind::Room, 0.0, 0.0));
    assert!(matches!(TopologicalMap::new(same, []), Err(Error::DuplicatePlace { .. })));
    let nowhere = Place::new("a", PlaceKind::Room, f64::NAN, 0.0);
    assert!(TopologicalMap::new([nowhere], []).is_err());
    let empty = TopologicalMap::default();
    assert!(empty.bounds().is_none() && empty.nearest(&[0.0, 0.0].into()).is_none());
}

proptest! {
    #[test]
    fn shortest_paths_agree_with_relaxing_all_edges(
        count in 1..15_usize,
        edges in prop::collection::vec((0..15_usize, 0..15_usize, 0.0..10.0), 0..40),
    ) {
        let places = (0..count).map(|k| Place::new(format!("p{k}"), PlaceKind::Room, 0.0, 0.0));
        let mut joined = std::collections::HashSet::new();
        let edges: Vec<Edge> = edges
            .into_iter()
            .filter(|(a, b, _)| a < b && *b < count && joined.insert((*a, *b)))
            .map(|(a, b, length)| Edge::new(a, b, length))
            .collect();
        let map = TopologicalMap::new(places, edges.iter().cloned()).unwrap();
        let mut expected = vec![f64::INFINITY; count];
        expected[0] = 0.0;
        for _ in 0..count {
            for Edge { between: [a, b], length, .. } in &edges {
                expected[*b] = expected[*b].min(expected[*a] + length);
                expected[*a] = expected[*a].min(expected[*b] + length);
            }
        }
        for (to, expected) in expected.iter().enumerate() {
            let route = map.shortest_path(0, to);
            prop_assert_eq!(route.is_some(), expected.is_finite());
            let Some(route) = route else { continue };
            prop_assert!((route.length - expected).abs() < 1e-9);
            let steps = route.places.windows(2).map(|step| {
                let mut ways = map.neighbours(step[0]).iter();
                ways.find(|(next, _)| *next == step[1]).unwrap().1
            });
            prop_assert!((steps.sum::<f64>() - expected).abs() < 1e-9);
            prop_assert_eq!((route.places[0], *route.places.last().unwrap()), (0, to));
        }
    }
}
