//! Markov localization on a topological map (K1 over the places of C4).
//!
//! "In which room am I?" needs no coordinates. The states are the places of the map: rooms,
//! corridors and doors. A drive lets probability flow along the edges, the further the more; a scan
//! multiplies each place by how similar it is to the scans that were taken there
//! ([`PlaceViews`]), whatever the robot's heading.
//!
//! Along the path the place is a Markov chain, continuous in the distance travelled: from a place i the robot goes on to a
//! neighbour j at the rate 1 / (n_i l_ij) per metre, for n_i neighbours at distances l_ij. It stays
//! in a place for about as long as its ways are, and all neighbours are as likely if they are
//! equally far. After the distance w, P' = P exp(Q w), which is summed up as the mean of powers of a
//! matrix over a Poisson distribution (uniformization, Jensen 1953).
//!
//! ```
//! use loc_filters::histogram::TopologicalFilter;
//! use loc_maps::TopologicalMap;
//! use loc_maps::topological::{Edge, Place, PlaceKind};
//! let map = TopologicalMap::new(
//!     [
//!         Place::new("kitchen", PlaceKind::Room, 0.0, 0.0),
//!         Place::new("hall", PlaceKind::Corridor, 4.0, 0.0),
//!         Place::new("cellar", PlaceKind::Room, 9.0, 0.0),
//!     ],
//!     [Edge::new(0, 1, 4.0)],
//! )?;
//! let mut filter = TopologicalFilter::new(map)?;
//! filter.correct(&[0.8, 0.1, 0.1])?; // It smells of coffee.
//! assert!((filter.belief()[0] - 0.8).abs() < 1e-12);
//! filter.predict(2.0)?;
//! // Out of the kitchen at 1/4 per metre, and back as often.
//! let flow = 0.5 * (1.0 - (-2.0 * 2.0 / 4.0_f64).exp());
//! assert!((filter.belief()[1] - (0.1 + 0.7 * flow)).abs() < 1e-9);
//! assert!((filter.belief()[2] - 0.1).abs() < 1e-9); // Not reachable.
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::Result;
use loc_core::error::{in_range, non_negative, positive, probability};
use loc_core::probability::{Discrete, bayes};
use loc_maps::TopologicalMap;
use loc_sensors::laser::LaserScan;
use std::f64::consts::PI;

/// Lower bound of the distance between neighbours \[m\], which bounds the rate of transitions.
const NEAREST: f64 = 0.2;

/// What is left of the Poisson distribution when the sum ends.
const TAIL: f64 = 1e-12;

/// Number of expected jumps after which the chain is stationary.
const MAX_JUMPS: f64 = 1e4;

/// The probability of each place of a map.
#[derive(Debug, Clone)]
pub struct TopologicalFilter {
    map: TopologicalMap,
    belief: Vec<f64>,
    /// For each place its neighbours, as (place, rate \[1/m\]).
    rates: Vec<Vec<(usize, f64)>>,
}

impl TopologicalFilter {
    /// A robot that may be in any place, all equally likely.
    ///
    /// # Errors
    /// [`loc_core::Error::Length`] for a map without places.
    pub fn new(map: TopologicalMap) -> Result<Self> {
        let count = map.places().len();
        if count == 0 {
            let expected = "at least one place";
            return Err(
                loc_core::Error::Length { what: "topological map", expected, found: 0 }.into()
            );
        }
        let rates = (0..count).map(|place| {
            let neighbours = map.neighbours(place);
            let rate = |length: f64| 1.0 / (neighbours.len() as f64 * length.max(NEAREST));
            neighbours.iter().map(|&(to, length)| (to, rate(length))).collect()
        });
        let rates = rates.collect();
        Ok(TopologicalFilter { map, belief: vec![1.0 / count as f64; count], rates })
    }

    /// The map.
    pub fn map(&self) -> &TopologicalMap {
        &self.map
    }

    /// The probability of each place, in the order of the map; their sum is 1.
    pub fn belief(&self) -> &[f64] {
        &self.belief
    }

    /// The likeliest place, by its index.
    pub fn most_likely(&self) -> usize {
        let better =
            |best: usize, k: usize| if self.belief[k] > self.belief[best] { k } else { best };
        (0..self.belief.len()).fold(0, better)
    }

