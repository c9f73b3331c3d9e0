//! The point cloud: as a table, and as one sees it from behind the camera.

use crate::sense::Taken;
use loc_plot::color::Image;
use loc_sensors::rgbd::{CloudPoint, DepthCamera, Frame};
use loc_sensors::world::Rgb;
use nalgebra::{Matrix3, Point3, Vector3};

/// Of the cloud's points one in this many is written, in each direction of the image.
const THIN: usize = 4;
const PAPER: Rgb = [247, 248, 250];
const SIZE: (usize, usize) = (1200, 680);

/// Adds every fourth point of every fourth row, in the camera's frame.
pub(super) fn add_table(taken: &mut Taken, frame: &Frame, camera: &DepthCamera) {
    let (depths, colors) = (&frame.depth, frame.color.colors());
    let points = depths.points(&camera.spec);
    let kept = points.filter(|(column, row, _)| column % THIN == 0 && row % THIN == 0);
    let rows = kept.map(|(column, row, point)| {
        let color = colors.get(row * depths.width() + column).copied().unwrap_or_default();
        let [r, g, b] = color.map(f64::from);
        let millimetre = |value: f64| (1e3 * value).round() / 1e3;
        [millimetre(point.x), millimetre(point.y), millimetre(point.z), r, g, b]
    });
    taken.table("cloud.csv", ["x_m", "y_m", "z_m", "red", "green", "blue"], rows);
}

/// A picture of the cloud from a place behind, above and to the right of the camera, which is
/// drawn as the pyramid of its view.
pub(super) fn seen_from_behind(frame: &Frame, camera: &DepthCamera) -> Image {
    let reach = camera.spec.range_max;
    let mut canvas = Canvas::new(reach, camera.height);
    for CloudPoint { position, color } in frame.cloud(&camera.spec) {
        canvas.dot(&position, color, 2);
    }
    let (left, up) = (camera.spec.horizontal_fov, camera.spec.vertical_fov);
    let corner = |x: f64, y: f64| {
        let depth = 0.25 * reach;
        Point3::new(depth, x * depth * (0.5 * left).tan(), y * depth * (0.5 * up).tan())
    };
    let corners = [corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)];
    for (k, from) in corners.iter().enumerate() {
        canvas.line(from, &corners[(k + 1) % corners.len()]);
        canvas.line(&Point3::origin(), from);
    }
    Image { width: SIZE.0, pixels: canvas.pixels }
}

/// A picture in perspective, nearer dots before farther ones.
struct Canvas {
    eye: Point3<f64>,
    /// Rows: to the right, down, ahead.
    turn: Matrix3<f64>,
    focal: f64,
    pixels: Vec<Rgb>,
    depths: Vec<f64>,
}

impl Canvas {
    fn new(reach: f64, height: f64) -> Self {
        let eye = Point3::new(-0.52 * reach, -0.52 * reach, 0.66 * reach);
        let target = Point3::new(0.50 * reach, 0.0, 0.75 - height);
        let ahead = (target - eye).normalize();
        let right = ahead.cross(&Vector3::z()).normalize();
        let turn = Matrix3::from_rows(&[
            right.transpose(),
            ahead.cross(&right).transpose(),
            ahead.transpose(),
        ]);
        let count = SIZE.0 * SIZE.1;
        Canvas {
            eye,
            turn,
            focal: 0.98 * SIZE.0 as f64,
            pixels: vec![PAPER; count],
            depths: vec![f64::INFINITY; count],
        }
    }

    /// A square dot of `size` pixels.
    fn dot(&mut self, point: &Point3<f64>, color: Rgb, size: usize) {
        let seen = self.turn * (point - self.eye);
        if seen.z < 0.05 {
            return;
        }
        let scale = self.focal / seen.z;
        let (x, y) = (seen.x * scale + 0.5 * SIZE.0 as f64, seen.y * scale + 0.5 * SIZE.1 as f64);
        for k in 0..size * size {
            let (column, row) = (x + (k % size) as f64, y + (k / size) as f64);
            let inside = column >= 0.0 && row >= 0.0;
            let (column, row) = (column as usize, row as usize);
            let index = row * SIZE.0 + column;
            if inside && column < SIZE.0 && row < SIZE.1 && seen.z < self.depths[index] {
                self.pixels[index] = color;
                self.depths[index] = seen.z;
            }
        }
    }

    fn line(&mut self, from: &Point3<f64>, to: &Point3<f64>) {
        for k in 0..=1000 {
            let share = f64::from(k) / 1000.0;
            self.dot(&(from + (to - from) * share), [31, 35, 40], 2);
        }
    }
}
