//! Simulated robots: a tour through a building with a laser, cars and Mecanum wheels.

use loc_core::motion::OdometryMotion;
use loc_core::{Pose2, angle};
use loc_sensors::event::{Control, Event, Measurement, Payload};
use loc_sensors::landmark_camera::Observed;
use loc_sensors::laser::LaserScan;
use loc_sensors::world::RangeWorld;
use loc_sim::localizer::Method;
use loc_sim::metrics::{Alignment, Summary};
use loc_sim::scenario::Scenario;
use loc_sim::source::{SimulatedTour, Source};
use std::sync::Arc;

/// A small office with perfect sensors.
const TOUR: &str = r#"
name = "tour"
title = "A tour"
seed = 1
methods = ["mcl"]
[tour]
world = { name = "office", width = 300, height = 200, seed = 2 }
duration = 30.0
time_step = 0.1
[tour.wheels]
track = 0.4
[tour.laser]
preset = "sick-lms100-50hz"
sigma = 0.0
mounting = { x = 0.2, theta = "10 deg" }
every = 0.5
"#;

fn tour(seed: u64, changes: &[&str]) -> SimulatedTour {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    let scenario = Scenario::parse("tour.toml", TOUR, &changes).unwrap();
    SimulatedTour::new("tour", &scenario.tour.unwrap(), seed).unwrap()
}

fn events(tour: &mut SimulatedTour) -> Vec<Event> {
    std::iter::from_fn(|| tour.next_event().unwrap()).collect()
}

fn truths(events: &[Event]) -> Vec<Pose2> {
    let truth = |event: &Event| match event.payload {
        Payload::Truth(truth) => Some(truth.pose),
        _ => None,
    };
    events.iter().filter_map(truth).collect()
}

fn odometries(events: &[Event]) -> Vec<Pose2> {
    let odometry = |event: &Event| match event.payload {
        Payload::Control(Control::Odometry(pose)) => Some(pose),
        _ => None,
    };
    events.iter().filter_map(odometry).collect()
}

fn scans(events: &[Event]) -> Vec<(f64, Arc<LaserScan>, Pose2)> {
    let scan = |event: &Event| match &event.payload {
        Payload::Measurement(Measurement::Scan { scan, mounting }) => {
            Some((event.stamp, scan.clone(), *mounting))
        }
        _ => None,
    };
    events.iter().filter_map(scan).collect()
}

#[test]
fn it_keeps_off_the_walls_and_within_its_speeds() {
    for seed in 1..=8 {
        let mut tour = tour(seed, &["tour.laser.every=30.0"]);
        let events = events(&mut tour);
        let poses = truths(&events);
        assert_eq!(poses.len(), 301);
        // 0.8 of the radius, less the step that a clearance grows and shrinks by.
        let room = |pose: &Pose2| tour.world().clearance(&pose.position());
        let least = poses.iter().map(room).fold(f64::INFINITY, f64::min);
        assert!(least > 0.19, "seed {seed}: {least}");
        let steps = || poses.windows(2).map(|pair| pair[0].between(pair[1]));
        assert!(steps().all(|step| f64::hypot(step.x, step.y) < 0.0701));
        assert!(steps().all(|step| step.theta.abs() < 7.01_f64.to_radians()));
        let driven: f64 = steps().map(|step| f64::hypot(step.x, step.y)).sum();
        assert!(driven > 8.0, "seed {seed}: {driven}");
        // Perfect wheels add up to the true path.
        let odometry = *odometries(&events).last().unwrap();
        let end = poses[0].between(*poses.last().unwrap());
        assert!(odometry.distance(end) < 1e-9);
    }
}

#[test]
fn it_visits_its_stops_in_turn() {
    let stops = ["tour.stops=[[3.0, 5.0], [11.0, 5.0]]", "tour.duration=60.0"];
    let start = "tour.start={x=7.0, y=5.0, theta='0 deg'}";
    let poses = truths(&events(&mut tour(1, &[stops[0], stops[1], start])));
    assert!(poses[0].distance(Pose2::new(7.0, 5.0, 0.0)) < 1.0);
    let first_at = |x: f64| {
        let stop = Pose2::new(x, 5.0, 0.0);
        poses.iter().position(|pose| pose.distance(stop) < 1.0).unwrap()
    };
    assert!(first_at(3.0) < first_at(11.0));
}

