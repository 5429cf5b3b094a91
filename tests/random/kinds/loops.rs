//! Four-bar linkages in a plane: friction, limits, motors, and another joint that is held.

use crate::draw::Draw;
use crate::kinds::trees::motor;
use crate::scene::{Scene, Start};
use crate::urdf::{Joint, Robot};
use nalgebra::Vector3;

/// Joint angles (rad) about −y of crank, rocker and rod of a four-bar that closes: crank at the origin, rocker at `ground`, the rod on the crank.
fn closed(lengths: [f64; 3], ground: f64, crank: f64) -> Option<(f64, f64)> {
    let [a, b, c] = lengths;
    let tip = [a * crank.cos(), a * crank.sin()];
    let (x, z) = (ground - tip[0], -tip[1]);
    let distance = x.hypot(z);
    let cosine = (distance * distance + b * b - c * c) / (2.0 * distance * b);
    let rod = z.atan2(x) + (cosine.abs() <= 0.999).then(|| cosine.acos())?;
    let end = [tip[0] + b * rod.cos() - ground, tip[1] + b * rod.sin()];
    Some((rod, end[1].atan2(end[0])))
}

/// A four-bar; `extra` adds what hangs on its rod.
fn linkage(draw: &mut Draw, mut scene: Scene, extra: impl FnOnce(&mut Draw, &mut Robot) -> Vec<String>) -> Scene {
    let (lengths, ground, crank, angles) = loop {
        let lengths = [draw.range(0.1, 0.4), draw.range(0.2, 0.6), draw.range(0.2, 0.6)];
        let (ground, crank) = (draw.range(0.2, 0.6), draw.range(-3.0, 3.0));
        if let Some(angles) = closed(lengths, ground, crank) {
            break (lengths, ground, crank, angles);
        }
    };
    let mut robot = Robot::new("four_bar");
    robot.base("base");
    let (rod, rocker) = angles;
    let mut tables = Vec::new();
    let mut start = Start::fixed(Vector3::zeros());
    let joints = [
        ("crank", "base", "a", 0.0, lengths[0], crank),
        ("knee", "a", "b", lengths[0], lengths[1], rod - crank),
        ("rocker", "base", "c", ground, lengths[2], rocker),
    ];
    for (name, parent, link, at, length, angle) in joints {
        let mass = draw.log(0.2, 3.0);
        let inertia = Vector3::new(0.1, 1.0, 1.0) * (mass * length * length / 12.0);
        robot.link(link, mass, inertia, Vector3::new(0.5 * length, 0.0, 0.0), None);
        let (friction, damping) = (draw.log(1e-2, 1.0), draw.log(1e-3, 0.3));
        let has_limit = draw.coin(0.3);
        let limit = has_limit.then(|| (angle - draw.log(0.02, 2.0), angle + draw.log(0.02, 2.0)));
        robot.joint(&Joint {
            origin: Vector3::new(at, 0.0, 0.0),
            // Angles turn x towards z.
            axis: -Vector3::y(),
            limit,
            friction: if draw.coin(0.5) { friction } else { 0.0 },
            damping: if draw.coin(0.3) { damping } else { 0.0 },
            ..Joint::new(name, if has_limit { "revolute" } else { "continuous" }, parent, link)
        });
        start.positions.push((name.to_string(), angle));
        if has_limit {
            tables.push(format!("[[joint]]\nname = \"{name}\"\nrestitution = {:?}", draw.restitution()));
        }
    }
    start.velocities.push(("crank".to_string(), draw.range(-6.0, 6.0)));
    tables.extend(extra(draw, &mut robot));
    if draw.coin(0.4) {
        tables.push(motor(draw, "crank", crank, 1.0));
    }
    let kind = draw.pick(&["revolute", "distance", "spherical"]);
    let axis = if kind == "revolute" { ", axis = [0, 1, 0]" } else { "" };
    // Pins that coincide have no distance: that end is short of the rocker's.
    let end = if kind == "distance" { 0.7 * lengths[2] } else { lengths[2] };
    scene.robot(&robot, &start, false);
    scene.table(format!(
        "[[loop]]\nname = \"closure\"\ntype = \"{kind}\"\na = {{ link = \"b\", position = [{:?}, 0, 0]{axis} }}\n\
         b = {{ link = \"c\", position = [{end:?}, 0, 0]{axis} }}",
        lengths[1]
    ));
    tables.into_iter().for_each(|table| scene.table(table));
    scene.duration = draw.range(0.3, 0.8);
    scene
}

/// A four-bar alone.
pub fn four_bar(draw: &mut Draw, scene: Scene) -> Scene {
    linkage(draw, scene, |_, _| Vec::new())
}

/// A four-bar with a link on its rod whose joint is held, by much friction or between narrow limits.
pub fn held(draw: &mut Draw, scene: Scene) -> Scene {
    linkage(draw, scene, |draw, robot| {
        let mass = draw.log(0.1, 1.0);
        robot.link("side", mass, Vector3::repeat(0.01 * mass), draw.vector(0.1), None);
        let plain = Joint { axis: -Vector3::y(), ..Joint::new("side", "continuous", "b", "side") };
        let upper = if draw.coin(0.5) { 0.0 } else { draw.log(1e-4, 0.1) };
        if draw.coin(0.3) {
            robot.joint(&Joint { friction: 50.0, ..plain });
            return Vec::new();
        }
        // A URDF says "no limits" by two zeros.
        robot.joint(&Joint { kind: "revolute", ..plain });
        robot.limits.push(("side".to_string(), 0.0, upper));
        vec![format!("[[joint]]\nname = \"side\"\nlimit = [0.0, {upper:?}]\nrestitution = {:?}", draw.restitution())]
    })
}
