//! Map views.

use super::{WILD, check, drawn, elements, number, subpaths, texts};
use loc_core::nalgebra::Vector2;
use loc_core::{Ellipse, Pose2};
use loc_plot::{Backdrop, Role, Scene};
use roxmltree::Document;

fn circle(x: f64, y: f64, radius: f64) -> Ellipse {
    Ellipse { center: Vector2::new(x, y), semi_major: radius, semi_minor: radius, angle: 0.3 }
}

#[test]
fn titles_labels_and_names_are_escaped() {
    let nasty = "a < b & \"c\" 'd' ]]> é 日本";
    let scene = Scene::new(nasty)
        .subtitle(nasty)
        .path(Role::Truth, nasty, [(0.0, 0.0), (9.0, 9.0)])
        .crosses(Role::Landmark, "", [((5.0, 2.0), "<7>&")]);
    let svg = scene.render();
    check(&svg);
    let found = texts(&svg);
    assert_eq!(found.iter().filter(|text| *text == nasty).count(), 3);
    assert!(found.contains(&"<7>&".to_owned()));
    let control = Scene::new("null \0, escape \x1b, line\nfeed, \u{ffff}").render();
    check(&control);
    assert!(texts(&control)[0].starts_with("null \u{fffd}, escape \u{fffd}, line feed, \u{fffd}"));
}

#[test]
fn metres_are_equally_long_along_x_and_y() {
    let shapes = [(1.0, 1.0), (30.0, 1.0), (1.0, 30.0), (0.001, 0.004)];
    for (width, height) in shapes {
        let unit = 0.5 * f64::min(width, height);
        let cross = [((0.0, 0.0), (unit, 0.0)), ((0.0, 0.0), (0.0, unit))];
        let svg = Scene::new("Aspect")
            .segments(Role::Map, "", cross)
            .dots(Role::Truth, "", [(width, height)])
            .ellipses(Role::Method(0), "", [circle(0.0, 0.0, unit)])
            .render();
        check(&svg);
        let lines = subpaths(&drawn(&svg, "loc-s-map")[0]);
        let across = lines[0][1].0 - lines[0][0].0;
        let upwards = lines[1][0].1 - lines[1][1].1;
        assert!((across - upwards).abs() <= 0.021, "{across} {upwards}");
        let doc = Document::parse(&svg).unwrap();
        let round = elements(&doc, "ellipse").next().unwrap();
        assert_eq!(number(round, "rx"), number(round, "ry"));
        assert!((number(round, "rx") - across).abs() <= 0.021);
    }
}

#[test]
fn up_is_up_and_turns_are_counter_clockwise() {
    let tilted = Ellipse { semi_major: 2.0, angle: 0.5, ..circle(1.0, 1.0, 1.0) };
    let svg = Scene::new("Turns")
        .path(Role::Truth, "", [(0.0, 0.0), (1.0, 1.0)])
        .poses(Role::Method(1), "", [Pose2::new(0.0, 0.0, std::f64::consts::FRAC_PI_2)])
        .ellipses(Role::Method(0), "", [tilted])
        .render();
    let path = &subpaths(&drawn(&svg, "loc-s-ink")[0])[0];
    assert!(path[1].0 > path[0].0 && path[1].1 < path[0].1);
    let arrow = &subpaths(&drawn(&svg, "loc-f-m1")[0])[0];
    assert!(arrow[0].1 < path[0].1 - 8.0 && (arrow[0].0 - path[0].0).abs() < 0.02);
    assert!(svg.contains("transform=\"rotate(-28.65 "));
}

#[test]
fn a_path_is_broken_where_a_point_is_not_finite() {
    let points = [
        (0.0, 0.0),
        (1.0, 1.0),
        (f64::NAN, 1.0),
        (2.0, 0.0),
        (3.0, 2.0),
        (1.0, f64::INFINITY),
        (4.0, 4.0),
    ];
    let svg = Scene::new("Gaps").path(Role::Method(0), "", points).render();
    check(&svg);
    let lengths: Vec<usize> = subpaths(&drawn(&svg, "loc-s-m0")[0]).iter().map(Vec::len).collect();
    assert_eq!(lengths, [2, 2, 1]);
}

#[test]
fn nothing_to_see_is_said() {
    let nan = [(f64::NAN, 0.0)];
    let empty = [
        Scene::new("Nothing"),
        Scene::new("").path(Role::Truth, "path", []),
        Scene::new("NaN").path(Role::Truth, "path", nan).dots(Role::Map, "dots", nan).stars(
            Role::Map,
            "stars",
            nan,
        ),
    ];
    for scene in empty {
        let svg = scene.render();
        check(&svg);
        assert!(texts(&svg).contains(&"no data".to_owned()));
    }
}

