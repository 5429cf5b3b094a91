//! Steps with closed contacts against the scheme word for word.

use super::*;
use crate::literal::scheme::{Literal, LiteralStep};
use crate::models::{self, Model};
use catena::instant::start::assembly::assemble;
use catena::kernels::step_for;
use catena::lobatto::numbers::lanes::Isa;
use catena::lobatto::stages::attempt::{Attempt, Guess, StopRule};
use catena::lobatto::tableau::butcher::Tableau;
use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::description::closure::{LoopJoint, LoopKind};
use catena::mechanism::description::contact::LEVEL;

/// All vector types; a processor that has not got one takes the next.
const VECTORS: [Isa; 3] = [Isa::Portable, Isa::Avx2, Isa::Avx512];

/// Features, their side, and the place and turn of the second in the frame of the first where they nearly touch.
type Pair = ([Feature; 2], f64, Vector3<f64>, Vector3<f64>);

/// All pairs of features.
fn pairs() -> [Pair; 14] {
    let (point, line) = (Feature::Point { radius: 0.13 }, Feature::Line { radius: 0.07 });
    let (edge, rim) = (Feature::Line { radius: 0.0 }, Feature::Rim { radius: 0.3 });
    let (turn, other) = (Vector3::new(0.9, 0.1, 0.3), Feature::Rim { radius: 0.5 });
    [
        ([Feature::Point { radius: 0.21 }, point], 1.0, Vector3::new(0.1, 0.2, 0.25), turn),
        ([Feature::Plane, point], 1.0, Vector3::new(0.1, 0.2, 0.13), turn),
        ([line, point], 1.0, Vector3::new(0.1, 0.17, 0.3), turn),
        ([line, Feature::Line { radius: 0.11 }], 1.0, Vector3::new(0.17, 0.0, 0.1), turn),
        ([Feature::Plane, rim], 1.0, Vector3::new(0.1, 0.2, 0.23), turn),
        ([edge, rim], 1.0, Vector3::new(0.3, 0.0, 0.1), Vector3::new(0.3, 0.2, 0.0)),
        ([rim, edge], 1.0, Vector3::new(0.0, 0.3, 0.0), Vector3::new(1.4, 0.0, 0.3)),
        ([rim, point], 1.0, Vector3::new(0.38, 0.1, 0.08), turn),
        // A round line beside a rim, and one that lies across it, at the place where it goes outwards.
        ([rim, Feature::Line { radius: 0.25 }], 0.0, Vector3::new(0.5, 0.15, 0.2), Vector3::new(1.2, 0.3, 0.2)),
        ([rim, line], 1.0, Vector3::new(0.1, 0.2, 0.13), Vector3::new(1.7, 0.0, 0.2)),
        // A rim that goes down through the plane of another, and two nearly in one plane.
        ([rim, other], 1.0, Vector3::new(0.44, 0.08, 0.0), Vector3::new(1.3, 0.0, 0.3)),
        ([rim, other], LEVEL, Vector3::new(0.4, 0.1, 0.0), Vector3::new(0.02, 0.0, 0.3)),
        ([Feature::Hollow { radius: 0.3 }, Feature::Point { radius: 0.0 }], 1.0, Vector3::new(0.1, 0.2, 0.2), turn),
        ([Feature::Plane, Feature::Ellipsoid { radii: [0.2, 0.3, 0.12] }], 1.0, Vector3::new(0.1, 0.2, 0.19), turn),
    ]
}

/// Puts a state onto its contacts and loops, and sees that it is there.
fn assembled(name: &str, mechanism: Mechanism, mut state: State) -> Model {
    assemble(&mechanism, &mut state).unwrap_or_else(|error| panic!("{name}: {error}"));
    let worst = violation(&mechanism, &state, &body_states(&mechanism, &state));
    assert!(worst.position < 1e-14 && worst.velocity < 1e-13, "{name}: {worst:?}");
    Model { mechanism, state }
}

/// States after each of some steps of the fast kernel.
fn fast(model: &Model, stages: usize, step: f64, count: usize, isa: Isa) -> Vec<State> {
    let Model { mechanism, state } = model;
    let mut kernel = step_for(mechanism, Tableau::of(stages).unwrap(), isa, &[]);
    let mut state = state.clone();
    let mut states = Vec::new();
    for _ in 0..count {
        kernel.begin(mechanism, &state);
        let attempt = kernel.attempt(mechanism, step, &StopRule::ROUNDING, Guess::Plain);
        assert!(matches!(attempt, Attempt::Converged { .. }), "{} s={stages}: {attempt:?}", mechanism.name);
        kernel.finish(mechanism, &mut state);
        states.push(state.clone());
    }
    states
}

