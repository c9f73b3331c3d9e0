//! The laser: which beams are used, and how they rate a pose.

use crate::Result;
use crate::nav2::given::Given;
use loc_maps::likelihood_field::UnknownSpace;
use loc_pf::MclSettings;
use loc_pf::mcl::{FieldSettings, SensorSettings, Weighting};
use loc_pf::sensor::{BeamModelSettings, BeamSkip};

/// Keys of the likelihood field alone.
const OF_THE_FIELD: [&str; 2] = ["laser_likelihood_max_dist", "model_unknown_space"];

/// Keys of the beam model alone.
const OF_THE_BEAM_MODEL: [&str; 3] = ["z_max", "z_short", "lambda_short"];

/// Keys of beam skipping, which nav2_amcl has for `likelihood_field_prob` alone.
const OF_SKIPPING: [&str; 3] =
    ["beam_skip_distance", "beam_skip_threshold", "beam_skip_error_threshold"];

#[derive(Clone, Copy, PartialEq, Eq)]
enum Model {
    Field,
    FieldProb,
    Beam,
}

const MODELS: [(&str, Model); 3] = [
    ("likelihood_field", Model::Field),
    ("likelihood_field_prob", Model::FieldProb),
    ("beam", Model::Beam),
];

pub(super) fn laser(given: &mut Given, mcl: &mut MclSettings) -> Result<()> {
    if let Some(beams) = given.integer("max_beams", 2)? {
        mcl.beams = usize::try_from(beams.value).unwrap_or(usize::MAX);
    }
    // Negative, and 0: what the sensor says.
    let mut range = |key| -> Result<Option<f64>> {
        let found = given.number(key, "metres, or -1", |_| true)?;
        Ok(found.map(|found| found.value).filter(|range| *range > 0.0))
    };
    mcl.min_range = range("laser_min_range")?.unwrap_or(mcl.min_range);
    let longest = range("laser_max_range")?;
    mcl.max_range = longest.unwrap_or(mcl.max_range);

    let model = given.choice("laser_model_type", &MODELS)?;
    let skip = match model.map(|found| found.value) {
        Some(Model::FieldProb) => beam_skip(given)?,
        _ => no_beam_skip(given)?,
    };
    if model.is_some_and(|found| found.value == Model::Beam) {
        given.pass_over(&OF_THE_FIELD, "belongs to the likelihood field, which is not used");
        mcl.sensor = SensorSettings::Beam(beam_model(given, longest)?);
        return Ok(());
    }
    if let Some(model) = model.filter(|found| found.value == Model::Field) {
        let reason = "likelihoods are multiplied, not added up as their cubes; for those set \
                      filter.mcl.sensor.likelihood-field.weighting=sum-of-cubes";
        given.warn(model.line, "laser_model_type", reason);
    }
    given.pass_over(&OF_THE_BEAM_MODEL, "belongs to the beam model, which is not used");
    mcl.sensor = SensorSettings::LikelihoodField(FieldSettings {
        weighting: Weighting::Product,
        beam_skip: skip,
        ..field(given, longest)?
    });
    Ok(())
}

/// The likelihood field. The Gaussian of nav2_amcl lacks its normaliser, so that its `z_hit` is
/// another share than here.
fn field(given: &mut Given, longest: Option<f64>) -> Result<FieldSettings> {
    let mut settings = FieldSettings::default();
    let field = &mut settings.field;
    field.max_range = longest.unwrap_or(field.max_range);
    field.sigma_hit = positive(given, "sigma_hit", "metres")?.unwrap_or(field.sigma_hit);
    let farthest = positive(given, "laser_likelihood_max_dist", "metres")?;
    field.max_distance = farthest.unwrap_or(field.max_distance);
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
fn beam_model(given: &mut Given, longest: Option<f64>) -> Result<BeamModelSettings> {
    let own = BeamModelSettings::default();
    Ok(BeamModelSettings {
        sigma_hit: positive(given, "sigma_hit", "metres")?.unwrap_or(own.sigma_hit),
        z_hit: share(given, "z_hit")?.unwrap_or(own.z_hit),
        z_short: share(given, "z_short")?.unwrap_or(own.z_short),
        z_max: share(given, "z_max")?.unwrap_or(own.z_max),
        z_rand: share(given, "z_rand")?.unwrap_or(own.z_rand),
        lambda_short: positive(given, "lambda_short", "1/m")?.unwrap_or(own.lambda_short),
        max_range: longest.unwrap_or(own.max_range),
        ..own
    })
}

/// Beams left out, if the file says so.
fn beam_skip(given: &mut Given) -> Result<Option<BeamSkip>> {
    if !given.flag("do_beamskip")?.is_some_and(|skip| skip.value) {
        given.pass_over(&OF_SKIPPING, "do_beamskip is not true");
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
    Ok(Some(BeamSkip { distance, threshold, error_threshold }))
}

/// nav2_amcl skips no beams with the other models either.
fn no_beam_skip(given: &mut Given) -> Result<Option<BeamSkip>> {
    let skip = given.flag("do_beamskip")?;
    if let Some(skip) = skip.filter(|skip| skip.value) {
        given.warn(skip.line, "do_beamskip", "only likelihood_field_prob skips beams");
    }
    given.pass_over(&OF_SKIPPING, "only likelihood_field_prob skips beams");
    Ok(None)
}

fn positive(given: &mut Given, key: &str, unit: &str) -> Result<Option<f64>> {
    let found = given.number(key, &format!("{unit} > 0"), |v| v > 0.0)?;
    Ok(found.map(|found| found.value))
}

fn share(given: &mut Given, key: &str) -> Result<Option<f64>> {
    let found = given.number(key, "a share >= 0", |v| v >= 0.0)?;
    Ok(found.map(|found| found.value))
}
