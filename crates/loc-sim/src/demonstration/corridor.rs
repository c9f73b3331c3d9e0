//! Localization in one dimension, in a corridor with doors that look all the same: with particles
//! (Monte Carlo localization, M2), and with a histogram (Markov localization, F5, K1).
//!
//! The robot knows where the doors are but not where it is. It observes doors and drives. With
//! particles it sees a door twice: two of the doors are nearer to each other than any others, and
//! only a start at the first of them fits. With a histogram a report, of a door or of none,
//! multiplies each bar by its likelihood there; a drive moves all bars along and blurs them.

use super::{Demonstration, check_count};
use crate::Result;
use crate::config::field;
use crate::output::Illustration;
use crate::output::figures::FigureFile;
use loc_core::Pose2;
use loc_core::error::{in_range, non_negative, positive, probability};
use loc_core::random::{ChaCha8Rng, stream};
use loc_filters::histogram::LineGrid;
use loc_pf::{ParticleFilter, Particles, Resampling};
use loc_plot::{Chart, Figure, Role};
use rand::RngExt;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;
use serde_json::json;

/// Monte Carlo localization: the corridor, and what the robot does in it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mcl1dConfig {
    /// Length of the corridor \[m\].
    pub length: f64,
    /// The middles of the doors \[m\].
    pub doors: Vec<f64>,
    /// Where the robot starts \[m\].
    pub start: f64,
    /// How far it drives between the two observations \[m\].
    pub drive: f64,
    /// Standard deviation of the distance driven \[m\].
    pub drive_sigma: f64,
    /// How far from a door's middle a robot may be that sees it, as a standard deviation \[m\].
    pub door_sigma: f64,
    /// How likely a door is reported where none is, beside one right before it.
    pub false_door: f64,
    /// Number of particles.
    pub particles: usize,
}

/// The particles after one step of the filter.
#[derive(Debug, Clone)]
pub struct Stage {
    /// What has just happened.
    pub name: &'static str,
    /// Place \[m\] and weight of each particle.
    pub particles: Vec<(f64, f64)>,
    /// True place of the robot \[m\].
    pub truth: f64,
    /// Whether the particles have just been weighed.
    pub weighed: bool,
}

/// Half the width of a door, as it is drawn \[m\].
const HALF_DOOR: f64 = 0.5;

impl Mcl1dConfig {
    /// How likely it is to report a door at a place, beside being right before one.
    pub fn likelihood(&self, place: f64) -> f64 {
        let nearness = |door: &f64| (-0.5 * ((place - door) / self.door_sigma).powi(2)).exp();
        self.false_door + self.doors.iter().map(nearness).sum::<f64>()
    }

    /// Runs the filter through its five stages, a to e.
    ///
    /// # Errors
    /// Values out of range.
    pub fn stages(&self, seed: u64) -> Result<Vec<Stage>> {
        self.check()?;
        let (count, mut rng) = (self.particles, stream(seed, "demonstration"));
        let at = |place: f64| Pose2::new(place, 0.0, 0.0);
        // Evenly spread, so that the prior looks like what it is.
        let spread = |k: usize, u: f64| (k as f64 + u) / count as f64;
        let places = (0..count).map(|k| self.length * spread(k, rng.random::<f64>()));
        let particles = Particles::from_poses(places.map(at));
        let mut filter = ParticleFilter::new(particles, stream(seed, "filter"));
        let door = |pose: Pose2| self.likelihood(pose.x).ln();
        let drive = |pose: Pose2, rng: &mut ChaCha8Rng| {
            let error: f64 = StandardNormal.sample(rng);
            // A wall ends the corridor.
            at((pose.x + self.drive + self.drive_sigma * error).clamp(0.0, self.length))
        };
        let (start, end) = (self.start, self.start + self.drive);
        let stage = |name, filter: &ParticleFilter, truth, weighed| {
            let set = filter.particles();
            let particles = set.poses().x.iter().copied().zip(set.weights()).collect();
            Stage { name, particles, truth, weighed }
        };
        let mut stages = vec![stage("a: no idea", &filter, start, false)];
        filter.weigh(&door);
        filter.normalize();
        stages.push(stage("b: a door is seen", &filter, start, true));
        filter.resample(Resampling::Systematic, count);
        filter.predict(&drive);
        stages.push(stage("c: resampled, driven on", &filter, end, false));
        filter.weigh(&door);
        filter.normalize();
        stages.push(stage("d: a door is seen again", &filter, end, true));
        filter.resample(Resampling::Systematic, count);
        stages.push(stage("e: resampled", &filter, end, false));
        Ok(stages)
    }

