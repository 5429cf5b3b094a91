//! A body that slides, spins, rolls or falls on tiles side by side, as on one plate.

use crate::draw::Draw;
use crate::scene::{Scene, Start};
use crate::shapes::Shape;
use crate::urdf::Robot;
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;

/// Thickness of the tiles (m).
const THICK: f64 = 0.2;
/// Half of the square that they cover, at least (m).
const HALF: f64 = 1.2;

/// Seams run straight through, or every other row of longer tiles is shifted.
pub fn tiles(draw: &mut Draw, mut scene: Scene) -> Scene {
    let size = draw.range(0.12, 0.5);
    let (shape, rpy, height) = match draw.index(3) {
        0 => {
            let [x, y, z] = [(); 3].map(|()| draw.range(0.05, 0.25));
            (Shape::Box { size: Vector3::new(x, y, z) }, 0.0, 0.5 * z)
        }
        1 => {
            let (radius, length) = (draw.range(0.03, 0.1), draw.range(0.05, 0.3));
            (Shape::Cylinder { radius, length }, FRAC_PI_2, radius)
        }
        _ => {
            let radius = draw.range(0.03, 0.1);
            (Shape::Sphere { radius }, 0.0, radius)
        }
    };
    let falls = draw.coin(0.3);
    let mut body = Robot::new("body");
    body.solid("body", draw.range(0.3, 3.0), shape);
    let place = Vector3::new(draw.range(-0.2, 0.2), draw.range(-0.2, 0.2), height);
    let start = Start {
        position: place + Vector3::z() * if falls { draw.range(0.001, 0.05) } else { 0.0 },
        rpy: Vector3::new(rpy, 0.0, draw.range(-3.0, 3.0)),
        linear: Vector3::new(draw.range(-1.0, 1.0), draw.range(-1.0, 1.0), 0.0),
        angular: Vector3::z() * if draw.coin(0.7) { draw.range(-4.0, 4.0) } else { 0.0 },
        ..Start::floating(Vector3::zeros())
    };
    let (friction, shifted) = (draw.range(0.05, 0.8), draw.coin(0.4));
    scene.duration = draw.range(0.3, 0.8);
    scene.robot(&body, &start, false);
    let mut plate = scene.clone();
    let (long, shift) = if shifted { (2.0 * size, 0.7 * size) } else { (size, 0.0) };
    let [columns, rows] = [long, size].map(|length| (2.0 * HALF / length).ceil() as usize + 1);
    for (column, row) in (0..columns).flat_map(|column| (0..rows).map(move |row| (column, row))) {
        let x = long * column as f64 - HALF + if row % 2 == 1 { shift } else { 0.0 };
        let tile = Shape::Box { size: Vector3::new(long, size, THICK) };
        scene.obstacle(tile, Vector3::new(x, size * row as f64 - HALF, -0.5 * THICK), Vector3::zeros());
    }
    let whole = Shape::Box { size: Vector3::new(6.0, 6.0, THICK) };
    plate.obstacle(whole, Vector3::new(0.0, 0.0, -0.5 * THICK), Vector3::zeros());
    for of in [&mut scene, &mut plate] {
        of.contacts(false, friction, 0.0);
    }
    scene.twin = Some(("plate.toml".to_string(), plate.text()));
    scene
}
