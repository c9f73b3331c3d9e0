use approx::assert_relative_eq;
use loc_core::Gaussian;
use loc_filters::kalman::{KalmanFilter, LinearMeasurement};
use loc_filters::{Error, Gate};
use nalgebra::{Matrix2, Vector2};

fn filter() -> KalmanFilter<2> {
    KalmanFilter::new(Gaussian::certain(Vector2::zeros())).unwrap()
}

/// A certain filter expects exactly its state: S = R, and everything can be done by hand.
#[test]
fn everything_by_hand() {
    let noise = Matrix2::new(4.0, 2.0, 2.0, 5.0);
    let sensor = LinearMeasurement::new(Matrix2::identity(), noise).unwrap();
    let innovation = filter().correct(&sensor, &Vector2::new(2.0, 5.0), &Gate::OPEN).unwrap();
    // L = [[2, 0], [1, 2]]: whitened (1, 2).
    assert_relative_eq!(innovation.whitened, Vector2::new(1.0, 2.0), epsilon = 1e-12);
    assert_relative_eq!(innovation.nis, 5.0, epsilon = 1e-12);
    assert_relative_eq!(innovation.determinant, 16.0, epsilon = 1e-12);
    let log_density = Gaussian::new(Vector2::zeros(), noise)
        .unwrap()
        .log_density(&Vector2::new(2.0, 5.0))
        .unwrap();
    assert_relative_eq!(innovation.log_likelihood(), log_density, epsilon = 1e-12);
}

#[test]
fn a_gate_turns_away_and_leaves_the_belief() {
    let sensor = LinearMeasurement::new(Matrix2::identity(), Matrix2::identity()).unwrap();
    let gate = Gate::probability(0.95).unwrap();
    let start = Gaussian::new(Vector2::zeros(), Matrix2::identity() * 3.0).unwrap();
    let mut filter = KalmanFilter::new(start).unwrap();
    // S = 4 I; the threshold is 5.9915, so the border lies at a distance of 4.8955.
    let far = filter.correct(&sensor, &Vector2::new(4.90, 0.0), &gate).unwrap();
    assert!(!far.accepted && far.nis > far.threshold);
    assert_eq!(*filter.belief(), start);
    let near = filter.correct(&sensor, &Vector2::new(4.89, 0.0), &gate).unwrap();
    assert!(near.accepted);
    assert_relative_eq!(filter.belief().mean.x, 0.75 * 4.89, epsilon = 1e-12);
}

#[test]
fn bad_input_is_refused_and_changes_nothing() {
    let sensor = LinearMeasurement::new(Matrix2::identity(), Matrix2::identity()).unwrap();
    let mut filter = filter();
    let before = *filter.belief();
    let refused = filter.correct(&sensor, &Vector2::new(f64::NAN, 1.0), &Gate::OPEN);
    assert_eq!(
        refused.unwrap_err().to_string(),
        "measurement: expected finite numbers, got [NaN, 1.0]"
    );
    assert_eq!(*filter.belief(), before);
    assert!(LinearMeasurement::new(Matrix2::identity(), Matrix2::zeros()).is_err());
    let indefinite = Matrix2::new(1.0, 2.0, 2.0, 1.0);
    assert!(
        KalmanFilter::new(Gaussian { mean: Vector2::zeros(), covariance: indefinite }).is_err()
    );
    for probability in [0.0, -0.1, 1.1, f64::NAN] {
        assert!(matches!(Gate::probability(probability), Err(Error::Core(_))));
    }
    assert_eq!(Gate::probability(1.0).unwrap(), Gate::OPEN);
    assert_eq!(Gate::probability(0.9).unwrap().threshold(0), f64::INFINITY);
}
