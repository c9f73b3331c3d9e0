//! All settings of grid localization, with defaults that serve most robots.

use crate::RobotSettings;
use loc_maps::likelihood_field::LikelihoodFieldSettings;
use std::f64::consts::PI;

loc_core::settings! {
    /// Settings of a [`GridLocalizer`](super::GridLocalizer).
    #[derive(Copy)]
    pub struct GridSettings {
        /// The robot and its sensors.
        pub robot: RobotSettings = RobotSettings::default() => check;
        /// Side of a cell of the grid over the whole map \[m\], rounded to whole cells of the map.
        pub cell: f64 = 0.2 => positive;
        /// Largest step from one heading to the next \[rad\]; the full turn is divided evenly.
        #[serde(with = "loc_core::settings::angle")]
        pub heading: f64 = 5_f64.to_radians() => within(1e-3, PI);
        /// The fine grid that follows the most likely place.
        pub fine: FineSettings = FineSettings::default() => check;
        /// How likely a beam's end is, by its distance from the nearest obstacle. `sigma_hit` is at
        /// least the side of a map cell.
        pub field: LikelihoodFieldSettings = LikelihoodFieldSettings::default() => check;
        /// Maximum number of beams of a scan that are used.
        pub beams: usize = 60 => within(1, 10_000);
        /// As how many independent beams a scan counts, if it has more: its beams see the same
        /// walls, with the same errors of the map.
        pub independent_beams: f64 = 20.0 => positive;
        /// Probability that the robot is kidnapped, or delocalized, between two updates: the share
        /// of a uniform distribution that is mixed in at each of them.
        pub kidnap_rate: f64 = 1e-3 => probability;
        /// Cells are passed over as long as all of them together have at most this share in the
        /// result.
        pub negligible: f64 = 1e-4 => within(0.0, 0.1);
        /// No update before the robot has driven this far \[m\] ..
        pub update_distance: f64 = 0.1 => non_negative;
        /// .. or turned this much \[rad\].
        #[serde(with = "loc_core::settings::angle")]
        pub update_turn: f64 = 0.1 => non_negative;
    }
}

loc_core::settings! {
    /// The fine grid that follows the most likely place.
    #[derive(Copy)]
    pub struct FineSettings {
        /// Side of a cell \[m\].
        pub cell: f64 = 0.04 => positive;
        /// Step from one heading to the next \[rad\].
        #[serde(with = "loc_core::settings::angle")]
        pub heading: f64 = 0.5_f64.to_radians() => within(1e-4, PI);
        /// How far it reaches from its middle, along both axes of the map \[m\].
        pub reach: f64 = 0.6 => positive;
        /// How far it reaches to both sides of its middle heading \[rad\].
        #[serde(with = "loc_core::settings::angle")]
        pub turn: f64 = 15_f64.to_radians() => holds(
            "a number above 0 and up to pi",
            |f| f.turn > 0.0 && f.turn <= PI
        );
    }
}
