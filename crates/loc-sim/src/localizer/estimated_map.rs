//! The landmarks of a method that draws its own map.

use loc_filters::slam::MapLandmark;

/// A map that a method has drawn.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EstimatedMap {
    /// Whether its numbers are those that were read off the landmarks. Otherwise the method has
    /// given them.
    pub numbered: bool,
    /// The landmarks, provisional ones included.
    pub landmarks: Vec<MapLandmark>,
}