/// The scans are those of an exact traversal of the grid, from where the laser sits.
#[test]
fn scans_show_the_walls_from_the_true_pose() {
    let mut tour = tour(3, &[]);
    let events = events(&mut tour);
    let grid = tour.setup().map.clone().unwrap();
    let poses = truths(&events);
    let scans = scans(&events);
    assert_eq!(scans.len(), 61);
    for (stamp, scan, mounting) in scans.iter().step_by(10) {
        assert_eq!(*mounting, Pose2::new(0.2, 0.0, 10_f64.to_radians()));
        let pose = poses[(stamp / 0.1).round() as usize];
        for index in (0..scan.ranges.len()).step_by(20) {
            let laser = pose * *mounting;
            let direction = laser.theta + scan.angle(index);
            let wall = grid.cast(&laser.position(), direction, 20.0).unwrap();
            let range = scan.ranges[index];
            let same =
                if wall < 0.5 { range == f64::NEG_INFINITY } else { (range - wall).abs() < 1e-6 };
            assert!(same, "{stamp} s, beam {index}: {range} for {wall}");
        }
    }
}

/// E7: the variance of the heading grows with the angle turned and the distance travelled. Errors in units
/// of their standard deviation have a mean square of 1.
#[test]
fn odometry_errors_match_the_noise_model() {
    let noise = "tour.wheels.noise={distance_sigma=0.02,turn_sigma='10 deg',drift_sigma='2 deg'}";
    let (mut squares, runs) = (0.0, 60);
    for seed in 1..=runs {
        let events = events(&mut tour(seed, &[noise, "tour.laser.every=30.0"]));
        let (poses, odometry) = (truths(&events), odometries(&events));
        let steps = || poses.windows(2).map(|pair| OdometryMotion::between(pair[0], pair[1]));
        let turned: f64 = steps().map(|step| (step.rot1 + step.rot2).abs()).sum();
        let driven: f64 = steps().map(|step| step.trans).sum();
        let variance = 10_f64.to_radians().powi(2) * turned / std::f64::consts::TAU
            + 2_f64.to_radians().powi(2) * driven;
        let turn = poses[0].between(*poses.last().unwrap()).theta;
        let error = angle::difference(odometry.last().unwrap().theta, turn);
        squares += error * error / variance;
    }
    let mean = squares / runs as f64;
    // Three standard deviations of the mean of 60 squares.
    assert!((mean - 1.0).abs() < 0.55, "{mean}");
}

#[test]
fn people_do_not_change_the_tour_of_a_seed() {
    let people = "tour.people={count=20, blocked_share=0.3}";
    let plain = events(&mut tour(5, &[]));
    assert_eq!(plain, events(&mut tour(5, &[])));
    let crowded = events(&mut tour(5, &[people]));
    assert_eq!(crowded, events(&mut tour(5, &[people])));
    assert_eq!(truths(&plain), truths(&crowded));
    assert_eq!(odometries(&plain), odometries(&crowded));
    assert_ne!(truths(&plain), truths(&events(&mut tour(6, &[]))));
}

/// K3: the visitors hide the wanted share of the beams, in clusters that last several scans.
#[test]
fn visitors_hide_four_of_ten_beams_in_clusters_that_last() {
    let changes = ["tour.laser.every=0.2", "tour.duration=40.0"];
    let plain = events(&mut tour(2, &changes));
    let people = "tour.people={blocked_share=0.4}";
    let crowded = events(&mut tour(2, &[changes[0], changes[1], people]));
    let pairs: Vec<_> = scans(&plain).into_iter().zip(scans(&crowded)).collect();
    let hidden: Vec<Vec<bool>> = pairs
        .iter()
        .map(|((_, a, _), (_, b, _))| {
            let shorter = |(a, b): (&f64, &f64)| *b < a - 1e-6;
            a.ranges.iter().zip(&b.ranges).map(shorter).collect()
        })
        .collect();
    let count = |beams: &[bool]| beams.iter().filter(|hidden| **hidden).count() as f64;
    let beams = hidden[0].len() as f64;
    let share = hidden.iter().map(|beams| count(beams)).sum::<f64>() / beams / hidden.len() as f64;
    assert!((share - 0.4).abs() < 0.03, "{share}");
    let starts = |beams: &[bool]| beams.windows(2).filter(|pair| !pair[0] && pair[1]).count();
    let clusters = hidden.iter().map(|beams| starts(beams) as f64).sum::<f64>();
    assert!((2.0..6.0).contains(&(clusters / hidden.len() as f64)), "{clusters}");
    let still: f64 = hidden
        .windows(2)
        .map(|pair| {
            let both = pair[0].iter().zip(&pair[1]).filter(|(a, b)| **a && **b).count();
            both as f64 / count(&pair[0]).max(1.0)
        })
        .sum::<f64>()
        / (hidden.len() - 1) as f64;
    assert!(still > 0.75, "{still}");
}

