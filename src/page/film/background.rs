//! The background of a film: the sky, the planes of half spaces with their grids, and the light.
//!
//! ```text
//!     p = e + t d,  t = n·(o − e) / n·d          the ray d of a pixel from the eye e meets the plane of normal n through o (m)
//!     line:  |u − round(u)| c < 1 pixel          grid lines of cells c (m); u: coordinate in the plane, in cells
//!     fade:  1 at 2 s from the middle, 0 at 7 s  so that a plane has no edge; s: diagonal of what is seen (m)
//!     light = 0.46 + 0.14 n_z + 0.62 max(0, n·l)  on a surface of normal n, with the direction l to the lamp
//! ```
//!
//! Half spaces are seen from outside alone, as in the page, so that nothing is hidden from a camera below a floor. Without half spaces the grid is in
//! the plane z = 0, behind everything.

use crate::film::camera::Camera;
use crate::film::canvas::{Canvas, FINE};
use crate::mechanism::description::joint::Pose;
use nalgebra::{Point3, Vector3};

/// Colours of the page: the sky at the top and at the bottom, tiles, grid lines on tiles, and axes of the grid on tiles.
const SKY: [[f64; 3]; 2] = [[223.0, 230.0, 238.0], [247.0, 249.0, 251.0]];
const TILE: [f64; 3] = [214.0, 221.0, 229.0];
const LINE: [f64; 3] = [176.0, 187.0, 200.0];
const AXIS: [f64; 3] = [138.0, 152.0, 168.0];

/// Direction from which the lamp shines: unit vector to the lamp.
pub(super) fn lamp() -> Vector3<f64> {
    Vector3::new(0.35, -0.55, 1.15).normalize()
}

/// The light on a surface of this unit normal.
pub(super) fn light(normal: &Vector3<f64>) -> f64 {
    0.46 + 0.14 * normal.z + 0.62 * normal.dot(&lamp()).max(0.0)
}

/// The planes that are drawn, with one size of their grids.
pub(super) struct Ground {
    /// Frames of half spaces: z is the normal.
    pub planes: Vec<Pose>,
    /// The width of a cell (m).
    pub cell: f64,
    /// The middle and the diagonal of what is seen (m).
    pub middle: Vector3<f64>,
    /// The diagonal (m).
    pub size: f64,
}

impl Ground {
    /// Cells that suit a robot of this size (m): a power of ten near a quarter of it, as in the page.
    pub(super) fn cell_of(size: f64) -> f64 {
        10f64.powf((size.max(1e-3) / 4.0).log10().round())
    }

    /// Draws everything that is behind the robot.
    pub(super) fn draw(&self, camera: &Camera, canvas: &mut Canvas) {
        let width = canvas.width();
        let [columns, rows] = [width / FINE, canvas.color.len() / width / FINE];
        let floor = [Pose::identity()];
        let is_bare = self.planes.is_empty();
        let planes = if is_bare { &floor[..] } else { &self.planes[..] };
        for row in 0..rows {
            let down = (row as f64 + 0.5) / rows as f64;
            let sky = [0, 1, 2].map(|k| SKY[0][k] + down * (SKY[1][k] - SKY[0][k]));
            for column in 0..columns {
                let at = [column as f64 + 0.5, row as f64 + 0.5];
                let hits = planes.iter().zip(1..=u8::MAX).filter_map(|(plane, number)| {
                    let distance = self.distance(plane, camera, at, is_bare)?;
                    Some((distance, plane, number))
                });
                let nearest = hits.min_by(|a, b| a.0.total_cmp(&b.0));
                let (mut color, mut nearness, mut number) = (sky, 0.0, 0);
                if let Some((distance, plane, index)) = nearest {
                    let (seen, strength) = self.tile(plane, camera, at, distance, is_bare);
                    color = [0, 1, 2].map(|k| sky[k] + strength * (seen[k] - sky[k]));
                    if !is_bare && strength > 0.0 {
                        (nearness, number) = ((1.0 / distance) as f32, index);
                    }
                }
                let [red, green, blue] = color.map(|part| part.round() as u8);
                for pixel in
                    (0..FINE).flat_map(|y| (0..FINE).map(move |x| (FINE * row + y) * width + FINE * column + x))
                {
                    canvas.color[pixel] = [red, green, blue, number];
                    canvas.nearness[pixel] = nearness;
                }
            }
        }
    }

    /// The distance along the camera's axis at which a pixel meets a plane (m).
    fn distance(&self, plane: &Pose, camera: &Camera, [x, y]: [f64; 2], from_below: bool) -> Option<f64> {
        let normal = plane.rotation * Vector3::z();
        let along = normal.dot(&camera.ray(x, y));
        let height = normal.dot(&(plane.translation.vector - camera.eye));
        let distance = height / along;
        let is_front = along < 0.0 || from_below && along > 0.0;
        (is_front && distance > 0.0 && distance.is_finite()).then_some(distance)
    }

    /// The colour of a plane in a pixel, and how strong it is beside the sky.
    fn tile(&self, plane: &Pose, camera: &Camera, [x, y]: [f64; 2], distance: f64, is_bare: bool) -> ([f64; 3], f64) {
        let inside = |[x, y]: [f64; 2], distance: f64| {
            let point = Point3::from(camera.eye + distance * camera.ray(x, y));
            (point, plane.inverse_transform_point(&point) / self.cell)
        };
        let (point, here) = inside([x, y], distance);
        let beside = [[x + 1.0, y], [x, y + 1.0]].map(|at| {
            let next = self.distance(plane, camera, at, is_bare).unwrap_or(distance);
            inside(at, next).1
        });
        let fade = 1.0 - smooth(((point.coords - self.middle).norm() / self.size - 2.0) / 5.0);
        // How much of the pixel a line covers, in both directions of the grid.
        let (mut covered, mut on_axis) = (0.0f64, false);
        for axis in 0..2 {
            let step = beside.iter().map(|next| (next[axis] - here[axis]).abs()).fold(1e-12, f64::max);
            let off = (here[axis] - here[axis].round()).abs() / step;
            // Lines that are closer than two pixels are a tint.
            let part = (1.2 - off).clamp(0.0, 1.0) * (1.0 - smooth(2.0 * step - 0.5));
            if part > covered {
                (covered, on_axis) = (part, here[axis].round() == 0.0);
            }
        }
        let line = if on_axis { AXIS } else { LINE };
        if is_bare {
            return (line, fade * covered);
        }
        ([0, 1, 2].map(|k| TILE[k] + covered * (line[k] - TILE[k])), fade)
    }
}

/// From 0 to 1 without a kink: 3 x² − 2 x³.
fn smooth(part: f64) -> f64 {
    let part = part.clamp(0.0, 1.0);
    part * part * (3.0 - 2.0 * part)
}
