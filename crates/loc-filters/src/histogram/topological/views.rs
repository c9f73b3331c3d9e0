//! What places look like to a laser.
//!
//! From a scan six numbers are taken that do not depend on the heading: below which ranges a tenth,
//! three, five, seven and nine tenths of the beams are, and how narrow the passage is in which the
//! robot stands (the least distance between two opposite walls: in a door its width). What a place
//! looks like is known from scans that were taken all over it, simulated in a map or recorded.

use crate::Result;
use loc_core::error::{positive, probability};
use loc_sensors::laser::LaserScan;
use std::f64::consts::PI;

/// How many numbers are taken from a scan.
const COUNT: usize = 6;

type Look = [f64; COUNT];

/// Shares of the beams that are shorter than the ranges that are looked at.
const SHARES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// Looks of a place lie on curves and in lumps, which are narrower than a normal distribution of
/// the same variance: share of the width by the rule of Scott.
const NARROWER: f64 = 0.5;

/// Bandwidths are at least this, in the logarithm of a length.
const FINEST: f64 = 0.02;

/// The looks of all places, as samples whose density stands for P(s | place): a sum of normal
/// densities, one about each sample, half as wide as by the rule of Scott (1992).
#[derive(Debug, Clone)]
pub struct PlaceViews {
    looks: Vec<Vec<Look>>,
    bandwidths: Vec<Look>,
    independence: f64,
    surprise: f64,
}

impl PlaceViews {
    /// From scans that were taken at various spots and headings, a list for each place. Scans that
    /// follow each other on a drive look alike: each counts as the share `independence` of an
    /// independent one, above 0. With the probability `surprise` a scan looks like in none of the
    /// places, or like in any of them.
    ///
    /// # Errors
    /// [`loc_core::Error::Length`] for a place without a scan in which anything is seen,
    /// [`loc_core::Error::OutOfRange`] for the shares, and scans that cannot be.
    pub fn new(places: &[Vec<LaserScan>], independence: f64, surprise: f64) -> Result<Self> {
        positive("independence of scans", independence)?;
        probability("surprise of a scan", surprise)?;
        let mut looks = Vec::with_capacity(places.len());
        for scans in places {
            let mut of_place = Vec::with_capacity(scans.len());
            for scan in scans {
                scan.check()?;
                of_place.extend(look(scan));
            }
            if of_place.is_empty() {
                let expected = "at least one that sees anything, for each place";
                let what = "scans of a place";
                return Err(loc_core::Error::Length { what, expected, found: 0 }.into());
            }
            looks.push(of_place);
        }
        let bandwidths = looks.iter().map(|looks| bandwidth(looks)).collect();
        Ok(PlaceViews { looks, bandwidths, independence, surprise })
    }

    /// How likely a scan is in each place, up to a common factor; `None` for a scan in which
    /// nothing is seen.
    ///
    /// # Errors
    /// A scan that cannot be one ([`LaserScan::check`]).
    pub fn likelihoods(&self, scan: &LaserScan) -> Result<Option<Vec<f64>>> {
        scan.check()?;
        let Some(seen) = look(scan) else { return Ok(None) };
        let places = self.looks.iter().zip(&self.bandwidths);
        let logs: Vec<f64> =
            places.map(|(looks, width)| log_density(looks, width, &seen)).collect();
        let highest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let densities: Vec<f64> = logs.iter().map(|log| (log - highest).exp()).collect();
        let mean = densities.iter().sum::<f64>() / densities.len() as f64;
        let mixed = |density: f64| (1.0 - self.surprise) * density + self.surprise * mean;
        Ok(Some(densities.into_iter().map(|d| mixed(d).powf(self.independence)).collect()))
    }
}

/// The numbers of a scan, as logarithms; beams without an echo count with the full range.
fn look(scan: &LaserScan) -> Option<Look> {
    let reach = if scan.range_max.is_finite() { scan.range_max } else { 0.0 };
    let range = |&range: &f64| match range {
        range if scan.is_valid(range) => Some(range),
        range if range == f64::INFINITY && reach > 0.0 => Some(reach),
        _ => None,
    };
    let ranges: Vec<Option<f64>> = scan.ranges.iter().map(range).collect();
    let mut seen: Vec<f64> = ranges.iter().copied().flatten().collect();
    if seen.is_empty() || !seen.iter().any(|range| *range < reach || reach <= 0.0) {
        return None;
    }
    seen.sort_by(f64::total_cmp);
    let last = (seen.len() - 1) as f64;
    let shorter = SHARES.map(|share| seen[(share * last) as usize]);
    let half_turn = (PI / scan.angle_increment.abs()).round();
    // A scanner that sees less than half a turn has no opposite beams.
    let opposite = if half_turn >= 1.0 && half_turn < ranges.len() as f64 {
        ranges.iter().zip(&ranges[half_turn as usize..])
    } else {
        ranges.iter().zip(&ranges[ranges.len()..])
    };
    let across = opposite.filter_map(|(a, b)| Some((*a)? + (*b)?));
    let narrowest = across.reduce(f64::min).unwrap_or(2.0 * shorter[0]);
    let log = |length: f64| length.max(1e-3).ln();
    let [a, b, c, d, e] = shorter.map(log);
    Some([a, b, c, d, e, log(narrowest)])
}

/// Widths of the normal densities about samples.
fn bandwidth(looks: &[Look]) -> Look {
    let count = looks.len() as f64;
    let factor = NARROWER * count.powf(-1.0 / (COUNT as f64 + 4.0));
    std::array::from_fn(|k| {
        let mean = looks.iter().map(|look| look[k]).sum::<f64>() / count;
        let variance = looks.iter().map(|look| (look[k] - mean).powi(2)).sum::<f64>() / count;
        (factor * variance.sqrt()).max(FINEST)
    })
}

fn log_density(looks: &[Look], width: &Look, seen: &Look) -> f64 {
    let squared =
        |look: &Look| -> f64 { (0..COUNT).map(|k| ((look[k] - seen[k]) / width[k]).powi(2)).sum() };
    let nearest = looks.iter().map(&squared).fold(f64::INFINITY, f64::min);
    let sum: f64 = looks.iter().map(|look| (0.5 * (nearest - squared(look))).exp()).sum();
    let volume: f64 = width.iter().map(|width| width.ln()).sum();
    (sum / looks.len() as f64).ln() - 0.5 * nearest - volume
}
