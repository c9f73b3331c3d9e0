//! How far stated probabilities are from what happens.

use super::simulation::Sample;
use loc_pf::confidence::{LostMonitor, LostSettings};

/// What a monitor says in every update, beside the truth.
pub(crate) fn statements(settings: LostSettings, drives: &[Vec<Sample>]) -> Vec<(f64, bool)> {
    let mut statements = Vec::new();
    for drive in drives {
        let mut monitor = LostMonitor::new(settings).unwrap();
        let state = |sample: &Sample| (monitor.update(sample.scan(), sample.support), sample.lost);
        statements.extend(drive.iter().map(state));
    }
    statements
}

/// One bar of a reliability diagram: statements from `k / 10` to `(k + 1) / 10`.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Bar {
    pub(crate) count: usize,
    /// Mean of what was stated.
    pub(crate) stated: f64,
    /// Share of the statements at which the robot was lost.
    pub(crate) lost: f64,
}

pub(crate) fn reliability(statements: &[(f64, bool)]) -> [Bar; 10] {
    let mut bars = [Bar::default(); 10];
    for &(stated, lost) in statements {
        let bar = &mut bars[((stated * 10.0) as usize).min(9)];
        bar.count += 1;
        bar.stated += stated;
        bar.lost += f64::from(u8::from(lost));
    }
    for bar in &mut bars {
        bar.stated /= bar.count.max(1) as f64;
        bar.lost /= bar.count.max(1) as f64;
    }
    bars
}

/// Mean distance of the bars from the diagonal, weighted by their counts (Guo, Pleiss, Sun and
/// Weinberger, "On calibration of modern neural networks", 2017).
pub(crate) fn calibration_error(bars: &[Bar; 10]) -> f64 {
    let total: usize = bars.iter().map(|bar| bar.count).sum();
    let weighted = |bar: &Bar| bar.count as f64 * (bar.stated - bar.lost).abs();
    bars.iter().map(weighted).sum::<f64>() / total as f64
}

/// Mean of `-ln P(what happened)` \[nats\].
pub(crate) fn log_loss(statements: &[(f64, bool)]) -> f64 {
    let loss = |&(stated, lost): &(f64, bool)| {
        let probability: f64 = if lost { stated } else { 1.0 - stated };
        -probability.max(1e-9).ln()
    };
    statements.iter().map(loss).sum::<f64>() / statements.len() as f64
}

pub(crate) fn print(bars: &[Bar; 10]) {
    for bar in bars {
        println!("{:8} statements of {:.3}: lost {:.3}", bar.count, bar.stated, bar.lost);
    }
    println!("expected calibration error {:.4}", calibration_error(bars));
}
