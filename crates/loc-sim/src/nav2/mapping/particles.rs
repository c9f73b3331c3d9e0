//! How many particles there are, when they are drawn, and by how many threads.

use crate::Result;
use crate::nav2::AmclParameters;
use crate::nav2::given::{Found, Given};
use loc_pf::MclSettings;
use loc_pf::adaptive::{KldCertainty, KldSettings};
use loc_pf::resample::ResampleWhen;

/// Why keys of the plain filter change nothing.
const BY_DEGREES: &str =
    "only counts for a filter without tempering; this one draws at every update that needs it";

pub(super) fn particles(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
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
fn number_of_particles(given: &mut Given, kld: &mut KldSettings) -> Result<()> {
    let count = |found: Found<i64>| usize::try_from(found.value).unwrap_or(usize::MAX);
    let least = given.integer("min_particles", 1)?;
    let most = given.integer("max_particles", 1)?;
    if let (Some(least), Some(most)) = (least, most)
        && most.value < least.value
    {
        let (least, most, line) = (least.value, most.value, most.line);
        let message = format!("line {line}: expected max_particles >= {least}, got {most}");
        return Err(given.error(&message));
    }
    let own = (kld.min_particles, kld.max_particles);
    (kld.min_particles, kld.max_particles) = match (least.map(count), most.map(count)) {
        (Some(least), Some(most)) => (least, most),
        (Some(least), None) => (least, own.1.max(least)),
        (None, Some(most)) => (own.0.min(most), most),
        (None, None) => own,
    };
    Ok(())
}

/// What KLD-sampling goes by. `pf_z` is the confidence that it is meant to be, not the quantile
/// that nav2_amcl takes it for; a number from 1 on can only be a quantile.
fn bins(given: &mut Given, kld: &mut KldSettings) -> Result<()> {
    let mut positive = |key, unit: &str| -> Result<Option<Found<f64>>> {
        given.number(key, &format!("{unit} > 0"), |v| v > 0.0)
    };
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
fn resampling(given: &mut Given, mcl: &mut MclSettings) -> Result<()> {
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
            given.warn(every.line, "resample_interval", BY_DEGREES);
        }
        if let Some(selective) = selective {
            given.warn(selective.line, "selective_resampling", BY_DEGREES);
        }
    }
    Ok(())
}
