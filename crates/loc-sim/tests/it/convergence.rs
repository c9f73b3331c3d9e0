//! When a delocalized method has converged.

use crate::replay::{corrected, drive, open};
use loc_core::{Pose2, Stamped};
use loc_filters::localizer::{Decision, Outcome};
use loc_sim::localizer::{Method, MethodSettings};
use loc_sim::metrics::{Alignment, Summary, found};
use loc_sim::record::Run;
use loc_sim::runner;

/// A run over 64 true poses, 0.5 s apart from 50 s on, whose estimates are the truth moved as
/// `moved` says, with an accepted measurement at each and a refused one at every other.
fn run(moved: impl Fn(usize, Pose2) -> Pose2) -> Run {
    let mut source = open(&corrected(), &Default::default()).unwrap();
    let (methods, settings) = ([Method::DeadReckoning], MethodSettings::default());
    let mut run = runner::run(&mut source, &methods, &settings, &mut |_| {}).unwrap();
    let record = &mut run.methods[0];
    for (k, truth) in drive().into_iter().enumerate() {
        record.estimates[k].pose = moved(k, truth);
        let stamp = run.stamps[k];
        let accepted = Outcome::of(Decision::Accepted);
        record.outcomes.push(Stamped { stamp, value: accepted });
        if k % 2 == 0 {
            record.outcomes.push(Stamped { stamp, value: Outcome::of(Decision::Rejected) });
        }
    }
    run
}

fn aside(truth: Pose2, way: f64, turn: f64) -> Pose2 {
    truth * Pose2::new(0.0, way, turn)
}

#[test]
fn a_robot_is_found_where_the_estimate_comes_near_and_stays() {
    // Near from 10 on, but for 14 (too far) and 40, which comes too late to matter.
    let run = run(|k, truth| match k {
        14 | 40 => aside(truth, 0.51, 0.0),
        k if k < 10 => aside(truth, 3.0, 0.0),
        _ => aside(truth, 0.49, 0.17),
    });
    let at = found(&run, &run.methods[0], 50.0).unwrap();
    assert_eq!((at.after, at.updates), (7.5, 16));
    // Of the estimates from 61 s on the first is near, and 55 to 60 do not count.
    let later = found(&run, &run.methods[0], 61.0).unwrap();
    assert_eq!((later.after, later.updates), (0.0, 1));
    // 0.18 rad are more than 10 degrees.
    let askew = super::convergence::run(|_, truth| aside(truth, 0.0, 0.18));
    assert_eq!(found(&askew, &askew.methods[0], 50.0), None);
    // At the end it is enough that all the rest is near.
    let late =
        super::convergence::run(|k, truth| aside(truth, if k < 62 { 9.0 } else { 0.0 }, 0.0));
    assert_eq!(found(&late, &late.methods[0], 50.0).map(|at| at.updates), Some(63));
}

#[test]
fn the_summary_reports_searches_and_kidnappings() {
    let mut run =
        run(|k, truth| aside(truth, if k < 4 || (30..36).contains(&k) { 5.0 } else { 0.0 }, 0.0));
    let figures = |run: &Run| Summary::of(run, None, Alignment::None).unwrap().methods[0].1.clone();
    let none = figures(&run);
    assert_eq!((none.converged_at_s, none.recovered_after_s), (None, None));
    // Dead reckoning cannot search, even without a start pose.
    run.settings.global = true;
    assert_eq!(figures(&run).converged_at_s, None);
    run.methods[0].method = Method::Mcl;
    run.setup.kidnapped_at = Some(65.0);
    let all = figures(&run);
    assert_eq!((all.converged_at_s, all.converged_after_updates), (Some(2.0), Some(5)));
    assert_eq!((all.recovered_after_s, all.recovered_after_updates), (Some(3.0), Some(7)));
}
