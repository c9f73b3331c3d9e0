//! What can be read from the belief.

use super::GridLocalizer;
use super::belief::Belief;
use super::focus::Peak;
use super::localizer::Found;
use super::moments::Sums;
use super::window::Window;
use loc_core::Gaussian;
use loc_maps::grid::GridFrame;

impl GridLocalizer {
    /// Finds the most likely place: that of the fine grid, where there is one.
    pub(super) fn look(&mut self) {
        let Belief { window, stack, anywhere, .. } = &self.belief;
        let in_window = window.as_ref().and_then(Window::gaussian);
        let peak = Peak::of(stack, &self.space, &self.settings.fine);
        self.found = match (in_window, peak) {
            (Some(gaussian), _) => Found { share: self.belief.in_window(), gaussian },
            (None, Some(Peak { share, gaussian, .. })) if share > *anywhere => {
                Found { share, gaussian }
            }
            _ => Found { share: 0.0, gaussian: self.mean() },
        };
    }

    /// Mean and covariance over (x, y, theta) \[m, m, rad\] of the most likely place, now: of the
    /// fine grid, where there is one, else of the surroundings of the most likely cell, carried along
    /// by the way since the last update. Of a robot that may be anywhere, those of the whole belief.
    pub fn estimate(&self) -> Gaussian<3> {
        let Found { gaussian, .. } = self.found;
        self.path.map_or(gaussian, |path| self.settings.motion.belief_after(&path, &gaussian))
    }

    /// The probability of the place that [`estimate`](GridLocalizer::estimate) describes; 0 for a
    /// robot that may be anywhere.
    pub fn certainty(&self) -> f64 {
        self.found.share
    }

    /// The probability of a robot that may be anywhere, evenly: what all cells have that are not
    /// kept one by one.
    pub fn anywhere(&self) -> f64 {
        self.belief.anywhere
    }

    /// Up to `most` likely places, the likeliest first: each with its probability and its mean and
    /// covariance over (x, y, theta) \[m, m, rad\].
    pub fn hypotheses(&self, most: usize) -> Vec<(f64, Gaussian<3>)> {
        let Belief { stack, window, .. } = &self.belief;
        let peaks = Peak::several(stack, &self.space, &self.settings.fine, most);
        let coarse = peaks.into_iter().map(|peak| (peak.share, peak.gaussian));
        let fine = window.as_ref().and_then(Window::gaussian);
        let fine = fine.map(|gaussian| (self.belief.in_window(), gaussian));
        let mut all: Vec<(f64, Gaussian<3>)> = fine.into_iter().chain(coarse).collect();
        all.sort_by(|a, b| b.0.total_cmp(&a.0));
        all.truncate(most);
        all
    }

    /// Mean and covariance over (x, y, theta) \[m, m, rad\] of the whole belief at the last update.
    pub fn mean(&self) -> Gaussian<3> {
        let Belief { stack, window, anywhere, .. } = &self.belief;
        let space = &self.space;
        let coarse = || stack.cells().map(|(layer, place, p)| (space.pose(layer, place), p));
        let fine = || {
            let windows = window.iter().flat_map(|w| w.stack().cells().map(move |cell| (w, cell)));
            windows.map(|(window, (layer, place, p))| (window.pose(layer, place), p))
        };
        let headings = space.size().headings as f64;
        let everywhere = || {
            let places = (0..space.size().layer()).map(move |place| (place, space.share(place)));
            let places = places.filter(|(_, share)| *share > 0.0);
            places.map(move |(place, share)| {
                let pose = space.pose(0, place);
                ([pose.x, pose.y], anywhere * share * headings)
            })
        };
        let mut sums = Sums::default();
        coarse().chain(fine()).for_each(|(pose, p)| sums.add(pose, p));
        everywhere().for_each(|(place, p)| sums.add_any_heading(place, p));
        // The belief adds up to 1, so there is something.
        let Some(mut spread) = sums.spread() else { return self.found.gaussian };
        coarse().chain(fine()).for_each(|(pose, p)| spread.add(pose, p));
        everywhere().for_each(|(place, p)| spread.add_any_heading(place, p));
        spread.gaussian(space.squares().resolution(), space.heading_step())
    }

    /// The squares of the map that probabilities are kept for.
    pub fn squares(&self) -> &GridFrame {
        self.space.squares()
    }

    /// The probability of each square at the last update, whatever the heading, row by row from the
    /// bottom; their sum is 1.
    pub fn position_probabilities(&self) -> Vec<f64> {
        let Belief { stack, window, anywhere, .. } = &self.belief;
        let size = self.space.size();
        let everywhere = anywhere * size.headings as f64;
        let mut sums: Vec<f64> =
            (0..size.layer()).map(|place| everywhere * self.space.share(place)).collect();
        stack.cells().for_each(|(_, place, p)| sums[place] += p);
        for (window, (layer, place, p)) in
            window.iter().flat_map(|w| w.stack().cells().map(move |cell| (w, cell)))
        {
            if let Some((_, place)) = self.space.cell_of(window.pose(layer, place)) {
                sums[place] += p;
            }
        }
        sums
    }
}
