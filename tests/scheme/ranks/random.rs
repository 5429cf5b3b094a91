//! Random over-constrained mechanisms: trees of one to six links with loops that are closed where they are made, and mimic relations.
//!
//! The truth is the singular values of the matrix of gap rates, a column for every freedom moved alone: nothing of the way in which the program
//! counts. Lengths are between 0.1 and 1 m, so that the matrix needs no scaling.

use crate::common::Numbers;
use catena::mechanism::description::closure::{Attachment, Coordinate, LoopJoint, LoopKind, Mimic};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::gaps::loop_gaps;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use nalgebra::{DMatrix, Rotation3, Translation3, UnitQuaternion, Vector3};

fn vector(numbers: &mut Numbers, size: f64) -> Vector3<f64> {
    let mut next = || numbers.next(-size, size);
    Vector3::new(next(), next(), next())
}

fn pose(numbers: &mut Numbers, size: f64) -> Pose {
    Pose::from_parts(Translation3::from(vector(numbers, size)), Rotation3::new(vector(numbers, 2.0)))
}

fn choice(numbers: &mut Numbers, count: usize) -> usize {
    (numbers.next(0.0, count as f64) as usize).min(count - 1)
}

/// A tree in a random state.
fn tree(numbers: &mut Numbers) -> (Mechanism, State) {
    let count = 1 + choice(numbers, 6);
    let mut bodies: Vec<Body> = Vec::new();
    let mut branch: Vec<usize> = Vec::new();
    for index in 0..count {
        let kind = match choice(numbers, 10) {
            0..=4 => JointKind::Revolute,
            5..=6 => JointKind::Prismatic,
            _ => JointKind::Spherical,
        };
        // Depth first: the parent is on the branch of the body before.
        branch.truncate(choice(numbers, branch.len() + 1).max(usize::from(numbers.next(0.0, 1.0) < 0.8)));
        let joint = Joint::new(&format!("joint{index}"), kind, pose(numbers, 0.5), pose(numbers, 0.3));
        let mass = numbers.next(-1.0, 1.0).exp();
        let inertia = Vector3::new(numbers.next(0.05, 0.09), numbers.next(0.05, 0.09), numbers.next(0.05, 0.09)) * mass;
        bodies.push(Body { name: format!("link{index}"), parent: branch.last().copied(), mass, inertia, joint });
        branch.push(index);
    }
    let mechanism = Mechanism::new("random", Vector3::new(0.0, 0.0, -9.81), bodies).expect("a tree");
    let mut state = State::zero(&mechanism);
    for body in &mechanism.bodies {
        let range = body.joint.position_range();
        match body.joint.kind {
            JointKind::Spherical => {
                let turn = UnitQuaternion::from_scaled_axis(vector(numbers, 1.5));
                state.position[range].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
            }
            JointKind::Prismatic => state.position[range.start] = numbers.next(-0.3, 0.3),
            _ => state.position[range.start] = numbers.next(-1.5, 1.5),
        }
    }
    state.velocity.iter_mut().for_each(|rate| *rate = numbers.next(-1.0, 1.0));
    (mechanism, state)
}

/// A loop between two different bodies, or a body and the world, that is closed in this state.
fn closed_loop(numbers: &mut Numbers, mechanism: &Mechanism, state: &State, index: usize) -> Option<LoopJoint> {
    let bodies = body_states(mechanism, state);
    let first = choice(numbers, bodies.len());
    let second = choice(numbers, bodies.len() + 1).checked_sub(1);
    if second == Some(first) {
        return None;
    }
    let place = bodies[first].position + vector(numbers, 0.4);
    let axes = Rotation3::new(vector(numbers, 2.0));
    let apart = axes * vector(numbers, 0.3);
    let along = |axis: usize| axes * Vector3::ith(axis, 1.0) * (axes.inverse() * apart)[axis];
    let turn = numbers.next(0.0, 6.0);
    let about = |axis: Vector3<f64>, angle: f64| axes * Rotation3::new(axis * angle);
    let (kind, place_b, axes_b) = match choice(numbers, 8) {
        0 => (LoopKind::Fixed, place, axes),
        1 => (LoopKind::Revolute, place, about(Vector3::z(), turn)),
        2 => (LoopKind::Prismatic, place + along(2), axes),
        3 => (LoopKind::Cylindrical, place + along(2), about(Vector3::z(), turn)),
        4 => (
            LoopKind::Universal,
            place,
            about(Vector3::z(), turn) * Rotation3::new(Vector3::x() * std::f64::consts::FRAC_PI_2),
        ),
        5 => (LoopKind::Spherical, place, Rotation3::new(vector(numbers, 2.0))),
        6 => (LoopKind::Planar, place + along(0) + along(1), about(Vector3::z(), turn)),
        _ => (LoopKind::Distance(apart.norm()), place + apart, axes),
    };
    let end = |body: Option<usize>, place: Vector3<f64>, axes: Rotation3<f64>| {
        let world = Pose::from_parts(Translation3::from(place), axes);
        let frame = body.map_or(world, |body| {
            let turn = Rotation3::from_matrix_unchecked(bodies[body].rotation);
            Pose::from_parts(Translation3::from(bodies[body].position), turn).inv_mul(&world)
        });
        Attachment { body, frame }
    };
    let name = format!("loop{index}");
    Some(LoopJoint { name, kind, a: end(Some(first), place, axes), b: end(second, place_b, axes_b) })
}

