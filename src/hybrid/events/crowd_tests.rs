//! Steps of crowds against motions event by event, and the laws that each of them keeps.

use crate::crowd::trees::Trees;
use crate::events::crowd::contacts::Scene;
use crate::events::crowd::step::{Crowd, Made};
use crate::events::integrator::Eventful;
use crate::instant::dynamics::mass_matrix::mass_matrix;
use crate::instant::dynamics::response::Response;
use crate::instant::holding::elements::Elements;
use crate::instant::holding::touching::Touching;
use crate::mechanism::description::closure::{Coordinate, JointLimit};
use crate::mechanism::description::contact::{Collider, ContactPair, Shape};
use crate::mechanism::description::course::Course;
use crate::mechanism::description::forces::{JointDamper, LinkLoad};
use crate::mechanism::description::joint::{Joint, JointKind, Pose};
use crate::mechanism::description::mechanism::{Body, Mechanism};
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::integrator::Integrator;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::{State, quaternion_exponential};
use crate::stepping::length::stage_choice::StageChoice;
use crate::stepping::recipe::{Recipe, Steps};
use nalgebra::{Translation3, Vector3};

mod closed;
mod horizon;
mod interrupted;
mod rebounds;
mod sleep;

/// Numbers from −1 to 1 that are the same in every run.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// Free boxes of 1 kg with these half sizes (m) on a floor, which touch each other.
fn boxes(count: usize, half: Vector3<f64>, friction: f64, restitution: f64) -> Mechanism {
    let square = half.component_mul(&half);
    let inertia = Vector3::new(square.y + square.z, square.x + square.z, square.x + square.y) / 3.0;
    let body = |_| {
        let joint = Joint::new("box", JointKind::Floating, Pose::identity(), Pose::identity());
        Body { name: "box".into(), parent: None, mass: 1.0, inertia, joint }
    };
    let mut mechanism =
        Mechanism::new("boxes", Vector3::z() * -9.81, (0..count).map(body).collect()).expect("free bodies");
    let nonsmooth = &mut mechanism.nonsmooth;
    let collider = |body, shape| Collider::still("one", body, Pose::identity(), shape);
    nonsmooth.colliders.push(collider(None, Shape::HalfSpace));
    nonsmooth.colliders.extend((0..count).map(|body| collider(Some(body), Shape::Box { half })));
    for a in 0..=count {
        for b in a + 1..=count {
            let number = nonsmooth.pairs.len();
            nonsmooth.pairs.push(ContactPair::without_moments(number, [a, b], friction, restitution));
        }
    }
    mechanism
}

/// Puts a free body at a place (m), turned by a vector (rad).
fn put(state: &mut State, body: usize, place: [f64; 3], turn: [f64; 3]) {
    state.position[7 * body..7 * body + 3].copy_from_slice(&place);
    state.position[7 * body + 3..7 * body + 7].copy_from_slice(&quaternion_exponential(&turn));
}

/// A grid of boxes of 0.2 m, slightly turned.
fn pile(side: usize) -> (Mechanism, State) {
    let mechanism = boxes(side.pow(3), Vector3::repeat(0.1), 0.5, 0.0);
    let (mut state, mut numbers) = (State::zero(&mechanism), Numbers(12345));
    for body in 0..side.pow(3) {
        let at = |index: usize| index as f64 - 0.5 * (side as f64 - 1.0);
        let (x, y, z) = (at(body % side), at(body / side % side), (body / side / side) as f64);
        let place = [0.23 * x + 0.01 * numbers.next(), 0.23 * y + 0.01 * numbers.next(), 0.15 + 0.25 * z];
        put(&mut state, body, place, [(); 3].map(|()| 0.045 * numbers.next()));
    }
    (mechanism, state)
}