    /// Starts anew from a belief, one weight for each place; they need not add up to 1.
    ///
    /// # Errors
    /// [`loc_core::Error::Length`] for another number of weights, and those of [`Discrete`] for
    /// weights that are no probabilities; the belief is kept then.
    pub fn start(&mut self, weights: &[f64]) -> Result<()> {
        self.check_count("start", weights)?;
        let start = Discrete::from_weights(weights.iter().copied().enumerate())?;
        self.belief = start.probabilities().to_vec();
        Ok(())
    }

    /// Prediction over a distance travelled \[m\], on any path.
    ///
    /// # Errors
    /// [`loc_core::Error::OutOfRange`] for a distance that is negative or not finite.
    pub fn predict(&mut self, way: f64) -> Result<()> {
        non_negative("way [m]", way)?;
        let leaving = |rates: &Vec<(usize, f64)>| rates.iter().map(|(_, rate)| rate).sum();
        let fastest = self.rates.iter().map(leaving).fold(0.0, f64::max);
        let jumps = (fastest * way).min(MAX_JUMPS);
        if jumps <= 0.0 {
            return Ok(());
        }
        // Logarithm of the Poisson probability of k jumps, of which some lead nowhere.
        let (mut log_p, mut left, mut k) = (-jumps, 1.0, 0_u32);
        let mut jumped = self.belief.clone();
        let mut after = vec![0.0; jumped.len()];
        while left > TAIL && f64::from(k) < 4.0 * jumps + 100.0 {
            let p = log_p.exp();
            after.iter_mut().zip(&jumped).for_each(|(after, jumped)| *after += p * jumped);
            left -= p;
            k += 1;
            log_p += (jumps / f64::from(k)).ln();
            jumped = self.jump(&jumped, fastest);
        }
        let sum: f64 = after.iter().sum();
        self.belief = after.into_iter().map(|p| p / sum).collect();
        Ok(())
    }

    /// One jump of the chain that jumps everywhere at the same rate.
    fn jump(&self, from: &[f64], fastest: f64) -> Vec<f64> {
        let mut to = from.to_vec();
        for ((place, rates), p) in self.rates.iter().enumerate().zip(from) {
            for (next, rate) in rates {
                let share = p * rate / fastest;
                to[place] -= share;
                to[*next] += share;
            }
        }
        to
    }

    /// A measurement, by how likely it is in each place, up to a common factor: P(place | s) =
    /// alpha P(s | place) P(place) (K1).
    ///
    /// # Errors
    /// [`loc_core::Error::Length`] for another number of likelihoods, and those of
    /// [`bayes::posterior`]; the belief is kept then.
    pub fn correct(&mut self, likelihoods: &[f64]) -> Result<()> {
        self.check_count("likelihoods", likelihoods)?;
        let places = Discrete::from_weights(self.belief.iter().copied().enumerate())?;
        let posterior = bayes::posterior(&places, |&place| likelihoods[place])?;
        self.belief = posterior.distribution.probabilities().to_vec();
        Ok(())
    }

    fn check_count(&self, what: &'static str, weights: &[f64]) -> Result<()> {
        let (count, found) = (self.belief.len(), weights.len());
        if found != count {
            let expected = "one for each place";
            return Err(loc_core::Error::Length { what, expected, found }.into());
        }
        let sound = |value: f64| value >= 0.0 && value.is_finite();
        weights.iter().try_for_each(|&weight| {
            in_range("weight of a place", "0 or more", weight, sound).map(|_| ())
        })?;
        Ok(())
    }
}

/// How many numbers are taken from a scan.
const COUNT: usize = 6;

type ScanFeatures = [f64; COUNT];

/// Shares of the beams that are shorter than the ranges that are looked at.
const SHARES: [f64; 5] = [0.1, 0.3, 0.5, 0.7, 0.9];

/// The scan features of a place lie on curves and in clusters, which are narrower than a normal distribution of
/// the same variance: share of the width by the rule of Scott.
const NARROWER: f64 = 0.5;

/// Bandwidths are at least this, in the logarithm of a length.
const FINEST: f64 = 0.02;

