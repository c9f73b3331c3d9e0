//! How the robot is found again. The search of the whole map on suspicion stays on beside what the
//! file says.

use crate::Result;
use crate::nav2::given::{Found, Given};
use loc_pf::MclSettings;
use loc_pf::recovery::AugmentedSettings;

const KEYS: [&str; 2] = ["recovery_alpha_slow", "recovery_alpha_fast"];

/// Random particles by the two running averages; 0 switches them off, as in nav2_amcl.
pub(super) fn recovery(given: &mut Given, mcl: &mut MclSettings) -> Result<()> {
    let share = |v: f64| (0.0..=1.0).contains(&v);
    let mut alpha = |key| given.number(key, "a share from 0 to 1", share);
    let [slow, fast] = [alpha(KEYS[0])?, alpha(KEYS[1])?];
    let on = |found: &Option<Found<f64>>| found.filter(|found| found.value > 0.0);
    match (on(&slow), on(&fast)) {
        (Some(slow), Some(fast)) if slow.value >= fast.value => {
            let (line, slow, fast) = (fast.line, slow.value, fast.value);
            let expected = format!("expected a share above {} ({slow})", KEYS[0]);
            return Err(given.error(&format!("line {line}: {}: {expected}, got `{fast}`", KEYS[1])));
        }
        (Some(slow), Some(fast)) => {
            let settings = AugmentedSettings { alpha_slow: slow.value, alpha_fast: fast.value };
            mcl.recovery.augmented = Some(settings);
        }
        (Some(slow), None) => given.warn(slow.line, KEYS[0], "takes recovery_alpha_fast above 0"),
        (None, Some(fast)) => given.warn(fast.line, KEYS[1], "takes recovery_alpha_slow above 0"),
        (None, None) => {}
    }
    Ok(())
}
