//! Error metrics against values computed by hand and general properties; consistency of reported
//! covariances over many seeds.

use approx::assert_relative_eq;
use loc_core::nalgebra::{Isometry3, UnitQuaternion, Vector3};
use loc_core::{Pose2, Trajectory, stats};
use loc_sim::localizer::Method;
use loc_sim::metrics::{
    Alignment, Consistency, EvalSettings, Pair, RigidPose, SpatialTrajectory, Statistics, Unit,
    aligned, ape_rotation, ape_translation, associate, evaluate, planar_errors, pose_nees,
    rpe_translation,
};
use loc_sim::scenario::Scenario;
use loc_sim::{Error, runner};

const ALIGNMENTS: [Alignment; 3] = [Alignment::None, Alignment::Origin, Alignment::Se2];

/// A drive of `n` poses with a wandering error, in different frames.
fn drive(n: u32) -> Vec<Pair<Pose2>> {
    let estimate_from_map = Pose2::new(4.0, -7.0, 2.5);
    (0..n)
        .map(|i| {
            let t = 0.1 * f64::from(i);
            let truth = Pose2::new(2.0 * t.cos() + t, (1.3 * t).sin(), 0.7 * t);
            let wander = Pose2::new(0.1 * (3.0 * t).sin(), 0.05 * t, 0.2 * (2.0 * t).cos());
            Pair::new(estimate_from_map * truth * wander, truth)
        })
        .collect()
}

fn trajectories(pairs: &[Pair<Pose2>]) -> (SpatialTrajectory, SpatialTrajectory) {
    let (mut estimate, mut reference) = (Trajectory::new(), Trajectory::new());
    for (i, pair) in pairs.iter().enumerate() {
        estimate.push(i as f64, pair.estimate).unwrap();
        reference.push(i as f64, pair.reference).unwrap();
    }
    (SpatialTrajectory::from(&estimate), SpatialTrajectory::from(&reference))
}

mod association {
    use super::*;

    #[test]
    fn takes_the_nearest_and_the_limit_itself() {
        let reference = [0.0, 0.25, 0.5, 0.75, 1.0];
        assert_eq!(associate(&[0.125, 0.625], &reference, 0.125), [(0, 0), (1, 2)]);
        assert_eq!(associate(&[0.3, 0.7], &reference, 0.125), [(0, 1), (1, 3)]);
        assert_eq!(associate(&[-0.25, 1.25], &reference, 0.25), [(0, 0), (1, 4)]);
        assert_eq!(associate(&[-0.26, 1.26], &reference, 0.25), []);
    }

    #[test]
    fn walks_through_the_shorter_list() {
        let (dense, sparse) = ([0.0, 0.1, 0.2, 0.3, 0.4], [0.11, 0.31]);
        assert_eq!(associate(&dense, &sparse, 1.0), [(1, 0), (3, 1)]);
        assert_eq!(associate(&sparse, &dense, 1.0), [(0, 1), (1, 3)]);
        // Of equal lengths, the estimate is walked through: both find the same reference.
        assert_eq!(associate(&[0.0, 0.1], &[0.0, 9.0], 1.0), [(0, 0), (1, 0)]);
    }

    #[test]
    fn of_equal_stamps_the_last_behind_and_the_first_ahead() {
        let reference = [0.0, 1.0, 1.0, 1.0, 2.0];
        assert_eq!(associate(&[1.0], &reference, 0.1), [(0, 3)]);
        assert_eq!(associate(&[1.1], &reference, 0.1 + 1e-9), [(0, 3)]);
        assert_eq!(associate(&[0.9], &reference, 0.1 + 1e-9), [(0, 1)]);
        assert_eq!(associate(&[2.0], &[1.0, 2.0, 2.0], 0.1), [(0, 1)]);
    }

    #[test]
    fn of_nothing_there_is_nothing() {
        assert_eq!(associate(&[], &[1.0], 1.0), []);
        assert_eq!(associate(&[1.0], &[], 1.0), []);
        assert_eq!(associate(&[1.0], &[1.0], 0.0), [(0, 0)]);
    }
}

