//! Charts and the figures that stack them.

use super::{WILD, check, drawn, subpaths, texts};
use loc_plot::{Chart, Figure, Role, Scene};

fn alone(chart: Chart) -> String {
    let svg = Figure::new("Chart").x_label("time [s]").panel(chart).render();
    check(&svg);
    svg
}

#[test]
fn a_line_is_broken_where_a_value_is_not_finite() {
    let values =
        [(0.0, 1.0), (1.0, 2.0), (2.0, f64::NAN), (3.0, 2.0), (4.0, 1.5), (5.0, f64::INFINITY)];
    let svg = alone(Chart::new("error [m]").line(Role::Method(0), "ekf", values));
    let lengths: Vec<usize> = subpaths(&drawn(&svg, "loc-s-m0")[0]).iter().map(Vec::len).collect();
    assert_eq!(lengths, [2, 2]);
}

#[test]
fn a_band_is_broken_where_an_edge_is_not_finite() {
    let edges = [
        (0.0, -1.0, 1.0),
        (1.0, -2.0, 2.0),
        (2.0, f64::NAN, 1.0),
        (3.0, -1.0, 1.0),
        (4.0, -1.0, 3.0),
    ];
    let svg = alone(Chart::new("error [m]").band(Role::Method(0), "2-sigma", edges));
    let parts = subpaths(&drawn(&svg, "loc-f-m0")[0]);
    assert_eq!(parts.iter().map(Vec::len).collect::<Vec<_>>(), [4, 4]);
    // Lower edge forth, upper edge back.
    let first = &parts[0];
    assert!(first[0].0 < first[1].0 && first[0].1 > first[3].1);
}

#[test]
fn panels_share_the_x_axis() {
    let svg = Figure::new("Two panels")
        .x_label("time [s]")
        .panel(Chart::new("a [m]").line(Role::Method(0), "a", [(0.0, 0.0), (5.0, 1.0)]))
        .panel(Chart::new("b [m]").line(Role::Method(1), "b", [(5.0, 100.0), (10.0, 2000.0)]))
        .render();
    check(&svg);
    let first = &subpaths(&drawn(&svg, "loc-s-m0")[0])[0];
    let second = &subpaths(&drawn(&svg, "loc-s-m1")[0])[0];
    assert_eq!(first[1].0, second[0].0);
    assert_eq!(texts(&svg).iter().filter(|text| *text == "time [s]").count(), 1);
}