/// Steps of this length (s) to an end (s); `see` is shown each of them.
fn run(mechanism: &Mechanism, state: &mut State, step: f64, end: f64, mut see: impl FnMut(&Made, &State, &Crowd)) {
    let (elements, touching) = (Elements::new(mechanism), Touching::new(mechanism));
    let mut response = Response::new(mechanism);
    let mut crowd = Crowd::new(mechanism).expect("a tree");
    let scene = Scene { whole: mechanism, elements: &elements, touching: &touching };
    for _ in 0..(end / step).round() as usize {
        let mut forces = |at: &State, accelerations: &mut [f64], efforts: &mut [f64]| {
            response.accelerations(at, efforts, accelerations);
        };
        let made = crowd.step(scene, &mut forces, state, step, true).expect("a step");
        see(&made, state, &crowd);
    }
}

#[test]
fn friction_and_dampers_take_no_more_than_a_step_loses_and_impacts_give_nothing_back() {
    for coefficient in [0.0, 30.0] {
        let (mut mechanism, mut state) = pile(2);
        let damper = |freedom| JointDamper { freedom, coefficient };
        mechanism.forces.joint_dampers = (0..mechanism.velocity_count).map(damper).collect();
        let (mut friction, mut impacts) = (0.0, 0.0);
        run(&mechanism, &mut state, 2e-3, 1.0, |made, _, _| {
            let lost = made.lost - made.dissipated - made.friction;
            // Of some 40 J, in roundings.
            assert!(lost >= -1e-12 && made.friction >= 0.0, "{lost:e} of {:e}, {:e}", made.lost, made.friction);
            (friction, impacts) = (friction + made.friction, impacts + lost);
        });
        assert!(friction > 1e-3 && impacts > 0.1, "{coefficient}: {friction} {impacts}");
    }
}

