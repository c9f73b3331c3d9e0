//! `loc-sim map info`: what a map holds.

use super::thumbnail::thumbnail;
use super::{AnyMap, read};
use crate::cli::{Global, print};
use loc_maps::{Bounds, OccupancyGrid};
use serde_json::{Value, json};
use std::path::PathBuf;

/// Print size, resolution, origin and counts of a map, and a thumbnail.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct InfoArgs {
    /// A map_server YAML file, a map file of Wean Hall (.dat), or a CSV file of lines (x1,y1,x2,y2) or points (x,y).
    #[arg(value_name = "MAP")]
    pub map: PathBuf,
    /// Width of the thumbnail in characters; 0 for none.
    #[arg(long, default_value_t = 60)]
    pub width: usize,
}

pub(super) fn info(args: &InfoArgs, global: &Global) -> anyhow::Result<()> {
    let map = read(&args.map)?;
    if global.quiet {
        return Ok(());
    }
    if global.json {
        return print(&serde_json::to_string_pretty(&figures(&map))?);
    }
    match &map {
        AnyMap::Grid(grid) => print_grid(grid, args.width),
        AnyMap::Lines(lines) => print(&format!("{} lines{}", lines.len(), box_of(lines.bounds()))),
        AnyMap::Points(points) => {
            print(&format!("{} points{}", points.len(), box_of(points.bounds())))
        }
    }
}

fn print_grid(grid: &OccupancyGrid, width: usize) -> anyhow::Result<()> {
    let resolution = grid.resolution();
    let size = |cells: usize| cells as f64 * resolution;
    let (w, h) = (grid.width(), grid.height());
    print(&format!("size        {w} x {h} cells, {:.2} m x {:.2} m", size(w), size(h)))?;
    print(&format!("resolution  {resolution} m"))?;
    let origin = grid.origin();
    let yaw = origin.theta.to_degrees();
    print(&format!("origin      ({:.3} m, {:.3} m), turned {yaw:.2} deg", origin.x, origin.y))?;
    let counts = grid.counts();
    let share = |count: usize| 100.0 * count as f64 / (w * h) as f64;
    for (name, count) in
        [("free", counts.free), ("occupied", counts.occupied), ("unknown", counts.unknown)]
    {
        print(&format!("{name:<11} {count} cells, {:.1} %", share(count)))?;
    }
    if width > 0 {
        print(&thumbnail(grid, width).join("\n"))?;
    }
    Ok(())
}

fn box_of(bounds: Option<Bounds>) -> String {
    bounds.map_or(String::new(), |b| {
        format!(", from ({:.2}, {:.2}) to ({:.2}, {:.2}) m", b.min.x, b.min.y, b.max.x, b.max.y)
    })
}

fn figures(map: &AnyMap) -> Value {
    let corners = |bounds: Option<Bounds>| {
        bounds.map(|b| json!({"min": [b.min.x, b.min.y], "max": [b.max.x, b.max.y]}))
    };
    match map {
        AnyMap::Grid(grid) => {
            let (counts, origin) = (grid.counts(), grid.origin());
            json!({
                "kind": "grid",
                "width": grid.width(),
                "height": grid.height(),
                "resolution_m": grid.resolution(),
                "origin": [origin.x, origin.y, origin.theta],
                "free": counts.free,
                "occupied": counts.occupied,
                "unknown": counts.unknown,
            })
        }
        AnyMap::Lines(map) => {
            json!({"kind": "lines", "count": map.len(), "bounds": corners(map.bounds())})
        }
        AnyMap::Points(map) => {
            json!({"kind": "points", "count": map.len(), "bounds": corners(map.bounds())})
        }
    }
}
