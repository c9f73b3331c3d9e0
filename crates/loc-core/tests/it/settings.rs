//! Settings: angles as text, builders and checks.

use loc_core::Pose2;
use proptest::prelude::*;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Angles {
    #[serde(default, with = "loc_core::settings::angle")]
    turn: f64,
    #[serde(default, with = "loc_core::settings::angle_per_s")]
    rate: Option<f64>,
    #[serde(default, with = "loc_core::settings::pose")]
    mounting: Pose2,
}

fn read(text: &str) -> Result<Angles, String> {
    toml::from_str(text).map_err(|error: toml::de::Error| error.message().to_owned())
}

#[test]
fn angles_are_numbers_or_texts() {
    for (text, turn) in [
        ("turn = 0.5", 0.5),
        ("turn = 1", 1.0),
        ("turn = '6 deg'", 6_f64.to_radians()),
        ("turn = '-6.5deg'", -6.5_f64.to_radians()),
        ("turn = ' 1e2 deg '", 100_f64.to_radians()),
        ("turn = '0.25 rad'", 0.25),
    ] {
        assert_eq!(read(text).unwrap().turn, turn, "{text}");
    }
    let nan = Angles { turn: f64::NAN, rate: Some(f64::INFINITY), mounting: Pose2::IDENTITY };
    let text = toml::to_string(&nan).unwrap();
    assert!(read(&text).unwrap().turn.is_nan() && text.contains("rate = inf"), "{text}");
    assert_eq!(read("rate = '180 deg/s'").unwrap().rate, Some(PI));
    assert_eq!(read("turn = 0").unwrap().rate, None);
    let posed = read("mounting = { x = 0.5, theta = '90 deg' }").unwrap().mounting;
    assert_eq!(posed, Pose2::new(0.5, 0.0, PI / 2.0));
}

#[test]
fn other_units_are_refused_with_what_is_expected() {
    for (text, found) in [
        ("turn = '6 grad'", "6 grad"),
        ("turn = '6'", "6"),
        ("turn = 'six deg'", "six deg"),
        ("turn = '6 deg/s'", "6 deg/s"),
        ("turn = ''", ""),
    ] {
        let error = read(text).unwrap_err();
        let expected = "expected a number [rad] or a text such as \"6 deg\"";
        assert!(error.contains(&format!("\"{found}\"")) && error.contains(expected), "{error}");
    }
    assert!(read("rate = '6 deg'").unwrap_err().contains("\"6 deg/s\""));
    assert!(read("turn = true").unwrap_err().contains("boolean `true`"));
    assert!(read("mounting = { x = 0.5, yaw = 1 }").unwrap_err().contains("unknown field `yaw`"));
}

proptest! {
    /// What is written is read as the same number, whether it is a round one in degrees or not.
    #[test]
    fn angles_come_back_to_the_bit(degrees in -720_i32..720, fine in -10.0..10.0_f64) {
        for turn in [f64::from(degrees).to_radians(), f64::from(degrees) / 8.0, fine, fine.to_radians()] {
            let angles = Angles { turn, rate: Some(turn), mounting: Pose2::new(1.0, 2.0, turn) };
            let text = toml::to_string(&angles).unwrap();
            prop_assert_eq!(read(&text).unwrap(), angles);
            let json = serde_json::to_string(&angles).unwrap();
            prop_assert_eq!(serde_json::from_str::<Angles>(&json).unwrap(), angles);
        }
        let round = Angles { turn: f64::from(degrees).to_radians(), rate: None, mounting: Pose2::IDENTITY };
        let expected = format!("turn = \"{degrees} deg\"");
        prop_assert!(toml::to_string(&round).unwrap().starts_with(&expected));
    }
}

loc_core::settings! {
    /// Settings of a test.
    #[derive(Copy)]
    pub struct TestSettings {
        /// A share.
        pub share: f64 = 0.5 => share;
        /// A count.
        pub count: usize = 2 => within(1, 10);
        /// More than the share.
        pub more: f64 = 0.75 => holds("more than the share", |s| s.more > s.share);
        /// A value that may be left out.
        pub length: Option<f64> = None => each_positive;
    }
}

#[test]
fn checks_name_the_setting_and_what_is_allowed() {
    let good = TestSettings::default();
    good.count(10).length(Some(1.0)).check().unwrap();
    for (bad, message) in [
        (good.share(0.0), "TestSettings.share: expected a number above 0 and up to 1, got 0"),
        (
            good.share(f64::NAN),
            "TestSettings.share: expected a number above 0 and up to 1, got NaN",
        ),
        (good.count(11), "TestSettings.count: expected a number from 1 to 10, got 11"),
        (good.more(0.5), "TestSettings.more: expected more than the share, got 0.5"),
        (good.length(Some(0.0)), "TestSettings.length: expected a finite number > 0, got 0"),
    ] {
        assert_eq!(bad.check().unwrap_err().to_string(), message);
    }
}
