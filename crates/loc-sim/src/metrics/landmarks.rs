//! Errors of a landmark map that a method has built.
//!
//! Such a map has its own frame, the one of the start pose. It is first aligned with the true map by
//! the rigid transform that minimizes the distances of the pairs; the rest is the error of the map
//! itself. With unknown data association, a landmark of the map is paired with the nearest true one.

use super::{Alignment, Pair, transform};
use crate::Result;
use crate::record::{MethodRecord, Run};
use loc_core::Pose2;
use nalgebra::Point2;
use serde::Serialize;

/// The figures of a map. Provisional landmarks do not count.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LandmarkErrors {
    /// Landmarks of the method's map.
    pub mapped: usize,
    /// True landmarks that are paired with one of these; null without a true map.
    pub found: Option<usize>,
    /// Landmarks of the map without a true one: false or duplicate.
    pub extra: Option<usize>,
    /// Root mean square distance of the found ones from the true ones after a rigid alignment;
    /// null for fewer than two.
    pub rmse_m: Option<f64>,
    /// Root mean square distance of the path from the true one, both in the same map: aligned by
    /// the landmarks. This is the error of the robot relative to its landmarks; the pose of its map's
    /// frame is unknown to it.
    pub path_rmse_m: Option<f64>,
}

/// Largest distance of a pair of landmarks \[m\].
const FARTHEST: f64 = 1.0;

/// Rounds of pairing and aligning of a map without numbers.
const ROUNDS: usize = 10;

/// The figures of the map that a method has built; `None` for a method that builds none.
///
/// # Errors
/// Those of [`transform`].
pub fn landmark_errors(run: &Run, record: &MethodRecord) -> Result<Option<LandmarkErrors>> {
    let Some(map) = &record.map else { return Ok(None) };
    let confirmed = map.landmarks.iter().filter(|landmark| landmark.confirmed);
    let places: Vec<(u32, Point2<f64>)> =
        confirmed.map(|landmark| (landmark.id, landmark.position.mean.into())).collect();
    let truth: Vec<(u32, Point2<f64>)> =
        run.setup.landmarks.iter().map(|l| (l.id, l.position.xy())).collect();
    if truth.is_empty() {
        let mapped = places.len();
        let (found, extra, rmse_m, path_rmse_m) = (None, None, None, None);
        return Ok(Some(LandmarkErrors { mapped, found, extra, rmse_m, path_rmse_m }));
    }
    let (pairs, carried) = match map.known_association {
        true => (by_number(&places, &truth), None),
        false => by_place(&places, &truth, path_alignment(run, record)?)?,
    };
    let aligned = match carried {
        Some(carried) => Some(carried),
        None => rigid(&pairs).ok().flatten(),
    };
    let aligned = aligned.filter(|_| pairs.len() > 1);
    let of_pairs = |to: Pose2| pairs.iter().map(move |(a, b)| (to.transform(a) - b).norm_squared());
    Ok(Some(LandmarkErrors {
        mapped: places.len(),
        found: Some(pairs.len()),
        extra: Some(places.len() - pairs.len()),
        rmse_m: aligned.and_then(|to| root_mean(of_pairs(to))),
        path_rmse_m: aligned.and_then(|to| root_mean(path_errors(run, record, to))),
    }))
}

/// Squared distances of the path from the true one, after a transform.
fn path_errors(run: &Run, record: &MethodRecord, to: Pose2) -> impl Iterator<Item = f64> {
    let pairs = record.estimates.iter().zip(&run.truth);
    pairs.map(move |(own, truth)| (to * own.pose).distance(truth.value.pose).powi(2))
}

/// `None` for no values.
fn root_mean(squares: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = squares.fold((0.0, 0), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| (sum / f64::from(count)).sqrt())
}

type Places = [(u32, Point2<f64>)];
type Pairs = Vec<(Point2<f64>, Point2<f64>)>;

fn by_number(places: &Places, truth: &Places) -> Pairs {
    let known = |id: u32| truth.iter().find(|(other, _)| *other == id).map(|(_, place)| *place);
    places.iter().filter_map(|(id, place)| Some((*place, known(*id)?))).collect()
}

/// Pairs each true landmark with the nearest of the map, and aligns by these, in turns.
fn by_place(places: &Places, truth: &Places, start: Pose2) -> Result<(Pairs, Option<Pose2>)> {
    let mut carried = start;
    let mut pairs = nearest(places, truth, carried);
    for _ in 0..ROUNDS {
        let Some(better) = rigid(&pairs)? else { break };
        let again = nearest(places, truth, better);
        carried = better;
        if again == pairs {
            break;
        }
        pairs = again;
    }
    Ok((pairs, Some(carried)))
}

/// The closest pairs first, each landmark once.
fn nearest(places: &Places, truth: &Places, carried: Pose2) -> Pairs {
    let mut all: Vec<(f64, usize, usize)> = Vec::new();
    for (i, (_, place)) in places.iter().enumerate() {
        let moved = carried.transform(place);
        let distances = truth.iter().map(|(_, other)| nalgebra::distance(&moved, other));
        all.extend(distances.enumerate().map(|(j, distance)| (distance, i, j)));
    }
    all.retain(|(distance, ..)| *distance <= FARTHEST);
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
    let (mut used, mut found) = (vec![false; places.len()], vec![false; truth.len()]);
    let mut pairs = Vec::new();
    for (_, i, j) in all {
        if !used[i] && !found[j] {
            (used[i], found[j]) = (true, true);
            pairs.push((places[i].1, truth[j].1));
        }
    }
    pairs
}

/// The transform from the first to the second of each pair, by least squares; `None` for fewer than
/// two pairs, and for landmarks at one position.
fn rigid(pairs: &[(Point2<f64>, Point2<f64>)]) -> Result<Option<Pose2>> {
    let pose = |point: &Point2<f64>| Pose2::new(point.x, point.y, 0.0);
    let pairs: Vec<Pair<Pose2>> = pairs.iter().map(|(a, b)| Pair::new(pose(a), pose(b))).collect();
    match transform(&pairs, Alignment::Se2) {
        Err(crate::Error::UndeterminedAlignment { .. }) => Ok(None),
        other => other,
    }
}

/// The transform that aligns the method's path with the true one, as first guess.
fn path_alignment(run: &Run, record: &MethodRecord) -> Result<Pose2> {
    let pairs = record.estimates.iter().zip(&run.truth);
    let pairs: Vec<Pair<Pose2>> =
        pairs.map(|(e, truth)| Pair::new(e.pose, truth.value.pose)).collect();
    match transform(&pairs, Alignment::Se2) {
        Err(crate::Error::UndeterminedAlignment { .. }) => Ok(Pose2::IDENTITY),
        other => Ok(other?.unwrap_or(Pose2::IDENTITY)),
    }
}