/// The same of the literal scheme.
fn literal(model: &Model, stages: usize, step: f64, count: usize) -> Vec<LiteralStep> {
    let literal = Literal::new(&model.mechanism, Tableau::of(stages).unwrap()).unwrap();
    let mut bodies: Vec<BodyState> = model.bodies();
    let next = |_| {
        let made = literal
            .step(&bodies, step)
            .unwrap_or_else(|error| panic!("{} s={stages}: {error:?}", model.mechanism.name));
        bodies.clone_from(&made.bodies);
        made
    };
    (0..count).map(next).collect()
}

/// Asserts that the fast kernel makes the steps of the literal scheme.
fn assert_literal(name: &str, model: &Model, stages: usize, step: f64, count: usize) {
    let exact = literal(model, stages, step, count);
    for isa in VECTORS {
        for (number, (state, literal)) in fast(model, stages, step, count, isa).iter().zip(&exact).enumerate() {
            let bodies = body_states(&model.mechanism, state);
            let position = models::pose_distance(&bodies, &literal.bodies);
            let velocity = models::velocity_distance(&bodies, &literal.bodies);
            println!(
                "{name}, s={stages}, {isa:?}, step {number}: {position:.1e} {velocity:.1e}, {} iterations",
                literal.iterations
            );
            assert!(position < 1e-12, "{name}, s={stages}, {isa:?}, step {number}: poses differ by {position:.1e}");
            assert!(
                velocity < 1e-11,
                "{name}, s={stages}, {isa:?}, step {number}: velocities differ by {velocity:.1e}"
            );
        }
    }
}

/// Two free bodies, the first of which may be left out, with a contact of a pair of features on parts of them that are aligned with nothing.
fn of_pair(pair: usize, grip: Grip, on_world: bool, surfaces: [Vector3<f64>; 2]) -> Model {
    let (features, side, apart, turn) = pairs()[pair];
    let gravity = Vector3::new(0.4, -0.3, -9.81);
    let shapes = [(2.0, Vector3::new(0.05, 0.06, 0.08)), (1.0, Vector3::new(0.02, 0.03, 0.025))];
    let mut mechanism = free(gravity, if on_world { &shapes[1..] } else { &shapes });
    let b = feature(Some(mechanism.bodies.len() - 1), Vector3::new(0.05, -0.03, 0.02), Vector3::new(0.2, -0.1, 0.3));
    let base = Pose::from_parts(Translation3::new(0.1, -0.2, 0.3), Rotation3::new(Vector3::new(0.1, 0.2, -0.3)));
    let a =
        feature(if on_world { None } else { Some(0) }, Vector3::new(0.02, 0.05, -0.04), Vector3::new(-0.1, 0.3, 0.2));
    let mut state = State::zero(&mechanism);
    let of = |pose: &Pose| (pose.translation.vector, pose.rotation.scaled_axis());
    if !on_world {
        let (place, turned) = of(&base);
        set(&mut state, 0, place.into(), turned, [0.3, -0.2, 0.1], [0.5, -0.7, 0.4]);
    }
    let under = if on_world { a.frame } else { base * a.frame };
    let second = under * Pose::from_parts(Translation3::from(apart), Rotation3::new(turn)) * b.frame.inverse();
    let (place, turned) = of(&second);
    set(&mut state, mechanism.bodies.len() - 1, place.into(), turned, [-0.8, 1.1, 0.6], [1.5, 2.0, -1.2]);
    let mut joint = touch(features, grip, a, b);
    (joint.touch.side, joint.surfaces) = (side, surfaces);
    mechanism.touches.push(joint);
    assembled(&format!("pair {pair}"), mechanism, state)
}

/// Steps of every pair of features that slides, rubs or rolls, on the world or on a body, with the numbers of stages that are asked for each pair.
fn every_pair_is_literal(stages_of: impl Fn(usize) -> Vec<usize>) {
    for pair in 0..pairs().len() {
        for (kind, grip) in [("slides", slides(0.0)), ("rubs", slides(0.4)), ("rolls", Grip::Rolls)] {
            for on_world in [true, false] {
                let model = of_pair(pair, grip, on_world, [Vector3::zeros(); 2]);
                for stages in stages_of(pair) {
                    assert_literal(&format!("pair {pair} {kind} {on_world}"), &model, stages, 0.02, 3);
                }
            }
        }
    }
}