mod by_hand {
    use super::*;

    #[test]
    fn statistics_of_four_errors() {
        let s = Statistics::of(Unit::Metre, &[4.0, 1.0, 2.0, 1.0]).unwrap();
        assert_eq!((s.count, s.mean, s.median), (4, 2.0, 1.5));
        assert_eq!((s.min, s.max, s.sse), (1.0, 4.0, 22.0));
        assert_eq!((s.rmse, s.std), (5.5_f64.sqrt(), 1.5_f64.sqrt()));
        let one = Statistics::of(Unit::Degree, &[3.0]).unwrap();
        assert_eq!((one.median, one.std, one.rmse), (3.0, 0.0, 3.0));
    }

    #[test]
    fn statistics_refuse_what_has_no_figure() {
        for errors in [&[][..], &[f64::NAN], &[f64::INFINITY], &[1e200]] {
            assert!(Statistics::of(Unit::Metre, errors).is_err(), "{errors:?}");
        }
    }

    #[test]
    fn a_corner_that_was_missed() {
        // True: one metre ahead, then a left turn. Believed: two metres ahead, no turn.
        let quarter = std::f64::consts::FRAC_PI_2;
        let pairs = [
            Pair::new(Pose2::IDENTITY, Pose2::IDENTITY),
            Pair::new(Pose2::new(2.0, 0.0, 0.0), Pose2::new(1.0, 0.0, quarter)),
            Pair::new(Pose2::new(3.0, 0.0, 0.0), Pose2::new(1.0, 1.0, quarter)),
        ];
        let errors = planar_errors(&pairs, Alignment::None).unwrap();
        assert_relative_eq!(errors.ate_rmse_m, 2.0_f64.sqrt(), epsilon = 1e-12);
        assert_relative_eq!(errors.ate_median_m, 1.0, epsilon = 1e-12);
        assert_relative_eq!(errors.ate_max_m, 5.0_f64.sqrt(), epsilon = 1e-12);
        assert_relative_eq!(errors.final_error_m, 5.0_f64.sqrt(), epsilon = 1e-12);
        let heading = (2.0 * 90.0_f64.powi(2) / 3.0).sqrt();
        assert_relative_eq!(errors.heading_rmse_deg.unwrap(), heading, epsilon = 1e-9);
        // The second step is right, one metre ahead; the first is 1 m and 90 degrees wrong.
        assert_relative_eq!(errors.rpe_trans_rmse_m.unwrap(), 0.5_f64.sqrt(), epsilon = 1e-12);
        let turn = 90.0 * 0.5_f64.sqrt();
        assert_relative_eq!(errors.rpe_rot_rmse_deg.unwrap(), turn, epsilon = 1e-9);
    }

    #[test]
    fn headings_across_the_wrap() {
        let pair = Pair::new(Pose2::new(0.0, 0.0, 3.1), Pose2::new(0.0, 0.0, -3.1));
        let expected = (std::f64::consts::TAU - 6.2).to_degrees();
        assert_relative_eq!(ape_rotation(&[pair])[0], expected, epsilon = 1e-9);
        // Fields are public, so a heading may come unwrapped.
        let unwrapped = Pose2 { theta: 7.0, ..Pose2::IDENTITY };
        let pair = Pair::new(unwrapped, Pose2::IDENTITY);
        let expected = (7.0 - std::f64::consts::TAU).to_degrees();
        assert_relative_eq!(ape_rotation(&[pair])[0], expected, epsilon = 1e-9);
    }

    #[test]
    fn one_pair_has_no_relative_error() {
        let (estimate, reference) = trajectories(&drive(1));
        let evaluation = evaluate(&estimate, &reference, &EvalSettings::default()).unwrap();
        assert_eq!((evaluation.rpe_trans, evaluation.rpe_rot), (None, None));
        let errors = planar_errors(&drive(1), Alignment::None).unwrap();
        assert_eq!((errors.rpe_trans_rmse_m, errors.rpe_rot_rmse_deg), (None, None));
        let json = serde_json::to_value(&evaluation).unwrap();
        assert!(json["rpe_trans"].is_null() && json["ape"]["rmse_m"].is_f64());
    }
}

