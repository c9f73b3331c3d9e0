use loc_core::Pose2;
use loc_maps::grid::{Cell, GridFrame};
use loc_maps::topological::{Edge, Place, PlaceKind};
use loc_maps::{
    Landmark, LandmarkMap, LineMap, MapPicture, OccupancyGrid, PointMap, TopologicalMap,
};

fn grid() -> OccupancyGrid {
    let frame = GridFrame::new(6, 4, 0.5, Pose2::new(1.0, 2.0, 0.5)).unwrap();
    let mut grid = OccupancyGrid::filled(frame, 0);
    for (column, row, value) in [(0, 0, 100), (1, 0, 100), (0, 1, 100), (1, 1, 100), (5, 3, -1)] {
        grid.set(Cell::new(column, row), value).unwrap();
    }
    grid
}

#[test]
fn equal_cells_are_drawn_as_few_rectangles() {
    let svg = grid().to_svg();
    assert!(svg.contains("fill=\"#000\" d=\"M0 0h2v2h-2z\""), "{svg}");
    assert!(svg.contains("fill=\"#fff\" d=\"M2 0h4v2h-4zM0 2h6v1h-6zM0 3h5v1h-5z\""), "{svg}");
    assert!(svg.contains("translate(1 -2) rotate(-28.6479) scale(0.5 -0.5)"), "{svg}");
}

#[test]
fn all_maps_are_drawn_one_over_the_other() {
    let lines = LineMap::parse_csv("a.csv", "0,0,4,0\n").unwrap();
    let points = PointMap::parse_csv("a.csv", "1,1\n2,1.5\n").unwrap();
    let landmarks = LandmarkMap::new([Landmark::planar(1, 3.0, 1.0)]).unwrap();
    let mut room = Place::new("R&D <1> \u{1}7\u{1}", PlaceKind::Room, 1.0, 1.0);
    room.outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0]].map(Into::into).into();
    let places = [room, Place::new("door", PlaceKind::Door, 2.0, 1.0)];
    let places = TopologicalMap::new(places, [Edge::new(0, 1, 1.0)]).unwrap();
    let picture = MapPicture::new().grid(&grid()).lines(&lines).points(&points);
    let svg = picture.landmarks(&landmarks).places(&places).to_svg();
    for part in [
        "M0 0L4 0",
        "M1 -1h0M2 -1.5h0",
        "M3 -1h0",
        "R&amp;D &lt;1&gt; 7</title>",
        "M0 0L2 0L2 -2z",
        "M1 -1L2 -1",
    ] {
        assert!(svg.contains(part), "{part} in {svg}");
    }
    assert!(!svg.contains('\u{1}') && !svg.contains("NaN"));
    assert_eq!(svg.matches("<g").count(), svg.matches("</g>").count());
    for alone in [lines.to_svg(), points.to_svg(), landmarks.to_svg(), places.to_svg()] {
        assert!(alone.starts_with("<svg") && alone.ends_with("</svg>\n"));
    }
    assert!(MapPicture::new().to_svg().contains("viewBox"));
}
