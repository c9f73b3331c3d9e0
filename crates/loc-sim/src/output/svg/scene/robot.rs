//! A robot that hides nothing: a ring around its place, and a line where it looks.

use super::Scene;
use crate::output::svg::style::Role;
use loc_core::{Ellipse, Pose2};

impl Scene {
    /// The true pose as a ring of `radius` \[m\] with a pointer, so that what lies within, such as
    /// particles, can be seen.
    #[must_use]
    pub fn ring(self, label: &str, radius: f64, pose: Pose2) -> Self {
        let center = pose.position().coords;
        let ring = Ellipse { center, semi_major: radius, semi_minor: radius, angle: 0.0 };
        let ahead = |share: f64| {
            let point = pose.transform(&[share * radius, 0.0].into());
            (point.x, point.y)
        };
        let style = Role::Truth.width(1.4);
        self.ellipses(style, label, [ring]).segments(style, "", [(ahead(1.0), ahead(2.0))])
    }
}