    /// Particles as stems; their weights as multiples of an equal share.
    fn panel(&self, stage: &Stage) -> Chart {
        let equal = 1.0 / self.particles as f64;
        let weights = || stage.particles.iter().map(|&(place, weight)| (place, weight / equal));
        let highest = weights().map(|(_, weight)| weight).fold(0.0, f64::max);
        panel(stage.name, (&self.doors, HALF_DOOR), self.length, highest, stage.truth, |chart| {
            let chart = chart.stems(Role::Method(0).width(0.7), "particle", weights());
            if !stage.weighed {
                return chart;
            }
            // Right before a door the report is as likely as it can be.
            let doors = self.doors.iter().map(|&door| self.likelihood(door));
            let scale = highest / doors.fold(0.0, f64::max);
            let curve = (0..=400).map(|k| self.length * f64::from(k) / 400.0);
            let curve = curve.map(|place| (place, scale * self.likelihood(place)));
            chart.line(Role::Method(1), "likelihood of seeing a door (its own scale)", curve)
        })
    }
}

impl Demonstration for Mcl1dConfig {
    fn check(&self) -> Result<()> {
        positive("demonstration.length", self.length)?;
        check_places(self.length, &self.doors, self.start)?;
        inside(self.length, "demonstration.start + drive", self.start + self.drive)?;
        non_negative("demonstration.drive_sigma", self.drive_sigma)?;
        positive("demonstration.door_sigma", self.door_sigma)?;
        positive("demonstration.false_door", self.false_door)?;
        check_count("demonstration.particles", self.particles, 100_000)
    }

    fn run(&self, title: &str, seed: u64) -> Result<Illustration> {
        let (all, count) = (self.stages(seed)?, self.particles);
        let head = ["mean [m]", "sigma [m]", "near truth"];
        let mut lines =
            vec![format!("{:<24}{:>10}{:>11}{:>12}", "stage", head[0], head[1], head[2])];
        let mut stages = Vec::new();
        let mut figure = Figure::new(title)
            .subtitle(format!(
                "{count} particles, each a line as high as its weight; 1 is an equal share"
            ))
            .x_label("place in the corridor [m]");
        for stage in &all {
            let ([mean, sigma], near) = (stage.moments(), stage.near_truth());
            let name = stage.name;
            lines.push(format!("{name:<24}{mean:>10.2}{sigma:>11.2}{:>10.1} %", 100.0 * near));
            stages.push(json!({"stage": name, "truth_m": stage.truth, "mean_m": mean,
                "sigma_m": sigma, "share_near_truth": near}));
            figure = figure.panel(self.panel(stage));
        }
        let caption = "Particles with their weights in a corridor with doors, in five stages";
        let figures = vec![FigureFile::new("stages.svg", caption, figure.render())];
        Ok(Illustration::new(lines, json!({"particles": count, "stages": stages}), figures))
    }
}

impl Stage {
    /// Weighted mean and standard deviation \[m\].
    pub fn moments(&self) -> [f64; 2] {
        let mean: f64 = self.particles.iter().map(|(x, weight)| weight * x).sum();
        let squares = self.particles.iter().map(|(x, weight)| weight * (x - mean).powi(2));
        [mean, squares.sum::<f64>().sqrt()]
    }

