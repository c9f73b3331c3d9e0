//! What a method claims about its own estimate, for estimates made by hand.

use approx::assert_relative_eq;
use loc_core::Pose2;
use loc_core::nalgebra::Matrix3;
use loc_filters::localizer::Estimate;
use loc_sim::localizer::Method;
use loc_sim::metrics::Claims;
use loc_sim::record::Run;
use loc_sim::scenario::Scenario;

/// Five estimates, 1 s apart, of a robot that stands at the origin.
fn claims(estimates: [(Pose2, f64, Option<f64>); 5]) -> Claims {
    let scenario = Scenario::named("circle-drive", &[]).unwrap();
    let mut run: Run = scenario.run(None, Some(&[Method::DeadReckoning]), &mut |_| {}).unwrap();
    run.stamps = vec![10.0, 11.0, 12.0, 13.0, 14.0];
    run.truth.truncate(5);
    run.truth.iter_mut().for_each(|truth| truth.value.pose = Pose2::IDENTITY);
    let mut record = run.methods.remove(0);
    let estimate = |(pose, sigma, lost): (Pose2, f64, Option<f64>)| {
        let covariance = Some(Matrix3::identity() * sigma * sigma);
        Estimate { pose, covariance, lost, rail: None }
    };
    record.estimates = estimates.map(estimate).to_vec();
    Claims::of(&run, &record)
}

#[test]
fn of_a_method_that_gives_a_probability() {
    let off = Pose2::new(0.0, 0.6, 0.0);
    let claims = claims([
        (off, 0.01, Some(0.05)),
        (off, 0.01, Some(0.6)),
        (off, 0.01, Some(0.9)),
        (off, 0.2, Some(0.0)),
        (off, 0.01, Some(0.0)),
    ]);
    assert_relative_eq!(claims.lost_mean.unwrap(), (0.05 + 0.6 + 0.9) / 4.0);
    assert_eq!(claims.lost_max, Some(0.9));
    assert_eq!(claims.doubtful_s, [[1.0, 3.0]]);
    // The first second: later ones are doubted, or within five standard deviations, or the end.
    assert_eq!(claims.sure_and_wrong_s, Some(1.0));
}

#[test]
fn of_a_method_that_has_a_covariance_only() {
    let turned = Pose2::new(0.0, 0.0, 21_f64.to_radians());
    let far = Pose2::new(3.0, 4.0, 0.0);
    let claims = claims([
        (turned, 1.0, None),
        (far, 0.99, None),
        (far, 1.01, None),
        (Pose2::IDENTITY, 0.01, None),
        (Pose2::IDENTITY, 0.01, None),
    ]);
    assert_eq!((claims.lost_mean, claims.lost_max), (None, None));
    assert!(claims.doubtful_s.is_empty());
    assert_eq!(claims.sure_and_wrong_s, Some(2.0));
    let right = (Pose2::IDENTITY, 0.01, None);
    let none = self::claims([right; 5]).sure_and_wrong_s.unwrap();
    assert!(none == 0.0 && none.is_sign_positive());
}