mod properties {
    use super::*;

    #[test]
    fn the_plane_and_space_give_the_same_figures() {
        let pairs = drive(100);
        let (estimate, reference) = trajectories(&pairs);
        for align in ALIGNMENTS {
            let planar = planar_errors(&pairs, align).unwrap();
            let settings = EvalSettings { align, ..EvalSettings::default() };
            let spatial = evaluate(&estimate, &reference, &settings).unwrap();
            let both = [
                (planar.ate_rmse_m, spatial.ape.rmse),
                (planar.ate_median_m, spatial.ape.median),
                (planar.ate_max_m, spatial.ape.max),
                (planar.heading_rmse_deg.unwrap(), spatial.ape_rot.rmse),
                (planar.rpe_trans_rmse_m.unwrap(), spatial.rpe_trans.unwrap().rmse),
                (planar.rpe_rot_rmse_deg.unwrap(), spatial.rpe_rot.unwrap().rmse),
            ];
            for (planar, spatial) in both {
                assert_relative_eq!(planar, spatial, epsilon = 1e-10);
            }
        }
    }

    #[test]
    fn alignment_undoes_a_rigid_motion_of_the_plane() {
        for (i, theta) in [-3.1, -1.0, 0.0, 0.5, 3.1].into_iter().enumerate() {
            let motion = Pose2::new(1e5 * i as f64, -20.0, theta);
            let pairs: Vec<_> = drive(50)
                .iter()
                .map(|pair| Pair::new(motion * pair.reference, pair.reference))
                .collect();
            for align in [Alignment::Origin, Alignment::Se2] {
                let errors = planar_errors(&pairs, align).unwrap();
                assert!(errors.ate_max_m < 1e-8, "{align:?} {theta}: {errors:?}");
                assert!(errors.heading_rmse_deg.unwrap() < 1e-8, "{align:?} {theta}: {errors:?}");
            }
        }
    }

    #[test]
    fn alignment_at_the_origin_undoes_a_rigid_motion_of_space() {
        let motion = Isometry3::new(Vector3::new(1.0, -2.0, 3.0), Vector3::new(0.3, -1.2, 2.0));
        let pairs: Vec<_> = (0..30)
            .map(|i| {
                let t = 0.1 * f64::from(i);
                let truth =
                    Isometry3::new(Vector3::new(t, t.sin(), t.cos()), Vector3::new(t, 1.0, 0.2));
                Pair::new(motion * truth, truth)
            })
            .collect();
        let aligned = aligned(&pairs, Alignment::Origin).unwrap();
        assert!(ape_translation(&aligned).iter().all(|e| *e < 1e-12));
        assert!(ape_rotation(&aligned).iter().all(|e| *e < 1e-9));
    }

    #[test]
    fn alignment_about_z_leaves_heights_and_tilts() {
        let tilt = UnitQuaternion::from_euler_angles(0.2, 0.0, 0.0);
        let pairs: Vec<_> = drive(20)
            .iter()
            .map(|pair| {
                let mut estimate = Isometry3::from_planar(pair.estimate);
                estimate.translation.z = 0.5;
                estimate.rotation *= tilt;
                Pair::new(estimate, Isometry3::from_planar(pair.reference))
            })
            .collect();
        for pair in aligned(&pairs, Alignment::Se2).unwrap() {
            assert_relative_eq!(pair.estimate.position().z, 0.5, epsilon = 1e-12);
            let up = pair.estimate.rotation * Vector3::z();
            assert_relative_eq!(up.z, 0.2_f64.cos(), epsilon = 1e-12);
        }
    }