/// The literal scheme solves dense equations of all stages, at a cost of their number cubed: each pair has few stages and one larger number.
#[test]
fn every_pair_of_features_makes_the_steps_of_the_literal_scheme() {
    every_pair_is_literal(|pair| vec![2, 3, 4 + pair % 4]);
}

/// `cargo test --release --test scheme every_number_of_stages -- --ignored`
#[test]
#[ignore = "a minute"]
fn every_pair_of_features_makes_the_steps_of_the_literal_scheme_with_every_number_of_stages() {
    every_pair_is_literal(|_| (2..=9).collect());
}

#[test]
fn surfaces_that_move_over_their_bodies_make_the_steps_of_the_literal_scheme() {
    // Along and across their planes, of the size of the velocities of the bodies.
    let surfaces = [Vector3::new(0.7, -0.5, 0.3), Vector3::new(-0.4, 0.6, 0.9)];
    for pair in 0..pairs().len() {
        for (kind, grip) in [("rubs", slides(0.4)), ("rolls", Grip::Rolls)] {
            for on_world in [true, false] {
                let model = of_pair(pair, grip, on_world, surfaces);
                for stages in [2, 3, [5, 4, 8, 6][pair % 4]] {
                    assert_literal(&format!("belts of pair {pair} {kind} {on_world}"), &model, stages, 0.02, 3);
                }
            }
        }
    }
}

/// A contact of a point of a body with a tilted plane of the world, which goes through where the point is.
fn under(model: &Model, body: usize, place: Vector3<f64>, grip: Grip) -> TouchJoint {
    let state = model.bodies()[body];
    let floor = feature(None, state.position + state.rotation * place, Vector3::new(0.2, -0.1, 0.0));
    let point = feature(Some(body), place, Vector3::zeros());
    touch([Feature::Plane, Feature::Point { radius: 0.0 }], grip, floor, point)
}

/// A point of a body that is held where it is in the world: what a corner that sticks is.
fn held(model: &Model, body: usize, place: Vector3<f64>) -> LoopJoint {
    let state = model.bodies()[body];
    let a = feature(None, state.position + state.rotation * place, Vector3::zeros());
    let b = feature(Some(body), place, Vector3::zeros());
    LoopJoint { name: "held".to_string(), kind: LoopKind::Spherical, a, b }
}

/// A rod between points of two bodies.
fn rod(model: &Model, [a, b]: [usize; 2], places: [Vector3<f64>; 2]) -> LoopJoint {
    let [a, b] = [(a, places[0]), (b, places[1])].map(|(body, place)| feature(Some(body), place, Vector3::zeros()));
    let [from, to] = [a, b].map(|end| end.point(&model.bodies()).0);
    LoopJoint { name: "rod".to_string(), kind: LoopKind::Distance((to - from).norm()), a, b }
}

#[test]
fn contacts_beside_joints_and_loops_make_the_steps_of_the_literal_scheme() {
    // Floating base with a slider that carries a hand, a club on a ball joint, and a leg on a hinge.
    let tree = models::floating_tree();
    let (leg, club, hand) =
        (Vector3::new(0.02, 0.03, -0.25), Vector3::new(0.03, -0.2, 0.05), Vector3::new(0.12, 0.02, 0.0));
    let sliding = || vec![under(&tree, 4, leg, slides(0.5)), under(&tree, 3, club, slides(0.2))];
    let held_and_rolling = || vec![under(&tree, 3, club, Grip::Rolls)];
    let between = || {
        // The hand slides on the side of the base, which is a plane of it that goes through a point of the hand.
        let bodies = tree.bodies();
        let touches = bodies[2].position + bodies[2].rotation * hand;
        let local = bodies[0].rotation.transpose() * (touches - bodies[0].position);
        let a = feature(Some(0), local, Vector3::new(0.3, 0.8, 0.0));
        let b = feature(Some(2), hand, Vector3::zeros());
        vec![
            touch([Feature::Plane, Feature::Point { radius: 0.0 }], slides(0.3), a, b),
            under(&tree, 4, leg, slides(0.4)),
        ]
    };
    let rod = rod(&tree, [2, 3], [hand, Vector3::new(0.0, 0.1, 0.0)]);
    for (name, touches, loops) in [
        ("two slide", sliding(), vec![]),
        ("two slide beside a rod", sliding(), vec![rod.clone()]),
        ("one rolls, one is held", held_and_rolling(), vec![held(&tree, 4, leg)]),
        ("body on body beside a rod", between(), vec![rod]),
    ] {
        let mut mechanism = tree.mechanism.clone();
        (mechanism.touches, mechanism.loops) = (touches, loops);
        let model = assembled(name, mechanism, tree.state.clone());
        // The dense oracle takes its time for five bodies.
        for (stages, count) in [(2, 3), (3, 3), (5, 2)] {
            assert_literal(name, &model, stages, 0.02, count);
        }
    }
}

