//! A scan out of a recording, with the lines that are found in it.

use super::Reading;
use crate::output::{Folder, backdrop};
use crate::source::carmen::CarmenLog;
use crate::{Error, Result};
use loc_core::Pose2;
use loc_maps::grid::io;
use loc_plot::{Role, Scene};
use loc_sensors::features::{Line, LineExtractor};
use loc_sensors::laser::LaserScan;
use serde_json::json;
use std::path::Path;

/// Draws scan `index` (counted from 0) of a CARMEN log and the lines in it: over a map at the pose
/// that the log gives, or else around the scanner.
///
/// # Errors
/// What is wrong with the log or the map, and [`Error::Recording`] for a scan that it has not.
pub fn recorded_scan(log: &Path, index: usize, map: Option<&Path>) -> Result<Reading> {
    let lasers = CarmenLog::open(log)?.lasers()?;
    let Some(laser) = lasers.get(index) else {
        return Err(Error::Recording {
            path: log.to_owned(),
            expected: format!("one of its {} scans, counted from 0", lasers.len()),
            found: format!("scan {index}"),
        });
    };
    let pose = if map.is_some() { laser.laser } else { Pose2::IDENTITY };
    let lines = LineExtractor::default().extract(&laser.scan)?;
    let name = log.file_name().unwrap_or_default().to_string_lossy();
    let title = format!("scan {index} of {name}");
    let mut scene = Scene::new("Lines in a recorded scan").subtitle(title.clone());
    if let Some(map) = map {
        scene = backdrop(&io::load(map)?).map_or(scene.clone(), |image| scene.backdrop(image));
    }
    let mut folder = Folder::default();
    folder.add("scan.svg", draw(scene, pose, &laser.scan, &lines).render());
    folder.add("lines.csv", table(&lines));
    let covered: usize = lines.iter().map(|line| line.points).sum();
    let results = vec![
        ("beams", json!(laser.scan.ranges.len())),
        ("valid", json!(laser.scan.beams().count())),
        ("lines", json!(lines.len())),
        ("beams_on_lines", json!(covered)),
    ];
    let figures: serde_json::Map<_, _> =
        results.iter().map(|(name, value)| ((*name).to_owned(), value.clone())).collect();
    let summary = json!({"log": name, "scan": index, "stamp": laser.stamp, "results": figures});
    folder.add("summary.json", format!("{summary:#}\n"));
    Ok(Reading { title, results, summary, folder })
}

/// Where the beams ended, the lines over them, and the scanner.
pub(super) fn draw(scene: Scene, laser: Pose2, scan: &LaserScan, lines: &[Line]) -> Scene {
    let ends = scan.beams().map(|beam| {
        let end = laser.transform(&beam.point());
        (end.x, end.y)
    });
    lines_over(scene.dots(Role::Method(1), "where a beam ended", ends), laser, lines).poses(
        Role::Truth,
        "scanner",
        [laser],
    )
}

/// The stretches that were seen of lines in the frame of a scanner at `laser`.
pub(super) fn lines_over(scene: Scene, laser: Pose2, lines: &[Line]) -> Scene {
    let stretches = lines.iter().map(|line| {
        let [start, end] = [line.start, line.end].map(|point| laser.transform(&point));
        ((start.x, start.y), (end.x, end.y))
    });
    scene.segments(Role::Method(2).width(2.5), "line found", stretches)
}

fn table(lines: &[Line]) -> String {
    let mut text =
        String::from("r_m,alpha_rad,sigma_r_m,sigma_alpha_rad,points,x1_m,y1_m,x2_m,y2_m\n");
    for line in lines {
        let [sigma_r, sigma_alpha] = [line.covariance.m11, line.covariance.m22].map(f64::sqrt);
        let numbers = [line.r, line.alpha, sigma_r, sigma_alpha, line.points as f64];
        let ends = [line.start.x, line.start.y, line.end.x, line.end.y];
        let cells: Vec<String> = numbers.iter().chain(&ends).map(f64::to_string).collect();
        text += &(cells.join(",") + "\n");
    }
    text
}
