//! What resampling does to a robot that stands still and sees nothing new (M11).
//!
//! Nothing happens, so nothing should be learned or forgotten. Yet every resampling by roulette
//! draws some particles twice and others never; in the end all are copies of one, and the filter
//! is sure of a place that chance has chosen. The spoke wheel draws each of equally weighted
//! particles exactly once. Where weights differ it loses particles too, only fewer; therefore one
//! resamples seldom: every N-th update, or when the weights have become unequal.

mod figure;

use super::count;
use crate::Result;
use crate::output::Illustration;
use loc_core::Pose2;
use loc_core::error::non_negative;
use loc_core::random::stream;
use loc_pf::resample::{ResamplePolicy, ResampleWhen};
use loc_pf::{ParticleFilter, Particles, Resampling};
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;
use serde_json::json;
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

impl DiversityConfig {
    pub(super) fn check(&self) -> Result<()> {
        count("demonstration.particles", self.particles, 100_000)?;
        count("demonstration.steps", self.steps, 100_000)?;
        count("demonstration.every", self.every, 100_000)?;
        non_negative("demonstration.scatter", self.scatter)?;
        self.on_share().validate()?;
        Ok(())
    }

    fn on_share(&self) -> ResamplePolicy {
        ResamplePolicy { every: 1, when: ResampleWhen::EffectiveShareBelow(self.effective_share) }
    }
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
    config: DiversityConfig,
    /// Equal weights, resampled at each update, by each scheme.
    pub equal: Vec<Course>,
    /// Weights that scatter, resampled at each update, by each scheme.
    pub scattered: Vec<Course>,
    /// Weights that scatter, by the spoke wheel, under each policy.
    pub seldom: Vec<Course>,
}

const ALWAYS: ResamplePolicy = ResamplePolicy { every: 1, when: ResampleWhen::Always };

impl Diversity {
    /// Lets the robot stand still.
    ///
    /// # Errors
    /// Values out of range.
    pub fn new(config: &DiversityConfig, seed: u64) -> Result<Self> {
        config.check()?;
        let by_scheme = |scatter: f64| {
            let course = |scheme| Course {
                name: name(scheme).into(),
                ancestors: ancestors(config, scatter, scheme, ALWAYS, seed),
            };
            Resampling::ALL.map(course).to_vec()
        };
        let every = ResamplePolicy { every: config.every, when: ResampleWhen::Always };
        let policies = [
            ("at every update".to_owned(), ALWAYS),
            (format!("at every {}th update", config.every), every),
            (format!("below {:.0} % effective", 100.0 * config.effective_share), config.on_share()),
        ];
        let seldom = policies.map(|(name, policy)| Course {
            name,
            ancestors: ancestors(config, config.scatter, Resampling::Systematic, policy, seed),
        });
        Ok(Diversity {
            config: config.clone(),
            equal: by_scheme(0.0),
            scattered: by_scheme(config.scatter),
            seldom: seldom.to_vec(),
        })
    }

    /// The courses as a figure and numbers.
    pub fn illustrate(&self, title: &str) -> Illustration {
        let groups = [
            ("equal weights, resampled at every update", &self.equal),
            ("weights that scatter, resampled at every update", &self.scattered),
            ("weights that scatter, spoke wheel, resampled", &self.seldom),
        ];
        let mut lines = vec![format!(
            "of {} particles after {} updates:",
            self.config.particles, self.config.steps
        )];
        for (group, courses) in groups {
            lines.push(group.to_owned());
            let row =
                |course: &Course| format!("  {:<24}{:>8} ancestors", course.name, course.left());
            lines.extend(courses.iter().map(row));
        }
        let left = |courses: &[Course]| {
            let pairs = courses.iter().map(|course| (course.name.clone(), json!(course.left())));
            serde_json::Value::Object(pairs.collect())
        };
        let summary = json!({
            "particles": self.config.particles,
            "updates": self.config.steps,
            "ancestors_left": {
                "equal_weights": left(&self.equal),
                "scattered_weights": left(&self.scattered),
                "seldom": left(&self.seldom),
            },
        });
        Illustration::new(lines, summary, vec![figure::figure(self, title)])
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

/// Runs the filter; the x of a particle, which never moves, tells its ancestor.
fn ancestors(
    config: &DiversityConfig,
    scatter: f64,
    scheme: Resampling,
    policy: ResamplePolicy,
    seed: u64,
) -> Vec<usize> {
    let cloud =
        Particles::from_poses((0..config.particles).map(|k| Pose2::new(k as f64, 0.0, 0.0)));
    let mut filter = ParticleFilter::new(cloud, stream(seed, "filter"));
    let mut chance = stream(seed, "weights");
    let (mut courses, mut updates) = (vec![config.particles], 0);
    for _ in 0..config.steps {
        if scatter > 0.0 {
            let weights = filter.particles_mut().log_weights_mut();
            weights.iter_mut().for_each(|weight| {
                let draw: f64 = StandardNormal.sample(&mut chance);
                *weight += scatter * draw;
            });
            filter.normalize();
        }
        updates += 1;
        let effective = filter.particles().effective_sample_size();
        if policy.is_due(updates, effective, config.particles) {
            filter.resample(scheme, config.particles);
            updates = 0;
        }
        courses.push(distinct(filter.particles()));
    }
    courses
}

fn distinct(cloud: &Particles) -> usize {
    cloud.poses().x.iter().map(|x| *x as usize).collect::<BTreeSet<usize>>().len()
}
