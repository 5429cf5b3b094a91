//! Derivatives behind landings on corners, edges and rims that stick: the material that holds moves on its body with the sizes of the shape.

use crate::sensitivity_events::{agrees_with_runs, derivatives, difference, last, scene};
use catena::prelude::*;

const GRAVITY: f64 = 9.81;

/// A body that falls on the floor z = 0, without rebound.
fn falls(name: &str, shape: &str, start: &str, friction: f64) -> Model {
    let text = format!(
        "[[body]]\nname = \"b\"\nshape = {{ {shape} }}\nmass = 1.0\n{start}\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = {friction}\n"
    );
    Model::load(scene(&format!("{name}.toml"), &text)).expect("a model")
}

/// Sizes along x and z (m), place (x, z, β) (m, rad) and velocity of the start.
#[derive(Clone, Copy)]
struct Box2 {
    sizes: [f64; 2],
    place: [f64; 3],
    velocity: [f64; 3],
}

/// x, z, β of a box of 1 kg, and their rates, that falls on its lower edge and pivots about it: with d from the edge to the center,
///
/// ```text
///     (I + d²) ω⁺ = I ω + (d × v)_y          (I + d²) β̈ = d_x g
/// ```
fn pivots(of: Box2, time: f64) -> [[f64; 3]; 2] {
    let Box2 { sizes: [a, c], place: [x, z, angle], velocity: [u, w, spin] } = of;
    let turned = |angle: f64, [x, z]: [f64; 2]| {
        let (sine, cosine) = angle.sin_cos();
        [cosine * x + sine * z, cosine * z - sine * x]
    };
    let edges = [[0.5, 0.5], [0.5, -0.5], [-0.5, 0.5], [-0.5, -0.5]].map(|[x, z]| [x * a, z * c]);
    let height = |edge: [f64; 2], t: f64| z + w * t - 0.5 * GRAVITY * t * t + turned(angle + spin * t, edge)[1];
    let lowest = |one: &[f64; 2], other: &[f64; 2]| height(*one, 0.2).total_cmp(&height(*other, 0.2));
    let edge = edges.into_iter().min_by(lowest).expect("four edges");
    let (mut before, mut after) = (0.0, time);
    while 0.5 * (before + after) != before && 0.5 * (before + after) != after {
        let middle = 0.5 * (before + after);
        if height(edge, middle) > 0.0 { before = middle } else { after = middle }
    }
    let struck = before;
    let local = [-edge[0], -edge[1]];
    let arm = turned(angle + spin * struck, local);
    let pivot = x + u * struck - arm[0];
    let inertia = (a * a + c * c) / 12.0;
    let about = inertia + local[0] * local[0] + local[1] * local[1];
    let falling = w - GRAVITY * struck;
    let (mut angle, mut rate) = (angle + spin * struck, (inertia * spin + arm[1] * u - arm[0] * falling) / about);
    let steps = 2000;
    let step = (time - struck) / f64::from(steps);
    let bend = |angle: f64| turned(angle, local)[0] * GRAVITY / about;
    for _ in 0..steps {
        let (a1, r1) = (rate, bend(angle));
        let (a2, r2) = (rate + 0.5 * step * r1, bend(angle + 0.5 * step * a1));
        let (a3, r3) = (rate + 0.5 * step * r2, bend(angle + 0.5 * step * a2));
        let (a4, r4) = (rate + step * r3, bend(angle + step * a3));
        angle += step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
        rate += step / 6.0 * (r1 + 2.0 * r2 + 2.0 * r3 + r4);
    }
    let arm = turned(angle, local);
    [[pivot + arm[0], arm[1], angle], [rate * arm[1], -rate * arm[0], rate]]
}

#[test]
fn a_box_that_lands_on_its_edge_and_pivots_has_the_derivatives_of_its_closed_form_by_its_sizes() {
    let of = Box2 { sizes: [0.12, 0.14], place: [0.0, 0.35, -0.85], velocity: [0.86, 0.0, -0.33] };
    let shape = "type = \"box\", size = [0.12, 0.2, 0.14]";
    let start = "pose = { position = [0, 0, 0.35], rpy = [0, -0.85, 0] }\nvelocity = { linear = [0.86, 0, 0], angular = [0, -0.33, 0] }";
    let model = falls("edge", shape, start, 0.5);
    let time = 0.3;
    let run = derivatives(&model, 9, 0.02, time, &["b.shape.size.x", "b.shape.size.z", "b.pose.position.z"]);
    assert_eq!(run.events.len(), 1, "it sticks to the end: {:?}", run.events);
    for key in 0..3 {
        let at = |by: f64| {
            let mut of = of;
            if key < 2 {
                of.sizes[key] += by
            } else {
                of.place[1] += by
            }
            pivots(of, time)
        };
        for (number, freedom) in [0, 2, 4].into_iter().enumerate() {
            for (part, found) in last(&run, freedom, key).into_iter().enumerate() {
                let wanted = difference(&|by| at(by)[part][number], 1e-4);
                println!(
                    "{}, {freedom}, {part}: {found} for {wanted}, off {:e}",
                    run.keys[key],
                    (found - wanted).abs()
                );
                // Roundings of the closed form over 1e-4 m are 1e-11; nine stages over 0.02 s have less.
                assert!((found - wanted).abs() < 1e-8, "{}, {freedom}, {part}: {found} and {wanted}", run.keys[key]);
            }
        }
    }
}

