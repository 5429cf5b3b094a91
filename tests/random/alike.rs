//! Scenes that are one: turned about the vertical and moved aside, scaled, and with their bodies in another order.
//!
//! ```text
//!     scaled:  lengths L, times √L, speeds √L, masses M           the same motion under the same gravity
//!     wrong:   two runs that say that they keep to the tolerance τ, and are farther apart than τ + 10 (ε₁ + ε₂)        ε: the errors that they tell
//! ```
//!
//! No reference is needed, and thresholds of a length or time of their own show. Bodies fall on a floor, a slope, a table, stairs, or into a corner.

use crate::draw::Draw;
use crate::folder;
use catena::prelude::{Model, Simulation};
use nalgebra::{Rotation3, Vector3};
use std::fmt::Write as _;

/// A shape at a place, turned by yaw after pitch after roll (rad).
struct Thing {
    shape: Shape,
    place: Vector3<f64>,
    turn: [f64; 3],
    /// Mass (kg) and velocities of a body.
    moves: Option<(f64, [Vector3<f64>; 2])>,
}

/// Lengths in m.
enum Shape {
    HalfSpace,
    Box([f64; 3]),
    Ball(f64),
    /// `cylinder` or `capsule`, radius and length.
    Long(&'static str, f64, f64),
}

/// How a scene is written.
#[derive(Clone, Copy)]
struct Way {
    length: f64,
    mass: f64,
    yaw: f64,
    aside: [f64; 2],
    backwards: bool,
}

const WAYS: [(&str, Way); 4] = [
    ("as it is", Way { length: 1.0, mass: 1.0, yaw: 0.0, aside: [0.0; 2], backwards: false }),
    ("scaled", Way { length: 0.01, mass: 1e-3, yaw: 0.0, aside: [0.0; 2], backwards: false }),
    ("turned", Way { length: 1.0, mass: 1.0, yaw: 0.7, aside: [0.3, -2.0], backwards: false }),
    ("in another order", Way { length: 1.0, mass: 1.0, yaw: 0.0, aside: [0.0; 2], backwards: true }),
];

impl Way {
    fn place(&self, place: &Vector3<f64>) -> Vector3<f64> {
        let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), self.yaw) * place;
        (turned + Vector3::new(self.aside[0], self.aside[1], 0.0)) * self.length
    }

    fn back(&self, place: &Vector3<f64>) -> Vector3<f64> {
        let near = place / self.length - Vector3::new(self.aside[0], self.aside[1], 0.0);
        Rotation3::from_axis_angle(&Vector3::z_axis(), -self.yaw) * near
    }
}

/// The obstacles and bodies of a seed, with friction and restitution.
fn things(seed: u64) -> (Vec<Thing>, [f64; 2]) {
    let mut draw = Draw::new(seed);
    let friction = draw.pick(&[0.0, 0.2, 0.5, 0.8]);
    let restitution = draw.pick(&[0.0, 0.0, 0.3, 0.6]);
    let floor = || Thing { shape: Shape::HalfSpace, place: Vector3::zeros(), turn: [0.0; 3], moves: None };
    let plate = |sizes: [f64; 3], place: [f64; 3], turn: [f64; 3]| Thing {
        shape: Shape::Box(sizes),
        place: place.into(),
        turn,
        moves: None,
    };
    let ground = draw.index(5);
    let mut all = match ground {
        0 => vec![floor()],
        1 => vec![plate([4.0, 4.0, 0.2], [0.0, 0.0, -0.1], [0.0, draw.range(0.1, 0.5), draw.range(-1.0, 1.0)])],
        2 => {
            let sizes = [draw.range(0.5, 1.0), draw.range(0.5, 1.0), 0.1];
            vec![plate(sizes, [0.0, 0.0, 0.5], [0.0, 0.0, draw.range(-1.0, 1.0)]), floor()]
        }
        3 => (0..5).map(f64::from).map(|k| plate([0.3, 1.0, 0.2], [0.3 * k, 0.0, -0.12 * k - 0.1], [0.0; 3])).collect(),
        _ => vec![
            floor(),
            plate([0.1, 2.0, 0.5], [0.5, 0.0, 0.25], [0.0, 0.0, draw.range(-0.2, 0.2)]),
            plate([2.0, 0.1, 0.5], [0.0, 0.5, 0.25], [0.0, 0.0, draw.range(-0.2, 0.2)]),
        ],
    };
    for number in 0..draw.pick(&[1, 1, 2, 2, 3]) {
        let radius = draw.range(0.05, 0.12);
        let shape = match draw.index(5) {
            0 => Shape::Ball(radius),
            1 => Shape::Long("cylinder", radius, draw.range(0.1, 0.3)),
            2 => Shape::Long("capsule", radius, draw.range(0.1, 0.3)),
            _ => Shape::Box([(); 3].map(|()| draw.range(0.08, 0.3))),
        };
        let height = if ground == 0 { 0.2 } else { 0.75 } + 0.35 * f64::from(number);
        let tilt = if draw.coin(0.6) { [draw.range(-0.5, 0.5), draw.range(-0.5, 0.5)] } else { [0.0; 2] };
        let place = Vector3::new(draw.range(-0.15, 0.15), draw.range(-0.15, 0.15), height);
        let spin = if draw.coin(0.5) { draw.vector(4.0) } else { Vector3::zeros() };
        let speed = Vector3::new(draw.range(-1.0, 1.0), draw.range(-1.0, 1.0), draw.range(-1.0, 0.0));
        let turn = [tilt[0], tilt[1], draw.range(-3.0, 3.0)];
        all.push(Thing { shape, place, turn, moves: Some((draw.log(0.1, 10.0), [speed, spin])) });
    }
    (all, [friction, restitution])
}

