use loc_core::Pose2;
use loc_core::random::stream;
use loc_maps::grid::{Cell, GridFrame, Occupancy};
use loc_maps::mapping::{GridMapper, InverseSensorModel};
use loc_sensors::laser::{LaserScan, LaserScanner, LaserSpec};
use loc_sensors::world::Room;
use nalgebra::Point2;

/// A scan of single beams.
fn scan(angle_min: f64, angle_increment: f64, ranges: &[f64]) -> LaserScan {
    LaserScan {
        angle_min,
        angle_max: angle_min + angle_increment * (ranges.len() - 1) as f64,
        angle_increment,
        time_increment: 0.0,
        scan_time: 0.0,
        range_min: 0.1,
        range_max: 20.0,
        ranges: ranges.to_vec(),
        intensities: vec![],
    }
}

/// One beam along a row of cells of 1 m: what it passed is free, where it ended occupied, the
/// rest unknown.
#[test]
fn one_beam_by_hand() {
    let frame = GridFrame::new(6, 3, 1.0, Pose2::IDENTITY).unwrap();
    let model = InverseSensorModel { hit: 2.0, miss: 2.0, ..InverseSensorModel::default() };
    let mut mapper = GridMapper::new(frame, model).unwrap();
    mapper.add(Pose2::new(0.5, 1.5, 0.0), &scan(0.0, 0.1, &[3.2])).unwrap();
    let grid = mapper.grid();
    assert_eq!(grid.row(1), [0, 0, 0, 100, -1, -1]);
    assert!(grid.row(0).iter().chain(grid.row(2)).all(|&value| value == -1));
}

#[test]
fn evidence_adds_up_and_can_turn() {
    let frame = GridFrame::new(6, 1, 1.0, Pose2::IDENTITY).unwrap();
    let model = InverseSensorModel { limit: 2.0, ..InverseSensorModel::default() };
    let mut mapper = GridMapper::new(frame, model).unwrap();
    let mut cell = |range: f64, times: usize| {
        for _ in 0..times {
            mapper.add(Pose2::new(0.5, 0.5, 0.0), &scan(0.0, 0.1, &[range])).unwrap();
        }
        mapper.grid().occupancy(Cell::new(3, 0))
    };
    assert_eq!(cell(3.2, 1), Occupancy::Occupied);
    // 0.85 - 2 * 0.4 = 0.05: undecided; with four more it is free.
    assert_eq!(cell(5.2, 2), Occupancy::Unknown);
    assert_eq!(cell(5.2, 4), Occupancy::Free);
    // However often it was seen free, the limit lets it change its mind: -2 + 4 * 0.85 = 1.4.
    cell(5.2, 100);
    assert_eq!(cell(3.2, 4), Occupancy::Occupied);
}

#[test]
fn beams_without_return_clear_only_what_they_are_told_to() {
    let frame = GridFrame::new(6, 1, 1.0, Pose2::IDENTITY).unwrap();
    let pose = Pose2::new(0.5, 0.5, 0.0);
    for (clear_without_return, free) in [(0.0, 0), (3.0, 4)] {
        let model = InverseSensorModel { clear_without_return, miss: 2.0, ..Default::default() };
        let mut mapper = GridMapper::new(frame, model).unwrap();
        for useless in [f64::INFINITY, f64::NAN, f64::NEG_INFINITY, 0.05, 21.0] {
            // A second, valid beam leads straight up, out of the frame.
            mapper.add(pose, &scan(0.0, 1.5, &[useless, 5.0])).unwrap();
        }
        let counts = mapper.grid().counts();
        assert_eq!((counts.free.max(1), counts.occupied), (free.max(1), 0));
    }
}

/// A room mapped from several places, in a frame of its own: walls where they are, to a cell.
#[test]
fn a_room_is_mapped_where_it_is() {
    let room = Room::new([-2.0, -1.5], [2.0, 1.5]).unwrap();
    let scanner = LaserScanner::new(LaserSpec::hokuyo_ust_10lx()).unwrap();
    let mut rng = stream(2, "laser");
    let poses = [(-1.0, 0.5, 0.0), (0.5, -0.5, 2.0), (1.0, 0.9, -2.5), (0.0, 0.0, 4.0)];
    let scans: Vec<(Pose2, LaserScan)> = (0..12)
        .map(|k| {
            let (x, y, theta) = poses[k % 4];
            let pose = Pose2::new(x, y, theta);
            (pose, scanner.scan(&room, pose, &mut rng))
        })
        .collect();
    let grid = GridMapper::map(&scans, 0.05, InverseSensorModel::default()).unwrap();
    let mut wrong = 0;
    for (cell, _) in grid.iter() {
        let Point2 { coords } = grid.frame().center(cell);
        let inside = (2.0 - coords.x.abs()).min(1.5 - coords.y.abs());
        match grid.occupancy(cell) {
            Occupancy::Occupied => wrong += usize::from(inside.abs() > 0.15),
            Occupancy::Free => wrong += usize::from(inside < -0.1),
            Occupancy::Unknown => wrong += usize::from(inside > 0.15),
        }
    }
    assert_eq!(wrong, 0);
    assert!(grid.counts().occupied > 200);
}

#[test]
fn bad_input_is_refused_and_changes_nothing() {
    let frame = GridFrame::new(6, 1, 1.0, Pose2::IDENTITY).unwrap();
    let mut mapper = GridMapper::new(frame, InverseSensorModel::default()).unwrap();
    assert!(mapper.add(Pose2::IDENTITY, &scan(0.0, 0.0, &[1.0, 1.0])).is_err());
    assert!(mapper.add(Pose2::IDENTITY, &scan(0.0, 0.1, &[f64::NAN])).is_err());
    assert!(mapper.add(Pose2 { x: f64::NAN, ..Pose2::IDENTITY }, &scan(0.0, 0.1, &[1.0])).is_err());
    assert_eq!(mapper.grid().counts().unknown, 6);
    for model in [
        InverseSensorModel { hit: 0.0, ..Default::default() },
        InverseSensorModel { miss: f64::NAN, ..Default::default() },
        InverseSensorModel { occupied: 0.1, ..Default::default() },
    ] {
        assert!(GridMapper::new(frame, model).is_err(), "{model:?}");
    }
    assert!(GridMapper::map(&[], 0.05, InverseSensorModel::default()).is_err());
    let far = [
        (Pose2::new(1e9, 0.0, 0.0), scan(0.0, 0.1, &[1.0])),
        (Pose2::IDENTITY, scan(0.0, 0.1, &[1.0])),
    ];
    assert!(GridMapper::map(&far, 0.05, InverseSensorModel::default()).is_err());
}
