//! What resampling does to a robot that stands still and observes nothing new (M11).
//!
//! Nothing happens, so nothing should be learned or forgotten. Yet every resampling by roulette
//! (multinomial) draws some particles twice and others never; in the end all are copies of one, and
//! the filter is confident of a place that chance has chosen. Low-variance (systematic) resampling,
//! the lectures' spoke wheel, draws each of equally weighted particles exactly once. Where weights
//! differ it loses particles too, only fewer; therefore one resamples seldom: every N-th update, or
//! when the weights have become unequal.

use super::{Demonstration, check_count};
use crate::Result;
use crate::output::Illustration;
use crate::output::figures::FigureFile;
use loc_core::Pose2;
use loc_core::error::non_negative;
use loc_core::random::stream;
use loc_pf::resample::{ResamplePolicy, ResampleWhen};
use loc_pf::{ParticleFilter, Particles, Resampling};
use loc_plot::{Chart, Figure, Role};
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// The robot that stands still.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DiversityConfig {
    /// Number of particles.
    pub particles: usize,
    /// Number of updates.
    pub steps: usize,
    /// How far the logarithms of the weights scatter by chance at each update where they are not
    /// equal, as a standard deviation.
    pub scatter: f64,
    /// Resampling at every N-th update, where it is not at each.
    pub every: usize,
    /// Resampling below this effective share of the particles, where it waits for unequal weights.
    pub effective_share: f64,
}

/// How many of the first particles still have descendants, over time.
#[derive(Debug, Clone)]
pub struct Course {
    /// How it was resampled.
    pub name: String,
    /// Number of distinct ancestors before the first update and after each.
    pub ancestors: Vec<usize>,
}

/// The courses of all schemes and policies.
#[derive(Debug, Clone)]
pub struct Diversity {
    /// Equal weights, resampled at each update, by each scheme.
    pub equal: Vec<Course>,
    /// Weights that scatter, resampled at each update, by each scheme.
    pub scattered: Vec<Course>,
    /// Weights that scatter, low-variance resampling, under each policy.
    pub seldom: Vec<Course>,
}

const ALWAYS: ResamplePolicy = ResamplePolicy { every: 1, when: ResampleWhen::Always };

impl DiversityConfig {
    fn on_share(&self) -> ResamplePolicy {
        ResamplePolicy { every: 1, when: ResampleWhen::EffectiveShareBelow(self.effective_share) }
    }

    /// Runs the filter under every scheme and policy.
    ///
    /// # Errors
    /// Values out of range.
    pub fn courses(&self, seed: u64) -> Result<Diversity> {
        self.check()?;
        let by_scheme = |scatter: f64| {
            let course = |scheme| Course {
                name: name(scheme).into(),
                ancestors: self.ancestors(scatter, scheme, ALWAYS, seed),
            };
            Resampling::ALL.map(course).to_vec()
        };
        let every = ResamplePolicy { every: self.every, when: ResampleWhen::Always };
        let policies = [
            ("at every update".to_owned(), ALWAYS),
            (format!("at every {}th update", self.every), every),
            (format!("below {:.0} % effective", 100.0 * self.effective_share), self.on_share()),
        ];
        let seldom = policies.map(|(name, policy)| Course {
            name,
            ancestors: self.ancestors(self.scatter, Resampling::Systematic, policy, seed),
        });
        let (equal, scattered) = (by_scheme(0.0), by_scheme(self.scatter));
        Ok(Diversity { equal, scattered, seldom: seldom.to_vec() })
    }

    /// Runs the filter; the x of a particle, which never moves, tells its ancestor.
    fn ancestors(
        &self,
        scatter: f64,
        scheme: Resampling,
        policy: ResamplePolicy,
        seed: u64,
    ) -> Vec<usize> {
        let poses = (0..self.particles).map(|k| Pose2::new(k as f64, 0.0, 0.0));
        let mut filter = ParticleFilter::new(Particles::from_poses(poses), stream(seed, "filter"));
        let mut chance = stream(seed, "weights");
        let (mut ancestors, mut updates) = (vec![self.particles], 0);
        for _ in 0..self.steps {
            if scatter > 0.0 {
                for weight in filter.particles_mut().log_weights_mut() {
                    let draw: f64 = StandardNormal.sample(&mut chance);
                    *weight += scatter * draw;
                }
                filter.normalize();
            }
            updates += 1;
            let effective = filter.particles().effective_sample_size();
            if policy.is_due(updates, effective, self.particles) {
                filter.resample(scheme, self.particles);
                updates = 0;
            }
            let distinct = filter.particles().poses().x.iter().map(|x| *x as usize);
            ancestors.push(distinct.collect::<BTreeSet<usize>>().len());
        }
        ancestors
    }