/// A plate on a slope and another on it, on three corners each: sliding and turning, so that each corner slips in a direction of its own; or
/// starting down the slope from rest, in the direction that is given.
fn plates(starts: bool, friction: [f64; 2]) -> Model {
    let shape = Vector3::new(0.01, 0.012, 0.02);
    let gravity = Vector3::new(3.0, 0.5, -9.2);
    let direction = if starts { Vector3::new(3.0, 0.5, 0.0).normalize() } else { Vector3::zeros() };
    let mut mechanism = free(gravity, &[(2.0, shape), (1.0, shape)]);
    for (x, y) in [(0.2, 0.15), (-0.2, 0.12), (-0.02, -0.18)] {
        let [lower, upper] = friction.map(|friction| Grip::Slides { friction, direction });
        mechanism.touches.push(on_floor(0, Vector3::new(x, y, -0.05), 0.0, lower));
        let top = feature(Some(0), Vector3::new(0.0, 0.0, 0.05), Vector3::zeros());
        let corner = feature(Some(1), Vector3::new(x, y, -0.04), Vector3::zeros());
        mechanism.touches.push(touch([Feature::Plane, Feature::Point { radius: 0.0 }], upper, top, corner));
    }
    let mut state = State::zero(&mechanism);
    let turn = Vector3::new(0.0, 0.0, 0.4);
    let moving = |velocity: [f64; 3], spin: [f64; 3]| if starts { ([0.0; 3], [0.0; 3]) } else { (velocity, spin) };
    let (velocity, spin) = moving([0.8, -0.3, 0.0], [0.0, 0.0, 1.5]);
    set(&mut state, 0, [0.0, 0.0, 0.05], turn, velocity, spin);
    let (velocity, spin) = moving([-0.7, 1.0, 0.0], [0.0, 0.0, -2.0]);
    set(&mut state, 1, [0.0, 0.0, 0.14], turn, velocity, spin);
    assembled("plates", mechanism, state)
}

#[test]
fn plates_on_three_corners_make_the_steps_of_the_literal_scheme() {
    for (name, starts) in [("slide", false), ("start to slide", true)] {
        let model = plates(starts, [0.1, 0.05]);
        for stages in 2..=9 {
            assert_literal(name, &model, stages, 0.02, 2);
        }
    }
}

#[test]
fn a_part_in_a_billion_of_friction_is_seen() {
    // The bounds of this page are worth something: friction of 1 + 1e-9 of another changes velocities by 1e-9 μ g h = 1e-11 m/s a contact and step,
    // and spins by that over a radius of gyration of a tenth of a metre.
    let [one, other] = [0.3, 0.3 * (1.0 + 1e-9)].map(|friction| plates(false, [friction, 0.2]));
    let exact = literal(&other, 5, 0.02, 1);
    let fast = fast(&one, 5, 0.02, 1, Isa::detect());
    let apart = models::velocity_distance(&body_states(&one.mechanism, &fast[0]), &exact[0].bodies);
    assert!(apart > 1e-11, "{apart:e}");
}

#[test]
fn a_loop_of_every_kind_makes_the_steps_of_the_literal_scheme() {
    for kind in [
        LoopKind::Revolute,
        LoopKind::Prismatic,
        LoopKind::Cylindrical,
        LoopKind::Universal,
        LoopKind::Spherical,
        LoopKind::Planar,
        LoopKind::Distance(0.3),
    ] {
        // A free body held to the world by the loop alone.
        let mut mechanism = free(Vector3::new(0.3, 0.2, -9.81), &[(1.5, Vector3::new(0.02, 0.03, 0.025))]);
        let a = feature(None, Vector3::new(0.1, 0.2, 0.3), Vector3::new(0.3, -0.2, 0.5));
        let b = feature(Some(0), Vector3::new(0.05, -0.1, 0.15), Vector3::new(0.1, 0.4, -0.2));
        mechanism.loops.push(LoopJoint { name: "loop".to_string(), kind, a, b });
        let mut state = State::zero(&mechanism);
        set(&mut state, 0, [0.1, 0.3, 0.2], Vector3::new(0.3, 0.1, 0.4), [0.5, -0.4, 0.3], [1.0, 2.0, -1.5]);
        let model = assembled(kind.name(), mechanism, state);
        for stages in 2..=9 {
            assert_literal(kind.name(), &model, stages, 0.02, 2);
        }
    }
}