/// Where a thrown box of 0.3 × 0.2 × 0.1 m is after 0.6 s: the run of a number, with steps of a length (s) or event by event.
fn thrown(number: usize, step: Option<f64>) -> Vector3<f64> {
    let mechanism = boxes(1, Vector3::new(0.15, 0.1, 0.05), 0.5, 0.0);
    let (mut state, mut numbers) = (State::zero(&mechanism), Numbers(1000 + 77 * number as u64));
    for _ in 0..10 {
        numbers.next();
    }
    put(&mut state, 0, [0.0, 0.0, 0.2], [(); 3].map(|()| 0.8 * numbers.next()));
    for (index, rate) in state.velocity.iter_mut().enumerate() {
        *rate = numbers.next() * if index == 2 { 0.0 } else { 1.0 };
    }
    match step {
        Some(step) => run(&mechanism, &mut state, step, 0.6, |_, _, _| {}),
        None => {
            let steps = Steps::Chosen { tolerance: 1e-7, stop: 1e-11, stages: StageChoice::Many };
            let mut eventful =
                Eventful::new(&mechanism, Recipe::new(steps, vec![Rule::Crowds])).expect("possible steps");
            while state.time < 0.6 {
                eventful.step(&mechanism, Inputs::constant(&[0.0; 6]), &mut state, 0.6).expect("a step");
            }
        }
    }
    body_states(&mechanism, &state)[0].position
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

#[test]
fn thrown_boxes_approach_their_motion_event_by_event_with_the_length_of_the_steps() {
    let exact: Vec<Vector3<f64>> = (0..24).map(|number| thrown(number, None)).collect();
    let error = |step: f64| {
        let errors = exact.iter().enumerate().map(|(number, exact)| (thrown(number, Some(step)) - exact).norm());
        median(errors.collect())
    };
    let errors = [2e-3, 1e-3, 5e-4, 2.5e-4].map(error);
    println!("{errors:?}");
    // Order 1: an eighth from 2 ms to 1/4 ms. With 24 starts the median is off by a factor of 1.6.
    let ratio = errors[0] / errors[3];
    assert!((5.0..13.0).contains(&ratio), "{errors:?}");
    // κ |Δv| h with κ = 0.3 and 1.5 m/s.
    assert!(errors[3] < 0.3 * 1.5 * 2.5e-4, "{errors:?}");
}

#[test]
fn piles_of_boxes_do_not_overlap_gain_no_energy_and_come_to_rest_without_creep() {
    for (side, end) in [(2, 1.0), (3, 1.0)] {
        let (mechanism, mut state) = pile(side);
        let mut before = f64::INFINITY;
        let mut worst = Made::default();
        run(&mechanism, &mut state, 1e-3, end, |made, state, _| {
            let energy = crate::events::effects::resting::energy(&mechanism, state).total();
            // A gap that closes to 3e-10 m lifts a box at rest by that much: 3e-9 J, which its next motion owes.
            assert!(energy <= before + 3e-9, "{energy} after {before} at {}", state.time);
            before = energy;
            worst.overlap = worst.overlap.max(made.overlap);
            worst.lifted = worst.lifted.max(made.lifted);
            worst.residual = worst.residual.max(made.residual);
            worst.unsolved += made.unsolved;
        });
        println!("{} boxes: {worst:?}", side.pow(3));
        assert!(worst.overlap <= 1e-9, "{worst:?}");
        assert!(state.velocity.iter().all(|rate| *rate == 0.0), "{:?}", state.velocity);
    }
}

#[test]
fn nearly_all_steps_of_piles_are_solved() {
    for (side, end) in [(2, 1.0), (3, 1.0), (4, 0.6)] {
        let (mechanism, mut state) = pile(side);
        let mut residuals = Vec::new();
        run(&mechanism, &mut state, 1e-3, end, |made, _, _| {
            residuals.extend((!made.asleep).then_some(made.residual));
        });
        residuals.sort_by(f64::total_cmp);
        let count = residuals.len();
        let part = |part: f64| residuals[((part * count as f64).ceil() as usize).clamp(1, count) - 1];
        let above = |bound: f64| residuals.iter().filter(|residual| **residual > bound).count();
        let parts = [0.5, 0.9, 0.99, 0.999, 1.0].map(part);
        println!("{} boxes, {count} steps: residuals {parts:?}, {} above 1e-8", side.pow(3), above(1e-8));
        // The bounds of the largest force that a law may be off by: in 999 of 1000 steps, where one step counts as none, and in all.
        assert!(above(1e-8) <= 1 + count / 1000, "{side}: {} of {count} above 1e-8", above(1e-8));
        assert!(residuals[count - 1] <= 1e-4, "{side}: {parts:?}");
    }
}

#[test]
fn the_same_start_gives_the_same_bits() {
    let ends = [(); 2].map(|()| {
        let (mechanism, mut state) = pile(2);
        run(&mechanism, &mut state, 2e-3, 0.4, |_, _, _| {});
        state
    });
    assert_eq!(ends[0], ends[1]);
}

/// A floating box with three flaps in a row, whose hinges have limits.
fn chain() -> Mechanism {
    let mut bodies = Vec::new();
    for index in 0..4_usize {
        let kind = if index == 0 { JointKind::Floating } else { JointKind::Revolute };
        let turn = nalgebra::Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::FRAC_PI_2);
        let frame =
            |x: f64| if index == 0 { Pose::identity() } else { Pose::from_parts(Translation3::new(x, 0.0, 0.0), turn) };
        let joint = Joint::new("joint", kind, frame(0.11), frame(-0.11));
        let parent = index.checked_sub(1);
        bodies.push(Body { name: "flap".into(), parent, mass: 0.5, inertia: Vector3::new(1e-3, 3e-3, 3e-3), joint });
    }
    let mut mechanism = Mechanism::new("chain", Vector3::z() * -9.81, bodies).expect("a tree");
    for body in 1..4 {
        let joint = &mechanism.bodies[body].joint;
        let coordinate = Coordinate { body, position: joint.position_index, freedom: joint.velocity_index };
        mechanism.nonsmooth.limits.push(JointLimit { coordinate, lower: -0.3, upper: 0.4, restitution: 0.2 });
    }
    let nonsmooth = &mut mechanism.nonsmooth;
    let collider = |body, shape| Collider::still("one", body, Pose::identity(), shape);
    nonsmooth.colliders.push(collider(None, Shape::HalfSpace));
    for body in 0..4 {
        nonsmooth.colliders.push(collider(Some(body), Shape::Box { half: Vector3::new(0.1, 0.05, 0.02) }));
        nonsmooth.pairs.push(ContactPair::without_moments(body, [0, body + 1], 0.0, 0.0));
    }
    mechanism
}