fn scene(things: &[Thing], [friction, restitution]: [f64; 2], way: &Way) -> String {
    let mut text = format!("[contact]\nfriction = {friction}\nrestitution = {restitution}\n");
    let scaled = |lengths: &[f64]| lengths.iter().map(|length| length * way.length).collect::<Vec<f64>>();
    let (speed, rate) = (way.length.sqrt(), 1.0 / way.length.sqrt());
    let numbered: Vec<(usize, &Thing)> = things.iter().enumerate().collect();
    let all: Vec<_> = if way.backwards { numbered.into_iter().rev().collect() } else { numbered };
    for (number, thing) in all {
        let shape = match &thing.shape {
            Shape::HalfSpace => "type = \"half_space\"".to_string(),
            Shape::Box(sizes) => format!("type = \"box\", size = {:?}", scaled(sizes)),
            Shape::Ball(radius) => format!("type = \"sphere\", radius = {}", radius * way.length),
            Shape::Long(name, radius, length) => {
                format!("type = \"{name}\", radius = {}, length = {}", radius * way.length, length * way.length)
            }
        };
        let table = if thing.moves.is_some() { "body" } else { "obstacle" };
        let place = way.place(&thing.place);
        let turn = [thing.turn[0], thing.turn[1], thing.turn[2] + way.yaw];
        // Writing into a String cannot fail.
        let _ = write!(
            text,
            "[[{table}]]\nname = \"t{number}\"\nshape = {{ {shape} }}\npose = {{ position = {:?}, rpy = {turn:?} }}\n",
            place.as_slice()
        );
        if let Some((mass, velocities)) = &thing.moves {
            let turned = Rotation3::from_axis_angle(&Vector3::z_axis(), way.yaw);
            let [linear, angular] = [turned * velocities[0] * speed, turned * velocities[1] * rate];
            let _ = write!(
                text,
                "mass = {}\nvelocity = {{ linear = {:?}, angular = {:?} }}\n",
                mass * way.mass,
                linear.as_slice(),
                angular.as_slice()
            );
        }
    }
    text
}

/// What is wrong with a seed at a tolerance (m); nothing if its runs agree.
pub fn differs(seed: u64, tolerance: f64) -> Option<String> {
    let (things, law) = things(seed);
    let folder = folder("alike", seed);
    std::fs::create_dir_all(&folder).expect("a folder");
    let mut first: Option<(Vec<Vector3<f64>>, f64, bool)> = None;
    let mut wrong = None;
    for (name, way) in &WAYS {
        let file = folder.join("alike.toml");
        std::fs::write(&file, scene(&things, law, way)).expect("a scene");
        let model = Model::load(&file).unwrap_or_else(|error| panic!("{seed} {name}: {error}"));
        let time = 0.8 * way.length.sqrt();
        let mut run = Simulation::new(&model).tolerance(tolerance * way.length).duration(time);
        run.run().unwrap_or_else(|error| panic!("{seed} {name}: {error}"));
        let end = run.finish().expect("a report");
        let mut links: Vec<_> = end.links.iter().collect();
        links.sort_by(|(one, _), (other, _)| one.cmp(other));
        let places: Vec<Vector3<f64>> = links.iter().map(|(_, link)| way.back(&link.position.into())).collect();
        let accuracy = end.accuracy.expect("an accuracy");
        let (told, reached) = (accuracy.estimated / way.length, accuracy.reached);
        let Some((others, before, kept)) = &first else {
            first = Some((places, told, reached));
            continue;
        };
        let apart = places.iter().zip(others).map(|(one, other)| (one - other).norm()).fold(0.0, f64::max);
        if *kept && reached && apart > tolerance + 10.0 * (before + told) {
            wrong = Some(format!("{name}: {apart:.1e} m apart, {before:.1e} and {told:.1e} told"));
        }
    }
    let _ = std::fs::remove_dir_all(&folder);
    wrong
}
