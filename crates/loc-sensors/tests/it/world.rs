use approx::assert_relative_eq;
use loc_sensors::world::{Glazed, Pane, RangeWorld, Room, Surface};
use nalgebra::{Point2, Vector2};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

fn room() -> Room {
    Room::new([0.0, 0.0], [4.0, 3.0]).unwrap()
}

#[test]
fn a_room_by_hand() {
    let here = Point2::new(1.0, 1.0);
    for (direction, range) in
        [(0.0, 3.0), (FRAC_PI_2, 2.0), (PI, 1.0), (-FRAC_PI_2, 1.0), (FRAC_PI_4, 8_f64.sqrt())]
    {
        assert_relative_eq!(room().cast(&here, direction, 9.0).unwrap(), range, epsilon = 1e-12);
    }
    assert_eq!(room().cast(&here, 0.0, 2.9), None);
    // From outside: onto the near wall, past the room, away from it.
    let outside = Point2::new(-2.0, 1.0);
    assert_relative_eq!(room().cast(&outside, 0.0, 9.0).unwrap(), 2.0);
    let slanting = room().cast(&outside, FRAC_PI_4, 9.0).unwrap();
    assert_relative_eq!(slanting, 8_f64.sqrt(), epsilon = 1e-12);
    assert_eq!(room().cast(&outside, 1.0, 99.0), None);
    assert_eq!(room().cast(&outside, PI, 99.0), None);
}

#[test]
fn a_pillar_by_hand() {
    let room = room().with_pillar([3.0, 1.0], 0.5).unwrap();
    let here = Point2::new(1.0, 1.0);
    assert_relative_eq!(room.cast(&here, 0.0, 9.0).unwrap(), 1.5, epsilon = 1e-12);
    assert_relative_eq!(room.cast(&here, 0.3, 9.0).unwrap(), 3.0 / 0.3_f64.cos(), epsilon = 1e-12);
    // From inside, and straight away from it.
    assert_relative_eq!(room.cast(&Point2::new(3.0, 1.0), 0.0, 9.0).unwrap(), 0.5);
    assert_relative_eq!(room.cast(&here, PI, 9.0).unwrap(), 1.0, epsilon = 1e-12);
}

#[test]
fn a_fan_is_its_rays() {
    let room = room().with_pillar([3.0, 1.0], 0.5).unwrap();
    let (here, mut fan) = (Point2::new(1.2, 0.7), vec![0.0; 50]);
    room.cast_fan(&here, -1.0, 0.1, 2.5, &mut fan);
    for (k, range) in fan.into_iter().enumerate() {
        let ray = room.cast(&here, -1.0 + 0.1 * k as f64, 2.5);
        assert_eq!(range, ray.unwrap_or(f64::INFINITY));
    }
}

#[test]
fn panes_by_hand() {
    let pane = Pane { from: [2.0, -1.0], to: [2.0, 1.0], surface: Surface::Mirror };
    let east = Vector2::x();
    assert_eq!(pane.distance(&Point2::origin(), &east), Some(2.0));
    assert_eq!(pane.distance(&Point2::origin(), &-east), None);
    assert_eq!(pane.distance(&Point2::new(0.0, 1.1), &east), None);
    assert_eq!(pane.distance(&Point2::origin(), &Vector2::y()), None);
    let back = pane.reflect(0.1);
    assert_relative_eq!(back.sin(), 0.1_f64.sin(), epsilon = 1e-12);
    assert_relative_eq!(back.cos(), -(0.1_f64.cos()), epsilon = 1e-12);
}

#[test]
fn bad_worlds_are_refused() {
    assert!(Room::new([0.0, 0.0], [1.0, 0.0]).is_err());
    assert!(Room::new([f64::NAN, 0.0], [1.0, 1.0]).is_err());
    assert!(room().with_pillar([0.0, 0.0], 0.0).is_err());
    for (to, surface) in [
        ([0.0, 0.0], Surface::Mirror),
        ([f64::INFINITY, 0.0], Surface::Mirror),
        ([1.0, 0.0], Surface::Glass { pass: 1.5 }),
    ] {
        assert!(Glazed::new(room(), [Pane { from: [0.0, 0.0], to, surface }]).is_err());
    }
}