    fn draw(&self, diversity: &Diversity, title: &str) -> FigureFile {
        let (scatter, count) = (self.scatter, self.particles);
        let scattered = format!("ln(weight) scatters by {scatter}: ancestors left");
        let seldom = "the same, spoke wheel, resampled more or less often";
        // The first course of the last panel is the last one of the panel above.
        let same = diversity.scattered.len() - 1;
        let figure = Figure::new(title)
            .subtitle(format!(
                "{count} particles; where weights are equal, all but roulette lose none"
            ))
            .x_label("update")
            .panel(panel("equal weights: ancestors left", &diversity.equal, count, 0))
            .panel(panel(&scattered, &diversity.scattered, count, 0))
            .panel(panel(seldom, &diversity.seldom, count, same));
        let caption = "Number of particles whose descendants survive resampling, over time";
        FigureFile::new("diversity.svg", caption, figure.render())
    }
}

impl Demonstration for DiversityConfig {
    fn check(&self) -> Result<()> {
        check_count("demonstration.particles", self.particles, 100_000)?;
        check_count("demonstration.steps", self.steps, 100_000)?;
        check_count("demonstration.every", self.every, 100_000)?;
        non_negative("demonstration.scatter", self.scatter)?;
        self.on_share().check()?;
        Ok(())
    }

    fn run(&self, title: &str, seed: u64) -> Result<Illustration> {
        let diversity = self.courses(seed)?;
        let groups = [
            ("equal weights, resampled at every update", &diversity.equal),
            ("weights that scatter, resampled at every update", &diversity.scattered),
            ("weights that scatter, spoke wheel, resampled", &diversity.seldom),
        ];
        let mut lines =
            vec![format!("of {} particles after {} updates:", self.particles, self.steps)];
        for (group, courses) in groups {
            lines.push(group.to_owned());
            let row = |c: &Course| format!("  {:<24}{:>8} ancestors", c.name, c.left());
            lines.extend(courses.iter().map(row));
        }
        let left = |courses: &[Course]| {
            Value::Object(courses.iter().map(|c| (c.name.clone(), json!(c.left()))).collect())
        };
        let ancestors_left = json!({
            "equal_weights": left(&diversity.equal),
            "scattered_weights": left(&diversity.scattered),
            "seldom": left(&diversity.seldom),
        });
        let summary = json!({"particles": self.particles, "updates": self.steps,
            "ancestors_left": ancestors_left});
        Ok(Illustration::new(lines, summary, vec![self.draw(&diversity, title)]))
    }
}

impl Course {
    /// Ancestors left at the end.
    pub fn left(&self) -> usize {
        self.ancestors.last().copied().unwrap_or(0)
    }
}

fn name(scheme: Resampling) -> &'static str {
    match scheme {
        Resampling::Roulette => "roulette",
        Resampling::Residual => "residual",
        Resampling::Stratified => "stratified",
        Resampling::Systematic => "spoke wheel",
    }
}

/// Courses in the colours from `first` on. Earlier ones are drawn wider, so that those that coincide
/// can be seen.
fn panel(label: &str, courses: &[Course], particles: usize, first: usize) -> Chart {
    let chart = Chart::new(label).log_y().y_range(0.8, 1.5 * particles as f64);
    courses.iter().enumerate().fold(chart, |chart, (k, course)| {
        let over_time = course.ancestors.iter().enumerate();
        let points = over_time.map(|(step, left)| (step as f64, *left as f64));
        let width = 1.8 + 0.9 * (courses.len() - 1 - k) as f64;
        chart.line(Role::Method(first + k).width(width), &course.name, points)
    })
}
