//! What the parameters of nav2_amcl are for the particle filter, by groups. A new setting of the
//! filter is honoured by changing the lines of its parameters here.

use super::AmclParameters;
use crate::Result;
use loc_core::motion::OdometryNoise;
use loc_maps::likelihood_field::UnknownSpace;
use loc_pf::MclSettings;
use loc_pf::adaptive::{KldCertainty, KldSettings};
use loc_pf::mcl::{FieldSettings, MotionSettings, SensorSettings, Weighting};
use loc_pf::motion::OmnidirectionalNoise;
use loc_pf::recovery::AugmentedSettings;
use loc_pf::resample::ResampleWhen;
use loc_pf::sensor::{BeamModelSettings, BeamSkip};
use loc_ros::{Found, NodeParameters};

/// What an alpha is where the file names a model of the drive, or another alpha: nav2_amcl's.
const ALPHA: f64 = 0.2;

/// The models of the drive, by the names of nav2_amcl (also the old ones) and of Beluga, and whether
/// the drive moves sideways.
const MOTION_MODELS: [(&str, bool); 6] = [
    ("nav2_amcl::DifferentialMotionModel", false),
    ("nav2_amcl::OmniMotionModel", true),
    ("differential", false),
    ("omnidirectional", true),
    ("differential_drive", false),
    ("omnidirectional_drive", true),
];

/// Noise of the odometry, and when the filter updates. A file that says nothing about the noise keeps the project's own.
pub(super) fn motion(given: &mut NodeParameters, mcl: &mut MclSettings) -> Result<()> {
    let distance = given.number("update_min_d", "metres >= 0", |v| v >= 0.0)?;
    let turn = given.number("update_min_a", "radians >= 0", |v| v >= 0.0)?;
    mcl.update_distance = distance.map_or(mcl.update_distance, |found| found.value);
    mcl.update_turn = turn.map_or(mcl.update_turn, |found| found.value);

    let model = given.choice("robot_model_type", &MOTION_MODELS)?.map(|found| found.value);
    let sideways = model.unwrap_or(false);
    if !sideways {
        given.ignore(&["alpha5"], "only a drive that moves sideways has it");
    }
    let mut alpha = |key| -> Result<Option<f64>> {
        let found = given.number(key, "a number >= 0", |v| v >= 0.0)?;
        Ok(found.map(|found| found.value))
    };
    let alphas =
        [alpha("alpha1")?, alpha("alpha2")?, alpha("alpha3")?, alpha("alpha4")?, alpha("alpha5")?];
    if model.is_none() && alphas.iter().all(Option::is_none) {
        return Ok(());
    }
    let [alpha1, alpha2, alpha3, alpha4, alpha5] = alphas.map(|alpha| alpha.unwrap_or(ALPHA));
    mcl.motion = if sideways {
        let noise = OmnidirectionalNoise { alpha1, alpha2, alpha3, alpha4, alpha5 };
        MotionSettings::Omnidirectional(noise)
    } else {
        MotionSettings::Differential(OdometryNoise { alpha1, alpha2, alpha3, alpha4 })
    };
    Ok(())
}

/// Why keys of the plain filter change nothing.
const TEMPERED: &str =
    "only counts for a filter without tempering; this one draws at every update that needs it";

/// How many particles there are, when they are drawn, and by how many threads.
pub(super) fn particles(given: &mut NodeParameters, parameters: &mut AmclParameters) -> Result<()> {
    number_of_particles(given, &mut parameters.mcl.particles)?;
    bins(given, &mut parameters.mcl.particles)?;
    resampling(given, &mut parameters.mcl)?;
    if let Some(parallel) = given.choice("execution_policy", &[("seq", false), ("par", true)])? {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        parameters.mcl.threads = if parallel.value { cores } else { 1 };
    }
    if let Some(seed) = given.integer("random_seed", i64::MIN)? {
        parameters.seed = u64::try_from(seed.value).ok();
        if parameters.seed.is_none() {
            let reason = "the clock is never asked, the seed is that of --seed";
            given.warn(seed.line, "random_seed", reason);
        }
    }
    Ok(())
}

