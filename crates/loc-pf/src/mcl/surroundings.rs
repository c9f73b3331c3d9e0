//! What is known of the map, made ready for the sensor model and for searches.

use super::observation::{MountedScan, Observation};
use super::{MclSettings, SensorSettings, Weighting};
use crate::Result;
use crate::free_space::FreeSpace;
use crate::global::{GlobalSearch, SearchSettings};
use crate::sensor::beam::telling_beams;
use crate::sensor::{BeamLikelihood, FieldLikelihood, SumOfCubes};
use loc_maps::likelihood_field::{Endpoints, LikelihoodFieldSettings};
use loc_maps::{LikelihoodField, OccupancyGrid, RayCaster};

/// The map as the filter uses it; nothing of it changes.
#[derive(Debug)]
pub(super) struct Surroundings {
    pub(super) free_space: FreeSpace,
    pub(super) field: LikelihoodField,
    /// The obstacles, where the beam model needs them.
    caster: Option<RayCaster>,
    pub(super) search: Option<GlobalSearch>,
}

/// Places that a search answers with.
const PLACES: usize = 64;

impl Surroundings {
    pub(super) fn new(map: &OccupancyGrid, settings: &MclSettings) -> Result<Self> {
        let free_space = FreeSpace::new(map)?;
        let field = settings.sensor.field();
        let casts = matches!(settings.sensor, SensorSettings::Beam(_));
        let search = settings.recovery.search.then(|| search(map, &field)).transpose()?;
        let field = LikelihoodField::new(map, &field)?;
        Ok(Surroundings { free_space, field, caster: casts.then(|| RayCaster::new(map)), search })
    }

    /// Makes scans ready, whose beams end at `endpoints`.
    pub(super) fn observe<'a>(
        &'a self,
        scans: &[MountedScan<'_>],
        endpoints: &'a Endpoints,
        settings: &MclSettings,
    ) -> Result<Observation<'a>> {
        let exponent = |beams: usize| (settings.independent_beams / beams.max(1) as f64).min(1.0);
        Ok(match (&settings.sensor, &self.caster) {
            (SensorSettings::Beam(model), Some(caster)) => {
                let telling = |mounted: &MountedScan<'_>| {
                    let beams = telling_beams(mounted.scan, settings.beams);
                    let exponent = exponent(beams.len() * scans.len());
                    BeamLikelihood::new(caster, model, mounted, &beams, exponent)
                };
                Observation::Beams(scans.iter().map(telling).collect::<Result<_>>()?)
            }
            (SensorSettings::LikelihoodField(field), _)
                if field.weighting == Weighting::SumOfCubes =>
            {
                Observation::SumOfCubes(SumOfCubes::new(&self.field, endpoints))
            }
            _ => Observation::Product(FieldLikelihood {
                field: &self.field,
                endpoints,
                exponent: exponent(endpoints.len()),
            }),
        })
    }
}

/// The search of a map, on a field that forgives the steps of the search.
fn search(map: &OccupancyGrid, field: &LikelihoodFieldSettings) -> Result<GlobalSearch> {
    let sigma_hit = field.sigma_hit.max(0.15).max(2.0 * map.frame().resolution());
    let field = LikelihoodField::new(map, &LikelihoodFieldSettings { sigma_hit, ..*field })?;
    GlobalSearch::new(map, field, SearchSettings { candidates: PLACES, ..Default::default() })
}
