//! Boxes over the edge of a table: one slides off and tips, one turns as it lies flat over it.

use crate::draw::Draw;
use crate::scene::{Answer, Scene, Start};
use crate::shapes::Shape;
use crate::tipping::OverEdge;
use crate::turning::OnTable;
use crate::urdf::Robot;
use nalgebra::Vector3;

/// A box slides over the edge of a table and begins to tip. It ends while it slides over the edge.
pub fn over_an_edge(draw: &mut Draw, mut scene: Scene) -> Scene {
    let size = [draw.range(0.15, 0.3), draw.range(0.1, 0.2), draw.range(0.05, 0.15)];
    let over = OverEdge { size, friction: draw.range(0.05, 0.2), speed: draw.range(1.0, 2.0), from: -0.2 };
    let mut body = Robot::new("box");
    body.solid("box", draw.range(0.3, 30.0), Shape::Box { size: Vector3::from(size) });
    let start = Start::floating(Vector3::new(over.from, 0.0, 0.5 * size[2]));
    scene.robot(&body, &Start { linear: Vector3::new(over.speed, 0.0, 0.0), ..start }, false);
    let thick = draw.range(0.03, 0.5);
    let table = Shape::Box { size: Vector3::new(1.0, 1.0, thick) };
    scene.obstacle(table, Vector3::new(-0.5, 0.0, -0.5 * thick), Vector3::zeros());
    scene.contacts(false, over.friction, 0.0);
    scene.duration = over.tips() + over.rest();
    // Contacts that part late leave 1e-6 m; a run at 1e-6 m is a tenth of that off.
    for (axis, right) in [0, 2].into_iter().zip(over.place()) {
        scene.answers.push(Answer::Place { link: "box".to_string(), axis, right, bound: 2e-7 });
    }
    scene.is_calm = true;
    scene
}

/// A box that lies flat over the edge of a table turns until it has half its spin.
pub fn turns_over_an_edge(draw: &mut Draw, mut scene: Scene) -> Scene {
    let size = [draw.range(0.2, 0.4), draw.range(0.1, 0.2), draw.range(0.02, 0.06)];
    let on = OnTable { size, friction: draw.range(0.1, 0.3) };
    let begins = [
        -draw.range(0.1, 0.3) * size[1],
        0.0,
        draw.range(-3.0, 3.0),
        draw.range(-0.2, 0.0),
        draw.range(-0.1, 0.1),
        draw.range(4.0, 10.0),
    ];
    let [x, y, angle, vx, vy, spin] = begins;
    let mut body = Robot::new("box");
    body.solid("box", draw.range(0.3, 30.0), Shape::Box { size: Vector3::from(size) });
    let start = Start {
        rpy: Vector3::z() * angle,
        linear: Vector3::new(vx, vy, 0.0),
        angular: Vector3::z() * spin,
        ..Start::floating(Vector3::new(x, y, 0.5 * size[2]))
    };
    scene.robot(&body, &start, false);
    let thick = draw.range(0.03, 0.5);
    let table = Shape::Box { size: Vector3::new(1.0, 1.0, thick) };
    scene.obstacle(table, Vector3::new(-0.5, 0.0, -0.5 * thick), Vector3::zeros());
    scene.contacts(false, on.friction, 0.0);
    while on.after(begins, scene.duration)[5] > 0.5 * spin {
        scene.duration += 0.02;
    }
    let ends = on.after(begins, scene.duration);
    // Pressures that are shared otherwise inside steps leave 1e-5 to 1e-3 m; a run at 1e-6 m is far less off.
    for axis in [0, 1] {
        scene.answers.push(Answer::Place { link: "box".to_string(), axis, right: ends[axis], bound: 2e-7 });
    }
    scene.is_calm = true;
    scene
}