/// A bound that is left out gives way to the one that is given.
fn number_of_particles(given: &mut NodeParameters, kld: &mut KldSettings) -> Result<()> {
    let count = |found: Found<i64>| usize::try_from(found.value).unwrap_or(usize::MAX);
    let min = given.integer("min_particles", 1)?;
    let max = given.integer("max_particles", 1)?;
    if let (Some(min), Some(max)) = (min, max)
        && max.value < min.value
    {
        let (min, max, line) = (min.value, max.value, max.line);
        let message = format!("line {line}: expected max_particles >= {min}, got {max}");
        return Err(given.error(&message).into());
    }
    let own = (kld.min_particles, kld.max_particles);
    (kld.min_particles, kld.max_particles) = match (min.map(count), max.map(count)) {
        (Some(min), Some(max)) => (min, max),
        (Some(min), None) => (min, own.1.max(min)),
        (None, Some(max)) => (own.0.min(max), max),
        (None, None) => own,
    };
    Ok(())
}

/// What KLD-sampling goes by. `pf_z` is the confidence that it is meant to be, not the quantile
/// that nav2_amcl takes it for; a number from 1 on can only be a quantile.
fn bins(given: &mut NodeParameters, kld: &mut KldSettings) -> Result<()> {
    let mut positive = |key, unit: &str| given.number(key, &format!("{unit} > 0"), |v| v > 0.0);
    if let Some(error) = positive("pf_err", "a number")? {
        kld.error = error.value;
    }
    if let Some(Found { value: z, .. }) = positive("pf_z", "a number")? {
        let is_confidence = z < 1.0;
        kld.certainty =
            if is_confidence { KldCertainty::Confidence(z) } else { KldCertainty::Quantile(z) };
    }
    if let Some(heading) = positive("spatial_resolution_theta", "radians")? {
        kld.bin_heading = heading.value;
    }
    let x = positive("spatial_resolution_x", "metres")?;
    let y = positive("spatial_resolution_y", "metres")?;
    if let Some(finer) = [x, y].into_iter().flatten().map(|found| found.value).reduce(f64::min) {
        kld.bin_position = finer;
    }
    if let (Some(x), Some(y)) = (x, y)
        && (x.value < y.value || y.value < x.value)
    {
        let (key, line) = if x.value > y.value {
            ("spatial_resolution_x", x.line)
        } else {
            ("spatial_resolution_y", y.line)
        };
        given.warn(line, key, "bins are square, with the finer of the two resolutions");
    }
    Ok(())
}

/// nav2_amcl draws at every `resample_interval`-th update, Beluga with `selective_resampling` only
/// when less than half of the particles are effective.
fn resampling(given: &mut NodeParameters, mcl: &mut MclSettings) -> Result<()> {
    let every = given.integer("resample_interval", 1)?;
    let selective = given.flag("selective_resampling")?;
    if let Some(every) = every {
        mcl.policy.every = usize::try_from(every.value).unwrap_or(usize::MAX);
    }
    if every.is_some() || selective.is_some() {
        let is_selective = selective.is_some_and(|found| found.value);
        let half = ResampleWhen::EffectiveShareBelow(0.5);
        mcl.policy.when = if is_selective { half } else { ResampleWhen::Always };
    }
    if mcl.tempering.is_some() {
        if let Some(every) = every.filter(|every| every.value > 1) {
            given.warn(every.line, "resample_interval", TEMPERED);
        }
        if let Some(selective) = selective {
            given.warn(selective.line, "selective_resampling", TEMPERED);
        }
    }
    Ok(())
}

const RECOVERY_KEYS: [&str; 2] = ["recovery_alpha_slow", "recovery_alpha_fast"];