#[test]
fn limits_and_contacts_without_friction_never_pull() {
    let mechanism = chain();
    let mut state = State::zero(&mechanism);
    put(&mut state, 0, [0.0, 0.0, 0.5], [0.3, 0.7, 0.0]);
    let mut pressed = 0;
    run(&mechanism, &mut state, 1e-3, 1.0, |made, state, crowd| {
        for candidate in &crowd.now.list {
            assert!(candidate.settling.x >= 0.0 && candidate.moving.x >= 0.0, "{:?} at {}", candidate.key, state.time);
            pressed += usize::from(candidate.settling.x > 0.0);
        }
        // The same number as of the piles, also for limits (rad).
        assert!(made.overlap <= 1e-9, "{made:?} at {}", state.time);
    });
    assert!(pressed > 100, "{pressed}");
}

#[test]
fn a_ball_like_box_rebounds_with_its_restitution() {
    // A cube that lands flat: 0.45 m of fall, 2.97 m/s, and 0.8 of it back.
    let mechanism = boxes(1, Vector3::repeat(0.05), 0.5, 0.8);
    let mut state = State::zero(&mechanism);
    put(&mut state, 0, [0.0, 0.0, 0.5], [0.0; 3]);
    let mut highest = 0.0_f64;
    let mut rises = false;
    run(&mechanism, &mut state, 1e-3, 0.55, |_, state, _| {
        rises |= state.velocity[2] > 0.0;
        if rises {
            highest = highest.max(state.position[2]);
        }
    });
    // e² of the height; an error of g h in the speed of the impact is 2 e² v g h/2g = 2 mm.
    assert!((highest - 0.05 - 0.64 * 0.45).abs() < 2e-3, "{highest}");
}

#[test]
fn loads_over_time_push_bodies_in_crowds_and_their_work_is_no_gain() {
    // 5 N and 0.3 N m on a box of 1 kg that falls from 2 m, for 0.4 s, and for half of that time.
    for (until, pushed) in [(f64::INFINITY, 0.4), (0.2, 0.2)] {
        let mut mechanism = boxes(1, Vector3::repeat(0.1), 0.5, 0.0);
        let course = Course::constant(1.0).between(f64::NEG_INFINITY, until);
        let (force, torque) = (Vector3::new(5.0, 0.0, 0.0), Vector3::new(0.0, 0.0, 0.3));
        mechanism.forces.link_loads =
            vec![LinkLoad { body: 0, point: Vector3::zeros(), force, torque, turns: false, course }];
        let mut state = State::zero(&mechanism);
        put(&mut state, 0, [0.0, 0.0, 2.0], [0.0; 3]);
        let (mut work, mut taken) = (0.0, 0.0);
        run(&mechanism, &mut state, 1e-3, 0.4, |made, _, _| {
            work += made.work;
            taken += made.taken;
        });
        // The moment of inertia is 0.02 m² kg / 3. Steps under constant forces are exact to roundings.
        let (speed, turn) = (5.0 * pushed, 0.3 * pushed / (0.02 / 3.0));
        let body = &body_states(&mechanism, &state)[0];
        assert!((body.velocity.x - speed).abs() < 1e-9, "{} {speed}", body.velocity.x);
        assert!((body.angular_velocity.z - turn).abs() < 1e-9 * turn, "{} {turn}", body.angular_velocity.z);
        let put_in = 0.5 * speed * speed + 0.5 * 0.3 * pushed * turn;
        assert!((work - put_in).abs() < 1e-9 * put_in && taken < 1e-9, "{work} {put_in} {taken}");
    }
}

