//! From the search's grid to the middle of the peak beside it.

use super::{Candidate, GlobalSearch};
use loc_core::{Pose2, angle};
use loc_maps::likelihood_field::Endpoints;
use std::f64::consts::TAU;

/// How often the steps to the peak are halved: from half a cell to an eighth.
const HALVINGS: usize = 3;

/// The mean is taken over this many poses to each side in each coordinate ..
const SIDE: i32 = 4;

/// .. which reach this far \[cells\].
const REACH: f64 = 2.0;

/// The mean's surroundings move with it once.
const PASSES: usize = 2;

impl GlobalSearch {
    /// The pose near `start` that explains the scan, finer than the search's grid.
    ///
    /// First uphill, by pattern search (Hooke and Jeeves, 1961): steps from half a cell and half an
    /// angle step to an eighth, no farther than a cell and an angle step from `start` in each
    /// coordinate. The field has one value a cell, so the top is a jagged plateau of about a cell;
    /// the answer is the mean of the posterior over it (729 poses that move the beams by up to two
    /// cells, weighted by their likelihood). It may be a little less likely than the peak, and is
    /// nearer to the truth: with 180 beams in an office at 5 cm by 1.2 cm and 0.14 deg (medians;
    /// 0.8 cm and 0.08 deg where [`Obstacles::Surfaces`] made the field) instead of 2 cm and
    /// 0.16 deg.
    ///
    /// [`Obstacles::Surfaces`]: loc_maps::likelihood_field::Obstacles::Surfaces
    pub fn refine(&self, start: Pose2, endpoints: &Endpoints) -> Candidate {
        let mut pose = self.peak(start, endpoints);
        let reach = REACH * self.field.frame().resolution();
        let turn = (reach / length(endpoints)).min(0.2);
        for _ in 0..PASSES {
            pose = self.mean(pose, [reach, reach, turn], endpoints);
        }
        Candidate::rate(&self.field, pose, endpoints)
    }

    /// The best pose near `start`.
    fn peak(&self, start: Pose2, endpoints: &Endpoints) -> Pose2 {
        let cell = self.field.frame().resolution();
        let reach = [cell, cell, TAU / self.settings.headings() as f64];
        let mut best = Candidate::rate(&self.field, start, endpoints);
        let mut share = 0.5;
        for _ in 0..HALVINGS {
            while let Some(better) = self
                .rate_around(best.pose, reach.map(|reach| reach * share), 1, endpoints)
                .filter(|tried| is_near(tried.pose, start, reach))
                .filter(|tried| tried.log_likelihood > best.log_likelihood)
                .max_by(|a, b| a.log_likelihood.total_cmp(&b.log_likelihood))
            {
                best = better;
            }
            share *= 0.5;
        }
        best.pose
    }

    /// The mean of the posterior within `reach` of a pose.
    fn mean(&self, about: Pose2, reach: [f64; 3], endpoints: &Endpoints) -> Pose2 {
        let step = reach.map(|reach| reach / f64::from(SIDE));
        let tried: Vec<Candidate> = self.rate_around(about, step, SIDE, endpoints).collect();
        let likelihoods = tried.iter().map(|tried| tried.log_likelihood);
        let best = likelihoods.fold(f64::NEG_INFINITY, f64::max);
        let (mut total, mut sum) = (0.0, [0.0; 3]);
        for Candidate { pose, log_likelihood } in tried {
            let weight = (log_likelihood - best).exp();
            let turn = angle::difference(pose.theta, about.theta);
            let away = [pose.x - about.x, pose.y - about.y, turn];
            sum.iter_mut().zip(away).for_each(|(sum, away)| *sum += weight * away);
            total += weight;
        }
        let [x, y, turn] = sum.map(|sum| sum / total);
        Pose2::new(about.x + x, about.y + y, about.theta + turn)
    }

    /// The poses on a grid about one, up to `side` steps away in each coordinate.
    fn rate_around(
        &self,
        pose: Pose2,
        step: [f64; 3],
        side: i32,
        endpoints: &Endpoints,
    ) -> impl Iterator<Item = Candidate> + use<> {
        let ways = move || (-side..=side).map(f64::from);
        let [mut xs, mut ys, mut thetas] = [(); 3].map(|()| Vec::new());
        for turn in ways() {
            for y in ways() {
                for x in ways() {
                    xs.push(pose.x + x * step[0]);
                    ys.push(pose.y + y * step[1]);
                    thetas.push(angle::wrap(pose.theta + turn * step[2]));
                }
            }
        }
        let mut rated = vec![0.0; xs.len()];
        self.field.log_likelihoods([&xs, &ys, &thetas], endpoints, &mut rated);
        xs.into_iter().zip(ys).zip(thetas).zip(rated).map(|(((x, y), theta), log_likelihood)| {
            Candidate { pose: Pose2 { x, y, theta }, log_likelihood }
        })
    }
}

/// The length of the beams, root mean square \[m\].
fn length(endpoints: &Endpoints) -> f64 {
    let squares = endpoints.xs().iter().zip(endpoints.ys());
    let squares = squares.map(|(&x, &y)| f64::from(x).powi(2) + f64::from(y).powi(2));
    let length = (squares.sum::<f64>() / endpoints.len().max(1) as f64).sqrt();
    length.max(f64::MIN_POSITIVE)
}

fn is_near(pose: Pose2, start: Pose2, reach: [f64; 3]) -> bool {
    let turn = angle::difference(pose.theta, start.theta);
    let away = [pose.x - start.x, pose.y - start.y, turn];
    away.iter().zip(reach).all(|(away, reach)| away.abs() <= reach * (1.0 + 1e-9))
}
