//! Heaps of bodies, and robots that lie on themselves.

use crate::draw::Draw;
use crate::kinds::trees::{Parts, tree};
use crate::scene::{Scene, Start};
use crate::shapes::Shape;
use crate::urdf::Robot;
use nalgebra::Vector3;
use std::f64::consts::FRAC_PI_2;

/// Two to twelve balls, boxes, capsules and polytopes that fall onto a floor, or into a bin.
pub fn heap(draw: &mut Draw, mut scene: Scene) -> Scene {
    let (count, size, in_bin) = (2 + draw.index(11), draw.log(0.05, 0.3), draw.coin(0.5));
    let friction = if draw.coin(0.15) { 0.0 } else { draw.range(0.05, 1.0) };
    let mut above = 0.0;
    for index in 0..count {
        let name = format!("b{index}");
        let mut body = Robot::new(&name);
        let shape = loop {
            match Shape::of_link(draw, &format!("{name}_b"), size) {
                // The rims of cylinders have kinds of their own.
                Shape::Cylinder { .. } => {}
                shape => break shape,
            }
        };
        let extent = shape.extent();
        body.solid("b", draw.log(0.2, 5.0), shape);
        // One above the other, a little beside each other, and nowhere nearer than the balls around them.
        let beside = draw.vector(0.3 * size);
        let position = Vector3::new(beside.x, beside.y, above + extent + 0.02);
        above = position.z + extent;
        let start = Start {
            rpy: draw.vector(1.5),
            linear: draw.vector(0.3),
            angular: draw.vector(2.0),
            ..Start::floating(position)
        };
        scene.robot(&body, &start, true);
    }
    scene.obstacle(Shape::HalfSpace, Vector3::zeros(), Vector3::zeros());
    if in_bin {
        let wide = size * draw.range(1.0, 2.0);
        for (side, turn) in [
            (Vector3::new(-wide, 0.0, 0.0), Vector3::new(0.0, FRAC_PI_2, 0.0)),
            (Vector3::new(wide, 0.0, 0.0), Vector3::new(0.0, -FRAC_PI_2, 0.0)),
            (Vector3::new(0.0, -wide, 0.0), Vector3::new(-FRAC_PI_2, 0.0, 0.0)),
            (Vector3::new(0.0, wide, 0.0), Vector3::new(FRAC_PI_2, 0.0, 0.0)),
        ] {
            scene.obstacle(Shape::HalfSpace, side, turn);
        }
    }
    let restitution = if draw.coin(0.7) { 0.0 } else { draw.range(0.05, 0.6) };
    scene.contacts(true, friction, restitution);
    scene.is_crowd = true;
    scene.duration = draw.range(0.4, 0.9);
    scene
}

/// A random tree that falls limp onto a floor and onto itself.
pub fn limp(draw: &mut Draw, scene: Scene) -> Scene {
    falls(draw, scene, 0.0)
}

/// The same with joints that follow others, as grippers have.
pub fn limp_with_followers(draw: &mut Draw, scene: Scene) -> Scene {
    falls(draw, scene, 0.4)
}

/// A random tree that falls limp, of which this part of the joints follow others.
fn falls(draw: &mut Draw, mut scene: Scene, mimic: f64) -> Scene {
    let joints = 2 + draw.index(7);
    let parts = Parts { joints, limit: 0.6, friction: 0.3, damping: 0.4, shape: 0.9, mimic, ..Parts::default() };
    let (robot, mut start, tables) = tree(draw, "r0", parts, "");
    start.floating = true;
    start.position = Vector3::new(0.0, 0.0, 0.3 + 0.3 * joints as f64);
    (start.rpy, start.linear, start.angular) = (draw.vector(1.5), draw.vector(0.5), draw.vector(1.0));
    start.linear.z = -draw.range(0.0, 4.0);
    scene.robot(&robot, &start, false);
    tables.into_iter().for_each(|table| scene.table(table));
    scene.obstacle(Shape::HalfSpace, Vector3::zeros(), Vector3::zeros());
    scene.is_crowd = true;
    let friction = if draw.coin(0.15) { 0.0 } else { draw.range(0.05, 1.0) };
    scene.contacts(false, friction, 0.0);
    scene.duration = draw.range(0.6, 1.0);
    scene
}
