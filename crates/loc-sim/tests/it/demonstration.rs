//! What the filters do inside: F5, K1 in one dimension, M2 and M11.

use approx::assert_relative_eq;
use loc_filters::lateration::Caution;
use loc_sim::demonstration::{
    DemonstrationConfig, DiversityConfig, DoorCorridorConfig, Mcl1dConfig, SamplingConfig, Stage,
    Step,
};
use loc_sim::scenario::Scenario;
use roxmltree::Document;

fn scenario(name: &str, changes: &[&str]) -> Scenario {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    Scenario::named(name, &changes).unwrap()
}

fn corridor() -> Mcl1dConfig {
    match scenario("mcl-1d", &[]).demonstration {
        Some(DemonstrationConfig::Mcl1d(config)) => config,
        other => panic!("{other:?}"),
    }
}

fn standing() -> DiversityConfig {
    match scenario("diversity", &[]).demonstration {
        Some(DemonstrationConfig::Diversity(config)) => config,
        other => panic!("{other:?}"),
    }
}

/// The posterior on a fine grid, by Bayes and a convolution.
fn exact_share_near_truth(config: &Mcl1dConfig) -> f64 {
    const STEP: f64 = 0.02;
    let count = (config.length / STEP).round() as usize;
    let place = |k: usize| (k as f64 + 0.5) * STEP;
    let first: Vec<f64> = (0..count).map(|k| config.likelihood(place(k))).collect();
    let mut after = vec![0.0; count];
    for (k, weight) in first.iter().enumerate() {
        let mean = place(k) + config.drive;
        let normal = |x: f64| (-0.5 * ((x - mean) / config.drive_sigma).powi(2)).exp();
        let total: f64 = (0..3 * count).map(|j| normal(place(j))).sum();
        for j in 0..3 * count {
            // What would lie behind the wall stands at it.
            after[j.min(count - 1)] += weight * normal(place(j)) / total;
        }
    }
    let weighed = |k: usize| after[k] * config.likelihood(place(k));
    let truth = config.start + config.drive;
    let near = (0..count).filter(|&k| (place(k) - truth).abs() <= 1.0).map(weighed).sum::<f64>();
    near / (0..count).map(weighed).sum::<f64>()
}

#[test]
fn five_stages_find_the_robot() {
    let config = Mcl1dConfig { particles: 20_000, ..corridor() };
    let stages = config.stages(1).unwrap();
    assert_eq!(stages.len(), 5);
    let near: Vec<f64> = stages.iter().map(Stage::near_truth).collect();
    assert!((near[0] - 0.1).abs() < 0.005, "2 m of 20 m: {near:?}");
    let exact = exact_share_near_truth(&config);
    println!("near the truth at the end: {:.3}, exactly {exact:.3}", near[3]);
    assert!((near[3] - exact).abs() < 0.02 && (near[4] - exact).abs() < 0.02, "{near:?} {exact}");
    for stage in &stages {
        let total: f64 = stage.particles.iter().map(|(_, weight)| weight).sum();
        assert!((total - 1.0).abs() < 1e-9);
        let equal =
            stage.particles.iter().all(|(_, weight)| (weight * 20_000.0 - 1.0).abs() < 1e-9);
        assert_eq!(equal, !stage.weighed);
    }
}

/// Roulette ends in copies of one particle; the others keep all, with equal weights.
#[test]
fn only_roulette_loses_the_particles_of_a_robot_that_stands_still() {
    let diversity = standing().courses(1).unwrap();
    let left = |name: &str| diversity.equal.iter().find(|c| c.name == name).unwrap().left();
    assert_eq!(left("roulette"), 1);
    for name in ["spoke wheel", "stratified", "residual"] {
        assert_eq!(left(name), 200, "{name}");
    }
    for course in &diversity.equal {
        assert!(course.ancestors.windows(2).all(|pair| pair[1] <= pair[0]), "{}", course.name);
    }
}

/// Kingman: k lines of N particles meet after about 2 N / (k (k - 1)) rounds of roulette, all of
/// them after 2 N.
#[test]
fn roulette_takes_as_long_as_theory_says() {
    let config = DiversityConfig { particles: 50, steps: 1000, ..standing() };
    let rounds = (0..40).map(|seed| {
        let roulette = &config.courses(seed).unwrap().equal[0].ancestors;
        roulette.iter().position(|left| *left == 1).unwrap() as f64
    });
    let mean = rounds.sum::<f64>() / 40.0;
    // 2 N (1 - 1/N) = 98, standard deviation about 1.08 N = 54 each.
    assert!((mean - 98.0).abs() < 3.0 * 54.0 / 40_f64.sqrt(), "{mean}");
}

