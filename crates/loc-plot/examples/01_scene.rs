//! A map of a short drive and its errors over time, as two SVG files.
//!
//! `cargo run -p loc-plot --example 01_scene [FOLDER]` writes `scene.svg` and `errors.svg` into the
//! folder, or into the current one.

use loc_core::motion::{Integration, VelocityNoise, dead_reckon};
use loc_core::{Ellipse, Gaussian, Pose2, Twist2};
use loc_plot::{Chart, Figure, Role, Scene};
use std::f64::consts::TAU;
use std::path::PathBuf;

/// Time step \[s\].
const STEP: f64 = 0.1;

fn main() -> std::io::Result<()> {
    let folder = std::env::args().nth(1).map_or_else(|| PathBuf::from("."), PathBuf::from);

    // The robot drives a circle. Its odometry believes in a slightly smaller turn rate.
    let twist = Twist2::forward(1.0, TAU / 14.0);
    let believed = Twist2 { omega: 0.97 * twist.omega, ..twist };
    let noise = VelocityNoise { distance_sigma: 0.02, ..VelocityNoise::NONE };
    let mut truth = vec![Pose2::new(2.0, 0.0, 0.0)];
    let mut beliefs = vec![Gaussian::certain(truth[0].to_vector())];
    for k in 0..130 {
        truth.push(Integration::ExactArc.step(truth[k], twist, STEP));
        beliefs.push(dead_reckon(&beliefs[k], believed, STEP, Integration::ExactArc, &noise));
    }

    // The plane from above. Things are drawn in the order in which they come.
    let ellipses = beliefs.iter().skip(20).step_by(20);
    let ellipses: Vec<Ellipse> = ellipses.map(|belief| belief.position().ellipse(2.0)).collect();
    let scene = Scene::new("Dead reckoning on a circle")
        .subtitle("ellipses of 2 standard deviations every 2 s")
        .ellipses(Role::Method(0).width(0.9), "2 sigma", ellipses)
        .path(Role::Truth.dotted(), "true path", truth.iter().map(|pose| (pose.x, pose.y)))
        .path(Role::Method(0), "estimate", beliefs.iter().map(|b| (b.mean.x, b.mean.y)))
        .poses(Role::Method(0), "", beliefs.last().map(Gaussian::pose))
        .crosses(Role::Landmark, "landmark", [((0.0, 2.0), "1"), ((4.5, 3.0), "2")]);

    // Quantities over time. The band shows what the covariance promises.
    let pairs = || beliefs.iter().zip(&truth).enumerate();
    let error = pairs().map(|(k, (belief, truth))| (k as f64 * STEP, belief.mean.x - truth.x));
    let band = pairs().map(|(k, (belief, _))| {
        let sigma = belief.covariance.m11.sqrt();
        (k as f64 * STEP, -2.0 * sigma, 2.0 * sigma)
    });
    let chart = Chart::new("error in x [m]")
        .band(Role::Method(0), "2 sigma", band)
        .line(Role::Method(0), "estimate", error)
        .reference(0.0, "");
    let figure = Figure::new("The error, and what the covariance promises")
        .x_label("time [s]")
        .mark(7.0, "half of the circle")
        .panel(chart);

    std::fs::write(folder.join("scene.svg"), scene.render())?;
    std::fs::write(folder.join("errors.svg"), figure.render())
}