#[test]
fn a_fixed_range_holds_and_an_invalid_one_is_ignored() {
    let line = [(0.0, 3.0), (1.0, 4.0)];
    let labels = |chart: Chart| texts(&alone(chart.line(Role::Truth, "", line)));
    let fixed = labels(Chart::new("y").y_range(-10.0, 10.0));
    assert!(fixed.contains(&"−10".to_owned()) && fixed.contains(&"10".to_owned()));
    let free = labels(Chart::new("y"));
    for (low, high) in [(1.0, 1.0), (2.0, 1.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        assert_eq!(labels(Chart::new("y").y_range(low, high)), free);
    }
    let log = labels(Chart::new("y").log_y());
    assert_eq!(labels(Chart::new("y").log_y().y_range(0.0, 10.0)), log);
}

#[test]
fn a_logarithmic_axis_makes_factors_equally_high() {
    let values =
        [(0.0, 1.0), (1.0, 100.0), (2.0, 10.0), (3.0, 0.0), (4.0, -5.0), (5.0, 1.0), (6.0, 10.0)];
    let svg = alone(Chart::new("y").log_y().line(Role::Truth, "", values));
    let parts = subpaths(&drawn(&svg, "loc-s-ink")[0]);
    assert_eq!(parts.iter().map(Vec::len).collect::<Vec<_>>(), [3, 2]);
    let heights: Vec<f64> = parts[0].iter().map(|point| point.1).collect();
    assert!((heights[0] - heights[1] - 2.0 * (heights[0] - heights[2])).abs() < 0.03);
}

#[test]
fn nothing_to_see_is_said() {
    let empty = [
        Figure::new("No panels"),
        Figure::new("No series").panel(Chart::new("x")),
        Figure::new("NaN").panel(Chart::new("x").line(Role::Truth, "t", [(0.0, f64::NAN)])),
        Figure::new("Not positive").panel(Chart::new("x").log_y().line(
            Role::Truth,
            "t",
            [(0.0, 0.0)],
        )),
    ];
    for figure in empty {
        let svg = figure.render();
        check(&svg);
        assert!(texts(&svg).contains(&"no data".to_owned()));
    }
}

#[test]
fn a_single_value_is_a_dot() {
    let svg = alone(Chart::new("x").line(Role::Truth, "", [(7.0, 3.0)]));
    assert!(drawn(&svg, "loc-s-ink")[0].ends_with("h.01"));
    assert!(!texts(&svg).contains(&"no data".to_owned()));
}

#[test]
fn wild_numbers_make_sound_files() {
    for a in WILD {
        for b in WILD {
            for log in [false, true] {
                let chart = Chart::new("wild & < [m]")
                    .line(Role::Truth, "line", [(a, b), (b, a), (b, b)])
                    .band(Role::Method(0), "band", [(a, a, b), (b, b, a)])
                    .points(Role::Method(1), "points", [(a, b)])
                    .reference(a, "limit")
                    .y_range(a, b);
                alone(if log { chart.log_y() } else { chart });
            }
        }
    }
}

#[test]
fn labels_of_limits_do_not_cover_each_other() {
    let mut chart = Chart::new("x").line(Role::Truth, "", [(0.0, 0.0), (9.0, 9.0)]);
    for k in 0..12 {
        chart = chart.reference(5.0 + 0.01 * f64::from(k), format!("limit {k}"));
    }
    let shown = texts(&alone(chart));
    let count = shown.iter().filter(|text| text.starts_with("limit")).count();
    assert!((2..=4).contains(&count), "{shown:?}");
}

#[test]
fn a_method_has_one_colour_in_all_figures() {
    let points = [(0.0, 1.0), (1.0, 2.0)];
    for k in [0, 3, 5, 7, 11, usize::MAX] {
        let scene = Scene::new("").path(Role::Method(k), "m", points).render();
        let chart = alone(Chart::new("x").line(Role::Method(k), "m", points));
        let class = format!("loc-s-m{}", k % 12);
        assert_eq!((drawn(&scene, &class).len(), drawn(&chart, &class).len()), (1, 1));
    }
}

/// A colour for each of twelve methods, light and dark, and dashes for those after the sixth.
#[test]
fn twelve_methods_are_told_apart() {
    let mut chart = Chart::new("x");
    for k in 0..12 {
        chart = chart.line(Role::Method(k), "", [(0.0, 1.0), (1.0, k as f64)]);
    }
    let svg = alone(chart);
    let mut strokes = std::collections::BTreeSet::new();
    for k in 0..12 {
        let class = format!("loc-s-m{k}\"");
        let line = svg.lines().find(|line| line.contains(&class)).unwrap();
        let (_, rest) = line.split_once("stroke=\"").unwrap();
        strokes.insert(rest[..7].to_owned());
        assert_eq!(line.contains("stroke-dasharray"), k >= 6, "method {k}: {line}");
        let (_, dark) = svg.split_once(&format!("--loc-m{k}:")).unwrap();
        strokes.insert(dark[..7].to_owned());
    }
    assert_eq!(strokes.len(), 24, "{strokes:?}");
}

#[test]
fn long_series_make_small_files() {
    let value = |k: i32| (f64::from(k) * 0.01, (f64::from(k) * 1.7).sin());
    let svg = alone(Chart::new("noise").line(Role::Truth, "", (0..100_000).map(value)));
    assert!(svg.len() < 80_000, "{} bytes", svg.len());
}

#[test]
fn equal_figures_are_equal_bytes() {
    let svg = || {
        alone(Chart::new("x").points(Role::Method(2), "p", (0..99).map(|k| (f64::from(k), 1.0))))
    };
    assert_eq!(svg(), svg());
}
