//! Tests of loc-pf, one module per topic.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::float_cmp)]

/// One number for many: results that must be the same on every machine.
fn fnv1a(words: impl Iterator<Item = u64>) -> u64 {
    words.fold(0xcbf2_9ce4_8422_2325, |hash, word| (hash ^ word).wrapping_mul(0x0100_0000_01b3))
}

mod adaptive;
mod bad_input;
mod beam;
mod clusters;
mod delay;
mod endurance;
mod fastslam;
mod frozen;
mod initial;
mod landmark;
mod landmark_mcl;
mod likelihood_field;
mod lost;
mod moments;
mod motion;
mod never_sure;
mod normals;
mod novelty;
mod own_models;
mod perceptual;
mod policy;
mod range_offset;
mod resample;
mod robot;
mod sensor_resetting;
mod tempering;
mod what_users_miss;