#[test]
fn corners_and_rims_that_stick_have_the_derivatives_of_their_runs_by_the_sizes_of_their_shapes() {
    let tilted = "pose = { position = [0, 0, 0.3], rpy = [0.3, 0.4, 0] }";
    let box_of = "type = \"box\", size = [0.1, 0.2, 0.2]";
    let way = (9, 0.01, 0.3);
    let sizes = ["b.shape.size.x", "b.shape.size.y", "b.shape.size.z"];
    agrees_with_runs(&falls("corner", box_of, tilted, 0.9), &sizes, way, 1e-3, 1e-8);
    let cylinder = "type = \"cylinder\", radius = 0.1, length = 0.2";
    agrees_with_runs(&falls("rim", cylinder, tilted, 0.9), &["b.shape.radius", "b.shape.length"], way, 1e-3, 1e-8);
    // A corner of a box, a cylinder on the rim of another one, and a collision shape that moves on its link.
    let text = "[[body]]\nname = \"b\"\nshape = { type = \"cylinder\", radius = 0.1, length = 0.2 }\nmass = 1.0\n\
         pose = { position = [0, 0, 0.3], rpy = [0, 0.4, 0] }\n\
         [[obstacle]]\nname = \"floor\"\nshape = { type = \"cylinder\", radius = 0.1, length = 0.2 }\nfriction = 0.9\n";
    let stacked = Model::load(scene("stacked.toml", text)).expect("a model");
    let keys = ["b.shape.radius", "b.shape.length", "floor.shape.radius", "floor.shape.length"];
    agrees_with_runs(&stacked, &keys, way, 1e-3, 1e-8);
    let urdf = "<robot name='b'><link name='b'><inertial><mass value='1'/><inertia ixx='0.0067' ixy='0' ixz='0' iyy='0.0042' iyz='0' \
         izz='0.0042'/></inertial><collision><geometry><box size='0.1 0.2 0.2'/></geometry></collision></link></robot>";
    let text = format!(
        "[[robot]]\nurdf = {:?}\nbase = \"floating\"\n{tilted}\n\
         [[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\nfriction = 0.9\n",
        scene("corner.urdf", urdf)
    );
    let link = Model::load(scene("corner_of_link.toml", &text)).expect("a model");
    let keys = ["b.collision.1.size.x", "b.collision.1.origin.x", "b.collision.1.origin.pitch"];
    agrees_with_runs(&link, &keys, way, 1e-3, 1e-8);
}

#[test]
fn a_parameter_that_takes_contacts_apart_that_strike_together_is_valid_within_nothing() {
    for (name, tilt) in [("lands_on_an_edge", 0.4), ("lands_flat", 0.0)] {
        let start = format!("pose = {{ position = [0, 0, 0.3], rpy = [0, {tilt}, 0] }}");
        let model = falls(name, "type = \"box\", size = [0.1, 0.2, 0.2]", &start, 0.9);
        let keys = [
            ("b.velocity.angular.x", true),
            ("b.velocity.linear.z", false),
            ("b.velocity.linear.x", false),
            ("b.velocity.angular.z", false),
            ("b.shape.size.z", false),
            ("b.mass", false),
        ];
        let run = derivatives(&model, 9, 0.02, 0.28, &keys.map(|(key, _)| key));
        for (column, (key, apart)) in keys.into_iter().enumerate() {
            let (within, cause) = (run.valid_within[column], &run.bounded_by[column]);
            assert_eq!(within == 0.0, apart, "{name}, {key}: {within}, {cause}");
            assert!(!apart || cause.contains("strike one after the other"), "{name}, {key}: {cause}");
        }
    }
    let ball = |name: &str, x: f64| {
        format!(
            "[[body]]\nname = \"{name}\"\nshape = {{ type = \"sphere\", radius = 0.1 }}\nmass = 1.0\npose = {{ position = [{x}, 0, 0.5] }}\n"
        )
    };
    let floor = "[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\nrestitution = 0.5\n";
    let text = format!("{}{}{floor}", ball("one", 0.0), ball("other", 1.0));
    let model = Model::load(scene("two_balls.toml", &text)).expect("a model");
    let run = derivatives(&model, 9, 0.02, 0.4, &["one.pose.position.z", "other.pose.position.z", "gravity.z"]);
    assert_eq!(run.valid_within.iter().map(|within| *within == 0.0).collect::<Vec<_>>(), [true, true, false]);
}
