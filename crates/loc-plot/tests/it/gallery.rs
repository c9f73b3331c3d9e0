//! Realistic figures, left in the target's tmp folder to be looked at.

use super::check;
use super::drives::{self, Drive, STEP};
use loc_core::{Ellipse, Pose2};
use loc_plot::{Backdrop, Chart, Figure, Role, Scene};

const COLORS: Role = Role::Method(0);

fn keep(name: &str, svg: &str) {
    check(svg);
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("figures");
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join(format!("{name}.svg")), svg).unwrap();
    assert!(svg.len() < 200_000, "{name} has {} bytes", svg.len());
}

fn positions(poses: &[Pose2]) -> Vec<(f64, f64)> {
    poses.iter().map(|pose| (pose.x, pose.y)).collect()
}

fn estimates(drive: &Drive) -> Vec<(f64, f64)> {
    drive.beliefs.iter().map(|b| (b.mean.x, b.mean.y)).collect()
}

fn ellipses(drive: &Drive, every: usize) -> Vec<Ellipse> {
    let chosen = drive.beliefs.iter().step_by(every).skip(1);
    chosen.map(|belief| belief.position().ellipse(2.0)).collect()
}

#[test]
fn dead_reckoning() {
    let drive = drives::circle(0, 4);
    let poses = drive.beliefs.iter().step_by(20).map(loc_core::Gaussian::pose);
    let scene = Scene::new("Dead reckoning on a circle")
        .subtitle("140 steps of 0.1 s; 2-sigma ellipses every 10 steps")
        .ellipses(COLORS, "2-sigma ellipse", ellipses(&drive, 10))
        .path(Role::Truth.dotted(), "true path", positions(&drive.truth))
        .path(COLORS, "dead reckoning", estimates(&drive))
        .poses(COLORS, "dead reckoning", poses);
    keep("dead_reckoning", &scene.render());
}

#[test]
fn landmark_drive() {
    let drive = drives::circle(10, 4);
    let lost = drives::circle(0, 4);
    let scene = Scene::new("Localization by landmarks")
        .subtitle("Range and bearing to the nearest landmark once per second")
        .ellipses(Role::Method(1), "2-sigma ellipse", ellipses(&drive, 5))
        .path(Role::Truth.dotted(), "true path", positions(&drive.truth))
        .path(COLORS.dashed(), "dead-reckoning", estimates(&lost))
        .path(Role::Method(1), "ekf", estimates(&drive))
        .stars(Role::Measurement, "measurement", drive.seen.clone())
        .crosses(Role::Landmark, "landmark", drives::landmarks());
    keep("landmark_drive", &scene.render());
}

#[test]
fn error_panels() {
    let drive = drives::circle(10, 4);
    let lost = drives::circle(0, 4);
    let mut figure = Figure::new("Errors of the pose with their 2-sigma bands")
        .subtitle("A consistent filter keeps its error inside its band 95 % of the time")
        .x_label("time [s]");
    for (axis, name) in
        ["x error [m]", "y error [m]", "heading error [rad]"].into_iter().enumerate()
    {
        let mut chart = Chart::new(name).reference(0.0, "");
        for (k, (method, drive)) in
            [("dead-reckoning", &lost), ("ekf", &drive)].into_iter().enumerate()
        {
            let rows = || {
                drive.beliefs.iter().zip(&drive.truth).enumerate().map(|(k, (b, t))| {
                    (
                        k as f64 * STEP,
                        b.pose_deviation(*t)[axis],
                        2.0 * b.covariance[(axis, axis)].sqrt(),
                    )
                })
            };
            chart = chart.band(Role::Method(k), method, rows().map(|(t, _, s)| (t, -s, s))).line(
                Role::Method(k),
                method,
                rows().map(|(t, e, _)| (t, e)),
            );
        }
        figure = figure.panel(chart);
    }
    keep("error_panels", &figure.render());
}

