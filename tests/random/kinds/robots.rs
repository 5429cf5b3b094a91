//! Two robots that may touch each other and a floor.

use crate::draw::Draw;
use crate::kinds::trees::{Parts, tree};
use crate::scene::Scene;
use crate::shapes::Shape;
use nalgebra::Vector3;

/// One above the other.
pub fn two(draw: &mut Draw, mut scene: Scene) -> Scene {
    for index in 0..2 {
        let name = format!("r{index}");
        let joints = draw.index(4);
        let parts =
            Parts { joints, limit: 0.6, friction: 0.2, damping: 0.3, motor: 0.3, shape: 0.8, ..Parts::default() };
        let (robot, mut start, tables) = tree(draw, &name, parts, &format!("{name}/"));
        start.floating = index == 1 || draw.coin(0.5);
        start.position = Vector3::new(0.0, 0.0, 0.5 + 0.8 * f64::from(index));
        start.rpy = draw.vector(1.0);
        if start.floating {
            (start.linear, start.angular) = (draw.vector(0.5) - Vector3::z() * f64::from(index), draw.vector(2.0));
        }
        scene.robot(&robot, &start, true);
        tables.into_iter().for_each(|table| scene.table(table));
    }
    if draw.coin(0.6) {
        scene.obstacle(Shape::HalfSpace, Vector3::zeros(), Vector3::zeros());
    }
    let (friction, restitution) = (draw.range(0.0, 1.0), draw.restitution());
    scene.contacts(true, friction, restitution);
    scene.duration = draw.range(0.3, 0.8);
    scene
}
