//! Noise of the odometry, and when the filter updates.

use crate::Result;
use crate::nav2::given::Given;
use loc_core::motion::OdometryNoise;
use loc_pf::MclSettings;
use loc_pf::mcl::MotionSettings;
use loc_pf::motion::OmnidirectionalNoise;

/// What an alpha is where the file names a model of the drive, or another alpha: nav2_amcl's.
const ALPHA: f64 = 0.2;

/// The models of the drive, by the names of nav2_amcl (also the old ones) and of Beluga, and whether
/// the drive moves sideways.
const MODELS: [(&str, bool); 6] = [
    ("nav2_amcl::DifferentialMotionModel", false),
    ("nav2_amcl::OmniMotionModel", true),
    ("differential", false),
    ("omnidirectional", true),
    ("differential_drive", false),
    ("omnidirectional_drive", true),
];

/// A file that says nothing about the noise keeps the project's own.
pub(super) fn motion(given: &mut Given, mcl: &mut MclSettings) -> Result<()> {
    let distance = given.number("update_min_d", "metres >= 0", |v| v >= 0.0)?;
    let turn = given.number("update_min_a", "radians >= 0", |v| v >= 0.0)?;
    mcl.update_distance = distance.map_or(mcl.update_distance, |found| found.value);
    mcl.update_turn = turn.map_or(mcl.update_turn, |found| found.value);

    let model = given.choice("robot_model_type", &MODELS)?.map(|found| found.value);
    let sideways = model.unwrap_or(false);
    if !sideways {
        given.pass_over(&["alpha5"], "only a drive that moves sideways has it");
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
