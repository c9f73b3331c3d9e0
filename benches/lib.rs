//! What the benches share. Run them with `cargo bench -p loc-bench`, or one of them with
//! `cargo bench -p loc-bench --bench kalman`.

use criterion::Criterion;
use std::time::Duration;

/// Settings that all benches run with: long enough to be steady, short enough to be rerun.
pub fn criterion() -> Criterion {
    Criterion::default()
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(3))
        .configure_from_args()
}
