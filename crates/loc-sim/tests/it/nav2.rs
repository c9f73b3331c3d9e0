//! Parameter files of nav2_amcl.

use loc_core::Pose2;
use loc_core::motion::OdometryNoise;
use loc_maps::likelihood_field::UnknownSpace;
use loc_pf::MclSettings;
use loc_pf::adaptive::KldCertainty;
use loc_pf::mcl::{MotionSettings, SensorSettings};
use loc_pf::motion::OmnidirectionalNoise;
use loc_pf::sensor::BeamModelSettings;
use loc_sim::nav2::AmclParameters;

fn parse(text: &str) -> Result<AmclParameters, String> {
    AmclParameters::parse("amcl.yaml", text).map_err(|error| error.to_string())
}

/// Parameters of the node `amcl`, a line each.
fn amcl(lines: &[&str]) -> Result<AmclParameters, String> {
    let lines: String = lines.iter().map(|line| format!("    {line}\n")).collect();
    parse(&format!("amcl:\n  ros__parameters:\n{lines}"))
}

#[test]
fn parameters_with_a_counterpart_are_honoured() {
    let parameters = amcl(&[
        "min_particles: 300",
        "max_particles: 3000",
        "pf_err: 0.02",
        "pf_z: 0.95",
        "spatial_resolution_x: 0.2",
        "spatial_resolution_theta: 0.3",
        "max_beams: 90",
        "update_min_d: 0.5",
        "update_min_a: 0.4",
        "laser_max_range: 20",
        "laser_min_range: 0.2",
        "recovery_alpha_slow: 0.002",
        "recovery_alpha_fast: 0.2",
        "random_seed: 7",
        "set_initial_pose: true",
        "initial_pose: {x: 1.0, y: -2, yaw: 0.5, covariance_x: 0.25, covariance_yaw: 0.01}",
        "execution_policy: seq",
    ])
    .unwrap();
    assert_eq!(parameters.warnings, Vec::<String>::new());
    let mcl = &parameters.mcl;
    assert_eq!((mcl.particles.min_particles, mcl.particles.max_particles), (300, 3000));
    assert_eq!((mcl.particles.error, mcl.particles.bin_position), (0.02, 0.2));
    assert_eq!(mcl.particles.bin_heading, 0.3);
    assert_eq!(mcl.particles.certainty, KldCertainty::Confidence(0.95));
    assert_eq!((mcl.beams, mcl.threads), (90, 1));
    assert_eq!((mcl.update_distance, mcl.update_turn), (0.5, 0.4));
    assert_eq!((mcl.min_range, mcl.max_range), (0.2, 20.0));
    let averages = mcl.recovery.augmented.unwrap();
    assert_eq!((averages.alpha_slow, averages.alpha_fast), (0.002, 0.2));
    assert_eq!(parameters.seed, Some(7));
    assert_eq!(parameters.start, Some(Pose2::new(1.0, -2.0, 0.5)));
    assert_eq!(parameters.start_sigmas, [Some(0.5), None, Some(0.1)]);
    // nav2_amcl's own reading of pf_z, for what is no probability.
    let quantile = amcl(&["pf_z: 2.33"]).unwrap().mcl.particles.certainty;
    assert_eq!(quantile, KldCertainty::Quantile(2.33));
    // Fewer than the fewest that are otherwise kept, and more than the most.
    let few = amcl(&["max_particles: 100"]).unwrap().mcl.particles;
    assert_eq!((few.min_particles, few.max_particles), (100, 100));
    let many = amcl(&["min_particles: 9000"]).unwrap().mcl.particles;
    assert_eq!((many.min_particles, many.max_particles), (9000, 9000));
}

#[test]
fn the_likelihood_field_is_that_of_nav2() {
    let lines = [
        "laser_model_type: likelihood_field_prob",
        "sigma_hit: 0.1",
        "z_hit: 0.9",
        "z_rand: 0.1",
        "laser_max_range: 20",
        "laser_likelihood_max_dist: 1.5",
        "model_unknown_space: true",
        "do_beamskip: true",
        "beam_skip_distance: 0.4",
        "beam_skip_error_threshold: 0.8",
    ];
    let parameters = amcl(&lines).unwrap();
    assert_eq!(parameters.warnings, Vec::<String>::new());
    let SensorSettings::LikelihoodField(settings) = parameters.mcl.sensor else { panic!() };
    let field = settings.field;
    assert_eq!((field.sigma_hit, field.z_rand, field.max_range), (0.1, 0.1, 20.0));
    assert_eq!(field.max_distance, 1.5);
    assert_eq!(field.unknown_space, UnknownSpace::Likelihood(0.05));
    // On an obstacle nav2_amcl says z_hit + z_rand / max_range, without the normaliser.
    approx::assert_relative_eq!(field.likelihood(0.0), 0.9 + 0.1 / 20.0, epsilon = 1e-12);
    let skip = settings.beam_skip.unwrap();
    assert_eq!((skip.distance, skip.threshold, skip.error_threshold), (0.4, 0.3, 0.8));
    let plain = amcl(&["laser_model_type: likelihood_field"]).unwrap();
    let warning = &plain.warnings[0];
    assert!(
        warning.starts_with("amcl.yaml:3: laser_model_type: likelihoods are mult"),
        "{warning}"
    );
}

