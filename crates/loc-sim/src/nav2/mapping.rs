//! What each parameter of nav2_amcl is here. A new setting of the filter is honoured by changing
//! the lines of its parameters in this file.

use super::AmclParameters;
use super::given::Given;
use crate::Result;
use loc_core::Pose2;
use loc_maps::likelihood_field::UnknownSpace;

/// Steps between updates that the defaults of nav2_amcl make: [m, rad].
const NAV2_STEP: [f64; 2] = [0.25, 0.2];

/// The shortest step that noise is converted for: [m, rad].
const SHORTEST_STEP: [f64; 2] = [0.05, 0.05];

pub(super) fn map(mut given: Given) -> Result<AmclParameters> {
    let mut parameters = AmclParameters::default();
    motion(&mut given, &mut parameters)?;
    particles(&mut given, &mut parameters)?;
    laser(&mut given, &mut parameters)?;
    beam_skipping(&mut given)?;
    start(&mut given, &mut parameters)?;
    ros(&mut given);
    beluga(&mut given, &mut parameters)?;
    parameters.mcl.validate().map_err(|error| given.error(&error))?;
    parameters.warnings = given.into_warnings();
    Ok(parameters)
}

/// Noise of the odometry. nav2_amcl gives variances per squared motion of a step, this project
/// per motion, which does not depend on how long steps are; the two agree for steps of
/// `update_min_d` and `update_min_a`.
fn motion(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    let threshold = |v: f64| v >= 0.0;
    let distance = given.number("update_min_d", "metres >= 0", threshold)?;
    let turn = given.number("update_min_a", "radians >= 0", threshold)?;
    let mcl = &mut parameters.mcl;
    mcl.update_distance = distance.map_or(mcl.update_distance, |found| found.value);
    mcl.update_turn = turn.map_or(mcl.update_turn, |found| found.value);
    let step = distance.map_or(NAV2_STEP[0], |found| found.value).max(SHORTEST_STEP[0]);
    let turn_step = turn.map_or(NAV2_STEP[1], |found| found.value).max(SHORTEST_STEP[1]);

    let sideways = given.choice(
        "robot_model_type",
        &[
            ("nav2_amcl::DifferentialMotionModel", false),
            ("nav2_amcl::OmniMotionModel", true),
            ("differential", false),
            ("omnidirectional", true),
            ("differential_drive", false),
            ("omnidirectional_drive", true),
        ],
    )?;
    let sideways = sideways.is_some_and(|found| found.value);
    let mut alpha = |key| given.number(key, "a number >= 0", |v| v >= 0.0);
    let noise = &mut mcl.motion;
    if let Some(turn) = alpha("alpha1")? {
        noise.turn = (turn.value * turn_step).sqrt();
    }
    if let Some(drift) = alpha("alpha2")? {
        // A differential drive is turned before the way, which leads it astray, and after it.
        let turns = if sideways { 1.0 } else { 2.0 };
        noise.drift = (turns * drift.value * step).sqrt();
        noise.across = if sideways { noise.across } else { (drift.value * step.powi(3)).sqrt() };
    }
    if let Some(along) = alpha("alpha3")? {
        noise.along = (along.value * step).sqrt();
        noise.fault_probability = 0.0;
    }
    if let Some(pivot) = alpha("alpha4")? {
        noise.pivot = (pivot.value * turn_step).sqrt();
    }
    if let Some(across) = alpha("alpha5")?.filter(|_| sideways) {
        noise.across = (across.value * step).sqrt();
    }
    Ok(())
}

fn particles(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    let least = given.integer("min_particles", 1)?;
    let most = given.integer("max_particles", 1)?;
    if let Some(most) = most {
        parameters.mcl.particles = usize::try_from(most.value).unwrap_or(usize::MAX);
    }
    if let Some(least) = least {
        if let Some(most) = most.filter(|most| most.value < least.value) {
            let (least, most, line) = (least.value, most.value, most.line);
            let message = format!("line {line}: expected max_particles >= {least}, got {most}");
            return Err(given.error(&message));
        }
        given.warn(least.line, "min_particles", "the number of particles is max_particles");
    }
    for key in ["pf_err", "pf_z"] {
        if let Some(found) = given.number(key, "a number > 0", |v| v > 0.0)? {
            given.warn(found.line, key, "the number of particles is max_particles");
        }
    }
    if let Some(every) = given.integer("resample_interval", 1)?.filter(|every| every.value > 1) {
        given.warn(every.line, "resample_interval", "particles are drawn when they need to be");
    }
    for key in ["recovery_alpha_slow", "recovery_alpha_fast"] {
        let found = given.number(key, "a share from 0 to 1", |v| (0.0..=1.0).contains(&v))?;
        if let Some(found) = found.filter(|found| found.value > 0.0) {
            given.warn(found.line, key, "recovery is not by these averages");
        }
    }
    // Any negative seed means the clock, which this project never asks: --seed says.
    let seed = given.integer("random_seed", i64::MIN)?;
    parameters.seed = seed.and_then(|seed| u64::try_from(seed.value).ok());
    Ok(())
}

