//! Markov localization in one dimension (F5, K1): a corridor with doors that look all the same.
//!
//! The belief is a histogram over the places of the corridor. A look for a door multiplies each bar
//! by how likely the report is there; a drive moves all bars along and blurs them. The robot and
//! its errors are drawn with the seed, the filter ([`LineGrid`]) draws nothing.

mod figure;

use crate::Result;
use crate::config::field;
use crate::output::Illustration;
use loc_core::error::{in_range, non_negative, positive, probability};
use loc_core::random::stream;
use loc_filters::histogram::LineGrid;
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;
use serde_json::json;

/// The corridor, and what the robot does in it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoorCorridorConfig {
    /// Length of the corridor.
    pub length_m: f64,
    /// Length of a cell.
    pub cell_m: f64,
    /// The middles of the doors.
    pub doors_m: Vec<f64>,
    /// Width of each door.
    pub door_width_m: f64,
    /// Where the robot really starts.
    pub start_m: f64,
    /// How far it drives between two looks, backwards if negative.
    pub drives_m: Vec<f64>,
    /// Standard deviation of the way after 1 m.
    pub drive_sigma_m: f64,
    /// P(reports a door | there is one).
    pub sees_door: f64,
    /// P(reports a door | there is none).
    pub false_door: f64,
}

/// The most drives, each of which takes two panels of the figure.
const MAX_DRIVES: usize = 8;

impl DoorCorridorConfig {
    pub(super) fn check(&self) -> Result<()> {
        positive("demonstration.length_m", self.length_m)?;
        positive("demonstration.cell_m", self.cell_m)?;
        LineGrid::uniform(self.length_m, self.cell_m)?;
        positive("demonstration.door_width_m", self.door_width_m)?;
        non_negative("demonstration.drive_sigma_m", self.drive_sigma_m)?;
        probability("demonstration.sees_door", self.sees_door)?;
        let possible = |p: f64| p > 0.0 && p < 1.0;
        in_range(
            "demonstration.false_door",
            "a number above 0 and below 1",
            self.false_door,
            possible,
        )?;
        let inside = |key: &str, place: f64| match place {
            place if (0.0..=self.length_m).contains(&place) => Ok(()),
            place => Err(field(key, "a place in the corridor", &place.to_string())),
        };
        self.doors_m.iter().try_for_each(|&door| inside("demonstration.doors_m", door))?;
        inside("demonstration.start_m", self.start_m)?;
        if !(1..=MAX_DRIVES).contains(&self.drives_m.len()) {
            let expected = format!("1 to {MAX_DRIVES} drives");
            return Err(field(
                "demonstration.drives_m",
                &expected,
                &self.drives_m.len().to_string(),
            ));
        }
        let mut place = self.start_m;
        self.drives_m.iter().try_for_each(|drive| {
            place += drive;
            inside("demonstration.start_m + drives_m", place)
        })
    }

    fn is_door(&self, place: f64) -> bool {
        self.doors_m.iter().any(|door| (place - door).abs() <= 0.5 * self.door_width_m)
    }

    /// P(report | place).
    fn likelihood(&self, reported: bool, place: f64) -> f64 {
        let door = if self.is_door(place) { self.sees_door } else { self.false_door };
        if reported { door } else { 1.0 - door }
    }
}

/// The belief after one step.
#[derive(Debug, Clone)]
pub struct Step {
    /// What has just happened.
    pub name: String,
    /// What is believed.
    pub belief: LineGrid,
    /// Where the robot really is \[m\].
    pub truth: f64,
}

/// A drive along the corridor.
#[derive(Debug, Clone)]
pub struct DoorCorridor {
    config: DoorCorridorConfig,
    /// The steps, the first one before anything has happened.
    pub steps: Vec<Step>,
}

impl DoorCorridor {
    /// Drives and filters.
    ///
    /// # Errors
    /// Values out of range.
    pub fn new(config: &DoorCorridorConfig, seed: u64) -> Result<Self> {
        config.check()?;
        let belief = LineGrid::uniform(config.length_m, config.cell_m)?;
        let mut robot = Robot { config, truth: config.start_m, belief, steps: Vec::new() };
        let mut rng = stream(seed, "demonstration");
        robot.keep("no idea".into());
        robot.look(rng.random())?;
        for &drive in &config.drives_m {
            robot.drive(drive, StandardNormal.sample(&mut rng))?;
            robot.look(rng.random())?;
        }
        Ok(DoorCorridor { config: config.clone(), steps: robot.steps })
    }

    /// The steps as a figure and numbers.
    pub fn illustrate(&self, title: &str) -> Illustration {
        let head = [("truth [m]", 11), ("most likely", 13), ("mean", 8), ("sigma", 8)];
        let head = head.map(|(name, width)| format!("{name:>width$}")).concat();
        let mut lines = vec![format!("{:<24}{head}{:>14}", "step", "near truth")];
        lines.extend(self.steps.iter().map(|step| {
            let Step { name, belief, truth } = step;
            let (likely, mean, sigma) =
                (belief.most_likely(), belief.mean(), belief.variance().sqrt());
            let near = 100.0 * step.near_truth();
            format!("{name:<24}{truth:>11.2}{likely:>13.2}{mean:>8.2}{sigma:>8.2}{near:>12.1} %")
        }));
        let steps = self.steps.iter().map(|step| {
            json!({
                "step": step.name,
                "truth_m": step.truth,
                "most_likely_m": step.belief.most_likely(),
                "mean_m": step.belief.mean(),
                "sigma_m": step.belief.variance().sqrt(),
                "share_near_truth": step.near_truth(),
            })
        });
        let summary = json!({"cells": self.steps[0].belief.probabilities().len(),
            "steps": steps.collect::<Vec<_>>()});
        Illustration::new(lines, summary, vec![figure::figure(self, title)])
    }
}

/// How near counts as near the truth \[m\].
const NEAR: f64 = 0.5;

impl Step {
    /// The probability of being within 0.5 m of the truth.
    pub fn near_truth(&self) -> f64 {
        self.belief.probability(self.truth - NEAR, self.truth + NEAR)
    }
}

/// The robot with its filter.
struct Robot<'a> {
    config: &'a DoorCorridorConfig,
    truth: f64,
    belief: LineGrid,
    steps: Vec<Step>,
}

impl Robot<'_> {
    fn keep(&mut self, name: String) {
        self.steps.push(Step { name, belief: self.belief.clone(), truth: self.truth });
    }

    /// Looks for a door; `chance` in \[0, 1) decides whether the report is wrong.
    fn look(&mut self, chance: f64) -> Result<()> {
        let config = self.config;
        let reported = chance < config.likelihood(true, self.truth);
        self.belief.correct(|place| config.likelihood(reported, place))?;
        let right = reported == config.is_door(self.truth);
        let what = if reported { "a door" } else { "no door" };
        self.keep(format!("sees {what}{}", if right { "" } else { " (wrong)" }));
        Ok(())
    }

    /// Drives on, with an error of so many standard deviations.
    fn drive(&mut self, way: f64, error: f64) -> Result<()> {
        let sigma = self.config.drive_sigma_m * way.abs().sqrt();
        self.truth = (self.truth + way + error * sigma).clamp(0.0, self.config.length_m);
        self.belief.predict(way, sigma)?;
        self.keep(format!("drives {way} m"));
        Ok(())
    }
}