    /// Total weight within 1 m of the truth.
    pub fn near_truth(&self) -> f64 {
        let near = self.particles.iter().filter(|(x, _)| (x - self.truth).abs() <= 1.0);
        near.map(|(_, weight)| weight).sum()
    }
}

/// Markov localization: the corridor, and what the robot does in it.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoorCorridorConfig {
    /// Length of the corridor \[m\].
    pub length: f64,
    /// Length of a cell \[m\].
    pub cell: f64,
    /// The middles of the doors \[m\].
    pub doors: Vec<f64>,
    /// Width of each door \[m\].
    pub door_width: f64,
    /// Where the robot starts \[m\].
    pub start: f64,
    /// How far it drives between two observations, backwards if negative; 1 to 8 drives, each of
    /// which takes two panels of the figure \[m\].
    pub drives: Vec<f64>,
    /// Standard deviation of the distance after 1 m \[m\].
    pub drive_sigma: f64,
    /// P(reports a door | there is one).
    pub sees_door: f64,
    /// P(reports a door | there is none).
    pub false_door: f64,
}

/// The belief after one step.
#[derive(Debug, Clone)]
pub struct Step {
    /// What has just happened.
    pub name: String,
    /// The belief.
    pub belief: LineGrid,
    /// True place of the robot \[m\].
    pub truth: f64,
}

impl DoorCorridorConfig {
    fn is_door(&self, place: f64) -> bool {
        self.doors.iter().any(|door| (place - door).abs() <= 0.5 * self.door_width)
    }

    /// P(report | place).
    fn likelihood(&self, reported: bool, place: f64) -> f64 {
        let door = if self.is_door(place) { self.sees_door } else { self.false_door };
        if reported { door } else { 1.0 - door }
    }

    /// Drives and filters; the first step is before anything has happened. The robot and its errors
    /// are drawn with the seed, the filter ([`LineGrid`]) draws nothing.
    ///
    /// # Errors
    /// Values out of range.
    pub fn steps(&self, seed: u64) -> Result<Vec<Step>> {
        self.check()?;
        let mut rng = stream(seed, "demonstration");
        let mut belief = LineGrid::uniform(self.length, self.cell)?;
        let mut truth = self.start;
        let mut steps = vec![Step { name: "no idea".into(), belief: belief.clone(), truth }];
        for drive in std::iter::once(None).chain(self.drives.iter().map(Some)) {
            if let Some(&distance) = drive {
                let error: f64 = StandardNormal.sample(&mut rng);
                let sigma = self.drive_sigma * distance.abs().sqrt();
                truth = (truth + distance + error * sigma).clamp(0.0, self.length);
                belief.predict(distance, sigma)?;
                let name = format!("drives {distance} m");
                steps.push(Step { name, belief: belief.clone(), truth });
            }
            let reported = rng.random::<f64>() < self.likelihood(true, truth);
            belief.correct(|place| self.likelihood(reported, place))?;
            let what = if reported { "a door" } else { "no door" };
            let wrong = if reported == self.is_door(truth) { "" } else { " (wrong)" };
            steps.push(Step { name: format!("sees {what}{wrong}"), belief: belief.clone(), truth });
        }
        Ok(steps)
    }

    fn panel(&self, step: &Step) -> Chart {
        let (belief, doors) = (&step.belief, (&self.doors[..], 0.5 * self.door_width));
        let highest = belief.probabilities().iter().copied().fold(0.0, f64::max);
        let heights = belief.centers().zip(belief.probabilities().iter().copied());
        panel(&step.name, doors, self.length, highest, step.truth, |chart| {
            chart.bars(Role::Method(0), "belief", 0.9 * belief.cell(), heights)
        })
    }
}

