//! Ancestors over time, a line for each way to resample.

use super::{Course, Diversity};
use crate::output::figures::FigureFile;
use loc_plot::{Chart, Figure, Role, Style};

pub(super) fn figure(diversity: &Diversity, title: &str) -> FigureFile {
    let config = &diversity.config;
    let scatter = config.scatter;
    let equal = panel("equal weights: ancestors left", &diversity.equal, config.particles, 0);
    let scattered = format!("ln(weight) scatters by {scatter}: ancestors left");
    let scattered = panel(&scattered, &diversity.scattered, config.particles, 0);
    // Its first course is the last one of the panel above.
    let same = diversity.scattered.len() - 1;
    let seldom = "the same, spoke wheel, resampled more or less often";
    let seldom = panel(seldom, &diversity.seldom, config.particles, same);
    let figure = Figure::new(title)
        .subtitle(format!(
            "{} particles; where weights are equal, all but roulette lose none",
            config.particles
        ))
        .x_label("update")
        .panel(equal)
        .panel(scattered)
        .panel(seldom);
    FigureFile {
        file: "diversity.svg".into(),
        caption: "Number of particles whose descendants survive resampling, over time".into(),
        svg: figure.render(),
    }
}

/// Courses in the colours from `first` on. Those that coincide take turns in being seen: earlier
/// ones are drawn wider.
fn panel(label: &str, courses: &[Course], most: usize, first: usize) -> Chart {
    let mut chart = Chart::new(label).log_y().y_range(0.8, 1.5 * most as f64);
    for (k, course) in courses.iter().enumerate() {
        let over_time = course.ancestors.iter().enumerate();
        let points = over_time.map(|(step, left)| (step as f64, *left as f64));
        let width = 1.8 + 0.9 * (courses.len() - 1 - k) as f64;
        let style: Style = Role::Method(first + k).width(width);
        chart = chart.line(style, &course.name, points);
    }
    chart
}
