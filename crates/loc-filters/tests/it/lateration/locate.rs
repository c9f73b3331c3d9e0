use super::{seen, solve};
use approx::assert_relative_eq;
use loc_core::random::stream;
use loc_filters::lateration::{
    BiasPrior, Caution, Cost, Dilution, LaterationSettings, Loss, Range, locate,
};
use nalgebra::{Point2, Point3};
use rand::RngExt;

const CORNERS: [[f64; 2]; 4] = [[0.0, 0.0], [10.0, 0.0], [10.0, 8.0], [0.0, 8.0]];

/// The cost of D2 and that of the most likely place, written down once more.
fn cost(ranges: &[Range<2>], at: Point2<f64>, settings: &LaterationSettings) -> f64 {
    let one = |range: &Range<2>| {
        let distance = (at - range.landmark).norm();
        match settings.cost {
            Cost::Distances => settings.loss.cost((distance - range.distance) / range.sigma),
            Cost::Squares => (distance.powi(2) - range.distance.powi(2)).powi(2),
        }
    };
    ranges.iter().map(one).sum()
}

/// Nothing on a fine grid around the answer, and on a coarse one over the whole map, is better, for
/// each cost and loss and for errors of up to 2 m in distances of some 5 m.
#[test]
fn nothing_is_better_than_the_answer() {
    let mut rng = stream(3, "ranges");
    for round in 0..40 {
        let mut draw = |low: f64, high: f64| rng.random_range(low..high);
        let truth = Point2::new(draw(-5.0, 5.0), draw(-5.0, 5.0));
        let ranges: Vec<Range<2>> = (0..3 + round % 4)
            .map(|_| {
                let place = Point2::new(draw(-5.0, 5.0), draw(-5.0, 5.0));
                let distance = nalgebra::distance(&place, &truth) + draw(-2.0, 2.0);
                Range::new(place.coords.into(), distance.max(0.0), draw(0.5, 1.0))
            })
            .collect();
        for (cost_kind, loss) in [
            (Cost::Distances, Loss::Quadratic),
            (Cost::Squares, Loss::Quadratic),
            (Cost::Distances, Loss::HUBER),
            (Cost::Distances, Loss::CAUCHY),
        ] {
            let settings =
                LaterationSettings { cost: cost_kind, loss, ..LaterationSettings::default() };
            let found = locate(&ranges, None, &settings).unwrap().best;
            let least = cost(&ranges, found.position, &settings);
            match cost_kind {
                Cost::Distances => assert_relative_eq!(found.cost, least, max_relative = 1e-9),
                Cost::Squares => assert_relative_eq!(found.sse, least, max_relative = 1e-9),
            }
            for (step, around) in [(0.6, Point2::origin()), (1e-4, found.position)] {
                for i in -20..=20 {
                    for k in -20..=20 {
                        let at = around + nalgebra::Vector2::new(f64::from(i), f64::from(k)) * step;
                        let there = cost(&ranges, at, &settings);
                        assert!(there >= least * (1.0 - 1e-7), "{round} {settings:?}: {at}");
                    }
                }
            }
        }
    }
}

/// Landmarks on one line: the robot is on this side or on that one, and the answer says so.
#[test]
fn landmarks_on_a_line_leave_two_sides() {
    let ranges = seen([3.0, 2.0], &[[0.0, 0.0], [4.0, 0.0], [9.0, 0.0]]);
    let settings = LaterationSettings::default();
    for side in [2.0, -2.0] {
        let solution = locate(&ranges, Some(Point2::new(5.0, side)), &settings).unwrap();
        assert_relative_eq!(solution.best.position, Point2::new(3.0, side), epsilon = 1e-9);
        let other = solution.other.as_ref().unwrap();
        assert_relative_eq!(other.position, Point2::new(3.0, -side), epsilon = 1e-9);
        assert!(!solution.is_unique());
    }
    // A landmark that is 1 cm off the line does not help against noise of 10 cm ...
    let almost = seen([3.0, 2.0], &[[0.0, 0.0], [4.0, 0.01], [9.0, 0.0]]);
    assert!(!locate(&almost, None, &settings).unwrap().is_unique());
    // ... one that is 1 m off does.
    let off = locate(&seen([3.0, 2.0], &[[0.0, 0.0], [4.0, 1.0], [9.0, 0.0]]), None, &settings);
    let off = off.unwrap();
    assert!(off.is_unique() && off.other.is_some());
    assert_relative_eq!(off.best.position, Point2::new(3.0, 2.0), epsilon = 1e-9);
}

