#![doc = include_str!("../README.md")]

pub mod bounds;
pub mod convert;
pub mod distance;
mod error;
pub mod extruded;
pub mod grid;
pub mod landmark;
pub mod likelihood_field;
pub mod line;
pub mod mapping;
pub mod picture;
pub mod point;
pub mod raycast;
pub mod search;
pub mod topological;
mod tree;
pub mod worlds;

pub use bounds::Bounds;
pub use distance::DistanceMap;
pub use error::{Error, Result};
pub use extruded::ExtrudedGrid;
pub use grid::OccupancyGrid;
pub use landmark::{Landmark, LandmarkMap, Occluded};
pub use likelihood_field::LikelihoodField;
pub use line::{LineMap, LineSegment};
pub use mapping::GridMapper;
pub use picture::MapPicture;
pub use point::PointMap;
pub use raycast::RayCaster;
pub use search::{GlobalSearch, SearchSettings};
pub use topological::TopologicalMap;
pub use worlds::{World, WorldSettings};