/// A mechanism with one to four loops and up to two mimic relations, closed in its state.
pub fn mechanism(seed: u64) -> (Mechanism, State) {
    let mut numbers = Numbers::new(seed + 1);
    let (mut mechanism, state) = tree(&mut numbers);
    let count = 1 + choice(&mut numbers, 4);
    while mechanism.loops.len() < count {
        let index = mechanism.loops.len();
        mechanism.loops.extend(closed_loop(&mut numbers, &mechanism, &state, index));
    }
    let scalar: Vec<usize> =
        (0..mechanism.bodies.len()).filter(|&body| mechanism.bodies[body].joint.kind.velocity_count() == 1).collect();
    for _ in 0..choice(&mut numbers, 3) {
        if scalar.len() < 2 {
            break;
        }
        let [follower, leader] = [0, 1].map(|_| {
            let body = scalar[choice(&mut numbers, scalar.len())];
            let joint = &mechanism.bodies[body].joint;
            Coordinate { body, position: joint.position_index, freedom: joint.velocity_index }
        });
        let multiplier = (numbers.next(-2.0, 2.0) * 1e3).round() / 1e3;
        if follower.body != leader.body {
            let offset = state.position[follower.position] - multiplier * state.position[leader.position];
            let name = mechanism.bodies[follower.body].joint.name.clone();
            mechanism.mimics.push(Mimic {
                name,
                follower,
                leader,
                multiplier,
                offset,
                more: Vec::new(),
                over_time: None,
            });
        }
    }
    (mechanism, state)
}

/// The rates of all gaps for every freedom alone.
pub fn gradient(mechanism: &Mechanism, state: &State) -> DMatrix<f64> {
    let columns: Vec<Vec<f64>> = (0..mechanism.velocity_count)
        .map(|freedom| {
            let mut moved = state.clone();
            moved.velocity.fill(0.0);
            moved.velocity[freedom] = 1.0;
            let bodies = body_states(mechanism, &moved);
            let mut rates = Vec::new();
            for joint in &mechanism.loops {
                let gaps = loop_gaps(joint, &bodies);
                rates.extend(&gaps.velocity[..gaps.count]);
            }
            let rate = |mimic: &Mimic| {
                moved.velocity[mimic.follower.freedom] - mimic.multiplier * moved.velocity[mimic.leader.freedom]
            };
            rates.extend(mechanism.mimics.iter().map(rate));
            rates
        })
        .collect();
    DMatrix::from_fn(columns[0].len(), columns.len(), |row, column| columns[column][row])
}

/// The number of singular values that are not rounding; `None` where that is not clear.
pub fn rank(gradient: &DMatrix<f64>) -> Option<usize> {
    let values = gradient.singular_values();
    let largest = values.max();
    let clear = values.iter().all(|&value| value > 1e-8 * largest || value < 1e-13 * largest);
    clear.then(|| values.iter().filter(|&&value| value > 1e-8 * largest).count())
}

/// All orders of the loops, or six of them.
pub fn orders(count: usize) -> Vec<Vec<usize>> {
    let forward: Vec<usize> = (0..count).collect();
    let backward: Vec<usize> = forward.iter().rev().copied().collect();
    let mut all: Vec<Vec<usize>> = Vec::new();
    for order in [forward, backward] {
        for shift in 0..count {
            let mut order = order.clone();
            order.rotate_left(shift);
            if !all.contains(&order) {
                all.push(order);
            }
        }
    }
    all
}

/// A mechanism with its loops in another order.
pub fn reordered(mechanism: &Mechanism, order: &[usize]) -> Mechanism {
    let loops = order.iter().map(|&index| mechanism.loops[index].clone()).collect();
    Mechanism { loops, ..mechanism.clone() }
}
