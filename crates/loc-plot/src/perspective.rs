//! Points and lines in space as an image, as an eye sees them.

use crate::color::{Image, Rgb};
use loc_core::nalgebra::{Matrix3, Point3, Vector3};

/// Nothing nearer to the eye than this is drawn \[m\].
const NEAREST: f64 = 0.05;

/// An image in perspective; nearer dots hide farther ones. z is up.
///
/// ```
/// use loc_core::nalgebra::Point3;
/// use loc_plot::Perspective;
/// let eye = Point3::new(-2.0, 0.0, 0.0);
/// let mut view = Perspective::new(eye, Point3::origin(), (40, 30), 40.0, [255; 3]);
/// view.dot(&Point3::origin(), [0, 0, 0], 1);
/// view.dot(&Point3::new(1.0, 0.0, 0.0), [9, 9, 9], 1);
/// assert_eq!(view.into_image().pixels[15 * 40 + 20], [0, 0, 0]);
/// ```
#[derive(Debug, Clone)]
pub struct Perspective {
    eye: Point3<f64>,
    /// Rows: to the right, down, ahead.
    turn: Matrix3<f64>,
    focal: f64,
    image: Image,
    height: usize,
    depths: Vec<f64>,
}

impl Perspective {
    /// An empty image of `size` (width, height) pixels, as seen from `eye` with the `target` in its
    /// middle. What is 1 m wide and 1 m away is `focal` pixels wide.
    pub fn new(
        eye: Point3<f64>,
        target: Point3<f64>,
        (width, height): (usize, usize),
        focal: f64,
        paper: Rgb,
    ) -> Self {
        let ahead = (target - eye).normalize();
        let right = ahead.cross(&Vector3::z()).normalize();
        let down = ahead.cross(&right);
        let turn = Matrix3::from_rows(&[right.transpose(), down.transpose(), ahead.transpose()]);
        let image = Image { width, pixels: vec![paper; width * height] };
        let depths = vec![f64::INFINITY; width * height];
        Perspective { eye, turn, focal, image, height, depths }
    }

    /// A square dot of `size` pixels.
    pub fn dot(&mut self, point: &Point3<f64>, color: Rgb, size: usize) {
        let seen = self.turn * (point - self.eye);
        if seen.z < NEAREST {
            return;
        }
        let (width, scale) = (self.image.width, self.focal / seen.z);
        let (x, y) =
            (seen.x * scale + 0.5 * width as f64, seen.y * scale + 0.5 * self.height as f64);
        for k in 0..size * size {
            let (column, row) = (x + (k % size) as f64, y + (k / size) as f64);
            let inside = column >= 0.0 && row >= 0.0;
            let (column, row) = (column as usize, row as usize);
            let index = row * width + column;
            if inside && column < width && row < self.height && seen.z < self.depths[index] {
                self.image.pixels[index] = color;
                self.depths[index] = seen.z;
            }
        }
    }

    /// A line of 1001 dots.
    pub fn line(&mut self, from: &Point3<f64>, to: &Point3<f64>, color: Rgb) {
        for k in 0..=1000 {
            self.dot(&(from + (to - from) * (f64::from(k) / 1000.0)), color, 2);
        }
    }

    /// The image.
    pub fn into_image(self) -> Image {
        self.image
    }
}