impl Demonstration for DoorCorridorConfig {
    fn check(&self) -> Result<()> {
        positive("demonstration.length", self.length)?;
        positive("demonstration.cell", self.cell)?;
        LineGrid::uniform(self.length, self.cell)?;
        positive("demonstration.door_width", self.door_width)?;
        non_negative("demonstration.drive_sigma", self.drive_sigma)?;
        probability("demonstration.sees_door", self.sees_door)?;
        let possible = |p: f64| p > 0.0 && p < 1.0;
        let expected = "a number above 0 and below 1";
        in_range("demonstration.false_door", expected, self.false_door, possible)?;
        check_places(self.length, &self.doors, self.start)?;
        let drives = self.drives.len();
        if !(1..=8).contains(&drives) {
            return Err(field("demonstration.drives", "1 to 8 drives", &drives.to_string()));
        }
        let mut place = self.start;
        self.drives.iter().try_for_each(|drive| {
            place += drive;
            inside(self.length, "demonstration.start + drives", place)
        })
    }

    fn run(&self, title: &str, seed: u64) -> Result<Illustration> {
        let all = self.steps(seed)?;
        let head = [("truth [m]", 11), ("most likely", 13), ("mean", 8), ("sigma", 8)];
        let head = head.map(|(name, width)| format!("{name:>width$}")).concat();
        let mut lines = vec![format!("{:<24}{head}{:>14}", "step", "near truth")];
        let mut steps = Vec::new();
        let cell = all[0].belief.cell();
        let mut figure = Figure::new(title)
            .subtitle(format!("probability of each cell of {cell:.2} m, after each step"))
            .x_label("place in the corridor [m]");
        for step in &all {
            let Step { name, belief, truth } = step;
            let (likely, mean, sigma) =
                (belief.most_likely(), belief.mean(), belief.variance().sqrt());
            let near = step.near_truth();
            let moments = format!("{truth:>11.2}{likely:>13.2}{mean:>8.2}{sigma:>8.2}");
            lines.push(format!("{name:<24}{moments}{:>12.1} %", 100.0 * near));
            steps.push(json!({"step": name, "truth_m": truth, "most_likely_m": likely,
                "mean_m": mean, "sigma_m": sigma, "share_near_truth": near}));
            figure = figure.panel(self.panel(step));
        }
        let summary = json!({"cells": all[0].belief.probabilities().len(), "steps": steps});
        let caption = "The belief over the places of a corridor after each step";
        let figures = vec![FigureFile::new("beliefs.svg", caption, figure.render())];
        Ok(Illustration::new(lines, summary, figures))
    }
}

impl Step {
    /// The probability of being within 0.5 m of the truth.
    pub fn near_truth(&self) -> f64 {
        self.belief.probability(self.truth - 0.5, self.truth + 0.5)
    }
}

fn inside(length: f64, key: &str, place: f64) -> Result<()> {
    if (0.0..=length).contains(&place) {
        return Ok(());
    }
    Err(field(key, "a place in the corridor", &place.to_string()))
}

fn check_places(length: f64, doors: &[f64], start: f64) -> Result<()> {
    doors.iter().try_for_each(|&door| inside(length, "demonstration.doors", door))?;
    inside(length, "demonstration.start", start)
}

/// Doors (middles and half their width), the belief up to `highest`, and the true place.
fn panel(
    name: &str,
    (doors, half): (&[f64], f64),
    length: f64,
    highest: f64,
    truth: f64,
    belief: impl FnOnce(Chart) -> Chart,
) -> Chart {
    let top = 1.15 * highest;
    let chart = Chart::new(name).y_range(0.0, top);
    let chart = doors.iter().fold(chart, |chart, door| {
        chart.band(Role::Map, "door", [(door - half, 0.0, top), (door + half, 0.0, top)])
    });
    // The ends of the corridor, so that all panels are equally wide.
    belief(chart).stems(Role::Truth.dashed(), "robot", [(truth, top)]).line(
        Role::Map,
        "",
        [(0.0, 0.0), (length, 0.0)],
    )
}
