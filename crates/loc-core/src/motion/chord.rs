//! The chord of one motion step: where, relative to the heading at its start, the step leads.
//!
//! A robot that drives one metre while it turns by phi ends at a chord whose components along and
//! across its first heading depend on phi alone. The three integration rules of E2 differ in
//! nothing else.

/// Components of the chord of a step of unit arc length.
///
/// As a complex number `along + i across` it multiplies the distance driven.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Chord {
    /// Along the heading at the start.
    pub along: f64,
    /// Across it, to the left.
    pub across: f64,
}

/// Below this turn \[rad\] the closed forms lose digits to cancellation and series take over.
const SMALL_TURN: f64 = 1e-2;

impl Chord {
    /// Euler's rule: straight on, as if the heading did not change.
    pub fn euler() -> Self {
        Chord { along: 1.0, across: 0.0 }
    }

    /// The midpoint rule: straight, at the heading of half the turn `phi` \[rad\].
    pub fn midpoint(phi: f64) -> Self {
        let (across, along) = (0.5 * phi).sin_cos();
        Chord { along, across }
    }

    /// The exact arc about the instantaneous centre of rotation:
    /// (sin phi / phi, (1 - cos phi) / phi).
    // ANCHOR: exact-arc
    pub fn exact(phi: f64) -> Self {
        if phi.abs() < SMALL_TURN {
            let p2 = phi * phi;
            let along = 1.0 - p2 / 6.0 * (1.0 - p2 / 20.0 * (1.0 - p2 / 42.0));
            let across = phi / 2.0 * (1.0 - p2 / 12.0 * (1.0 - p2 / 30.0));
            return Chord { along, across };
        }
        let (sin, cos) = phi.sin_cos();
        Chord { along: sin / phi, across: (1.0 - cos) / phi }
    }
    // ANCHOR_END: exact-arc

    /// Derivative of [`midpoint`](Chord::midpoint) over `phi`.
    pub fn midpoint_slope(phi: f64) -> Self {
        let (sin, cos) = (0.5 * phi).sin_cos();
        Chord { along: -0.5 * sin, across: 0.5 * cos }
    }

    /// Derivative of [`exact`](Chord::exact) over `phi`.
    pub fn exact_slope(phi: f64) -> Self {
        if phi.abs() < SMALL_TURN {
            let p2 = phi * phi;
            let along = -phi / 3.0 * (1.0 - p2 / 10.0 * (1.0 - p2 / 28.0));
            let across = 0.5 - p2 / 8.0 * (1.0 - p2 / 18.0);
            return Chord { along, across };
        }
        let (sin, cos) = phi.sin_cos();
        let p2 = phi * phi;
        Chord { along: (phi * cos - sin) / p2, across: (phi * sin + cos - 1.0) / p2 }
    }
}
