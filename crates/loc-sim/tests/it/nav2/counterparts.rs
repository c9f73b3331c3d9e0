//! What the parameters are here.

use super::amcl;
use loc_core::Pose2;
use loc_core::motion::OdometryNoise;
use loc_maps::likelihood_field::UnknownSpace;
use loc_pf::adaptive::KldCertainty;
use loc_pf::mcl::{FieldSettings, MotionSettings, SensorSettings, Weighting};
use loc_pf::motion::OmnidirectionalNoise;
use loc_pf::recovery::AugmentedSettings;
use loc_pf::resample::ResampleWhen;
use loc_pf::sensor::{BeamModelSettings, BeamSkip};
use loc_pf::{MclSettings, ResamplePolicy};

const NONE: [&str; 0] = [];

/// The settings, and the warnings.
fn settings(lines: &[&str]) -> (MclSettings, Vec<String>) {
    let parameters = amcl(lines).unwrap();
    (parameters.mcl, parameters.warnings)
}

fn field_of(mcl: &MclSettings) -> FieldSettings {
    let SensorSettings::LikelihoodField(field) = mcl.sensor else { panic!("{:?}", mcl.sensor) };
    field
}

#[test]
fn start_seed_steps_and_threads() {
    let parameters = amcl(&[
        "random_seed: 7",
        "update_min_d: 0.5",
        "update_min_a: 0.4",
        "execution_policy: seq",
        "set_initial_pose: true",
        "initial_pose: {x: 1.0, y: -2, yaw: 0.5, covariance_x: 0.25, covariance_yaw: 0.01}",
    ])
    .unwrap();
    assert_eq!(parameters.warnings, NONE);
    assert_eq!(parameters.seed, Some(7));
    assert_eq!(parameters.start, Some(Pose2::new(1.0, -2.0, 0.5)));
    assert_eq!(parameters.start_sigmas, [Some(0.5), None, Some(0.1)]);
    let mcl = &parameters.mcl;
    assert_eq!((mcl.update_distance, mcl.update_turn, mcl.threads), (0.5, 0.4, 1));
}

#[test]
fn alphas_are_those_of_the_drive() {
    let all = ["alpha1: 0.1", "alpha2: 0.3", "alpha3: 0.4", "alpha4: 0.5"];
    let (mcl, warnings) = settings(&all);
    let noise = OdometryNoise { alpha1: 0.1, alpha2: 0.3, alpha3: 0.4, alpha4: 0.5 };
    assert_eq!((mcl.motion, warnings.len()), (MotionSettings::Differential(noise), 0));

    let omni = "robot_model_type: nav2_amcl::OmniMotionModel";
    let (mcl, warnings) = settings(&[&all[..], &["alpha5: 0.6", omni]].concat());
    let (alpha1, alpha2, alpha3, alpha4, alpha5) = (0.1, 0.3, 0.4, 0.5, 0.6);
    let noise = OmnidirectionalNoise { alpha1, alpha2, alpha3, alpha4, alpha5 };
    assert_eq!((mcl.motion, warnings.len()), (MotionSettings::Omnidirectional(noise), 0));

    // nav2_amcl's 0.2 for those that are left out ..
    let (mcl, _) = settings(&["alpha3: 0.4"]);
    let noise = OdometryNoise { alpha1: 0.2, alpha2: 0.2, alpha3: 0.4, alpha4: 0.2 };
    assert_eq!(mcl.motion, MotionSettings::Differential(noise));
    let (mcl, _) = settings(&["robot_model_type: omnidirectional_drive"]);
    assert_eq!(mcl.motion, MotionSettings::Omnidirectional(OmnidirectionalNoise::default()));
    // .. but where nothing is said about noise, it is the project's.
    let (mcl, warnings) = settings(&["alpha5: 0.1"]);
    assert_eq!(mcl.motion, MclSettings::default().motion);
    assert_eq!(warnings, ["amcl.yaml:3: alpha5: only a drive that moves sideways has it"]);
}

#[test]
fn particles_follow_kld_sampling() {
    let (mcl, warnings) = settings(&[
        "min_particles: 200",
        "max_particles: 3000",
        "pf_err: 0.02",
        "pf_z: 0.95",
        "spatial_resolution_x: 0.2",
        "spatial_resolution_y: 0.2",
        "spatial_resolution_theta: 0.1",
    ]);
    assert_eq!(warnings, NONE);
    let kld = mcl.particles;
    assert_eq!((kld.min_particles, kld.max_particles, kld.error), (200, 3000, 0.02));
    assert_eq!((kld.bin_position, kld.bin_heading), (0.2, 0.1));
    // A probability, which nav2_amcl takes for the quantile itself.
    assert_eq!(kld.certainty, KldCertainty::Confidence(0.95));
    assert_eq!(settings(&["pf_z: 2.33"]).0.particles.certainty, KldCertainty::Quantile(2.33));

    let bounds = |line: &str| {
        let kld = settings(&[line]).0.particles;
        (kld.min_particles, kld.max_particles)
    };
    assert_eq!(bounds("max_particles: 77"), (77, 77));
    assert_eq!(bounds("min_particles: 9000"), (9000, 9000));

    let (mcl, warnings) = settings(&["spatial_resolution_x: 0.2", "spatial_resolution_y: 0.3"]);
    assert_eq!(mcl.particles.bin_position, 0.2);
    let square = "bins are square, with the finer of the two resolutions";
    assert_eq!(warnings, [format!("amcl.yaml:4: spatial_resolution_y: {square}")]);
}