#[test]
fn in_space_three_landmarks_leave_two_places_and_four_do_not() {
    let ground = [[0.0, 0.0, 0.0], [6.0, 0.0, 0.0], [0.0, 6.0, 0.0]];
    let three = solve(&seen([2.0, 1.0, 3.0], &ground));
    assert!(!three.is_unique());
    let heights = [three.best.position.z, three.other.as_ref().unwrap().position.z];
    assert_relative_eq!(heights[0].abs(), 3.0, epsilon = 1e-9);
    assert_relative_eq!(heights[0], -heights[1], epsilon = 1e-9);
    let above = locate(
        &seen([2.0, 1.0, 3.0], &ground),
        Some(Point3::new(0.0, 0.0, 1.0)),
        &LaterationSettings::default(),
    );
    assert_relative_eq!(above.unwrap().best.position.z, 3.0, epsilon = 1e-9);
    let four = [ground.as_slice(), &[[5.0, 5.0, 4.0]]].concat();
    let four = solve(&seen([2.0, 1.0, 3.0], &four));
    assert!(four.is_unique() && four.best.position.z > 2.99);
    // All in one plane: the height follows from the plane distance, its sign does not.
    let plane = [ground.as_slice(), &[[6.0, 6.0, 0.0]]].concat();
    assert!(!solve(&seen([2.0, 1.0, 3.0], &plane)).is_unique());
}

/// By hand: two crossed directions give 1 along each axis; with the angle `a` between them the
/// dilution is sqrt(2) / sin(a).
#[test]
fn dilution_grows_with_the_sine_of_the_angle() {
    for degrees in [90.0, 45.0, 10.0, 2.0_f64] {
        let angle = degrees.to_radians();
        let landmarks = [Point2::new(5.0, 0.0), Point2::new(7.0 * angle.cos(), 7.0 * angle.sin())];
        let dilution = Dilution::at(&Point2::origin(), landmarks).unwrap();
        let expected = 2_f64.sqrt() / angle.sin();
        assert_relative_eq!(dilution.position(), expected, max_relative = 1e-9);
    }
    let flat = [Point2::new(5.0, 0.0), Point2::new(-7.0, 0.0)];
    assert_eq!(Dilution::at(&Point2::origin(), flat).unwrap().position(), f64::INFINITY);
    let axes = [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0], [0.0, 0.0, -4.0]];
    let space = Dilution::at(&Point3::origin(), axes.map(Point3::from)).unwrap();
    assert_relative_eq!(space.horizontal(), 2_f64.sqrt(), epsilon = 1e-12);
    assert_relative_eq!(space.vertical(), 0.5_f64.sqrt(), epsilon = 1e-12);
}

/// With equal ranges the covariance is sigma^2 (H^T H)^-1, so the dilution by the sigma.
#[test]
fn covariance_and_dilution_agree() {
    let solution = solve(&seen([2.0, 7.0], &CORNERS));
    let sigmas = solution.best.covariance.diagonal().map(f64::sqrt);
    assert_relative_eq!(sigmas, 0.1 * solution.best.dilution.axes, max_relative = 1e-6);
    assert!(solution.cautions.is_empty(), "{:?}", solution.cautions);
    let far = seen([500.0, 4.0], &CORNERS);
    let far = locate(&far, Some(Point2::new(499.0, 5.0)), &LaterationSettings::default()).unwrap();
    let bad = |caution: &Caution| matches!(caution, Caution::BadGeometry { .. });
    assert!(far.cautions.iter().any(bad), "{:?}", far.cautions);
}

