//! The landmark likelihood: by hand, and fast against plain.

use approx::assert_relative_eq;
use loc_core::random::stream;
use loc_core::{Normal, Pose2, angle};
use loc_maps::{Landmark, LandmarkMap};
use loc_pf::sensor::landmark::{LandmarkLikelihood, ObservationModel};
use loc_pf::{Likelihood, Particles};
use loc_sensors::landmark_camera::{LandmarkNoise, LandmarkObservation, Observed};
use rand::RngExt;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

fn map() -> LandmarkMap {
    let places = [(1, 3.0, 4.0), (2, -2.0, 1.0), (3, 0.0, -6.0)];
    LandmarkMap::new(places.map(|(id, x, y)| Landmark::planar(id, x, y))).unwrap()
}

fn model(outlier_share: f64) -> ObservationModel {
    let noise = LandmarkNoise { range_sigma: 0.1, range_sigma_per_m: 0.0, bearing_sigma: 0.05 };
    ObservationModel { noise, outlier_share, ..ObservationModel::default() }
}

fn likelihood(observations: &[(u32, Observed)], model: &ObservationModel) -> LandmarkLikelihood {
    let observations: Vec<LandmarkObservation> = observations
        .iter()
        .map(|&(landmark, observed)| LandmarkObservation { landmark, observed })
        .collect();
    LandmarkLikelihood::new(&map(), &observations, model).unwrap()
}

fn fast(likelihood: &LandmarkLikelihood, poses: &[Pose2]) -> Vec<f64> {
    let mut cloud = Particles::from_poses(poses.iter().copied());
    cloud.log_weights_mut().fill(0.25);
    let (poses, weights) = cloud.poses_and_log_weights();
    likelihood.rate(poses, weights);
    weights.iter().map(|weight| weight - 0.25).collect()
}

/// Landmark 1 lies 5 m away; seen 0.1 m too far (1 sigma) and 0.1 rad too far left (2 sigma).
#[test]
fn one_sighting_by_hand() {
    let bearing = 4_f64.atan2(3.0) + 0.1;
    let observed = Observed::RangeBearing { range: 5.1, bearing };
    // 1 / (2 pi 0.1 0.05) exp(-(1 + 4) / 2) = 31.83099 * 0.0820850 = 2.612847
    let seen = likelihood(&[(1, observed)], &model(0.0));
    assert_relative_eq!(seen.log_likelihood(Pose2::IDENTITY).exp(), 2.612847, epsilon = 1e-6);
    // A tenth of them lies anywhere in 10 m x 2 pi: 0.9 * 2.612847 + 0.1 / 62.83185 = 2.353154
    let seen = likelihood(&[(1, observed)], &model(0.1));
    assert_relative_eq!(seen.log_likelihood(Pose2::IDENTITY).exp(), 2.353154, epsilon = 1e-6);
    let trust = seen.trust(Pose2::IDENTITY).next().unwrap();
    assert_relative_eq!(trust.probability, 2.351562 / 2.353154, epsilon = 1e-6);
    let peak = 0.9 * 31.830_989 + 0.1 / 62.831_853;
    assert_relative_eq!(seen.log_peak().exp(), peak, epsilon = 1e-6);
}

#[test]
fn distance_and_direction_alone() {
    let range = likelihood(&[(3, Observed::Range { range: 5.8 })], &model(0.0));
    // Landmark 3 is 6 m away: two sigma short.
    let expected = Normal::new(6.0, 0.1).unwrap().log_density(5.8);
    assert_relative_eq!(range.log_likelihood(Pose2::IDENTITY), expected, epsilon = 1e-12);
    let turned = Pose2::new(0.0, 0.0, 2.0);
    assert_relative_eq!(range.log_likelihood(turned), expected, epsilon = 1e-12);
    let bearing = likelihood(&[(3, Observed::Bearing { bearing: -FRAC_PI_2 + 0.05 })], &model(0.0));
    let expected = Normal::new(0.0, 0.05).unwrap().log_density(0.05);
    assert_relative_eq!(bearing.log_likelihood(Pose2::IDENTITY), expected, epsilon = 1e-12);
    let nearer = Pose2::new(0.0, -4.0, 0.0);
    assert_relative_eq!(bearing.log_likelihood(nearer), expected, epsilon = 1e-12);
}