#[test]
fn resampling_is_set_though_tempering_stays_on() {
    let (mcl, warnings) = settings(&["resample_interval: 3", "selective_resampling: true"]);
    let when = ResampleWhen::EffectiveShareBelow(0.5);
    assert_eq!(mcl.policy, ResamplePolicy { every: 3, when });
    assert!(mcl.tempering.is_some());
    assert_eq!(warnings.len(), 2);
    let (mcl, warnings) = settings(&["resample_interval: 1"]);
    assert_eq!(mcl.policy, ResamplePolicy { every: 1, when: ResampleWhen::Always });
    assert_eq!(warnings, NONE);
}

#[test]
fn recovery_takes_both_averages() {
    let both = ["recovery_alpha_slow: 0.002", "recovery_alpha_fast: 0.2"];
    let (mcl, warnings) = settings(&both);
    let expected = AugmentedSettings::default().alpha_slow(0.002).alpha_fast(0.2);
    assert_eq!((mcl.recovery.augmented, warnings.len()), (Some(expected), 0));
    let (mcl, warnings) = settings(&["recovery_alpha_slow: 0", "recovery_alpha_fast: 0.0"]);
    assert_eq!((mcl, warnings.len()), (MclSettings::default(), 0));
    let (mcl, warnings) = settings(&both[..1]);
    assert_eq!((mcl.recovery.augmented, warnings.len()), (None, 1));
    let error = amcl(&["recovery_alpha_slow: 0.1", "recovery_alpha_fast: 0.1"]).unwrap_err();
    let expected = "expected a share above recovery_alpha_slow (0.1), got `0.1`";
    assert_eq!(error, format!("amcl.yaml: line 4: recovery_alpha_fast: {expected}"));
}

#[test]
fn the_likelihood_field_has_the_values_of_nav2() {
    let (mcl, warnings) = settings(&[
        "laser_model_type: likelihood_field_prob",
        "max_beams: 90",
        "sigma_hit: 0.1",
        "z_hit: 0.9",
        "z_rand: 0.1",
        "laser_max_range: 20",
        "laser_min_range: 0.2",
        "laser_likelihood_max_dist: 1.5",
        "model_unknown_space: true",
        "do_beamskip: true",
        "beam_skip_threshold: 0.4",
    ]);
    assert_eq!(warnings, NONE);
    assert_eq!((mcl.beams, mcl.robot.laser_min_range, mcl.robot.laser_max_range), (90, 0.2, 20.0));
    let FieldSettings { field, weighting, beam_skip, .. } = field_of(&mcl);
    assert_eq!((field.sigma_hit, field.z_rand, field.max_range), (0.1, 0.1, 20.0));
    assert_eq!(field.max_distance, 1.5);
    assert_eq!(field.unknown_space, UnknownSpace::Likelihood(0.05));
    // z_hit exp(-1/2) + z_rand / max_range at a distance of sigma_hit, without the normaliser.
    let expected = 0.9 * (-0.5_f64).exp() + 0.1 / 20.0;
    approx::assert_relative_eq!(field.likelihood(0.1), expected, epsilon = 1e-12);
    assert_eq!(weighting, Weighting::Product);
    assert_eq!(beam_skip, Some(BeamSkip::default().threshold(0.4)));
}

#[test]
fn negative_ranges_are_the_sensors_own() {
    let (mcl, warnings) = settings(&["laser_min_range: -1.0", "laser_max_range: -1"]);
    assert_eq!((mcl, warnings.len()), (MclSettings::default(), 0));
}

#[test]
fn cubes_are_not_added_up_and_beams_not_skipped() {
    let skipping = "do_beamskip: true";
    let (mcl, warnings) = settings(&["laser_model_type: likelihood_field", skipping, "z_max: 0.1"]);
    let FieldSettings { weighting, beam_skip, .. } = field_of(&mcl);
    assert_eq!((weighting, beam_skip), (Weighting::Product, None));
    assert_eq!(warnings.len(), 3);
    assert!(warnings[0].contains("weighting=sum-of-cubes"), "{}", warnings[0]);
    assert!(warnings[1].ends_with("do_beamskip: only likelihood_field_prob skips beams"));
    assert!(warnings[2].ends_with("z_max: belongs to the beam model, which is not used"));
}

#[test]
fn the_beam_model_is_the_beam_model() {
    let (mcl, warnings) = settings(&[
        "laser_model_type: beam",
        "sigma_hit: 0.1",
        "z_hit: 0.8",
        "z_short: 0.1",
        "z_max: 0.04",
        "z_rand: 0.06",
        "lambda_short: 0.3",
        "laser_max_range: 30.0",
        "laser_likelihood_max_dist: 2.0",
    ]);
    let reason = "belongs to the likelihood field, which is not used";
    assert_eq!(warnings, [format!("amcl.yaml:11: laser_likelihood_max_dist: {reason}")]);
    let SensorSettings::Beam(beam) = mcl.sensor else { panic!("{:?}", mcl.sensor) };
    let expected = BeamModelSettings::default()
        .z_hit(0.8)
        .z_short(0.1)
        .z_max(0.04)
        .z_rand(0.06)
        .sigma_hit(0.1)
        .lambda_short(0.3)
        .max_range(30.0);
    assert_eq!(beam, expected);
}