/// Where weights scatter all lose some: the spoke wheel least, and less when resampled seldom.
#[test]
fn seldom_is_better_where_weights_differ() {
    let mut sums = [0; 5];
    for seed in 0..6 {
        let config = DiversityConfig { particles: 100, steps: 300, ..standing() };
        let diversity = config.courses(seed).unwrap();
        let courses = [&diversity.scattered[0], &diversity.scattered[2], &diversity.scattered[3]];
        let courses = courses.into_iter().chain(&diversity.seldom[1..]);
        courses.zip(&mut sums).for_each(|(course, sum)| *sum += course.left());
    }
    let [roulette, stratified, spokes, tenth, share] = sums;
    println!("{sums:?}");
    assert!(roulette < stratified && stratified < spokes && spokes < tenth.min(share), "{sums:?}");
}

#[test]
fn figures_are_written_and_the_same_for_the_same_seed() {
    for (name, file) in [
        ("mcl-1d", "stages.svg"),
        ("diversity", "diversity.svg"),
        ("lateration", "lateration.svg"),
        ("mailbox", "mailbox.svg"),
        ("door-corridor", "beliefs.svg"),
    ] {
        let scenario = scenario(name, &[]);
        let files = |seed| {
            let illustration = scenario.illustrate(seed).unwrap().unwrap();
            illustration.files(&scenario.title, "loc-sim").unwrap()
        };
        let (first, second) = (files(1), files(1));
        assert!(Document::parse(first.text(file).unwrap()).is_ok());
        assert!(first.text(file) == second.text(file), "{name}");
        // The mailbox draws nothing.
        assert_eq!(first.text(file) == files(2).text(file), name == "mailbox");
        assert!(scenario.run(None, None, &mut |_| {}).is_err());
    }
}