    #[test]
    fn no_other_motion_of_the_plane_comes_closer() {
        let aligned = aligned(&drive(60), Alignment::Se2).unwrap();
        let sse = |motion: Pose2| -> f64 {
            let error = |p: &Pair<Pose2>| (motion * p.estimate).distance(p.reference).powi(2);
            aligned.iter().map(error).sum()
        };
        let best = sse(Pose2::IDENTITY);
        for step in [1e-3, -1e-3] {
            for motion in [[step, 0.0, 0.0], [0.0, step, 0.0], [0.0, 0.0, step]] {
                let [x, y, theta] = motion;
                assert!(sse(Pose2::new(x, y, theta)) > best);
            }
        }
    }

    #[test]
    fn relative_errors_do_not_feel_the_frame() {
        let pairs = drive(40);
        let errors = rpe_translation(&pairs);
        for align in ALIGNMENTS {
            let moved = rpe_translation(&aligned(&pairs, align).unwrap());
            for (a, b) in errors.iter().zip(moved) {
                assert_relative_eq!(*a, b, epsilon = 1e-12);
            }
        }
    }

    #[test]
    fn a_straight_line_determines_the_alignment() {
        let pairs: Vec<_> = (0..5)
            .map(|i| {
                let truth = Pose2::new(f64::from(i), 0.0, 0.0);
                Pair::new(Pose2::new(1.0, 2.0, -0.4) * truth, truth)
            })
            .collect();
        assert!(planar_errors(&pairs, Alignment::Se2).unwrap().ate_max_m < 1e-12);
    }
}

mod refusals {
    use super::*;

    const LINE: &str = "1.0 0 0 0 0 0 0 1\n";

    fn refused(text: &str) -> String {
        SpatialTrajectory::parse_tum("path.tum", text).unwrap_err().to_string()
    }

    #[test]
    fn files_that_are_not_trajectories() {
        assert!(refused("").contains("path.tum: poses"));
        assert!(refused("# only a comment\n").contains("path.tum: poses"));
        assert!(refused("1 2 3\n").starts_with("path.tum:1: tz"));
        assert!(
            refused(&format!("{LINE}0.5 0 0 0 0 0 0 1\n")).starts_with("path.tum:2: timestamp")
        );
        assert!(refused("1 0 nan 0 0 0 0 1\n").starts_with("path.tum:1: ty"));
        assert!(refused("1 0 0 0 0 0 0 0\n").contains("a quaternion to be normalised"));
        assert!(refused("1 0 0 0 1e200 0 0 1e200\n").contains("a quaternion to be normalised"));
        assert!(refused("1 0 0 0 0 0 0 1 9\n").contains("8 columns"));
        let missing = SpatialTrajectory::read_tum("no/such.tum").unwrap_err();
        assert!(missing.to_string().starts_with("no/such.tum: "));
    }

    #[test]
    fn files_of_other_hands_are_read() {
        let text = "\u{feff}# comment\r\n1.0\t0 0 0  0 0 0 2\r\n\r\n  1.0 1 2 3 0 0 0 -1\n";
        let trajectory = SpatialTrajectory::parse_tum("path.tum", text).unwrap();
        assert_eq!(trajectory.stamps(), [1.0, 1.0]);
        assert_eq!(trajectory.name(), "path.tum");
        let angle = trajectory.poses()[1].value.rotation_angle();
        assert!(angle < 1e-12);
    }

    #[test]
    fn stamps_that_never_meet_name_both_files() {
        let early = SpatialTrajectory::parse_tum("early.tum", LINE).unwrap();
        let late = SpatialTrajectory::parse_tum("late.tum", "9 0 0 0 0 0 0 1\n").unwrap();
        let error = evaluate(&early, &late, &EvalSettings::default()).unwrap_err();
        assert!(matches!(error, Error::NoCommonStamps { .. }));
        let text = error.to_string();
        assert!(text.contains("early.tum (from 1 s") && text.contains("late.tum (from 9 s"));
    }

