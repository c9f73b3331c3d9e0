//! What the parameters of nav2_amcl about the laser are here.

use super::AmclParameters;
use super::given::Given;
use crate::Result;
use loc_maps::likelihood_field::UnknownSpace;
use loc_pf::mcl::{FieldSettings, SensorSettings};
use loc_pf::sensor::{BeamModelSettings, BeamSkip};

/// Which laser model nav2_amcl is told to use.
#[derive(Clone, Copy, PartialEq)]
enum Model {
    Field,
    FieldProduct,
    Beam,
}

pub(super) fn laser(given: &mut Given, parameters: &mut AmclParameters) -> Result<()> {
    let mcl = &mut parameters.mcl;
    if let Some(beams) = given.integer("max_beams", 2)? {
        mcl.beams = usize::try_from(beams.value).unwrap_or(usize::MAX);
    }
    // Negative, and 0: what the sensor says.
    let mut range = |key| -> Result<Option<f64>> {
        let found = given.number(key, "metres, or -1", |_| true)?;
        Ok(found.map(|found| found.value).filter(|range| *range > 0.0))
    };
    mcl.min_range = range("laser_min_range")?.unwrap_or(mcl.min_range);
    let max_range = range("laser_max_range")?;
    mcl.max_range = max_range.unwrap_or(mcl.max_range);
    let models = [
        ("likelihood_field", Model::Field),
        ("likelihood_field_prob", Model::FieldProduct),
        ("beam", Model::Beam),
    ];
    let model = given.choice("laser_model_type", &models)?;
    if model.is_some_and(|model| model.value == Model::Beam) {
        mcl.sensor = SensorSettings::Beam(beam_model(given, max_range)?);
        return Ok(());
    }
    if let Some(model) = model.filter(|model| model.value == Model::Field) {
        let reason = "likelihoods are multiplied; \
                      --set filter.mcl.sensor.likelihood-field.weighting=sum-of-cubes for 1 + sum p^3";
        given.warn(model.line, "laser_model_type", reason);
    }
    mcl.sensor = SensorSettings::LikelihoodField(field(given, max_range)?);
    Ok(())
}

/// The likelihood field. The Gaussian of nav2_amcl lacks its normaliser, so that its `z_hit` is
/// another share than here.
fn field(given: &mut Given, max_range: Option<f64>) -> Result<FieldSettings> {
    let mut settings = FieldSettings::default();
    let field = &mut settings.field;
    field.max_range = max_range.unwrap_or(field.max_range);
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
    if let Some(model) = given.flag("model_unknown_space")? {
        let nothing_known = UnknownSpace::Likelihood(1.0 / field.max_range);
        field.unknown_space = if model.value { nothing_known } else { UnknownSpace::ByDistance };
    }
    given.without_effect(&["z_max", "z_short", "lambda_short"]);
    if given.flag("do_beamskip")?.is_some_and(|skip| skip.value) {
        settings.beam_skip = Some(beam_skip(given)?);
    } else {
        let keys = ["beam_skip_distance", "beam_skip_threshold", "beam_skip_error_threshold"];
        given.without_effect(&keys);
    }
    Ok(settings)
}

fn beam_skip(given: &mut Given) -> Result<BeamSkip> {
    let mut skip = BeamSkip::default();
    if let Some(distance) = given.number("beam_skip_distance", "metres > 0", |v| v > 0.0)? {
        skip.distance = distance.value;
    }
    let mut share = |key, default: f64| -> Result<f64> {
        let found = given.number(key, "a share from 0 to 1", |v| (0.0..=1.0).contains(&v))?;
        Ok(found.map_or(default, |found| found.value))
    };
    skip.threshold = share("beam_skip_threshold", skip.threshold)?;
    skip.error_threshold = share("beam_skip_error_threshold", skip.error_threshold)?;
    Ok(skip)
}

/// The beam model, whose defaults are those of nav2_amcl.
fn beam_model(given: &mut Given, max_range: Option<f64>) -> Result<BeamModelSettings> {
    let defaults = BeamModelSettings::default();
    let mut share = |key, default: f64| -> Result<f64> {
        let found = given.number(key, "a number >= 0", |v| v >= 0.0)?;
        Ok(found.map_or(default, |found| found.value))
    };
    let settings = BeamModelSettings {
        form: defaults.form,
        z_hit: share("z_hit", defaults.z_hit)?,
        z_short: share("z_short", defaults.z_short)?,
        z_max: share("z_max", defaults.z_max)?,
        z_rand: share("z_rand", defaults.z_rand)?,
        sigma_hit: share("sigma_hit", defaults.sigma_hit)?,
        lambda_short: share("lambda_short", defaults.lambda_short)?,
        max_range: max_range.unwrap_or(defaults.max_range),
    };
    // nav2_amcl's beam model knows neither.
    given.without_effect(&["laser_likelihood_max_dist"]);
    let skipping =
        ["do_beamskip", "beam_skip_distance", "beam_skip_threshold", "beam_skip_error_threshold"];
    given.without_effect(&skipping);
    given.pass_over("model_unknown_space", "the beam model sees through unknown cells");
    Ok(settings)
}