/// The landmark lies straight behind; seen on the other side of the cut at +-pi.
#[test]
fn directions_wrap_at_pi() {
    let map = LandmarkMap::new([Landmark::planar(1, -4.0, 0.01)]).unwrap();
    let observed = Observed::Bearing { bearing: -PI + 0.01 };
    let seen = [LandmarkObservation { landmark: 1, observed }];
    let seen = LandmarkLikelihood::new(&map, &seen, &model(0.0)).unwrap();
    let pose = Pose2::IDENTITY;
    let error = angle::difference(-PI + 0.01, (0.01_f64).atan2(-4.0));
    assert!(error.abs() < 0.02);
    let expected = Normal::new(0.0, 0.05).unwrap().log_density(error);
    assert_relative_eq!(seen.log_likelihood(pose), expected, epsilon = 1e-12);
    assert_relative_eq!(fast(&seen, &[pose])[0], expected, epsilon = 1e-4);
    for theta in [PI, -PI + 1e-9, -3.0, 3.0] {
        let pose = Pose2 { x: 0.0, y: 0.0, theta };
        assert_relative_eq!(fast(&seen, &[pose])[0], seen.log_likelihood(pose), epsilon = 2e-2);
    }
}

/// A camera 0.5 m ahead of the axle that looks to the left.
#[test]
fn the_mounting_counts() {
    let mounting = Pose2::new(0.5, 0.0, FRAC_PI_2);
    let model = ObservationModel { mounting, ..model(0.0) };
    let map = LandmarkMap::new([Landmark::planar(1, 0.5, 2.0)]).unwrap();
    let observed = Observed::RangeBearing { range: 2.0, bearing: 0.0 };
    let seen = [LandmarkObservation { landmark: 1, observed }];
    let seen = LandmarkLikelihood::new(&map, &seen, &model).unwrap();
    let at = seen.log_likelihood(Pose2::IDENTITY);
    assert_relative_eq!(at, seen.log_peak(), epsilon = 1e-12);
    assert_relative_eq!(fast(&seen, &[Pose2::IDENTITY])[0], at, epsilon = 1e-5);
}

fn random_observation(kind: usize, rng: &mut impl rand::Rng) -> Observed {
    let (range, bearing) = (8.0 * rng.random::<f64>(), TAU * rng.random::<f64>() - PI);
    match kind % 3 {
        0 => Observed::RangeBearing { range, bearing },
        1 => Observed::Range { range },
        _ => Observed::Bearing { bearing },
    }
}

/// Every combination of sights, outliers, growing sigma and mounting, against the plain form.
#[test]
fn many_at_once_agree_with_one_by_one() {
    let mut rng = stream(3, "test");
    for case in 0..120 {
        let noise = LandmarkNoise {
            range_sigma: 0.1,
            range_sigma_per_m: if case % 2 == 0 { 0.0 } else { 0.04 },
            bearing_sigma: 0.05,
        };
        let outlier_share = [0.0, 0.01, 0.3][case % 3];
        let mounting = if case % 4 < 2 { Pose2::IDENTITY } else { Pose2::new(0.3, -0.1, 1.2) };
        let model = ObservationModel { noise, mounting, outlier_share, outlier_range: 10.0 };
        let count = case % 13;
        let observations: Vec<(u32, Observed)> = (0..count)
            .map(|k| (1 + (k % 3) as u32, random_observation(k + case, &mut rng)))
            .collect();
        let seen = likelihood(&observations, &model);
        // Not a multiple of any vector's length, and more than one block.
        let poses: Vec<Pose2> = (0..150)
            .map(|_| {
                let [x, y, theta] = [10.0, 10.0, TAU].map(|s| s * (rng.random::<f64>() - 0.5));
                Pose2::new(x, y, theta)
            })
            .collect();
        for (pose, fast) in poses.iter().zip(fast(&seen, &poses)) {
            let plain = seen.log_likelihood(*pose);
            // 1e-5 sigma of error at a residual of many sigma.
            let allowed = 2e-5 * (1.0 + plain.abs());
            assert!((fast - plain).abs() < allowed, "case {case} {pose:?}: {fast} {plain}");
        }
    }
}