/// Six good ranges and one that came by way of a wall.
#[test]
fn outliers_cost_little_under_a_robust_loss() {
    let landmarks = [CORNERS.as_slice(), &[[5.0, 9.0], [5.0, -1.0], [11.0, 4.0]]].concat();
    let truth = Point2::new(3.0, 4.5);
    let mut ranges = seen([truth.x, truth.y], &landmarks);
    ranges[2].distance += 4.0;
    let error = |loss: Loss| {
        let settings = LaterationSettings { loss, ..LaterationSettings::default() };
        let solution = locate(&ranges, None, &settings).unwrap();
        (nalgebra::distance(&solution.best.position, &truth), solution)
    };
    let (quadratic, solution) = error(Loss::Quadratic);
    assert!(quadratic > 0.5, "{quadratic}");
    let is_contradiction = |caution: &Caution| matches!(caution, Caution::Contradiction { .. });
    assert!(solution.cautions.iter().any(is_contradiction));
    let (huber, _) = error(Loss::HUBER);
    let (cauchy, solution) = error(Loss::CAUCHY);
    assert!(huber < 0.12 && cauchy < 0.02, "{huber} {cauchy}");
    let weights = &solution.best.weights;
    assert!(weights[2] < 0.01 && weights[0] > 0.95, "{weights:?}");
}

/// Plaza's ranges are 1.07 times too long: with the scale as an unknown the place is right.
#[test]
fn a_bias_is_found_beside_the_place() {
    let landmarks = [CORNERS.as_slice(), &[[5.0, 12.0]]].concat();
    let exact = seen([3.0, 2.5], &landmarks);
    for (scale, offset, bias) in [
        (1.07, 0.0, BiasPrior::FREE_SCALE),
        (1.0, 0.4, BiasPrior::FREE_OFFSET),
        (0.95, 0.4, BiasPrior { scale_sigma: f64::INFINITY, offset_sigma: f64::INFINITY }),
    ] {
        let mut ranges = exact.clone();
        ranges.iter_mut().for_each(|range| range.distance = scale * range.distance + offset);
        let blind = solve(&ranges).best.position;
        assert!((blind - Point2::new(3.0, 2.5)).norm() > 0.05, "{blind}");
        let settings = LaterationSettings { bias, ..LaterationSettings::default() };
        let fix = locate(&ranges, None, &settings).unwrap().best;
        assert_relative_eq!(fix.position, Point2::new(3.0, 2.5), epsilon = 1e-8);
        assert_relative_eq!(fix.bias.scale, scale, epsilon = 1e-8);
        assert_relative_eq!(fix.bias.offset, offset, epsilon = 1e-8);
        assert_eq!(fix.bias_sigmas[0] > 0.0, bias.scale_sigma > 0.0);
    }
    // Known to 1 %, and 1 % is what is found.
    let bias = BiasPrior { scale_sigma: 0.01, offset_sigma: 0.0 };
    let settings = LaterationSettings { bias, ..LaterationSettings::default() };
    let two = locate(&exact[..2], None, &settings).unwrap().best;
    assert_relative_eq!(two.bias_sigmas[0], 0.01, max_relative = 1e-3);
}

/// Landmarks on a circle with a free scale: the place and its image in the circle have the same
/// ratios of distances. By hand: the circle about (5, 4) has the squared radius 41.
#[test]
fn a_circle_of_landmarks_and_a_free_scale_leave_two_places() {
    let ranges = seen([3.0, 2.5], &CORNERS);
    let settings = LaterationSettings { bias: BiasPrior::FREE_SCALE, ..Default::default() };
    let solution = locate(&ranges, None, &settings).unwrap();
    assert!(!solution.is_unique());
    assert_relative_eq!(solution.best.position, Point2::new(3.0, 2.5), epsilon = 1e-7);
    let factor = 41.0 / 6.25;
    let image = Point2::new(5.0 - 2.0 * factor, 4.0 - 1.5 * factor);
    assert_relative_eq!(solution.other.unwrap().position, image, epsilon = 1e-6);
}