#[test]
fn wild_numbers_make_sound_files() {
    for a in WILD {
        for b in WILD {
            let scene = Scene::new("Wild")
                .path(Role::Truth, "path", [(a, b), (b, a), (a, a)])
                .segments(Role::Map, "segment", [((a, b), (b, b))])
                .dots(Role::Method(1), "dots", [(a, b), (b, a)])
                .poses(Role::Method(2), "pose", [Pose2 { x: a, y: b, theta: b }])
                .ellipses(Role::Method(3), "ellipse", [circle(a, b, a), circle(b, b, b)])
                .crosses(Role::Landmark, "cross", [((a, b), "1"), ((b, a), "2")])
                .stars(Role::Measurement.width(a), "star", [(a, b)]);
            check(&scene.render());
        }
    }
}

#[test]
fn a_huge_ellipse_does_not_shrink_the_rest() {
    let svg = Scene::new("Lost")
        .path(Role::Map, "", [(0.0, 0.0), (10.0, 10.0)])
        .ellipses(Role::Method(0), "", [circle(5.0, 5.0, 1e6)])
        .render();
    check(&svg);
    let path = &subpaths(&drawn(&svg, "loc-s-map")[0])[0];
    assert!(path[1].0 - path[0].0 > 150.0);
}

#[test]
fn long_paths_make_small_files() {
    let point = |k: i32| (f64::from(k) * 1e-3, (f64::from(k) * 1e-3).sin());
    let svg = Scene::new("Long").path(Role::Truth, "", (0..100_000).map(point)).render();
    assert!(svg.len() < 20_000, "{} bytes", svg.len());
}

#[test]
fn one_label_in_one_colour_is_one_entry() {
    let svg = Scene::new("Legend")
        .path(Role::Method(0), "ekf", [(0.0, 0.0), (1.0, 1.0)])
        .poses(Role::Method(0), "ekf", [Pose2::IDENTITY])
        .path(Role::Method(1), "ekf", [(0.0, 0.0), (1.0, 2.0)])
        .path(Role::Method(1), "", [(0.0, 0.0), (1.0, 3.0)]);
    assert_eq!(texts(&svg.render()).iter().filter(|text| *text == "ekf").count(), 2);
}

#[test]
fn names_do_not_cover_each_other() {
    let crowd = (0..400).map(|k| ((f64::from(k % 20), f64::from(k / 20)), format!("landmark {k}")));
    let svg = Scene::new("Crowd").crosses(Role::Landmark, "", crowd).render();
    check(&svg);
    let doc = Document::parse(&svg).unwrap();
    let names: Vec<(f64, f64)> = elements(&doc, "text")
        .filter(|text| text.text().unwrap().starts_with("landmark"))
        .map(|text| (number(text, "x"), number(text, "y")))
        .collect();
    assert!((20..400).contains(&names.len()));
    for (k, a) in names.iter().enumerate() {
        assert!(names[..k].iter().all(|b| (a.0 - b.0).abs() > 50.0 || (a.1 - b.1).abs() > 10.0));
    }
}

#[test]
fn a_backdrop_comes_first_and_never_from_the_network() {
    let image = |uri: &str| Backdrop { min: (0.0, 0.0), max: (4.0, 2.0), data_uri: uri.into() };
    let local = Scene::new("Map").backdrop(image("data:image/png;base64,AAAA"));
    let svg = local.path(Role::Truth, "", [(1.0, 1.0), (2.0, 1.0)]).render();
    check(&svg);
    let doc = Document::parse(&svg).unwrap();
    let picture = elements(&doc, "image").next().unwrap();
    let (width, height) = (number(picture, "width"), number(picture, "height"));
    assert!((width - 2.0 * height).abs() < 0.03);
    // Over the grid, whose lines would cut through its walls, and under everything drawn.
    assert!(svg.find("<path") < svg.find("<image") && svg.find("<image") < svg.rfind("<path"));
    for refused in ["http://example.org/map.png", "map.png", "javascript:alert(1)"] {
        let svg = Scene::new("Map").backdrop(image(refused)).render();
        check(&svg);
        assert!(!svg.contains("<image"));
    }
}

#[test]
fn equal_scenes_are_equal_bytes() {
    let scene = || {
        Scene::new("Same")
            .dots(
                Role::Method(3),
                "cloud",
                (0..500).map(|k| (f64::from(k % 37), f64::from(k % 23))),
            )
            .crosses(Role::Landmark, "landmark", [((3.3, 4.4), "1")])
    };
    assert_eq!(scene().render(), scene().render());
}