    #[test]
    fn trajectories_without_poses_and_times_without_meaning() {
        let (some, _) = trajectories(&drive(3));
        let none = SpatialTrajectory::new("none");
        assert!(evaluate(&none, &some, &EvalSettings::default()).is_err());
        assert!(evaluate(&some, &none, &EvalSettings::default()).is_err());
        for max_dt in [-1.0, f64::NAN, f64::INFINITY] {
            let settings = EvalSettings { max_dt, ..EvalSettings::default() };
            assert!(evaluate(&some, &some, &settings).is_err(), "{max_dt}");
        }
        assert!(planar_errors(&[], Alignment::None).is_err());
        assert!(planar_errors(&[], Alignment::Origin).is_err());
    }

    #[test]
    fn poses_that_are_not_numbers() {
        let mut trajectory = SpatialTrajectory::new("demo");
        assert!(trajectory.push(f64::NAN, Isometry3::identity()).is_err());
        assert!(trajectory.push(0.0, Isometry3::translation(0.0, f64::INFINITY, 0.0)).is_err());
        trajectory.push(1.0, Isometry3::identity()).unwrap();
        assert!(trajectory.push(0.0, Isometry3::identity()).is_err());
        let broken = Pose2 { x: f64::NAN, ..Pose2::IDENTITY };
        for align in ALIGNMENTS {
            assert!(planar_errors(&[Pair::new(broken, broken); 3], align).is_err());
        }
    }

    #[test]
    fn a_robot_that_stands_still_leaves_the_rotation_open() {
        let still = [Pair::new(Pose2::new(4e5, 0.1, 0.3), Pose2::new(1.0, 2e6, 0.3)); 7];
        let error = planar_errors(&still, Alignment::Se2).unwrap_err();
        assert!(matches!(error, Error::UndeterminedAlignment { pairs: 7 }));
        assert!(planar_errors(&still, Alignment::Origin).is_ok());
    }
}

const SEEDS: u64 = 200;

/// Share of time steps at which the mean NEES over all seeds lies in its 95 % band.
fn share_in_band(scenario: &str, method: Method, changes: &[String]) -> f64 {
    let scenario = Scenario::named(scenario, changes).unwrap();
    let mut sums: Vec<f64> = Vec::new();
    for seed in 1..=SEEDS {
        let run = scenario.run(Some(seed), Some(&[method]), &mut |_| {}).unwrap();
        sums.resize(run.truth.len(), 0.0);
        for ((sum, estimate), truth) in
            sums.iter_mut().zip(&run.methods[0].estimates).zip(&run.truth)
        {
            *sum += pose_nees(estimate, truth.value.pose).unwrap();
        }
    }
    let band = stats::chi_square_band(3, SEEDS as usize, 0.95).unwrap();
    let inside = sums.iter().filter(|sum| band.contains(&(**sum / SEEDS as f64))).count();
    inside as f64 / sums.len() as f64
}

#[test]
fn landmark_drive_is_consistent() {
    let share = share_in_band("landmark-drive", Method::Ekf, &[]);
    println!("EKF: mean NEES in the band at {:.1} % of the steps", 100.0 * share);
    assert!(share >= 0.9, "{share}");
}

/// The same test detects a filter that assumes half of the true sensor noise.
#[test]
fn an_optimistic_filter_is_noticed() {
    let boast = "filter.robot.camera={range_sigma=0.05,bearing_sigma='1 deg'}".to_owned();
    assert!(share_in_band("landmark-drive", Method::Ekf, &[boast]) < 0.1);
}

fn consistency(scenario: &Scenario, method: Method, seeds: u64) -> Consistency {
    let mut consistency = Consistency::new(0.95).unwrap();
    for seed in 1..=seeds {
        let run = scenario.run(Some(seed), Some(&[method]), &mut |_| {}).unwrap();
        consistency.push(&run, &run.methods[0]).unwrap();
    }
    consistency
}