/// The scan features of all places, as samples whose density stands for P(s | place): a sum of normal
/// densities, one about each sample, half as wide as by the rule of Scott (1992).
///
/// A scan is described by six numbers that do not depend on the heading: the ranges below which one,
/// three, five, seven and nine tenths of the beams are, and the width of the passage at the robot (the
/// smallest distance between two opposite walls; in a door its width). The distribution of these
/// numbers in a place is learned from scans that were taken all over it, simulated in a map or recorded.
#[derive(Debug, Clone)]
pub struct PlaceViews {
    samples: Vec<Vec<ScanFeatures>>,
    bandwidths: Vec<ScanFeatures>,
    independence: f64,
    surprise: f64,
}

impl PlaceViews {
    /// From scans that were taken at various spots and headings, a list for each place. Scans that
    /// follow each other in a recording are similar: each counts as the share `independence` of an
    /// independent one, above 0. With the probability `surprise` a scan is similar to those of none of the
    /// places, or like in any of them.
    ///
    /// # Errors
    /// [`loc_core::Error::Length`] for a place without a scan in which anything is seen,
    /// [`loc_core::Error::OutOfRange`] for the shares, and scans that cannot be.
    pub fn new(places: &[Vec<LaserScan>], independence: f64, surprise: f64) -> Result<Self> {
        positive("independence of scans", independence)?;
        probability("surprise of a scan", surprise)?;
        let mut samples = Vec::with_capacity(places.len());
        for scans in places {
            let mut of_place = Vec::with_capacity(scans.len());
            for scan in scans {
                scan.check()?;
                of_place.extend(features(scan));
            }
            if of_place.is_empty() {
                let expected = "at least one that sees anything, for each place";
                let what = "scans of a place";
                return Err(loc_core::Error::Length { what, expected, found: 0 }.into());
            }
            samples.push(of_place);
        }
        let bandwidths = samples.iter().map(|samples| bandwidth(samples)).collect();
        Ok(PlaceViews { samples, bandwidths, independence, surprise })
    }

    /// How likely a scan is in each place, up to a common factor; `None` for a scan in which
    /// nothing is seen.
    ///
    /// # Errors
    /// A scan that cannot be one ([`LaserScan::check`]).
    pub fn likelihoods(&self, scan: &LaserScan) -> Result<Option<Vec<f64>>> {
        scan.check()?;
        let Some(seen) = features(scan) else { return Ok(None) };
        let places = self.samples.iter().zip(&self.bandwidths);
        let logs: Vec<f64> =
            places.map(|(samples, width)| log_density(samples, width, &seen)).collect();
        let highest = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let densities: Vec<f64> = logs.iter().map(|log| (log - highest).exp()).collect();
        let mean = densities.iter().sum::<f64>() / densities.len() as f64;
        let mixed = |density: f64| (1.0 - self.surprise) * density + self.surprise * mean;
        Ok(Some(densities.into_iter().map(|d| mixed(d).powf(self.independence)).collect()))
    }
}

/// The numbers of a scan, as logarithms; beams without an echo count with the full range.
fn features(scan: &LaserScan) -> Option<ScanFeatures> {
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
fn bandwidth(samples: &[ScanFeatures]) -> ScanFeatures {
    let count = samples.len() as f64;
    let factor = NARROWER * count.powf(-1.0 / (COUNT as f64 + 4.0));
    std::array::from_fn(|k| {
        let mean = samples.iter().map(|features| features[k]).sum::<f64>() / count;
        let variance =
            samples.iter().map(|features| (features[k] - mean).powi(2)).sum::<f64>() / count;
        (factor * variance.sqrt()).max(FINEST)
    })
}

fn log_density(samples: &[ScanFeatures], width: &ScanFeatures, seen: &ScanFeatures) -> f64 {
    let squared = |features: &ScanFeatures| -> f64 {
        (0..COUNT).map(|k| ((features[k] - seen[k]) / width[k]).powi(2)).sum()
    };
    let nearest = samples.iter().map(&squared).fold(f64::INFINITY, f64::min);
    let sum: f64 = samples.iter().map(|features| (0.5 * (nearest - squared(features))).exp()).sum();
    let volume: f64 = width.iter().map(|width| width.ln()).sum();
    (sum / samples.len() as f64).ln() - 0.5 * nearest - volume
}