#[test]
fn walkers_stay_in_free_space_and_shorten_beams_only() {
    let people = "tour.people={count=40, speed=1.5}";
    let plain = events(&mut tour(4, &[]));
    let crowded = events(&mut tour(4, &[people]));
    let mut shorter = 0;
    for ((_, a, _), (_, b, _)) in scans(&plain).iter().zip(&scans(&crowded)) {
        for (a, b) in a.ranges.iter().zip(&b.ranges) {
            assert!(b <= a);
            shorter += usize::from(b < a);
        }
    }
    assert!(shorter > 1000, "{shorter}");
}

#[test]
fn a_kidnapped_robot_is_elsewhere_and_its_odometry_is_not() {
    for (to, exactly) in
        [("\"random\"", None), ("{x=3.0, y=5.0, theta='90 deg'}", Some(Pose2::new(3.0, 5.0, 1.5)))]
    {
        let kidnap = format!("tour.kidnap={{at=12.0, to={to}}}");
        let mut tour = tour(2, &[&kidnap]);
        assert_eq!(tour.setup().kidnapped_at, Some(12.0));
        let events = events(&mut tour);
        let (poses, odometry) = (truths(&events), odometries(&events));
        let jump = |poses: &[Pose2], k: usize| poses[k - 1].distance(poses[k]);
        let jumps: Vec<usize> = (1..poses.len()).filter(|&k| jump(&poses, k) > 0.1).collect();
        assert_eq!(jumps, [120]);
        assert!((1..odometry.len()).all(|k| jump(&odometry, k) < 0.1));
        match exactly {
            Some(there) => assert!(poses[120].distance(there) < 1.0),
            None => assert!(jump(&poses, 120) >= 5.0),
        }
        let room = poses.iter().map(|pose| tour.world().clearance(&pose.position()));
        assert!(room.fold(f64::INFINITY, f64::min) > 0.19);
    }
}

#[test]
fn bad_tours_name_the_key() {
    for (change, message) in [
        ("tour.world={name=\"castle\"}", "world: expected one of office, corridor"),
        ("tour.map=\"map.yaml\"", "tour.world, tour.map: expected one of the two, got `both`"),
        ("tour.duration=-1.0", "tour.duration: expected a finite number > 0, got -1"),
        ("tour.laser.every=0.25", "tour.laser.every: expected a multiple of the time step"),
        ("tour.people={blocked_share=1.5}", "tour.people.blocked_share: expected a share"),
        ("tour.kidnap={at=31.0,to=\"random\"}", "tour.kidnap.at: expected a time within"),
        ("tour.robot.radius=nan", "tour.robot.radius: expected a finite number > 0, got NaN"),
        ("tour.stops=[[0.0, inf]]", "tour.stops: expected a finite number"),
        ("tour.laser.preset=\"torch\"", "unknown variant `torch`"),
    ] {
        let error = Scenario::parse("my.toml", TOUR, &[change.into()]).unwrap_err().to_string();
        assert!(error.contains(message), "{change}: {error}");
    }
    for (change, message) in [
        ("tour.robot.radius=8.0", "free space for a robot of radius 8 m"),
        ("tour.start={x=90.0,y=0.0,theta='0 deg'}", "tour.start: expected a place within 1 m"),
        ("tour.stops=[[90.0, 0.0]]", "tour.stops: expected a place within 1 m"),
    ] {
        let scenario = Scenario::parse("my.toml", TOUR, &[change.into()]).unwrap();
        let error = scenario.run(None, None, &mut |_| {}).unwrap_err().to_string();
        assert!(error.contains(message), "{change}: {error}");
    }
}

#[test]
fn a_camera_sees_the_landmarks_that_no_wall_hides() {
    let camera = [
        "tour.camera={every=0.5,fov='360 deg',max_range=30.0,noise={range_sigma=0.0,bearing_sigma='0 deg'}}",
        "tour.world.width=500",
        "tour.world.height=400",
    ];
    let mut tour = tour(4, &camera);
    let landmarks = tour.setup().landmarks.clone();
    let (mut pose, mut seen, mut hidden) = (Pose2::IDENTITY, 0, 0);
    let events = events(&mut tour);
    // The truth of a step comes after what was seen there.
    for event in events.iter().rev() {
        match &event.payload {
            Payload::Truth(truth) => pose = truth.pose,
            Payload::Measurement(Measurement::Landmarks(observations)) => {
                for observation in observations {
                    let place = landmarks.get(observation.landmark).unwrap().position.xy();
                    let way = place - pose.position();
                    let Observed::RangeBearing { range, bearing } = observation.observed else {
                        panic!()
                    };
                    assert!((range - way.norm()).abs() < 1e-9);
                    let direction = pose.theta + bearing;
                    let free = tour.world().walls().cast(&pose.position(), direction, range - 0.15);
                    assert_eq!(free, None, "a wall before landmark {}", observation.landmark);
                }
                seen += observations.len();
                hidden += landmarks.iter().count() - observations.len();
            }
            _ => {}
        }
    }
    assert!(seen > 50 && hidden > 50, "{seen} seen, {hidden} hidden");
}