#[test]
fn log_chart_with_limits() {
    let particles =
        |k: usize| 20_000.0 * (-0.06 * k as f64).exp() + 300.0 + 40.0 * (k as f64).sin();
    let nees = |k: usize| 3.0 + 2.0 * (k as f64 * 0.7).sin() + if k == 40 { f64::NAN } else { 0.0 };
    let figure = Figure::new("Convergence of global localization")
        .x_label("time [s]")
        .panel(
            Chart::new("particles [1]")
                .log_y()
                .line(Role::Method(10), "mcl", (0..160).map(|k| (k as f64 * 0.25, particles(k))))
                .reference(500.0, "fewest for tracking"),
        )
        .panel(
            Chart::new("NEES [1]")
                .points(Role::Method(10), "mcl", (0..160).map(|k| (k as f64 * 0.25, nees(k))))
                .reference(7.81, "95 % of chi-square, 3 degrees of freedom")
                .reference(3.0, "expected mean"),
        );
    keep("log_chart", &figure.render());
}

#[test]
fn one_panel_of_many_methods() {
    let names = "dead-reckoning lateration kf ekf ukf line-ekf fusion histogram mcl kf-slam ekf-slam fastslam";
    let mut chart = Chart::new("position error [m]");
    for (k, name) in names.split(' ').enumerate() {
        let error = move |i: i32| {
            let t = f64::from(i) * 0.05;
            (t, 0.1 * (k + 1) as f64 + 0.04 * (t * (0.5 + 0.1 * k as f64)).sin())
        };
        chart = chart.line(Role::Method(k), name, (0..1200).map(error));
    }
    let figure = Figure::new("Twelve methods on one drive, each with a colour and dashes of its own, under a title of two lines")
        .x_label("time [s]")
        .panel(chart);
    keep("many_methods", &figure.render());
}

#[test]
fn a_long_recording() {
    let point = |k: i32| {
        let t = f64::from(k) * 1e-3;
        let spiral = 4.0 + 0.1 * t;
        (
            433_120.0 + spiral * t.cos() + 0.01 * (40.0 * t).sin(),
            5_793_440.0 + 0.7 * spiral * t.sin(),
        )
    };
    let scene = Scene::new("A hundred thousand positions in UTM").path(
        Role::Method(2),
        "gps",
        (0..100_000).map(point),
    );
    keep("long_utm", &scene.render());
    let noisy = |k: i32| {
        let t = 1.2e9 + f64::from(k) * 0.01;
        (t, (f64::from(k) * 1.7).sin() * (f64::from(k) * 1e-4).cos())
    };
    let chart =
        Chart::new("residual [m]").line(Role::Method(0), "residual", (0..100_000).map(noisy));
    keep("long_series", &Figure::new("Noise").x_label("time [s]").panel(chart).render());
}

#[test]
fn particles_in_a_corridor() {
    let drive = drives::circle(0, 9);
    let mut rng = loc_core::random::stream(1, "particles");
    let last = drive.beliefs[140].position();
    let cloud: Vec<(f64, f64)> =
        (0..3000).map(|_| last.sample(&mut rng)).map(|p| (p.x, p.y)).collect();
    let walls = [
        ((-12.0, -1.2), (26.0, -1.2)),
        ((-12.0, 5.5), (6.0, 5.5)),
        ((8.0, 5.5), (26.0, 5.5)),
        ((-12.0, -1.2), (-12.0, 5.5)),
    ];
    let scene = Scene::new("Particles in a corridor")
        .backdrop(Backdrop { min: (-12.0, -1.2), max: (0.0, 5.5), data_uri: CHECKERS.into() })
        .segments(Role::Obstacle.width(3.0), "wall", walls)
        .dots(Role::Method(4), "particles", cloud)
        .path(Role::Truth.dotted(), "true path", positions(&drive.truth))
        .poses(Role::Truth, "robot", [drive.truth[140]]);
    keep("corridor", &scene.render());
}

#[test]
fn single_point_and_nothing() {
    let landmark = [((5.8e6, 4.3e5), "<7>")];
    keep(
        "single",
        &Scene::new("A single landmark").crosses(Role::Landmark, "landmark", landmark).render(),
    );
    keep("empty_scene", &Scene::new("Nothing").render());
    let panels = Figure::new("Nothing")
        .x_label("time [s]")
        .panel(Chart::new("x [m]"))
        .panel(Chart::new("y [m]"));
    keep("empty_chart", &panels.render());
}

/// Two by two pixels.
const CHECKERS: &str = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAACCAAAAABX3VL4AAAADklEQVR4nGP4f5bh7H8ACs4DmS20PHEAAAAASUVORK5CYII=";