/// How the robot is found again: random particles by the two running averages; 0 switches them off, as in
/// nav2_amcl. The search of the whole map on suspicion stays on beside what the file says.
pub(super) fn recovery(given: &mut NodeParameters, mcl: &mut MclSettings) -> Result<()> {
    let share = |v: f64| (0.0..=1.0).contains(&v);
    let mut alpha = |key| given.number(key, "a share from 0 to 1", share);
    let [slow, fast] = [alpha(RECOVERY_KEYS[0])?, alpha(RECOVERY_KEYS[1])?];
    let on = |found: &Option<Found<f64>>| found.filter(|found| found.value > 0.0);
    match (on(&slow), on(&fast)) {
        (Some(slow), Some(fast)) if slow.value >= fast.value => {
            let (line, slow, fast) = (fast.line, slow.value, fast.value);
            let expected = format!("expected a share above {} ({slow})", RECOVERY_KEYS[0]);
            return Err(given
                .error(&format!("line {line}: {}: {expected}, got `{fast}`", RECOVERY_KEYS[1]))
                .into());
        }
        (Some(slow), Some(fast)) => {
            let settings =
                AugmentedSettings::default().alpha_slow(slow.value).alpha_fast(fast.value);
            mcl.recovery.augmented = Some(settings);
        }
        (Some(slow), None) => {
            given.warn(slow.line, RECOVERY_KEYS[0], "takes recovery_alpha_fast above 0");
        }
        (None, Some(fast)) => {
            given.warn(fast.line, RECOVERY_KEYS[1], "takes recovery_alpha_slow above 0");
        }
        (None, None) => {}
    }
    Ok(())
}

/// Keys of the likelihood field alone.
const OF_THE_FIELD: [&str; 2] = ["laser_likelihood_max_dist", "model_unknown_space"];

/// Keys of the beam model alone.
const OF_THE_BEAM_MODEL: [&str; 3] = ["z_max", "z_short", "lambda_short"];

/// Keys of beam skipping, which nav2_amcl has for `likelihood_field_prob` alone.
const OF_SKIPPING: [&str; 3] =
    ["beam_skip_distance", "beam_skip_threshold", "beam_skip_error_threshold"];

#[derive(Clone, Copy, PartialEq, Eq)]
enum SensorModel {
    Field,
    FieldProb,
    Beam,
}

const SENSOR_MODELS: [(&str, SensorModel); 3] = [
    ("likelihood_field", SensorModel::Field),
    ("likelihood_field_prob", SensorModel::FieldProb),
    ("beam", SensorModel::Beam),
];

/// The laser: which beams are used, and how they rate a pose.
pub(super) fn laser(given: &mut NodeParameters, mcl: &mut MclSettings) -> Result<()> {
    if let Some(beams) = given.integer("max_beams", 2)? {
        mcl.beams = usize::try_from(beams.value).unwrap_or(usize::MAX);
    }
    // Negative, and 0: what the sensor says.
    let mut range = |key| -> Result<Option<f64>> {
        let found = given.number(key, "metres, or -1", |_| true)?;
        Ok(found.map(|found| found.value).filter(|range| *range > 0.0))
    };
    mcl.robot.laser_min_range = range("laser_min_range")?.unwrap_or(mcl.robot.laser_min_range);
    let max_range = range("laser_max_range")?;
    mcl.robot.laser_max_range = max_range.unwrap_or(mcl.robot.laser_max_range);

    let model = given.choice("laser_model_type", &SENSOR_MODELS)?;
    let skip = match model.map(|found| found.value) {
        Some(SensorModel::FieldProb) => beam_skip(given)?,
        _ => no_beam_skip(given)?,
    };
    if model.is_some_and(|found| found.value == SensorModel::Beam) {
        given.ignore(&OF_THE_FIELD, "belongs to the likelihood field, which is not used");
        mcl.sensor = SensorSettings::Beam(beam_model(given, max_range)?);
        return Ok(());
    }
    if let Some(model) = model.filter(|found| found.value == SensorModel::Field) {
        let reason = "likelihoods are multiplied, not added up as their cubes; for those set \
                      filter.mcl.sensor.likelihood-field.weighting=sum-of-cubes";
        given.warn(model.line, "laser_model_type", reason);
    }
    given.ignore(&OF_THE_BEAM_MODEL, "belongs to the beam model, which is not used");
    mcl.sensor = SensorSettings::LikelihoodField(
        field(given, max_range)?.weighting(Weighting::Product).beam_skip(skip),
    );
    Ok(())
}

