//! When to resample.

use loc_pf::resample::{ResamplePolicy, ResampleWhen};

fn policy(every: usize, when: ResampleWhen) -> ResamplePolicy {
    ResamplePolicy { every, when }
}

#[test]
fn conditions() {
    use ResampleWhen::{Always, EffectiveShareBelow, Never, WeightVarianceAbove};
    // (condition, effective of 1000, due)
    let table = [
        (Always, 1000.0, true),
        (Never, 1.0, false),
        (EffectiveShareBelow(0.5), 499.0, true),
        (EffectiveShareBelow(0.5), 500.0, false),
        (EffectiveShareBelow(1.0), 1000.0, false),
        (WeightVarianceAbove(1.0), 499.0, true),
        (WeightVarianceAbove(1.0), 501.0, false),
        (WeightVarianceAbove(0.0), 1000.0, false),
    ];
    for (when, effective, due) in table {
        assert_eq!(policy(1, when).is_due(1, effective, 1000), due, "{when:?} {effective}");
        assert_eq!(policy(3, when).is_due(3, effective, 1000), due, "{when:?} {effective}");
        assert!(!policy(3, when).is_due(2, effective, 1000), "{when:?} too early");
    }
}

#[test]
fn variance_of_the_weights_is_that_of_its_definition() {
    // Weights 0.1, 0.2, 0.3, 0.4 in units of their mean: 0.4, 0.8, 1.2, 1.6, variance 0.2.
    let effective = 1.0 / (0.01 + 0.04 + 0.09 + 0.16);
    assert!(policy(1, ResampleWhen::WeightVarianceAbove(0.199)).is_due(1, effective, 4));
    assert!(!policy(1, ResampleWhen::WeightVarianceAbove(0.201)).is_due(1, effective, 4));
}

#[test]
fn thresholds_are_checked() {
    assert!(ResamplePolicy::default().check().is_ok());
    for share in [-0.1, 1.1, f64::NAN] {
        assert!(policy(1, ResampleWhen::EffectiveShareBelow(share)).check().is_err());
    }
    assert!(policy(1, ResampleWhen::WeightVarianceAbove(-1.0)).check().is_err());
}