#[test]
fn landmarks_and_the_poses_of_an_odometry_serve_the_ekf() {
    let scenario = Scenario::named("overview", &["tour.duration=30.0".into()]).unwrap();
    let methods = [Method::Ekf, Method::Mcl];
    let run = scenario.run(Some(3), Some(&methods), &mut |_| {}).unwrap();
    let summary = Summary::of(&run, Some(3), Alignment::None).unwrap();
    let rmse = |name: &str| {
        let (_, method) = summary.methods.iter().find(|(method, _)| method == name).unwrap();
        method.errors.as_ref().unwrap().ate_rmse_m
    };
    assert!(rmse("ekf") < 0.3, "ekf {}", rmse("ekf"));
    assert!(rmse("mcl") < 0.05, "mcl {}", rmse("mcl"));
}

/// The last true pose of a scenario with changes.
fn end(name: &str, changes: &[&str]) -> Result<loc_core::Pose2, String> {
    let changes: Vec<String> = changes.iter().map(|change| (*change).to_owned()).collect();
    let scenario = Scenario::named(name, &changes).map_err(|error| error.to_string())?;
    let run = scenario.run(None, None, &mut |_| {}).map_err(|error| error.to_string())?;
    Ok(run.truth.last().unwrap().value.pose)
}

/// A steering angle of atan(L / r) drives a circle of radius r: half a turn ends 2 r to the left.
#[test]
fn a_car_drives_the_circle_of_its_steering_angle() {
    let duration = std::f64::consts::PI * 2.0;
    let course = format!(
        "drive.course=[{{duration = {duration}, v = 1.0, steering = {} }}]",
        (0.87_f64 / 2.0).atan()
    );
    let step = format!("drive.time_step={}", duration / 60.0);
    let pose = end("ackermann-drive", &[&course, &step]).unwrap();
    assert!(pose.x.abs() < 1e-9 && (pose.y - 4.0).abs() < 1e-9, "{pose}");
}

/// Encoders with few counts round the steering angle: dead reckoning is off by what they lose.
#[test]
fn the_steering_encoder_rounds() {
    let run = |counts: u32| {
        let changes = [
            format!("drive.ackermann.steering_counts={counts}"),
            "drive.ackermann.noise={distance_sigma = 0.0, turn_sigma = '0 deg', drift_sigma = '0 deg'}".to_owned(),
        ];
        let scenario = Scenario::named("ackermann-drive", &changes).unwrap();
        let run = scenario.run(None, None, &mut |_| {}).unwrap();
        let estimate = run.methods[0].estimates.last().unwrap().pose;
        estimate.distance(run.truth.last().unwrap().value.pose)
    };
    assert!(run(1 << 24) < 0.01);
    assert!(run(90) > 0.1);
}

/// Left wheels backwards and right ones forwards turn on the spot by rim speed over lever.
#[test]
fn mecanum_wheels_turn_by_their_rim_speeds() {
    let spot = "drive.course=[{duration = 1.0, wheels = [-0.25, 0.25, -0.25, 0.25] }]";
    let pose = end("mecanum-drive", &[spot]).unwrap();
    assert!(pose.x.abs() < 1e-12 && (pose.theta - 0.5).abs() < 1e-12, "{pose}");
    let aside = "drive.course=[{duration = 1.0, wheels = [-0.3, 0.3, 0.3, -0.3] }]";
    let pose = end("mecanum-drive", &[aside]).unwrap();
    assert!((pose.y - 0.3).abs() < 1e-12 && pose.x.abs() < 1e-12, "{pose}");
}

#[test]
fn what_a_body_cannot_do_is_refused() {
    let turn = "drive.course=[{duration = 1.0, v = 0.0, omega = '10 deg/s' }]";
    let error = end("ackermann-drive", &[turn]).unwrap_err();
    assert!(error.contains("turn on the spot"), "{error}");
    let aside = "drive.course=[{duration = 1.0, sideways = 0.1 }]";
    let error = end("ackermann-drive", &[aside]).unwrap_err();
    assert!(error.contains("v with steering"), "{error}");
    let wheels = "drive.course=[{duration = 1.0, v = 1.0, wheels = [0.0, 0.0, 0.0, 0.0] }]";
    let error = end("mecanum-drive", &[wheels]).unwrap_err();
    assert!(error.contains("four wheels"), "{error}");
    let both = "drive.wheels={track = 0.3}";
    let error = end("mecanum-drive", &[both]).unwrap_err();
    assert!(error.contains("expected one of them, got `several`"), "{error}");
}
