//! Boxes that fall on each other and come to rest in a stack.

use crate::draw::Draw;
use crate::scene::{Answer, Scene, Start};
use crate::shapes::Shape;
use crate::urdf::Robot;
use nalgebra::Vector3;

/// Up to three boxes, a centimetre apart at the start.
pub fn stack(draw: &mut Draw, mut scene: Scene) -> Scene {
    let (count, edge) = (2 + draw.index(2), draw.range(0.05, 0.3));
    for index in 0..count {
        let mut cube = Robot::new(&format!("b{index}"));
        cube.solid("b", draw.range(0.5, 2.0), Shape::Box { size: Vector3::repeat(edge) });
        let height = 0.5 * edge + index as f64 * (edge + 0.01);
        scene.robot(&cube, &Start::floating(Vector3::new(0.0, 0.0, height)), true);
        let right = edge * (0.5 + index as f64);
        scene.answers.push(Answer::Place { link: format!("b{index}/b"), axis: 2, right, bound: 1e-5 });
    }
    let (floor, below) = match draw.index(2) {
        0 => (Shape::HalfSpace, 0.0),
        _ => (Shape::Box { size: Vector3::new(3.0, 3.0, 0.1) }, 0.05),
    };
    scene.obstacle(floor, Vector3::new(0.0, 0.0, -below), Vector3::zeros());
    let restitution = draw.pick(&[0.0, 0.2, 0.4]);
    scene.contacts(true, 0.5, restitution);
    scene.duration = 1.2;
    scene
}
