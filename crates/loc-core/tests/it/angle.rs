use approx::assert_relative_eq;
use loc_core::angle::{circular_mean, weighted_circular_mean, wrap};
use proptest::prelude::*;
use std::f64::consts::PI;

#[test]
fn the_interval_is_open_below_and_closed_above() {
    assert_relative_eq!(wrap(PI), PI);
    assert_relative_eq!(wrap(-PI), PI);
    assert_relative_eq!(wrap(3.0 * PI), PI, epsilon = 1e-12);
    assert_relative_eq!(wrap(-0.5), -0.5);
    assert!(wrap(f64::NAN).is_nan() && wrap(f64::INFINITY).is_nan());
}

#[test]
fn means_cross_the_seam() {
    let mean = circular_mean([PI - 0.1, -PI + 0.3]).expect("has a direction");
    assert_relative_eq!(mean, -PI + 0.1, epsilon = 1e-12);
    assert_eq!(circular_mean([0.0, PI]), None);
    assert_eq!(circular_mean([]), None);
    assert_eq!(circular_mean([f64::NAN]), None);
    let weighted = weighted_circular_mean([(0.0, 3.0), (PI / 2.0, 0.0)]).expect("one weight");
    assert_relative_eq!(weighted, 0.0);
}

proptest! {
    #[test]
    fn wrapping_keeps_the_direction(angle in -1e4..1e4_f64) {
        let wrapped = wrap(angle);
        prop_assert!(wrapped > -PI && wrapped <= PI);
        prop_assert!((wrapped.sin() - angle.sin()).abs() < 1e-9);
        prop_assert!((wrapped.cos() - angle.cos()).abs() < 1e-9);
        prop_assert!(wrap(wrapped) == wrapped);
    }

    #[test]
    fn every_size_of_angle_ends_in_the_interval(angle in proptest::num::f64::NORMAL) {
        let wrapped = wrap(angle);
        prop_assert!(wrapped > -PI && wrapped <= PI, "{angle} became {wrapped}");
    }
}
