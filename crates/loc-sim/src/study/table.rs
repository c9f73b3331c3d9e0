//! The tables that a study prints.

use super::{Group, Results, Spread};

/// No more rows than this are printed.
const ROWS: usize = 40;

/// How the methods fare, and whether they are honest; without a line break at its end.
pub fn table(results: &Results) -> String {
    let Results { scenario, runs, seeds, first_seed, .. } = results;
    let last = first_seed + (seeds - 1);
    let runs = if *runs == 1 { "1 run".to_owned() } else { format!("{runs} runs") };
    let mut lines = vec![
        format!("{scenario}: {runs}, seeds {first_seed} to {last}"),
        format!("success: {}; ranges at 95 %", results.success),
        String::new(),
    ];
    lines.extend(columns(results, &accuracy()));
    if results.groups.iter().any(|group| group.consistency.nees_mean.is_some()) {
        lines.push(String::new());
        lines.push(
            "consistency: 1 per degree of freedom is honest, more is too sure; 95 % in band".into(),
        );
        lines.extend(columns(results, &consistency()));
    }
    if results.groups.len() > ROWS {
        lines.push(format!("{} more rows in study.json", results.groups.len() - ROWS));
    }
    if let Some(error) = &results.first_error {
        lines.push(format!("{} runs ended with an error, the first at {error}", results.failed));
    }
    lines.join("\n")
}

/// A column: its heading and what stands in it.
type TableColumn = (&'static str, fn(&Group) -> String);

fn accuracy() -> Vec<TableColumn> {
    vec![
        ("success [%]", |group| match (group.success_rate, group.success_interval) {
            (Some(rate), Some([low, high])) => {
                format!("{} ({}..{})", percent(rate), percent(low), percent(high))
            }
            _ => "-".into(),
        }),
        ("ATE [m]", |group| with_range(group.ate_rmse_m, 3)),
        ("p95", |group| figure(group.ate_rmse_m.map(|s| s.p95), 3)),
        ("head [deg]", |group| figure(group.heading_rmse_deg.map(|s| s.mean), 2)),
        ("time [ms]", |group| figure(group.runtime_s.map(|s| 1e3 * s.mean), 1)),
    ]
}

fn consistency() -> Vec<TableColumn> {
    vec![
        ("NEES/dof", |group| match group.consistency.nees_interval {
            Some([low, high]) => {
                let mean = figure(group.consistency.nees_per_degree, 3);
                format!("{mean} ({low:.3}..{high:.3})")
            }
            None => figure(group.consistency.nees_per_degree, 3),
        }),
        ("in band", |group| share(group.consistency.nees_share_in_band)),
        ("NIS/dof (band)", |group| match group.consistency.nis_band {
            Some([low, high]) => {
                let mean = figure(group.consistency.nis_per_degree, 3);
                format!("{mean} ({low:.3}..{high:.3})")
            }
            None => "-".into(),
        }),
        ("white", |group| share(group.consistency.white_share)),
    ]
}

/// The columns under their headings, each as wide as it must be.
fn columns(results: &Results, columns: &[TableColumn]) -> Vec<String> {
    let axes = results.varied.iter().map(|key| key.rsplit('.').next().unwrap_or(key).to_owned());
    let mut heading: Vec<String> = axes.collect();
    let left = heading.len() + 1;
    heading.push("method".into());
    heading.extend(columns.iter().map(|(name, _)| (*name).to_owned()));
    let mut rows = vec![heading];
    for group in results.groups.iter().take(ROWS) {
        let setting = |value: &toml::Value| match value {
            toml::Value::String(text) => text.clone(),
            value => value.to_string(),
        };
        let mut row: Vec<String> = group.settings.iter().map(|(_, v)| setting(v)).collect();
        row.push(group.method.clone());
        row.extend(columns.iter().map(|(_, cell)| cell(group)));
        rows.push(row);
    }
    let count = rows[0].len();
    let width = |k: usize| rows.iter().map(|row| row[k].chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..count).map(width).collect();
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).enumerate().map(|(k, (cell, &width))| match k < left {
            true => format!("{cell:<width$}"),
            false => format!("{cell:>width$}"),
        });
        cells.collect::<Vec<_>>().join("  ").trim_end().to_owned()
    };
    rows.iter().map(line).collect()
}

fn with_range(spread: Option<Spread>, digits: usize) -> String {
    match spread {
        Some(Spread { mean, interval: Some([_, high]), .. }) => {
            format!("{mean:.digits$} +- {:.digits$}", high - mean)
        }
        spread => figure(spread.map(|spread| spread.mean), digits),
    }
}

fn figure(value: Option<f64>, digits: usize) -> String {
    match value {
        None => "-".into(),
        // A covariance far too small, or a method that is lost.
        Some(value) if value >= 1e5 => format!("{value:.0e}"),
        Some(value) => format!("{value:.digits$}"),
    }
}

/// In whole percent, but not 100 where there is a failure, nor 0 where there is a success.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    let whole = (1.0..=99.0).contains(&percent) || percent <= 0.0 || percent >= 100.0;
    if whole { format!("{percent:.0}") } else { format!("{percent:.1}") }
}

fn share(share: Option<f64>) -> String {
    share.map_or("-".into(), |share| format!("{} %", percent(share)))
}