#[test]
fn the_beam_model_is_that_of_nav2() {
    let lines = ["laser_model_type: beam", "z_short: 0.2", "lambda_short: 0.3", "z_hit: 0.7"];
    let parameters = amcl(&lines).unwrap();
    assert_eq!(parameters.warnings, Vec::<String>::new());
    let expected = BeamModelSettings {
        z_short: 0.2,
        lambda_short: 0.3,
        z_hit: 0.7,
        ..BeamModelSettings::default()
    };
    assert_eq!(parameters.mcl.sensor, SensorSettings::Beam(expected));
}

#[test]
fn alphas_keep_their_meaning() {
    let lines = ["alpha1: 0.1", "alpha2: 0.3", "alpha4: 0.4", "alpha5: 0.5"];
    let (alpha1, alpha2, alpha3, alpha4) = (0.1, 0.3, 0.2, 0.4);
    let drive = MotionSettings::Differential(OdometryNoise { alpha1, alpha2, alpha3, alpha4 });
    assert_eq!(amcl(&lines).unwrap().mcl.motion, drive);
    let omni = [&lines[..], &["robot_model_type: nav2_amcl::OmniMotionModel"]].concat();
    let noise = OmnidirectionalNoise { alpha1, alpha2, alpha3, alpha4, alpha5: 0.5 };
    assert_eq!(amcl(&omni).unwrap().mcl.motion, MotionSettings::Omnidirectional(noise));
}

/// Every parameter of nav2_amcl and of Beluga, at a value that asks for something.
const EVERY: [(&str, &str); 55] = [
    ("alpha1", "0.1"),
    ("alpha2", "0.1"),
    ("alpha3", "0.1"),
    ("alpha4", "0.1"),
    ("alpha5", "0.1"),
    ("robot_model_type", "nav2_amcl::OmniMotionModel"),
    ("min_particles", "400"),
    ("max_particles", "700"),
    ("pf_err", "0.06"),
    ("pf_z", "0.9"),
    ("resample_interval", "2"),
    ("recovery_alpha_slow", "0.001"),
    ("recovery_alpha_fast", "0.1"),
    ("update_min_d", "0.3"),
    ("update_min_a", "0.3"),
    ("random_seed", "5"),
    ("laser_model_type", "likelihood_field"),
    ("max_beams", "30"),
    ("laser_min_range", "0.1"),
    ("laser_max_range", "50.0"),
    ("laser_likelihood_max_dist", "2.5"),
    ("sigma_hit", "0.3"),
    ("z_hit", "0.6"),
    ("z_rand", "0.4"),
    ("z_max", "0.06"),
    ("z_short", "0.06"),
    ("lambda_short", "0.2"),
    ("do_beamskip", "true"),
    ("beam_skip_distance", "0.6"),
    ("beam_skip_threshold", "0.4"),
    ("beam_skip_error_threshold", "0.8"),
    ("base_frame_id", "base_footprint"),
    ("odom_frame_id", "odom"),
    ("global_frame_id", "map"),
    ("scan_topic", "scan"),
    ("map_topic", "map"),
    ("transform_tolerance", "1.0"),
    ("tf_broadcast", "true"),
    ("set_initial_pose", "true"),
    ("initial_pose.x", "1.0"),
    ("initial_pose.y", "1.0"),
    ("initial_pose.z", "1.0"),
    ("initial_pose.yaw", "1.0"),
    ("always_reset_initial_pose", "true"),
    ("first_map_only", "true"),
    ("selective_resampling", "true"),
    ("spatial_resolution_x", "0.4"),
    ("spatial_resolution_y", "0.4"),
    ("spatial_resolution_theta", "0.17"),
    ("execution_policy", "seq"),
    ("model_unknown_space", "true"),
    ("initial_pose.covariance_x", "0.25"),
    ("initial_pose.covariance_yaw", "0.07"),
    ("initial_pose.covariance_xy", "0.01"),
    ("save_pose_rate", "0.5"),
];

