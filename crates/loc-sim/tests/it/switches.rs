//! Parts of the particle filter that are switched off and on in configurations.

use loc_pf::MclSettings;
use loc_pf::mcl::{FieldSettings, NoveltyFilter, SensorSettings};
use loc_pf::novelty::{DistanceFilter, EntropyFilter};
use loc_sim::localizer::Method;
use loc_sim::nav2::AmclParameters;
use loc_sim::scenario::{RecordingConfig, Scenario, recording};

/// The settings of the filter after changes on the command line.
fn settings(changes: &[&str]) -> Result<MclSettings, String> {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    let scenario = Scenario::named("position-tracking", &changes);
    Ok(scenario.map_err(|error| error.to_string())?.filter.unwrap_or_default().mcl)
}

#[test]
fn parts_of_the_filter_are_switched_off_and_on_by_name() {
    let own = MclSettings::default();
    assert!(own.tempering.is_some() && own.recovery.suspicion.is_some());
    for off in ["false", "off", "\"off\""] {
        let set = |key: &str| settings(&[&format!("filter.mcl.{key}={off}")]).unwrap();
        assert_eq!(set("tempering"), MclSettings { tempering: None, ..own.clone() });
        assert_eq!(set("recovery.suspicion").recovery.suspicion, None);
        assert_eq!(set("recovery.augmented"), own);
        assert_eq!(set("novelty"), own);
    }
    assert_eq!(settings(&["filter.mcl.tempering=true"]).unwrap(), own);
    let crowd = settings(&["filter.mcl.novelty=on"]).unwrap();
    assert_eq!(crowd.novelty, Some(NoveltyFilter::Distance(DistanceFilter::default())));
    let entropy = settings(&["filter.mcl.novelty.entropy.tolerance=0.02"]).unwrap();
    let filter = EntropyFilter { tolerance: 0.02, ..EntropyFilter::default() };
    assert_eq!(entropy.novelty, Some(NoveltyFilter::Entropy(filter)));
    assert!(settings(&["filter.mcl.recovery.search=false"]).is_ok_and(|mcl| !mcl.recovery.search));
}

#[test]
fn what_is_neither_settings_nor_a_switch_is_refused() {
    for (change, message) in [
        ("tempering=0", "integer `0`, expected a table of settings, false (off) or true"),
        ("tempering=maybe", "string \"maybe\", expected a table of settings"),
        ("tempering.stages=3", "unknown field `stages`, expected one of `effective_share`"),
        ("novelty.people=1", "unknown variant `people`"),
        ("recovery.suspicion=[1]", "invalid type: sequence, expected a table of settings"),
    ] {
        let error = settings(&[&format!("filter.mcl.{change}")]).unwrap_err();
        assert!(error.contains(message), "{error}");
    }
}

/// Settings that are written and read again are the same, whatever is switched off.
#[test]
fn written_settings_are_read_as_they_were() {
    let mut all_off = MclSettings { tempering: None, novelty: None, ..Default::default() };
    (all_off.recovery.suspicion, all_off.recovery.augmented) = (None, None);
    let mut all_on = MclSettings { novelty: Some(NoveltyFilter::default()), ..Default::default() };
    all_on.recovery.augmented = Some(Default::default());
    let skip = Some(Default::default());
    all_on.sensor =
        SensorSettings::LikelihoodField(FieldSettings { beam_skip: skip, ..Default::default() });
    for settings in [MclSettings::default(), all_off, all_on] {
        let text = toml::to_string(&settings).unwrap();
        assert_eq!(toml::from_str::<MclSettings>(&text).unwrap(), settings, "{text}");
        let json = serde_json::to_string(&settings).unwrap();
        assert_eq!(serde_json::from_str::<MclSettings>(&json).unwrap(), settings, "{json}");
    }
}

/// A part stays off through the file of a replay, and beside a parameter file of nav2_amcl.
#[test]
fn a_part_that_is_off_stays_off() {
    let off = ["filter.mcl.tempering=false".to_owned()];
    let config = RecordingConfig::parse("laser", recording::LASER, &off).unwrap();
    assert_eq!(config.filter.mcl.tempering, None);
    let text = "amcl:\n  ros__parameters:\n    max_particles: 800\n";
    let mut mcl = AmclParameters::parse("amcl.yaml", text).unwrap().mcl;
    mcl.tempering = None;
    let read: MclSettings = toml::Value::try_from(&mcl).unwrap().try_into().unwrap();
    assert_eq!(read, mcl);
}

#[test]
fn the_plain_filter_tracks_too() {
    let changes = ["filter.mcl.tempering=false", "tour.duration_s=10.0"].map(str::to_owned);
    let plain = Scenario::named("position-tracking", &changes).unwrap();
    let tempered = Scenario::named("position-tracking", &changes[1..]).unwrap();
    let run = |scenario: Scenario| {
        let mut run = scenario.run(None, Some(&[Method::Mcl]), &mut |_| {}).unwrap();
        let end = run.truth.last().unwrap().value.pose;
        let estimates = run.methods.remove(0).estimates;
        assert!(estimates.last().unwrap().pose.distance(end) < 0.2);
        estimates
    };
    assert_ne!(run(plain), run(tempered));
}