/// The laser. The Gaussian of nav2_amcl's likelihood field lacks its normaliser, so that its
/// `z_hit` is another share than here.
fn laser(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    let models = [("likelihood_field", 0), ("likelihood_field_prob", 1), ("beam", 2)];
    match given.choice("laser_model_type", &models)? {
        Some(model) if model.value == 0 => {
            let reason = "likelihoods are multiplied, not added up as their cubes";
            given.warn(model.line, "laser_model_type", reason);
        }
        Some(model) if model.value == 2 => {
            let reason = "the likelihood field takes the place of the beam model";
            given.warn(model.line, "laser_model_type", reason);
            for key in ["z_max", "z_short", "lambda_short"] {
                given.pass_over(key, "belongs to the beam model, which is not used");
            }
        }
        _ => given.without_effect(&["z_max", "z_short", "lambda_short"]),
    }
    let field = &mut parameters.mcl.field;
    let mut positive = |key, unit: &str| -> Result<Option<f64>> {
        let found = given.number(key, &format!("{unit} > 0"), |v| v > 0.0)?;
        Ok(found.map(|found| found.value))
    };
    field.sigma_hit = positive("sigma_hit", "metres")?.unwrap_or(field.sigma_hit);
    let farthest = positive("laser_likelihood_max_dist", "metres")?;
    field.max_distance = farthest.unwrap_or(field.max_distance);
    field.z_rand = positive("z_rand", "a share")?.unwrap_or(field.z_rand);
    if let Some(share) = given.number("z_hit", "a share >= 0", |v| v >= 0.0)? {
        field.z_hit = share.value * field.sigma_hit * std::f64::consts::TAU.sqrt();
    }
    if let Some(beams) = given.integer("max_beams", 2)? {
        parameters.mcl.beams = usize::try_from(beams.value).unwrap_or(usize::MAX);
    }
    // Negative, and 0: what the sensor says.
    let mut range = |key| given.number(key, "metres, or -1", |_| true);
    let [least, most] = [range("laser_min_range")?, range("laser_max_range")?]
        .map(|found| found.map(|found| found.value).filter(|range| *range > 0.0));
    (parameters.min_range, parameters.max_range) = (least, most);
    field.max_range = most.unwrap_or(field.max_range);
    Ok(())
}

fn beam_skipping(given: &mut Given) -> Result<()> {
    let keys = ["beam_skip_distance", "beam_skip_threshold", "beam_skip_error_threshold"];
    match given.flag("do_beamskip")? {
        Some(skip) if skip.value => {
            given.warn(skip.line, "do_beamskip", "no beams are skipped");
            keys.iter().for_each(|key| given.pass_over(key, "no beams are skipped"));
        }
        _ => given.without_effect(&keys),
    }
    Ok(())
}

fn start(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    let mut number = |key: &str| given.number(&format!("initial_pose.{key}"), "a number", |_| true);
    let [x, y, yaw, z] = [number("x")?, number("y")?, number("yaw")?, number("z")?];
    let mut covariance = |key: &str| {
        given.number(&format!("initial_pose.covariance_{key}"), "a number >= 0", |v| v >= 0.0)
    };
    let variances = [covariance("x")?, covariance("y")?, covariance("yaw")?];
    parameters.start_sigmas = variances.map(|found| found.map(|found| found.value.sqrt()));
    if let Some(z) = z.filter(|z| z.value.abs() > 0.0) {
        given.warn(z.line, "initial_pose.z", "the robot drives in the plane");
    }
    for key in ["covariance_xy", "covariance_xyaw", "covariance_yyaw"] {
        let key = format!("initial_pose.{key}");
        let found = given.number(&key, "a number", |_| true)?;
        if let Some(found) = found.filter(|found| found.value.abs() > 0.0) {
            given.warn(found.line, &key, "the start pose has independent deviations");
        }
    }
    if given.flag("set_initial_pose")?.is_some_and(|set| set.value) {
        let or_zero = |found: Option<super::given::Found<f64>>| found.map_or(0.0, |f| f.value);
        parameters.start = Some(Pose2::new(or_zero(x), or_zero(y), or_zero(yaw)));
    }
    Ok(())
}

/// What only a running robot needs.
fn ros(given: &mut Given) {
    for key in ["base_frame_id", "odom_frame_id", "global_frame_id"] {
        given.pass_over(key, "a recording names no frames");
    }
    given.pass_over("scan_topic", "a recording has one laser");
    given.pass_over("map_topic", "the map comes from --map");
    for key in ["transform_tolerance", "tf_broadcast"] {
        given.pass_over(key, "nothing is broadcast");
    }
    given.pass_over("always_reset_initial_pose", "a run is never reset");
    given.pass_over("first_map_only", "a run has one map");
    given.pass_over("use_sim_time", "time is that of the recording");
    given.pass_over("save_pose_rate", "every pose is saved");
}

/// What Beluga adds to nav2_amcl.
fn beluga(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    if let Some(selective) = given.flag("selective_resampling")? {
        let reason = "particles are drawn when they need to be";
        given.warn(selective.line, "selective_resampling", reason);
    }
    for key in ["spatial_resolution_x", "spatial_resolution_y", "spatial_resolution_theta"] {
        given.pass_over(key, "the number of particles is max_particles");
    }
    if let Some(parallel) = given.choice("execution_policy", &[("seq", false), ("par", true)])? {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        parameters.mcl.threads = if parallel.value { cores } else { 1 };
    }
    if let Some(model) = given.flag("model_unknown_space")? {
        let field = &mut parameters.mcl.field;
        let nothing_known = UnknownSpace::Likelihood(1.0 / field.max_range);
        field.unknown_space = if model.value { nothing_known } else { UnknownSpace::ByDistance };
    }
    Ok(())
}