#[test]
fn every_parameter_does_something_or_is_named() {
    // What these do shows only together with another one.
    let together = [
        ("alpha5", "robot_model_type: omnidirectional"),
        ("recovery_alpha_slow", "recovery_alpha_fast: 0.1"),
        ("recovery_alpha_fast", "recovery_alpha_slow: 0.001"),
        ("initial_pose.x", "set_initial_pose: true"),
        ("initial_pose.y", "set_initial_pose: true"),
        ("initial_pose.yaw", "set_initial_pose: true"),
        ("z_max", "laser_model_type: beam"),
        ("z_short", "laser_model_type: beam"),
        ("lambda_short", "laser_model_type: beam"),
        ("beam_skip_distance", "do_beamskip: true"),
        ("beam_skip_threshold", "do_beamskip: true"),
        ("beam_skip_error_threshold", "do_beamskip: true"),
        // One thread is the default.
        ("execution_policy", "execution_policy: par"),
    ];
    for (key, value) in EVERY {
        let other =
            together.iter().find(|(known, _)| *known == key).map_or("", |(_, other)| *other);
        if other.starts_with(key) {
            assert!(amcl(&[other]).unwrap().warnings.is_empty());
            continue;
        }
        let line = format!("{key}: {value}");
        let without = amcl(&[other, "max_beams: 60"]).unwrap();
        let with = amcl(&[other, "max_beams: 60", &line.replace("max_beams: 30", "sigma_hit: 9")]);
        let with = with.unwrap_or_else(|error| panic!("{key}: {error}"));
        let named = with.warnings.iter().any(|warning| warning.contains(&format!(" {key}: ")));
        assert!(!with.warnings.iter().any(|warning| warning.contains("known here")), "{key}");
        assert!(named || with != without, "{key} is dropped in silence");
    }
}

#[test]
fn unknown_parameters_are_named_with_their_line() {
    let parameters = amcl(&["max_particles: 800", "laser_importance: 3", "qos: {depth: 1}"]);
    assert_eq!(
        parameters.unwrap().warnings,
        [
            "amcl.yaml:4: laser_importance: not a parameter of amcl that is known here",
            "amcl.yaml:5: qos.depth: not a parameter of amcl that is known here",
        ]
    );
}

#[test]
fn the_node_is_found_whatever_stands_around_it() {
    let count = |text: &str| parse(text).map(|parameters| parameters.mcl.particles.max_particles);
    let own = "ros__parameters: {max_particles: 77}";
    for text in [
        format!("/amcl:\n  {own}\n"),
        format!("/robot1/amcl:\n  {own}\n"),
        format!("robot1:\n  amcl:\n    {own}\n"),
        format!("/**:\n  {own}\n"),
        format!("/**:\n  amcl:\n    {own}\n"),
        format!("localizer_7:\n  {own}\n"),
        format!("bt_navigator:\n  ros__parameters: {{foo: 1}}\namcl:\n  {own}\nother: 3\n"),
        // A node's own parameter goes before that of all nodes, whichever comes first.
        format!("amcl:\n  {own}\n/**:\n  ros__parameters: {{max_particles: 5}}\n"),
    ] {
        assert_eq!(count(&text), Ok(77), "{text}");
    }
    let others = "controller:\n  ros__parameters: {a: 1}\nplanner:\n  ros__parameters: {a: 1}\n";
    let expected = "amcl.yaml: expected `amcl:` and below it `ros__parameters:`, got ";
    assert_eq!(count(others), Err(format!("{expected}/controller, /planner")));
    assert_eq!(count("amcl: {max_particles: 3}\n"), Err(format!("{expected}no node")));
    assert_eq!(count(""), Err(format!("{expected}no node")));
}

#[test]
fn what_the_file_leaves_out_keeps_its_default() {
    let parameters = amcl(&["{}"]).unwrap();
    assert_eq!(parameters, AmclParameters::default());
    assert_eq!(parameters.mcl, MclSettings::default());
}

#[test]
fn wrong_values_name_line_and_key() {
    for (line, message) in [
        ("max_particles: many", "max_particles: expected a whole number >= 1, got the text `many`"),
        ("max_particles: 10.5", "max_particles: expected a whole number >= 1, got `10.5`"),
        ("max_particles: 0", "max_particles: expected a whole number >= 1, got `0`"),
        ("max_particles: [1, 2]", "max_particles: expected a whole number >= 1, got a list"),
        ("max_particles:", "max_particles: expected a whole number >= 1, got nothing"),
        ("alpha1: -0.2", "alpha1: expected a number >= 0, got `-0.2`"),
        ("alpha1: \"0.2\"", "alpha1: expected a number >= 0, got the text `0.2`"),
        ("sigma_hit: 0", "sigma_hit: expected metres > 0, got `0`"),
        ("do_beamskip: 1", "do_beamskip: expected true or false, got `1`"),
        (
            "laser_model_type: sonar",
            "laser_model_type: expected one of likelihood_field, likelihood_field_prob, beam, got \
             the text `sonar`",
        ),
        ("laser_max_range: far", "laser_max_range: expected metres, or -1, got the text `far`"),
        ("recovery_alpha_slow: 2", "recovery_alpha_slow: expected a share from 0 to 1, got `2`"),
    ] {
        let error = amcl(&["# a comment", line]).unwrap_err();
        assert_eq!(error, format!("amcl.yaml: line 4: {message}"));
    }
    let error = amcl(&["max_particles: 10", "min_particles: 20"]).unwrap_err();
    assert!(
        error.starts_with("amcl.yaml: max_particles: expected at least min_particles"),
        "{error}"
    );
    for text in ["amcl:\n  ros__parameters: {a: [1\n", "amcl: {ros__parameters: {alpha1: .nan}}\n"]
    {
        let error = parse(text).unwrap_err();
        assert!(error.starts_with("amcl.yaml: line "), "{error}");
    }
}
