//! The ends of a scan's beams, laid out for lookups.

/// How many beams are placed together: as many as the widest vector instructions take at once.
pub(super) const BLOCK: usize = 16;

/// Ends of beams in the frame of the sensor or the robot, x and y apart, in single precision.
#[derive(Debug, Clone, Default)]
pub struct Endpoints {
    /// Coordinates, filled up to whole blocks with NaN, which lies off every map.
    xs: Vec<f32>,
    ys: Vec<f32>,
    len: usize,
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
        self.len
    }

    /// Whether there are no beams.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The x coordinates \[m\].
    pub fn xs(&self) -> &[f32] {
        self.xs.get(..self.len).unwrap_or_default()
    }

    /// The y coordinates \[m\].
    pub fn ys(&self) -> &[f32] {
        self.ys.get(..self.len).unwrap_or_default()
    }

    /// The beams for which `keep` says so, in order; those that it does not reach are left out.
    #[must_use]
    pub fn selected(&self, keep: &[bool]) -> Self {
        let beams = self.xs().iter().zip(self.ys()).zip(keep);
        beams.filter(|&(_, keep)| *keep).map(|((&x, &y), _)| (x, y)).collect()
    }

    /// The coordinates in blocks, the last one filled up.
    #[inline(always)]
    pub(super) fn blocks(&self) -> (&[[f32; BLOCK]], &[[f32; BLOCK]]) {
        (self.xs.as_chunks().0, self.ys.as_chunks().0)
    }
}

impl PartialEq for Endpoints {
    fn eq(&self, other: &Self) -> bool {
        self.xs() == other.xs() && self.ys() == other.ys()
    }
}

impl FromIterator<[f64; 2]> for Endpoints {
    /// Points (x, y) \[m\]; those that are not finite are left out.
    fn from_iter<I: IntoIterator<Item = [f64; 2]>>(points: I) -> Self {
        points.into_iter().map(|[x, y]| (x as f32, y as f32)).collect()
    }
}

impl FromIterator<(f32, f32)> for Endpoints {
    /// Points (x, y) \[m\]; those that are not finite are left out.
    fn from_iter<I: IntoIterator<Item = (f32, f32)>>(points: I) -> Self {
        let finite = points.into_iter().filter(|(x, y)| x.is_finite() && y.is_finite());
        let (mut xs, mut ys): (Vec<f32>, Vec<f32>) = finite.unzip();
        let len = xs.len();
        xs.resize(len.next_multiple_of(BLOCK), f32::NAN);
        ys.resize(len.next_multiple_of(BLOCK), f32::NAN);
        Endpoints { xs, ys, len }
    }
}