/// The likelihood field. The Gaussian of nav2_amcl lacks its normaliser, so that its `z_hit` is
/// another share than here.
fn field(given: &mut NodeParameters, max_range: Option<f64>) -> Result<FieldSettings> {
    let mut settings = FieldSettings::default();
    let field = &mut settings.field;
    field.max_range = max_range.unwrap_or(field.max_range);
    field.sigma_hit = positive(given, "sigma_hit", "metres")?.unwrap_or(field.sigma_hit);
    let max_distance = positive(given, "laser_likelihood_max_dist", "metres")?;
    field.max_distance = max_distance.unwrap_or(field.max_distance);
    field.z_rand = positive(given, "z_rand", "a share")?.unwrap_or(field.z_rand);
    if let Some(z_hit) = share(given, "z_hit")? {
        field.z_hit = z_hit;
        *field = field.unnormalised();
    }
    if let Some(model) = given.flag("model_unknown_space")? {
        let nothing_known = UnknownSpace::Likelihood(1.0 / field.max_range);
        field.unknown_space = if model.value { nothing_known } else { UnknownSpace::ByDistance };
    }
    Ok(settings)
}

/// The beam model, whose defaults are those of nav2_amcl; its shares are made to add up to 1.
fn beam_model(given: &mut NodeParameters, max_range: Option<f64>) -> Result<BeamModelSettings> {
    let own = BeamModelSettings::default();
    Ok(own
        .sigma_hit(positive(given, "sigma_hit", "metres")?.unwrap_or(own.sigma_hit))
        .z_hit(share(given, "z_hit")?.unwrap_or(own.z_hit))
        .z_short(share(given, "z_short")?.unwrap_or(own.z_short))
        .z_max(share(given, "z_max")?.unwrap_or(own.z_max))
        .z_rand(share(given, "z_rand")?.unwrap_or(own.z_rand))
        .lambda_short(positive(given, "lambda_short", "1/m")?.unwrap_or(own.lambda_short))
        .max_range(max_range.unwrap_or(own.max_range)))
}

/// Beams left out, if the file says so.
fn beam_skip(given: &mut NodeParameters) -> Result<Option<BeamSkip>> {
    if !given.flag("do_beamskip")?.is_some_and(|skip| skip.value) {
        given.ignore(&OF_SKIPPING, "do_beamskip is not true");
        return Ok(None);
    }
    let own = BeamSkip::default();
    let mut part = |key| -> Result<Option<f64>> {
        let allowed = |v: f64| (0.0..=1.0).contains(&v);
        Ok(given.number(key, "a share from 0 to 1", allowed)?.map(|found| found.value))
    };
    let [_, threshold, error_threshold] = OF_SKIPPING;
    let threshold = part(threshold)?.unwrap_or(own.threshold);
    let error_threshold = part(error_threshold)?.unwrap_or(own.error_threshold);
    let distance = positive(given, OF_SKIPPING[0], "metres")?.unwrap_or(own.distance);
    Ok(Some(
        BeamSkip::default()
            .distance(distance)
            .threshold(threshold)
            .error_threshold(error_threshold),
    ))
}

/// nav2_amcl skips no beams with the other models either.
fn no_beam_skip(given: &mut NodeParameters) -> Result<Option<BeamSkip>> {
    let skip = given.flag("do_beamskip")?;
    if let Some(skip) = skip.filter(|skip| skip.value) {
        given.warn(skip.line, "do_beamskip", "only likelihood_field_prob skips beams");
    }
    given.ignore(&OF_SKIPPING, "only likelihood_field_prob skips beams");
    Ok(None)
}

fn positive(given: &mut NodeParameters, key: &str, unit: &str) -> Result<Option<f64>> {
    let found = given.number(key, &format!("{unit} > 0"), |v| v > 0.0)?;
    Ok(found.map(|found| found.value))
}

fn share(given: &mut NodeParameters, key: &str) -> Result<Option<f64>> {
    let found = given.number(key, "a share >= 0", |v| v >= 0.0)?;
    Ok(found.map(|found| found.value))
}
