//! The likelihood field that the filter starts from.

use loc_maps::likelihood_field::{LikelihoodFieldSettings, Obstacles};

/// A sharper field than nav2_amcl's, on the surfaces of the walls: the filter can follow it.
pub(super) fn sharp() -> LikelihoodFieldSettings {
    LikelihoodFieldSettings {
        sigma_hit: 0.05,
        z_hit: 0.8,
        z_rand: 0.2,
        obstacles: Obstacles::Surfaces,
        ..LikelihoodFieldSettings::default()
    }
}

/// Reads the settings of a field of which only some are given; the others are those of [`sharp`].
#[cfg(feature = "serde")]
pub(super) fn over_sharp<'de, D>(deserializer: D) -> Result<LikelihoodFieldSettings, D::Error>
where
    D: serde::Deserializer<'de>,
{
    use loc_maps::likelihood_field::{OffMap, UnknownSpace};
    use serde::Deserialize;

    #[derive(Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Given {
        sigma_hit: Option<f64>,
        z_hit: Option<f64>,
        z_rand: Option<f64>,
        max_range: Option<f64>,
        max_distance: Option<f64>,
        unknown_space: Option<UnknownSpace>,
        obstacles: Option<Obstacles>,
        off_map: Option<OffMap>,
    }

    let (given, sharp) = (Given::deserialize(deserializer)?, sharp());
    Ok(LikelihoodFieldSettings {
        sigma_hit: given.sigma_hit.unwrap_or(sharp.sigma_hit),
        z_hit: given.z_hit.unwrap_or(sharp.z_hit),
        z_rand: given.z_rand.unwrap_or(sharp.z_rand),
        max_range: given.max_range.unwrap_or(sharp.max_range),
        max_distance: given.max_distance.unwrap_or(sharp.max_distance),
        unknown_space: given.unknown_space.unwrap_or(sharp.unknown_space),
        obstacles: given.obstacles.unwrap_or(sharp.obstacles),
        off_map: given.off_map.unwrap_or(sharp.off_map),
    })
}
