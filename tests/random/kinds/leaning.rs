//! Two cards that lean on each other, edge on edge, and slide apart on a floor: mirror images, each of which moves as one that leans on a smooth wall.

use crate::draw::Draw;
use crate::scene::{Answer, Scene, Start};
use crate::shapes::Shape;
use crate::urdf::Robot;
use nalgebra::Vector3;

/// The edge between them holds: they stay steeper than its friction angle.
pub fn leaning(draw: &mut Draw, mut scene: Scene) -> Scene {
    let [thick, wide, high] = [draw.range(0.005, 0.03), draw.range(0.1, 0.8), draw.range(0.3, 0.8)];
    let (tilt, mass) = (draw.range(0.25, 0.35), draw.log(0.1, 5.0));
    let (sine, cosine) = tilt.sin_cos();
    let at = Vector3::new(0.5 * (thick * cosine + high * sine), 0.0, 0.5 * (thick * sine + high * cosine));
    let card = |name: &str, side: f64| {
        let mut card = Robot::new(name);
        card.solid("card", mass, Shape::Box { size: Vector3::new(thick, wide, high) });
        let rpy = Vector3::new(0.0, -side * tilt, 0.0);
        (card, Start { rpy, ..Start::floating(Vector3::new(side * at.x, at.y, at.z)) })
    };
    let floor = draw.range(0.02, 0.08);
    let grounds = |scene: &mut Scene| {
        scene.obstacle(Shape::HalfSpace, Vector3::zeros(), Vector3::zeros());
        scene.contacts(true, 1.0, 0.0);
        scene.table(format!("[[contact.pair]]\na = \"*\"\nb = \"o*\"\nfriction = {floor:?}"));
        scene.duration = 0.2;
    };
    let mut alone = Scene::new("leaning", 0.0);
    for (name, side) in [("right", 1.0), ("left", -1.0)] {
        let (card, start) = card(name, side);
        scene.robot(&card, &start, true);
        if side > 0.0 {
            alone.robot(&card, &start, true);
        }
        scene.answers.push(Answer::Place { link: format!("{name}/card"), axis: 1, right: 0.0, bound: 1e-6 });
    }
    grounds(&mut scene);
    alone.table("[[obstacle]]\nname = \"wall\"\nshape = { type = \"half_space\", normal = [1, 0, 0] }\nfriction = 0");
    grounds(&mut alone);
    scene.twin = Some(("alone.toml".to_string(), alone.text()));
    scene.is_calm = true;
    scene
}