/// The library call gives the figures that the loops above compute.
#[test]
fn the_library_call_counts_the_same_steps() {
    let scenario = Scenario::named("landmark-drive", &[]).unwrap();
    let tests = consistency(&scenario, Method::Ekf, SEEDS);
    let figures = tests.figures();
    let share = share_in_band("landmark-drive", Method::Ekf, &[]);
    assert!((figures.nees_share_in_band.unwrap() - share).abs() < 1e-12);
    assert_eq!((figures.runs, tests.nees().steps().len()), (SEEDS, 421));
    assert!((figures.nees_mean.unwrap() - 3.0 * figures.nees_per_degree.unwrap()).abs() < 1e-9);
    // An EKF is consistent as far as its linearization holds; here it does, to two percent.
    assert!((figures.nis_per_degree.unwrap() - 1.0).abs() < 0.02, "{figures:?}");
    assert!((figures.nis_share_inside.unwrap() - 0.95).abs() < 0.01);
    assert!(figures.white_share.unwrap() >= 0.8, "{figures:?}");
}

/// A vehicle whose errors have the statistics that the Kalman filter assumes.
const RAIL: &str = r#"
name = "honest-rail"
title = "A linear system"
seed = 1
methods = ["kf"]
[rail]
time_step = 0.1
steps = 60
acceleration_sigma = 0.4
position_sigma = 1.0
speed_sigma = 0.1
sensors = [{ sigma = 0.5 }]
"#;

/// The properties of the linear filter hold.
#[test]
fn the_linear_filter_is_consistent() {
    let scenario = Scenario::parse("rail", RAIL, &[]).unwrap();
    let figures = consistency(&scenario, Method::Kf, 300).figures();
    let holds = |interval: Option<[f64; 2]>, value: f64| {
        interval.is_some_and(|[low, high]| low <= value && value <= high)
    };
    assert!(holds(figures.nees_interval, 1.0), "{figures:?}");
    assert!(holds(figures.nis_band, figures.nis_per_degree.unwrap()), "{figures:?}");
    assert!(figures.nees_share_in_band.unwrap() >= 0.8, "{figures:?}");
    assert!(figures.white_share.unwrap() >= 0.8, "{figures:?}");
    assert_eq!(figures.measurements, 300 * 60);
}

/// A vehicle with more process noise than its filter assumes: errors last over several steps, so
/// the innovations are not white.
#[test]
fn unmodelled_motion_is_found_in_the_order_of_the_innovations() {
    let scenario = Scenario::parse("rail", RAIL, &["rail.acceleration_sigma=4.0".into()]);
    let mut scenario = scenario.unwrap();
    let source = |seed| scenario.source(seed).unwrap();
    let mut sources: Vec<_> = (1..=100).map(source).collect();
    scenario.rail.as_mut().unwrap().acceleration_sigma = 0.4;
    let settings = scenario.settings().unwrap();
    let mut tests = Consistency::new(0.95).unwrap();
    for source in &mut sources {
        let run = runner::run(source.as_mut(), &[Method::Kf], &settings, &mut |_| {}).unwrap();
        tests.push(&run, &run.methods[0]).unwrap();
    }
    let figures = tests.figures();
    assert!(figures.white_share.unwrap() < 0.5, "{figures:?}");
    assert!(figures.autocorrelation[0].unwrap() > 3.0 * figures.whiteness_bound.unwrap());
    assert!(figures.nees_share_in_band.unwrap() < 0.5 && figures.nis_per_degree.unwrap() > 1.5);
}

/// Dead reckoning measures nothing; that is no figure of 0.
#[test]
fn what_has_no_meaning_is_null() {
    let scenario = Scenario::named("circle-drive", &[]).unwrap();
    let figures = consistency(&scenario, Method::DeadReckoning, 3).figures();
    assert_eq!((figures.measurements, figures.nis_mean, figures.nis_band), (0, None, None));
    assert_eq!((figures.whiteness_bound, figures.white_share), (None, None));
    assert!(figures.nees_mean.is_some());
    let json = serde_json::to_value(&figures).unwrap();
    assert!(json["nis_mean"].is_null() && json["autocorrelation"][0].is_null());
}
