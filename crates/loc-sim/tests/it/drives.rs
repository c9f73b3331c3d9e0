//! Cars and Mecanum wheels in simulation.

use loc_sim::scenario::Scenario;

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
        "drive.course=[{{duration_s = {duration}, v_m_s = 1.0, steering_deg = {} }}]",
        (0.87_f64 / 2.0).atan().to_degrees()
    );
    let step = format!("drive.time_step_s={}", duration / 60.0);
    let pose = end("ackermann-drive", &[&course, &step]).unwrap();
    assert!(pose.x.abs() < 1e-9 && (pose.y - 4.0).abs() < 1e-9, "{pose}");
}

/// Encoders with few counts round the steering angle: dead reckoning is off by what they lose.
#[test]
fn the_steering_encoder_rounds() {
    let run = |counts: u32| {
        let changes = [
            format!("drive.ackermann.steering_counts={counts}"),
            "drive.ackermann.noise={distance_sigma_m = 0.0, turn_sigma_deg = 0.0, drift_sigma_deg = 0.0}".to_owned(),
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
    let spot = "drive.course=[{duration_s = 1.0, wheels_m_s = [-0.25, 0.25, -0.25, 0.25] }]";
    let pose = end("mecanum-drive", &[spot]).unwrap();
    assert!(pose.x.abs() < 1e-12 && (pose.theta - 0.5).abs() < 1e-12, "{pose}");
    let aside = "drive.course=[{duration_s = 1.0, wheels_m_s = [-0.3, 0.3, 0.3, -0.3] }]";
    let pose = end("mecanum-drive", &[aside]).unwrap();
    assert!((pose.y - 0.3).abs() < 1e-12 && pose.x.abs() < 1e-12, "{pose}");
}

#[test]
fn what_a_body_cannot_do_is_refused() {
    let turn = "drive.course=[{duration_s = 1.0, v_m_s = 0.0, omega_deg_s = 10.0 }]";
    let error = end("ackermann-drive", &[turn]).unwrap_err();
    assert!(error.contains("turn on the spot"), "{error}");
    let aside = "drive.course=[{duration_s = 1.0, sideways_m_s = 0.1 }]";
    let error = end("ackermann-drive", &[aside]).unwrap_err();
    assert!(error.contains("v_m_s with steering_deg"), "{error}");
    let wheels =
        "drive.course=[{duration_s = 1.0, v_m_s = 1.0, wheels_m_s = [0.0, 0.0, 0.0, 0.0] }]";
    let error = end("mecanum-drive", &[wheels]).unwrap_err();
    assert!(error.contains("four wheels_m_s"), "{error}");
    let both = "drive.wheels={track_m = 0.3}";
    let error = end("mecanum-drive", &[both]).unwrap_err();
    assert!(error.contains("expected one of them, got `several`"), "{error}");
}