/// Single precision counts from the first landmark, so that maps far from their origin lose
/// nothing.
#[test]
fn far_from_the_origin_of_the_map() {
    let far = Pose2::new(4.5e5, -5.4e5, 0.0);
    let map = LandmarkMap::new([Landmark::planar(1, far.x + 3.0, far.y + 4.0)]).unwrap();
    let observed = Observed::RangeBearing { range: 5.0, bearing: 0.9 };
    let seen = LandmarkLikelihood::new(
        &map,
        &[LandmarkObservation { landmark: 1, observed }],
        &model(0.01),
    )
    .unwrap();
    assert_relative_eq!(fast(&seen, &[far])[0], seen.log_likelihood(far), epsilon = 1e-4);
}

/// 400 observations without outliers: the likelihood itself is far below the smallest number.
#[test]
fn nothing_underflows() {
    for outlier_share in [0.0, 1e-3] {
        let observed = Observed::RangeBearing { range: 2.0, bearing: 2.0 };
        let seen = likelihood(&[(1, observed); 400], &model(outlier_share));
        let poses = [Pose2::IDENTITY, Pose2::new(0.0, 0.1, 0.0)];
        let rated = fast(&seen, &poses);
        for (pose, rated) in poses.iter().zip(&rated) {
            assert_relative_eq!(*rated, seen.log_likelihood(*pose), max_relative = 1e-4);
        }
        assert!(outlier_share > 0.0 || (rated[0] < -1e5 && rated[0] != rated[1]));
    }
}

#[test]
fn no_pose_gives_nan() {
    let seen = likelihood(
        &[
            (1, Observed::RangeBearing { range: 1.0, bearing: 0.5 }),
            (2, Observed::Bearing { bearing: 1.0 }),
        ],
        &model(0.0),
    );
    let robust = ObservationModel { outlier_share: 0.01, ..*seen.model() };
    let robust = likelihood(&[(1, Observed::RangeBearing { range: 1.0, bearing: 0.5 })], &robust);
    // On a landmark, and beyond what single precision holds.
    let poses =
        [Pose2::new(3.0, 4.0, 0.0), Pose2::new(1e30, 0.0, 1.0), Pose2::new(-1e300, 1e300, 1.0)];
    for seen in [seen, robust] {
        for rated in fast(&seen, &poses) {
            assert!(!rated.is_nan());
        }
    }
}

#[test]
fn unknown_numbers_are_told_and_left_out() {
    let observed = Observed::Range { range: 5.0 };
    let seen = likelihood(&[(9, observed), (1, observed), (77, observed)], &model(0.0));
    let unknown: Vec<u32> = seen.unknown().iter().map(|s| s.landmark).collect();
    assert_eq!((unknown, seen.len()), (vec![9, 77], 1));
    let trust: Vec<_> = seen.trust(Pose2::IDENTITY).collect();
    assert_eq!(trust.iter().map(|t| t.observation.landmark).collect::<Vec<_>>(), [1, 9, 77]);
    assert_eq!(trust.iter().map(|t| t.probability).collect::<Vec<_>>(), [1.0, 0.0, 0.0]);
    let nothing = likelihood(&[(9, observed)], &model(0.0));
    assert!(nothing.is_empty() && fast(&nothing, &[Pose2::IDENTITY]) == [0.0]);
}

#[test]
fn bad_input_is_named() {
    let refusal = |observed: Observed, model: ObservationModel| {
        let seen = [LandmarkObservation { landmark: 1, observed }];
        LandmarkLikelihood::new(&map(), &seen, &model).unwrap_err().to_string()
    };
    let fine = Observed::Range { range: 1.0 };
    let message = refusal(Observed::Range { range: -1.0 }, model(0.0));
    assert_eq!(message, "range to a landmark [m]: expected a finite number >= 0, got -1");
    let message = refusal(Observed::Bearing { bearing: f64::NAN }, model(0.0));
    assert_eq!(message, "bearing of a landmark [rad]: expected a finite number, got NaN");
    let message = refusal(fine, model(1.0));
    assert_eq!(message, "share of outliers: expected a number in [0, 1), got 1");
    let noise = LandmarkNoise::NONE;
    let message = refusal(fine, ObservationModel { noise, ..model(0.0) });
    assert_eq!(message, "sigma of the range [m]: expected a finite number > 0, got 0");
}
