//! How likely a scan is: the likelihood field in the forms that grids need.

use super::bounds::BoundMaps;
use super::codes::PaddedCodes;
use super::scan::Scan;
use super::settings::GridSettings;
use super::space::PoseSpace;
use super::window::Window;
use crate::Result;
use loc_maps::likelihood_field::LikelihoodFieldSettings;
use loc_maps::{LikelihoodField, OccupancyGrid};

/// The likelihood field of a map, made ready for grids.
#[derive(Debug, Clone)]
pub(super) struct Sensor {
    pub(super) field: LikelihoodField,
    codes: PaddedCodes,
    pub(super) bounds: BoundMaps,
}

impl Sensor {
    pub(super) fn new(
        map: &OccupancyGrid,
        space: &PoseSpace,
        settings: &GridSettings,
    ) -> Result<Self> {
        // A field cannot be sharper than the map.
        let sigma_hit = settings.field.sigma_hit.max(map.resolution());
        let field = LikelihoodFieldSettings { sigma_hit, ..settings.field };
        let field = LikelihoodField::new(map, &field)?;
        let codes = PaddedCodes::new(&field, space.side());
        let bounds = BoundMaps::new(&field, space.side());
        Ok(Sensor { field, codes, bounds })
    }

    /// Logarithm of the mean likelihood of a scan over the poses of a square and a sector; `ends`
    /// are those of the sector's headings.
    pub(super) fn rate_square(
        &self,
        space: &PoseSpace,
        scan: &Scan,
        place: usize,
        ends: &[Vec<[i32; 2]>],
    ) -> f64 {
        let side = space.side();
        let corner = space.corner_of(place);
        let free: Vec<bool> = (0..side * side)
            .map(|k| space.is_free(corner[0] + k % side, corner[1] + k / side))
            .collect();
        let mut sums = vec![0; side * side * ends.len()];
        for (ends, sums) in ends.iter().zip(sums.chunks_exact_mut(side * side)) {
            self.codes.sums(corner, ends, sums);
        }
        let rated = || sums.iter().zip(free.iter().cycle()).filter(|(_, free)| **free);
        let highest = rated().map(|(sum, _)| *sum).max().unwrap_or(0);
        let relative = |sum: u32| (-scan.per_code * f64::from(highest - sum)).exp();
        let (count, total) = rated()
            .fold((0.0, 0.0), |(count, total), (sum, _)| (count + 1.0, total + relative(*sum)));
        scan.lowest + scan.per_code * f64::from(highest) + (total / count).ln()
    }

    /// Logarithm of the likelihood of a scan in each cell of a window, layer by layer.
    pub(super) fn rate_window(&self, window: &Window, scan: &Scan) -> Vec<f64> {
        let size = window.stack().size();
        let poses = || (0..size.layer()).map(|place| window.pose(0, place));
        let x: Vec<f64> = poses().map(|pose| pose.x).collect();
        let y: Vec<f64> = poses().map(|pose| pose.y).collect();
        let mut rated = vec![0.0; size.count()];
        for (layer, rated) in rated.chunks_exact_mut(size.layer()).enumerate() {
            let theta = vec![window.pose(layer, 0).theta; size.layer()];
            self.field.log_likelihoods([&x, &y, &theta], &scan.endpoints, rated);
            rated.iter_mut().for_each(|log_likelihood| *log_likelihood *= scan.exponent);
        }
        rated
    }
}