#[test]
fn trees_of_crowds_have_the_mass_matrix_of_the_mechanism_with_its_rotors() {
    let arm = |parent: Option<usize>, kind: JointKind, armature: f64| {
        let frame =
            Pose::from_parts(Translation3::new(0.3, 0.1, -0.2), nalgebra::Rotation3::from_euler_angles(0.4, 0.2, 0.7));
        let joint = Joint { armature, ..Joint::new("joint", kind, frame, frame.inverse()) };
        Body { name: "link".into(), parent, mass: 1.5, inertia: Vector3::new(0.1, 0.2, 0.25), joint }
    };
    let bodies = vec![
        arm(None, JointKind::Floating, 0.0),
        arm(Some(0), JointKind::Revolute, 0.3),
        arm(Some(1), JointKind::Prismatic, 0.7),
        arm(None, JointKind::Revolute, 0.2),
    ];
    let mechanism = Mechanism::new("arms", Vector3::zeros(), bodies).expect("trees");
    let mut state = State::zero(&mechanism);
    put(&mut state, 0, [0.1, 0.2, 0.3], [0.5, -0.4, 0.3]);
    (7..10).for_each(|place| state.position[place] = 0.1 * place as f64);
    let mut trees = Trees::new(&mechanism);
    trees.place(&mechanism, &body_states(&mechanism, &state));
    let expected = mass_matrix(&mechanism, &state);
    for tree in &trees.trees {
        for (row, &a) in tree.freedoms.iter().enumerate() {
            for (column, &b) in tree.freedoms.iter().enumerate() {
                let entry = tree.mass[row * tree.freedoms.len() + column];
                assert!((entry - expected[(a, b)]).abs() < 1e-13, "{a} {b}: {entry} {}", expected[(a, b)]);
            }
        }
    }
}

#[test]
fn a_step_of_a_rounding_of_the_time_leaves_nothing_to_the_step_after_it() {
    // Two boxes on each other that slide: steps of 1 ms, one of 1e-15 s, as where steps end a rounding before a given instant, and one of 1 ms.
    let mechanism = boxes(2, Vector3::repeat(0.1), 0.3, 0.0);
    let (elements, touching) = (Elements::new(&mechanism), Touching::new(&mechanism));
    let mut response = Response::new(&mechanism);
    let scene = Scene { whole: &mechanism, elements: &elements, touching: &touching };
    let mut run = |steps: &[f64]| {
        let mut state = State::zero(&mechanism);
        (0..2).for_each(|body| put(&mut state, body, [0.01 * body as f64, 0.0, 0.1 + 0.2 * body as f64], [0.0; 3]));
        state.velocity[0] = 1.0;
        let mut crowd = Crowd::new(&mechanism).expect("trees");
        let mut forces = |at: &State, accelerations: &mut [f64], efforts: &mut [f64]| {
            response.accelerations(at, efforts, accelerations)
        };
        let step = |&step: &f64| crowd.step(scene, &mut forces, &mut state, step, false).expect("a step");
        let made: Vec<Made> = steps.iter().map(step).collect();
        (made[made.len() - 1], state)
    };
    let ((plain, end), (after, other)) = (run(&[1e-3; 4]), run(&[1e-3, 1e-3, 1e-3, 1e-15, 1e-3]));
    assert_eq!(after.candidates, plain.candidates);
    assert!(after.iterations <= 4 * plain.iterations + 20, "{} and {}", after.iterations, plain.iterations);
    let off = end.position.iter().zip(&other.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off <= 1e-9, "{off:e}");
}
