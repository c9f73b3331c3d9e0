use loc_core::random::stream;
use loc_filters::delayed::{DelayedFilter, Step};
use loc_filters::{Error, Result};
use rand::RngExt;

/// A filter whose state depends on the order of its inputs, and that refuses -1.
#[derive(Clone, Debug, PartialEq)]
struct Hash(f64);

impl Step for Hash {
    type Input = f64;
    type Report = f64;
    fn step(&mut self, stamp: f64, input: &f64) -> Result<f64> {
        if *input < 0.0 {
            return Err(Error::NotFinite { what: "input", found: "-1".into() });
        }
        self.0 = (self.0 * 1.7 + input + stamp).sin();
        Ok(self.0)
    }
}

#[test]
fn any_order_within_the_horizon_gives_the_same_state() {
    let mut rng = stream(5, "order");
    let in_order: Vec<(f64, f64)> =
        (0..300).map(|k| (f64::from(k / 2) * 0.01, rng.random::<f64>())).collect();
    let mut reference = DelayedFilter::new(Hash(0.0), 0.25).unwrap();
    for &(stamp, input) in &in_order {
        reference.input("input", stamp, input).unwrap();
    }
    for seed in 0..20 {
        let mut rng = stream(seed, "shuffle");
        // Every input arrives up to 0.2 s after its stamp; inputs of one stamp keep their order.
        let mut arrivals: Vec<(f64, f64, f64)> = Vec::new();
        for pair in in_order.chunks(2) {
            let delay = 0.2 * rng.random::<f64>();
            arrivals.extend(pair.iter().map(|&(stamp, input)| (stamp + delay, stamp, input)));
        }
        arrivals.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut filter = DelayedFilter::new(Hash(0.0), 0.25).unwrap();
        for (_, stamp, input) in arrivals {
            filter.input("input", stamp, input).unwrap();
        }
        assert_eq!(filter.newest(), reference.newest());
        assert_eq!(filter.at(1.4), reference.at(1.4));
    }
}

#[test]
fn too_late_is_an_error_that_says_how_late() {
    let mut filter = DelayedFilter::new(Hash(0.0), 0.5).unwrap();
    filter.input("observations", 1.0, 1.0).unwrap();
    filter.input("observations", 2.0, 1.0).unwrap();
    let before = filter.newest().clone();
    let message = filter.input("observations", 1.4, 1.0).unwrap_err().to_string();
    assert_eq!(
        message,
        "observations at 1.4 s: expected at most 0.5 s before 2 s, the newest input"
    );
    assert_eq!(*filter.newest(), before);
    assert!(filter.input("observations", 1.5, 1.0).is_ok());
    assert!(filter.input("observations", f64::NAN, 1.0).is_err());
    assert!(DelayedFilter::new(Hash(0.0), -1.0).is_err());
}

#[test]
fn a_refused_input_changes_nothing_in_order_or_late() {
    let mut filter = DelayedFilter::new(Hash(0.0), 1.0).unwrap();
    for stamp in [0.0, 0.1, 0.2, 0.3] {
        filter.input("input", stamp, 0.5).unwrap();
    }
    let before = filter.newest().clone();
    assert!(filter.input("input", 0.4, -1.0).is_err());
    assert!(filter.input("input", 0.15, -1.0).is_err());
    assert_eq!(*filter.newest(), before);
    assert_eq!(filter.at(0.3), &before);
}