#[test]
fn bad_values_name_their_key() {
    for (name, change, message) in [
        ("mcl-1d", "particles=0", "demonstration.particles: expected 1 to 100000, got `0`"),
        ("mcl-1d", "doors=[25.0]", "demonstration.doors: expected a place in the corridor"),
        ("mcl-1d", "drive=17.0", "start + drive: expected a place in the corridor, got `21`"),
        ("mcl-1d", "false_door=0.0", "demonstration.false_door: expected a finite number > 0"),
        ("mailbox", "mail_comes=1.5", "demonstration.mail_comes: expected a probability"),
        ("mailbox", "flags=[]", "demonstration.flags: expected 1 to 366 days, got `0`"),
        ("mailbox", "flags=[\"red\"]", "unknown variant `red`"),
        ("door-corridor", "drives=[3.0, 30.0]", "start + drives: expected a place"),
        ("door-corridor", "cell=0.0", "demonstration.cell: expected a finite number > 0"),
        ("door-corridor", "cell=1e-9", "cells of the corridor: expected at most 1e7"),
        ("door-corridor", "false_door=0.0", "expected a number above 0 and below 1"),
        ("diversity", "steps=0", "demonstration.steps: expected 1 to 100000, got `0`"),
        ("diversity", "effective_share=2.0", "effective share of the particles"),
        ("diversity", "kind=\"magic\"", "unknown variant `magic`"),
        ("diversity", "colour=1", "unknown field `colour`"),
        ("lateration", "draws=0", "demonstration.draws: expected 1 to 100000, got `0`"),
        ("lateration", "range_sigma=0", "demonstration.range_sigma: expected a finite number"),
        ("lateration", "rooms=[]", "demonstration.rooms: expected 1 to 12, got `0`"),
        (
            "lateration",
            "rooms=[{name=\"x\",robot=[1.0],landmarks=[]}]",
            "demonstration.rooms.robot: expected 2 or 3 coordinates, got `[1.0] in x`",
        ),
        (
            "lateration",
            "rooms=[{name=\"x\",robot=[1.0,2.0],landmarks=[[1.0,2.0,3.0]]}]",
            "expected places of 2 finite coordinates, as the robot has, got `[1.0, 2.0, 3.0] in x`",
        ),
    ] {
        let change = format!("demonstration.{change}");
        let error = Scenario::named(name, &[change]).unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}

/// D1 to D4: two places with two landmarks and with three in space, one with five; the ellipse is
/// as large as the scatter except where all landmarks lie in one direction.
#[test]
fn four_rooms_show_what_lateration_can_do() {
    let Some(DemonstrationConfig::Lateration(mut config)) =
        scenario("lateration", &[]).demonstration
    else {
        panic!()
    };
    config.draws = 2000;
    let rooms = config.measure(4).unwrap();
    let ambiguous = rooms.iter().map(|room| {
        room.cautions.iter().any(|caution| matches!(caution, Caution::Ambiguous { .. }))
    });
    assert_eq!(ambiguous.collect::<Vec<_>>(), [true, false, true, true]);
    for room in &rooms[..3] {
        let ratio = room.measured / room.promised;
        assert!((0.85..1.15).contains(&ratio), "{}: {ratio}", room.name);
    }
    assert!(rooms[3].dilution > 3.0 * rooms[0].dilution && rooms[3].other.is_some());
    let apart = rooms[2].other.unwrap().mean.y - rooms[2].best.mean.y;
    assert!(apart > 7.0, "the other place is above the ceiling: {apart}");
}

/// F5: P(full | up) = 0.27 / 0.34, then a day by hand.
#[test]
fn the_mailbox_by_hand() {
    let Some(DemonstrationConfig::Mailbox(config)) = scenario("mailbox", &[]).demonstration else {
        panic!("no mailbox");
    };
    let diagnosis = config.diagnose().unwrap();
    assert_relative_eq!(diagnosis.full_if_up, 0.27 / 0.34, epsilon = 1e-12);
    assert_relative_eq!(diagnosis.full_if_down, 0.03 / 0.66, epsilon = 1e-12);
    assert_relative_eq!(diagnosis.days[0].believed, 0.27 / 0.34, epsilon = 1e-12);
    let predicted = 0.5 * 0.27 / 0.34 + 0.4 * 0.07 / 0.34;
    assert_relative_eq!(diagnosis.days[1].predicted, predicted, epsilon = 1e-12);
    let believed = 0.9 * predicted / (0.9 * predicted + 0.1 * (1.0 - predicted));
    assert_relative_eq!(diagnosis.days[1].believed, believed, epsilon = 1e-12);
}

/// An impossible flag is said to be so, not turned into NaN.
#[test]
fn a_flag_that_cannot_be_is_an_error() {
    let changes = ["demonstration.flag_up_if_full=0.0", "demonstration.flag_up_if_empty=0.0"];
    let error = scenario("mailbox", &changes).illustrate(1).unwrap_err().to_string();
    assert_eq!(
        error,
        "posterior distribution: the evidence has probability 0, so nothing follows from it"
    );
}

/// Doors at 4, 7, 12 and 19 m: only a start at the first fits drives of 3 m and 5 m.
#[test]
fn the_corridor_is_told_apart_by_its_doors() {
    let Some(DemonstrationConfig::DoorCorridor(config)) =
        scenario("door-corridor", &[]).demonstration
    else {
        panic!("no corridor");
    };
    let sure = DoorCorridorConfig { sees_door: 1.0, false_door: 1e-9, drive_sigma: 0.05, ..config };
    for seed in 0..20 {
        let steps = sure.steps(seed).unwrap();
        assert_eq!(steps.len(), 8);
        for step in &steps {
            assert_relative_eq!(
                step.belief.probabilities().iter().sum::<f64>(),
                1.0,
                epsilon = 1e-9
            );
        }
        assert!(steps[0].near_truth() < 0.05);
        // Doors are 1 m wide: nothing tells where in one the robot stands.
        let Step { belief, truth, .. } = &steps[7];
        let near = belief.probability(truth - 1.0, truth + 1.0);
        assert!(near > 0.95, "seed {seed}: {near}");
    }
}

/// The moments of each way to draw: exact for all but the tails of the stand-ins.
#[test]
fn draws_have_the_moments_of_their_distributions() {
    let config = SamplingConfig { draws: 40_000, sigma: 2.0, correlation: 0.6 };
    let sampling = config.draw(3).unwrap();
    // Means of 40 000 draws err by 0.01 in one standard deviation.
    let means = [0.0, 0.0, 0.0, 2.0];
    let third = [0.9973, 0.9983, 1.0, 0.9817];
    for ((kind, mean), third) in sampling.kinds.iter().zip(means).zip(third) {
        let moments = kind.moments();
        assert!((moments.mean - mean).abs() < 0.04, "{} {moments:?}", kind.name);
        assert!((moments.sigma - 2.0).abs() < 0.05, "{} {moments:?}", kind.name);
        assert!((moments.within[2] - third).abs() < 0.002, "{} {moments:?}", kind.name);
    }
    assert!((sampling.correlation() - 0.6).abs() < 0.015);
    assert!(SamplingConfig { correlation: 1.5, ..config }.draw(1).is_err());
}

/// What was put in front of the beams is what the fit finds, as far as shorter ranges count: those
/// below the scanner's least range are no ranges.
#[test]
fn the_perceptual_model_finds_what_was_put_in() {
    let scenario =
        Scenario::named("perceptual-model", &["demonstration.places=60".into()]).unwrap();
    let summary = scenario.illustrate(5).unwrap().unwrap().summary;
    let fitted = &summary["fitted"];
    let of = |key: &str| fitted[key].as_f64().unwrap();
    assert!((of("sigma_hit") - 0.012).abs() < 0.001, "{fitted}");
    assert!((of("z_max") - 0.03).abs() < 0.01, "{fitted}");
    assert!((0.06..0.12).contains(&of("z_short")), "{fitted}");
}
