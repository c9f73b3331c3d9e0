//! What a grid filter believes at twelve moments (K1): each square of the map in the colour of its
//! probability, and the robot.

use super::FigureFile;
use super::moments::{self, Look};
use crate::localizer::PlaceBelief;
use crate::output::canvas::Canvas;
use crate::output::ramp;
use crate::output::svg::{Backdrop, Frames, Scene};
use crate::record::Run;
use loc_core::{Pose2, Stamped};
use loc_maps::OccupancyGrid;

/// Powers of 10 that the colours reach down to.
const DECADES: f64 = 6.0;
/// Radius of the ring around the robot, as a share of the map's larger side.
const RING: f64 = 0.03;

/// The beliefs of the last method that keeps a grid.
pub(super) fn histogram(run: &Run) -> Option<FigureFile> {
    let record = run.methods.iter().rfind(|record| !record.beliefs.is_empty())?;
    let map = run.setup.map.as_deref()?;
    let canvas = Canvas::new(map)?;
    let moments: Vec<&Stamped<PlaceBelief>> = record.beliefs.iter().collect();
    let looks: Vec<Look> = moments.iter().map(|moment| look(run, moment)).collect();
    let mut frames = Frames::new(format!("What {} believes over time", record.method))
        .subtitle("whatever the heading; with the standard deviation of the position")
        .bar(ramp::bar(-DECADES, 0.0, "log10 of the probability of a square"));
    for index in moments::choose(&looks) {
        let scene = Scene::new("").backdrop(paint(&canvas, map, &moments[index].value));
        let scene = match moments::truth_at(run, moments[index].stamp) {
            Some(truth) => scene.ring("robot", RING * canvas.larger_side(), truth),
            None => scene,
        };
        frames = frames.frame(caption(run, moments[index], looks[index]), scene);
    }
    Some(FigureFile {
        file: "histogram.svg".into(),
        caption: "The probability of each place of the map at twelve moments, with the true pose"
            .into(),
        svg: frames.render(),
    })
}

fn look(run: &Run, moment: &Stamped<PlaceBelief>) -> Look {
    let (mean, spread) = moment.value.mean_and_spread();
    let off = |truth: Pose2| f64::hypot(truth.x - mean[0], truth.y - mean[1]);
    let error = moments::truth_at(run, moment.stamp).map_or(0.0, off);
    Look { time: moment.stamp - run.setup.start, spread, error }
}

fn caption(run: &Run, moment: &Stamped<PlaceBelief>, look: Look) -> String {
    let carried = run.setup.kidnapped_at.is_some_and(|at| moment.stamp >= at);
    let after = if carried { ", kidnapped" } else { "" };
    format!("{:.1} s, ± {:.2} m{after}", look.time, look.spread)
}

/// The belief in colours.
fn paint(canvas: &Canvas, map: &OccupancyGrid, belief: &PlaceBelief) -> Backdrop {
    canvas.paint(map, |_, place| {
        let square = belief.squares.cell_at(place).and_then(|cell| belief.squares.index(cell));
        let p = square.and_then(|k| belief.probabilities.get(k)).copied();
        ramp::color(1.0 + f64::from(p.unwrap_or(0.0)).log10() / DECADES)
    })
}
