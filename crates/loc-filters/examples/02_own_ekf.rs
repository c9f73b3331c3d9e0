//! An extended Kalman filter with models of your own (H1): a mass on a spring, of which only the
//! potential energy is measured.

use loc_core::Gaussian;
use loc_filters::extended::LinearizedMotion;
use loc_filters::{ExtendedKalmanFilter, Gate, MeasurementModel, MotionModel};
use nalgebra::{Matrix1, Matrix1x2, Matrix2, Vector1, Vector2};

/// State (x, v) \[m, m/s\]; one step of `dt` \[s\] at 1 rad/s.
struct Spring {
    dt: f64,
}

impl MotionModel<2> for Spring {
    fn predict(&self, x: &Vector2<f64>) -> Vector2<f64> {
        let (sin, cos) = self.dt.sin_cos();
        Matrix2::new(cos, sin, -sin, cos) * x
    }

    fn linearize(&self, x: &Vector2<f64>) -> LinearizedMotion<2> {
        let (sin, cos) = self.dt.sin_cos();
        let jacobian = Matrix2::new(cos, sin, -sin, cos);
        LinearizedMotion { state: jacobian * x, jacobian, noise: Matrix2::identity() * 1e-4 }
    }
}

/// Energy `x^2 / 2` \[J\], measured to 0.05 J.
struct Energy;

impl MeasurementModel<2, 1> for Energy {
    fn predict(&self, x: &Vector2<f64>) -> Vector1<f64> {
        Vector1::new(0.5 * x.x * x.x)
    }

    fn jacobian(&self, x: &Vector2<f64>) -> Matrix1x2<f64> {
        Matrix1x2::new(x.x, 0.0)
    }

    fn noise(&self, _expected: &Vector1<f64>) -> Matrix1<f64> {
        Matrix1::new(0.05 * 0.05)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let start = Gaussian::new(Vector2::new(0.6, 0.1), Matrix2::identity() * 0.1)?;
    let mut filter = ExtendedKalmanFilter::new(start)?;
    let gate = Gate::probability(0.999)?;
    for step in 1..=60 {
        filter.predict(&Spring { dt: 0.1 })?;
        let truth = (0.1 * f64::from(step)).cos();
        let innovation = filter.correct(&Energy, &Vector1::new(0.5 * truth * truth), &gate)?;
        if step % 20 == 0 {
            let x = filter.belief().mean.x;
            println!("x = {x:+.3} m, true {truth:+.3} m, NIS {:.2}", innovation.nis);
        }
    }
    Ok(())
}
