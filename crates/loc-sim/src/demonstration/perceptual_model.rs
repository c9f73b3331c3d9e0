//! The perceptual model learned from scans (K2).
//!
//! A laser looks around at many places of a world. Some of its beams are stopped by what the map
//! does not know (people), some do not come back (glass). From the true poses every beam is cast in the map; the pairs of expected and
//! measured ranges are counted, and the parameters of the beam model are fitted to them by
//! expectation maximization. What was put in is known, so that the fit can be held against it.

use super::count;
use crate::output::Illustration;
use crate::output::figures::FigureFile;
use crate::perceptual::{LearnSettings, Learned, learn};
use crate::source::tour::{LaserConfig, TourWorld, WorldConfig};
use crate::{Result, perceptual};
use loc_core::Pose2;
use loc_core::random::{ChaCha8Rng, stream};
use loc_pf::sensor::BeamModelSettings;
use loc_sensors::laser::{LaserFaults, LaserScan};
use rand::RngExt;
use serde::Deserialize;
use serde_json::json;
use std::f64::consts::TAU;

/// From the robot to the nearest wall \[m\].
const CLEARANCE: f64 = 0.3;

/// After so many tries any place will do; [`learn`] leaves out those that are not free.
const MAX_TRIES: usize = 10_000;

/// Where is looked, with what, and what the map does not know.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerceptualModelConfig {
    /// The world.
    pub world: WorldConfig,
    /// The laser; `every_s` has no meaning here.
    pub laser: LaserConfig,
    /// Places at which it looks.
    pub places: usize,
}

impl PerceptualModelConfig {
    pub(super) fn check(&self) -> Result<()> {
        self.world.settings()?;
        self.laser.scanner()?;
        count("demonstration.places", self.places, 100_000)?;
        Ok(())
    }
}

/// Looks, learns and draws.
///
/// # Errors
/// Values out of range, and too few beams to learn from.
pub(super) fn illustrate(
    config: &PerceptualModelConfig,
    title: &str,
    seed: u64,
) -> Result<Illustration> {
    config.check()?;
    let learned = look_and_learn(config, seed)?;
    let fitted = &learned.fit.settings;
    let LaserFaults { dropout, short, .. } = config.laser.faults;
    let rows = [
        ("z_hit", 1.0 - short - dropout, fitted.z_hit),
        ("z_short", short, fitted.z_short),
        ("z_max", dropout, fitted.z_max),
        ("z_rand", 0.0, fitted.z_rand),
        ("sigma_hit [m]", config.laser.scanner()?.spec.noise.sigma, fitted.sigma_hit),
    ];
    let mut lines = vec![
        format!("{} beams of {} scans", learned.pairs.len(), learned.scans),
        format!("{:<20}{:>10}{:>10}", "", "put in", "fitted"),
    ];
    lines.extend(rows.map(|(name, put, fitted)| format!("{name:<20}{put:>10.4}{fitted:>10.4}")));
    let put_in = json!({"short": short, "none": dropout});
    let summary = json!({"beams": learned.pairs.len(), "fitted": fitted, "put_in": put_in});
    let surfaces = FigureFile {
        file: "surfaces.svg".into(),
        caption: "p(measured | expected) as counted, beside the fitted beam model".into(),
        svg: perceptual::surfaces(&learned, title)?,
    };
    let cuts = FigureFile {
        file: "cuts.svg".into(),
        caption: "Cuts through both surfaces at a few expected ranges".into(),
        svg: perceptual::cuts(&learned, title)?,
    };
    Ok(Illustration::new(lines, summary, vec![surfaces, cuts]))
}

fn look_and_learn(config: &PerceptualModelConfig, seed: u64) -> Result<Learned> {
    let world = TourWorld::open(Some(&config.world), None)?;
    let (scanner, map) = (config.laser.scanner()?, world.grid());
    let (mut places, mut errors) = (stream(seed, "places"), stream(seed, "laser"));
    let scans: Vec<(Pose2, LaserScan)> = (0..config.places)
        .map(|_| {
            let pose = free_pose(&world, &mut places);
            let scan = scanner.scan(&world.walls, pose, &mut errors);
            (pose * scanner.mounting, scan)
        })
        .collect();
    let start = BeamModelSettings { max_range: scanner.spec.range_max, ..Default::default() };
    learn(&scans, map, &LearnSettings { start, ..LearnSettings::default() })
}

/// A pose in free space, at least [`CLEARANCE`] from every wall.
fn free_pose(world: &TourWorld, rng: &mut ChaCha8Rng) -> Pose2 {
    let frame = world.grid().frame();
    let mut pose = Pose2::IDENTITY;
    for _ in 0..MAX_TRIES {
        let (u, v, turn): (f64, f64, f64) = (rng.random(), rng.random(), rng.random());
        let place = frame.to_map(u * frame.width() as f64, v * frame.height() as f64);
        pose = Pose2::new(place.x, place.y, TAU * turn);
        if world.clearance(&place) >= CLEARANCE {
            break;
        }
    }
    pose
}
