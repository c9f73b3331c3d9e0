//! A picture of each map.

use super::Maps;
use crate::output::figures::FigureFile;
use loc_maps::MapPicture;
use loc_maps::grid::Cell;
use loc_plot::{Backdrop, Scene};

pub(super) fn figures(maps: &Maps) -> Vec<FigureFile> {
    let grid = &maps.world.grid;
    let picture = MapPicture::new;
    let pictures = [
        ("grid.svg", "C1: occupancy grid, with the landmarks (C6) of the world", {
            let picture = picture().grid(grid);
            if maps.world.landmarks.is_empty() {
                picture
            } else {
                picture.landmarks(&maps.world.landmarks)
            }
        }),
        ("lines.svg", "C2: its walls as lines, over the grid drawn of them", {
            picture().grid(&maps.redrawn).lines(&maps.lines)
        }),
        ("points.svg", "C3: its obstacles as points", picture().points(&maps.points)),
        (
            "places.svg",
            "C4: its rooms, corridors and doors",
            picture().grid(grid).places(&maps.places),
        ),
    ];
    let mut figures: Vec<FigureFile> = pictures
        .into_iter()
        .map(|(file, caption, picture)| FigureFile {
            file: file.into(),
            caption: caption.into(),
            svg: picture.to_svg(),
        })
        .collect();
    figures.push(field(maps));
    figures
}

/// The likelihood field as an image: the darker, the more likely a beam ends there.
fn field(maps: &Maps) -> FigureFile {
    let frame = maps.field.frame();
    let (columns, rows) = (frame.width(), frame.height());
    let cells = (0..rows).rev().flat_map(|row| (0..columns).map(move |column| (column, row)));
    let values = cells
        .map(|(column, row)| maps.field.log_likelihood_at(&frame.center(Cell::new(column, row))));
    let values: Vec<f64> = values.collect();
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let shade = |value: f64| (255.0 * (most - value) / (most - least).max(1e-12)).round() as u8;
    let pixels = values.into_iter().map(|value| [shade(value); 3]).collect();
    let (width, height) = (columns as f64 * frame.resolution(), rows as f64 * frame.resolution());
    let origin = frame.origin();
    let backdrop = Backdrop {
        min: (origin.x, origin.y),
        max: (origin.x + width, origin.y + height),
        data_uri: loc_plot::color::Image { width: columns, pixels }.data_uri(),
    };
    let scene = Scene::new("Likelihood field (C5)")
        .subtitle(format!("ln p of a beam's end, from {least:.2} (white) to {most:.2} (black)"))
        .backdrop(backdrop);
    FigureFile {
        file: "field.svg".into(),
        caption: "C5: how likely a beam ends where".into(),
        svg: scene.render(),
    }
}
