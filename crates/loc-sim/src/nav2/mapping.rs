//! What each parameter of nav2_amcl is here. A new setting of the filter is honoured by changing
//! the lines of its parameters in this file, or in `laser.rs`.

use super::AmclParameters;
use super::given::{Found, Given};
use crate::Result;
use loc_core::Pose2;
use loc_core::motion::OdometryNoise;
use loc_pf::adaptive::KldCertainty;
use loc_pf::mcl::MotionSettings;
use loc_pf::motion::OmnidirectionalNoise;
use loc_pf::policy::ResampleWhen;
use loc_pf::recovery::AugmentedSettings;

pub(super) fn map(mut given: Given) -> Result<AmclParameters> {
    let mut parameters = AmclParameters::default();
    motion(&mut given, &mut parameters)?;
    particles(&mut given, &mut parameters)?;
    resampling(&mut given, &mut parameters)?;
    recovery(&mut given, &mut parameters)?;
    super::laser::laser(&mut given, &mut parameters)?;
    start(&mut given, &mut parameters)?;
    ros(&mut given);
    execution(&mut given, &mut parameters)?;
    parameters.mcl.validate().map_err(|error| given.error(&error))?;
    parameters.warnings = given.into_warnings();
    Ok(parameters)
}

/// Thresholds of an update, and the noise of the odometry. A file that says anything about the
/// noise asks for nav2's model, whose alphas are 0.2 where it leaves them out.
fn motion(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    let mcl = &mut parameters.mcl;
    let mut threshold = |key, unit: &str| given.number(key, unit, |v| v >= 0.0);
    let distance = threshold("update_min_d", "metres >= 0")?;
    let turn = threshold("update_min_a", "radians >= 0")?;
    mcl.update_distance = distance.map_or(mcl.update_distance, |found| found.value);
    mcl.update_turn = turn.map_or(mcl.update_turn, |found| found.value);
    let models = [
        ("nav2_amcl::DifferentialMotionModel", false),
        ("nav2_amcl::OmniMotionModel", true),
        ("differential", false),
        ("omnidirectional", true),
        ("differential_drive", false),
        ("omnidirectional_drive", true),
    ];
    let sideways = given.choice("robot_model_type", &models)?.map(|found| found.value);
    let mut alpha = |key| given.number(key, "a number >= 0", |v| v >= 0.0);
    let alphas = [alpha("alpha1")?, alpha("alpha2")?, alpha("alpha3")?, alpha("alpha4")?];
    // Without a drive that moves sideways, nav2_amcl has no use for it either.
    let alpha5 = alpha("alpha5")?;
    if sideways.is_none() && alphas.iter().all(Option::is_none) {
        return Ok(());
    }
    let [alpha1, alpha2, alpha3, alpha4] = alphas.map(|found| found.map_or(0.2, |f| f.value));
    mcl.motion = if sideways == Some(true) {
        let alpha5 = alpha5.map_or(0.2, |found| found.value);
        let noise = OmnidirectionalNoise { alpha1, alpha2, alpha3, alpha4, alpha5 };
        MotionSettings::Omnidirectional(noise)
    } else {
        MotionSettings::Differential(OdometryNoise { alpha1, alpha2, alpha3, alpha4 })
    };
    Ok(())
}

/// How many particles (KLD). `pf_z` is what it is meant to be, a probability; nav2_amcl itself
/// takes it for the quantile of the normal distribution, as is done here for numbers that are no
/// probability.
fn particles(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    let kld = &mut parameters.mcl.particles;
    let count = |found: Found<i64>| usize::try_from(found.value).unwrap_or(usize::MAX);
    let least = given.integer("min_particles", 1)?.map(count);
    let most = given.integer("max_particles", 1)?.map(count);
    kld.max_particles =
        most.or(least.filter(|n| *n > kld.max_particles)).unwrap_or(kld.max_particles);
    kld.min_particles = least.unwrap_or(kld.min_particles.min(kld.max_particles));
    let mut positive = |key: &str| given.number(key, "a number > 0", |v| v > 0.0);
    kld.error = positive("pf_err")?.map_or(kld.error, |found| found.value);
    if let Some(Found { value, .. }) = positive("pf_z")? {
        let probability = value < 1.0;
        kld.certainty = if probability {
            KldCertainty::Confidence(value)
        } else {
            KldCertainty::Quantile(value)
        };
    }
    let [x, y] = [positive("spatial_resolution_x")?, positive("spatial_resolution_y")?];
    let theta = positive("spatial_resolution_theta")?;
    kld.bin_position = x.or(y).map_or(kld.bin_position, |found| found.value);
    kld.bin_heading = theta.map_or(kld.bin_heading, |found| found.value);
    if let (Some(x), Some(y)) = (x, y)
        && (x.value - y.value).abs() > 0.0
    {
        given.warn(y.line, "spatial_resolution_y", "bins are as wide in y as in x");
    }
    Ok(())
}

/// When particles are drawn, which a tempered update decides by itself.
fn resampling(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    let reason = "tempering draws particles when it needs to; only the plain filter heeds this";
    let policy = &mut parameters.mcl.policy;
    if let Some(every) = given.integer("resample_interval", 1)? {
        policy.every = usize::try_from(every.value).unwrap_or(usize::MAX);
        if every.value > 1 {
            given.warn(every.line, "resample_interval", reason);
        }
    }
    if let Some(selective) = given.flag("selective_resampling")? {
        let half = ResampleWhen::EffectiveShareBelow(0.5);
        policy.when = if selective.value { half } else { ResampleWhen::Always };
        given.warn(selective.line, "selective_resampling", reason);
    }
    // Any negative seed means the clock, which this project never asks: --seed says.
    let seed = given.integer("random_seed", i64::MIN)?;
    parameters.seed = seed.and_then(|seed| u64::try_from(seed.value).ok());
    Ok(())
}

/// Random particles by the averages of the evidence, which are off where one of the two is 0.
fn recovery(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    let mut share = |key: &str| -> Result<Option<Found<f64>>> {
        let found = given.number(key, "a share from 0 to 1", |v| (0.0..=1.0).contains(&v))?;
        Ok(found.filter(|found| found.value > 0.0))
    };
    match (share("recovery_alpha_slow")?, share("recovery_alpha_fast")?) {
        (Some(slow), Some(fast)) => {
            let averages = AugmentedSettings { alpha_slow: slow.value, alpha_fast: fast.value };
            parameters.mcl.recovery.augmented = Some(averages);
        }
        (Some(slow), None) => {
            given.warn(slow.line, "recovery_alpha_slow", "nothing without recovery_alpha_fast");
        }
        (None, Some(fast)) => {
            given.warn(fast.line, "recovery_alpha_fast", "nothing without recovery_alpha_slow");
        }
        (None, None) => {}
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
        let or_zero = |found: Option<Found<f64>>| found.map_or(0.0, |f| f.value);
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

fn execution(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    if let Some(parallel) = given.choice("execution_policy", &[("seq", false), ("par", true)])? {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        parameters.mcl.threads = if parallel.value { cores } else { 1 };
    }
    Ok(())
}
