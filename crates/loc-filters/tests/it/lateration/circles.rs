use approx::assert_relative_eq;
use loc_filters::Error;
use loc_filters::lateration::{
    Caution, Crossing, LaterationSettings, Miss, Range, locate, newton, two_circles,
};
use nalgebra::{Point2, Point3};

fn circle(x: f64, y: f64, distance: f64, sigma: f64) -> Range<2> {
    Range::new([x, y], distance, sigma)
}

/// Circles of radius 5 about (1, 1) and 4 about (1, 8): by hand, y = 5 + 1/14 * (25 - 16 - 9) ...
#[test]
fn both_points_lie_on_both_circles() {
    let (a, b) = (circle(1.0, 1.0, 5.0, 0.1), circle(1.0, 8.0, 4.0, 0.1));
    let Crossing::Meet([left, right]) = two_circles(&a, &b).unwrap() else { panic!() };
    // Along the line: (49 + 25 - 16) / 14 = 58/14; across: sqrt(25 - (58/14)^2).
    let along = 58.0 / 14.0;
    let across = f64::sqrt(25.0 - along * along);
    assert_relative_eq!(left, Point2::new(1.0 - across, 1.0 + along), epsilon = 1e-12);
    assert_relative_eq!(right, Point2::new(1.0 + across, 1.0 + along), epsilon = 1e-12);
}

#[test]
fn touching_circles_have_one_point_twice() {
    let Crossing::Meet(points) =
        two_circles(&circle(0.0, 0.0, 2.0, 0.1), &circle(5.0, 0.0, 3.0, 0.1)).unwrap()
    else {
        panic!()
    };
    assert_eq!(points, [Point2::new(2.0, 0.0); 2]);
}

/// The gap is shared as the variances are; `locate` comes to the same place, with the reason.
#[test]
fn circles_that_miss_give_the_nearest_point() {
    for (a, b, x, gap, reason) in [
        (circle(0.0, 0.0, 2.0, 0.1), circle(10.0, 0.0, 3.0, 0.2), 3.0, 5.0, Miss::Apart),
        (circle(0.0, 0.0, 10.0, 0.2), circle(1.0, 0.0, 4.0, 0.1), 6.0, 5.0, Miss::Inside),
        (circle(1.0, 0.0, 4.0, 0.1), circle(0.0, 0.0, 10.0, 0.2), 6.0, 5.0, Miss::Inside),
    ] {
        let crossing = two_circles(&a, &b).unwrap();
        let nearest = Point2::new(x, 0.0);
        assert_eq!(crossing, Crossing::Miss { nearest, gap, reason });
        let solution = locate(&[a, b], None, &LaterationSettings::default()).unwrap();
        assert_relative_eq!(solution.best.position, nearest, epsilon = 1e-6);
        let refused = solution.cautions.iter().find_map(|caution| match caution {
            Caution::NoIntersection { gap, .. } => Some(*gap),
            _ => None,
        });
        assert_relative_eq!(refused.unwrap(), 4.0, epsilon = 1e-6);
        assert!(solution.best.covariance.iter().all(|value| value.is_finite()));
    }
}

#[test]
fn circles_about_one_point_are_refused() {
    let error = two_circles(&circle(1.0, 2.0, 1.0, 0.1), &circle(1.0, 2.0, 1.0, 0.1)).unwrap_err();
    let message = "lateration: expected two landmarks at different places, got both at (1, 2)";
    assert_eq!(error.to_string(), message);
}

/// D1: the start decides which of the two places is found.
#[test]
fn newton_finds_the_root_on_the_side_of_its_start() {
    let ranges = [circle(-2.0, 1.0, 5.0, 0.1), circle(4.0, 3.0, 3.0, 0.1)];
    let Crossing::Meet(roots) = two_circles(&ranges[0], &ranges[1]).unwrap() else { panic!() };
    for (k, start) in [(0, [0.0, 9.0]), (1, [2.0, -6.0])] {
        assert_relative_eq!(newton(&ranges, start.into()).unwrap(), roots[k], epsilon = 1e-11);
    }
}

/// D3, with numbers by hand: landmarks on the axes, the robot at (1, 2, 2) or its mirror image in
/// the plane x + y + z = 3.
#[test]
fn newton_in_space() {
    let landmarks = [[3.0, 0.0, 0.0], [0.0, 3.0, 0.0], [0.0, 0.0, 3.0]];
    let ranges: [Range<3>; 3] = super::seen([1.0, 2.0, 2.0], &landmarks).try_into().unwrap();
    let found = newton(&ranges, Point3::new(2.0, 2.0, 3.0)).unwrap();
    assert_relative_eq!(found, Point3::new(1.0, 2.0, 2.0), epsilon = 1e-11);
    let mirrored = newton(&ranges, Point3::new(-1.0, 0.0, -1.0)).unwrap();
    let back = 2.0 * (5.0 - 3.0) / 3.0;
    assert_relative_eq!(mirrored, Point3::new(1.0 - back, 2.0 - back, 2.0 - back), epsilon = 1e-11);
}

#[test]
fn newton_says_where_it_has_no_way() {
    let apart = [circle(0.0, 0.0, 1.0, 0.1), circle(10.0, 0.0, 1.0, 0.1)];
    let error = newton(&apart, [5.0, 1.0].into()).unwrap_err();
    assert!(matches!(error, Error::NoRoot { .. }));
    let crossing = [circle(0.0, 0.0, 5.0, 0.1), circle(6.0, 0.0, 5.0, 0.1)];
    let on_the_line = newton(&crossing, [2.0, 0.0].into()).unwrap_err().to_string();
    assert_eq!(
        on_the_line,
        "Newton's method from [2.0, 0.0]: expected circles that cross, and a start beside the \
         line through their centres, got no root"
    );
    assert!(newton(&crossing, [f64::NAN, 0.0].into()).is_err());
}
