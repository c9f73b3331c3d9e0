//! The ends of a scan's beams, laid out for lookups.

/// Ends of beams in the frame of the sensor or the robot, x and y apart, in single precision.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Endpoints {
    xs: Vec<f32>,
    ys: Vec<f32>,
}

impl Endpoints {
    /// The ends of a scan's beams, from their angles \[rad\] and ranges \[m\]; beams whose range
    /// is not a finite number >= 0 (no return, too close, an error) are left out.
    pub fn from_scan(angles: &[f64], ranges: &[f64]) -> Self {
        let beams = angles.iter().zip(ranges);
        let valid = beams.filter(|&(_, range)| range.is_finite() && *range >= 0.0);
        valid.map(|(angle, range)| [range * angle.cos(), range * angle.sin()]).collect()
    }

    /// Number of beams.
    pub fn len(&self) -> usize {
        self.xs.len()
    }

    /// Whether there are no beams.
    pub fn is_empty(&self) -> bool {
        self.xs.is_empty()
    }

    /// The x coordinates \[m\].
    pub fn xs(&self) -> &[f32] {
        &self.xs
    }

    /// The y coordinates \[m\].
    pub fn ys(&self) -> &[f32] {
        &self.ys
    }
}

impl FromIterator<[f64; 2]> for Endpoints {
    /// Points (x, y) \[m\]; those that are not finite are left out.
    fn from_iter<I: IntoIterator<Item = [f64; 2]>>(points: I) -> Self {
        let points = points.into_iter().filter(|[x, y]| x.is_finite() && y.is_finite());
        let (xs, ys) = points.map(|[x, y]| (x as f32, y as f32)).unzip();
        Endpoints { xs, ys }
    }
}
