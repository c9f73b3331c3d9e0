//! Second pass: the lower envelope of the parabolas that the columns span over a row.

/// A parabola `(x - at)^2 + height` that is lowest from `from` on.
#[derive(Debug, Clone, Copy)]
struct Parabola {
    at: i32,
    height: i32,
    from: f64,
}

/// The pass along rows, with the memory that it needs.
#[derive(Debug)]
pub(super) struct Envelope {
    reach: i16,
    /// 1 / (2 d), by the distance d of two parabolas.
    halved_inverse: Vec<f64>,
    lowest: Vec<Parabola>,
}

impl Envelope {
    pub(super) fn new(width: usize, reach: i16) -> Self {
        let spans = width.min(2 * usize::from(reach.unsigned_abs()) + 1);
        let halved_inverse = (0..=spans).map(|span| 0.5 / span as f64).collect();
        Envelope { reach, halved_inverse, lowest: Vec::with_capacity(width) }
    }

    /// Squared distances of a row from the steps along its columns, at most `reach` squared.
    pub(super) fn transform(&mut self, steps: &[i16], squared: &mut [u32]) {
        self.lowest.clear();
        for (at, &step) in steps.iter().enumerate() {
            if step < self.reach {
                self.push(at as i32, i32::from(step) * i32::from(step));
            }
        }
        self.fill(squared);
    }

    /// Adds the next parabola to the right; those that it hides leave.
    fn push(&mut self, at: i32, height: i32) {
        let mut from = f64::NEG_INFINITY;
        while let Some(last) = self.lowest.last() {
            let span = (at - last.at) as usize;
            let middle = 0.5 * (f64::from(at) + f64::from(last.at));
            // Parabolas farther apart than the table reaches meet beyond the cut-off of both.
            let inverse = self.halved_inverse.get(span).copied().unwrap_or(0.0);
            from = middle + f64::from(height - last.height) * inverse;
            if from > last.from {
                break;
            }
            self.lowest.pop();
            from = f64::NEG_INFINITY;
        }
        self.lowest.push(Parabola { at, height, from });
    }

    fn fill(&self, squared: &mut [u32]) {
        let reach = i32::from(self.reach);
        let limit = reach * reach;
        let width = squared.len();
        let mut done = 0;
        for (k, parabola) in self.lowest.iter().enumerate() {
            let until = self.lowest.get(k + 1).map_or(width as f64, |next| next.from.ceil());
            let end = (until.max(0.0) as usize).min(width);
            // Only this part of the parabola lies below the cut-off.
            let left = ((parabola.at - reach).max(0) as usize).clamp(done, done.max(end));
            let right = ((parabola.at + reach + 1) as usize).clamp(left, left.max(end));
            squared[done..left].fill(limit as u32);
            for (x, out) in (left as i32..).zip(&mut squared[left..right]) {
                let dx = x - parabola.at;
                *out = (dx * dx + parabola.height).min(limit) as u32;
            }
            done = right;
            if end > done {
                squared[done..end].fill(limit as u32);
                done = end;
            }
        }
        squared[done..].fill(limit as u32);
    }
}
