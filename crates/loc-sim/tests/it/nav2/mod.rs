//! Parameter files of nav2_amcl.

mod counterparts;

use loc_pf::MclSettings;
use loc_sim::nav2::AmclParameters;

fn parse(text: &str) -> Result<AmclParameters, String> {
    AmclParameters::parse("amcl.yaml", text).map_err(|error| error.to_string())
}

/// Parameters of the node `amcl`, a line each.
fn amcl(lines: &[&str]) -> Result<AmclParameters, String> {
    let lines: String = lines.iter().map(|line| format!("    {line}\n")).collect();
    parse(&format!("amcl:\n  ros__parameters:\n{lines}"))
}

/// Every parameter of nav2_amcl and of Beluga, at a value that asks for something.
pub(crate) const EVERY: [(&str, &str); 55] = [
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

/// Whether a warning, `file:line: key, key: reason`, is about this parameter.
fn names(warning: &str, key: &str) -> bool {
    let keys = warning.split(": ").nth(1).unwrap_or_default();
    keys.split(", ").any(|name| name == key)
}

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
        let named = with.warnings.iter().any(|warning| names(warning, key));
        assert!(!with.warnings.iter().any(|warning| warning.contains("known here")), "{key}");
        assert!(named || with != without, "{key} is dropped in silence");
        let (alone, empty) = (amcl(&[&line]).unwrap(), amcl(&["{}"]).unwrap());
        let is_default = key == "execution_policy";
        assert!(is_default || alone != empty, "{key} alone is dropped in silence");
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
    assert_eq!(error, "amcl.yaml: line 3: expected max_particles >= 20, got 10");
    for text in ["amcl:\n  ros__parameters: {a: [1\n", "amcl: {ros__parameters: {alpha1: .nan}}\n"]
    {
        let error = parse(text).unwrap_err();
        assert!(error.starts_with("amcl.yaml: line "), "{error}");
    }
}
