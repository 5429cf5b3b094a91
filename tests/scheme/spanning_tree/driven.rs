//! Mechanisms with friction, motors, limits, contacts and controllers: the same motion and the same work, whichever way they are written.

use super::apart;
use crate::linkage::{Linkage, path};
use catena::instant::exerting::reactions::Reactions;
use catena::lobatto::plan::elimination::Elimination;
use catena::mechanism::description::closure::{Coordinate, JointLimit};
use catena::mechanism::description::contact::{Collider, ContactPair, Shape};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::nonsmooth::{DryFriction, Motor, MotorLaw};
use catena::mechanism::description::rules::Rule;
use catena::mechanism::description::target::{Interpolation, Target};
use catena::mechanism::motion::event::Event;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::mechanism::structure::other_tree::OtherTree;
use catena::mechanism::structure::plane::Plane;
use catena::simulation::{ContinuousController, Simulation, SimulationOptions, StepChoice};
use catena::stepping::trees::other_tree::other_tree;
use nalgebra::{DMatrix, Rotation3, Translation3, Vector3};

/// The same four-bars as a row, whose cranks stand on the ground with couplers on their tips, and as a path; the knees are joints of both trees.
fn written(count: usize, speed: f64) -> [(Mechanism, State); 2] {
    let row = Linkage::four_bars(count, speed, true);
    [row.written(&row.first(&["pin", "knee"])), row.written(&row.first(&["pin0", "elbow", "knee"]))]
}

/// The coordinate of a hinge.
fn coordinate(mechanism: &Mechanism, name: &str) -> Coordinate {
    let body = mechanism.bodies.iter().position(|body| body.joint.name == name).expect("a joint of this name");
    let joint = &mechanism.bodies[body].joint;
    Coordinate { body, position: joint.position_index, freedom: joint.velocity_index }
}

/// Adds to all hinges of a kind what `add` says.
fn add(mechanism: &mut Mechanism, kind: &str, mut add: impl FnMut(&mut Mechanism, Coordinate)) {
    let names: Vec<String> = mechanism.bodies.iter().map(|body| body.joint.name.clone()).collect();
    for name in names.iter().filter(|name| name.starts_with(kind)) {
        let at = coordinate(mechanism, name);
        add(mechanism, at);
    }
}

fn friction(mechanism: &mut Mechanism, coordinate: Coordinate, effort: f64) {
    mechanism.nonsmooth.friction.push(DryFriction { coordinate, effort });
}

fn motor(mechanism: &mut Mechanism, coordinate: Coordinate, law: MotorLaw, target: Target, max_effort: f64) {
    mechanism.nonsmooth.motors.push(Motor { coordinate, law, target, max_effort, period: 0.0, held: None });
}

/// A run in fixed steps: its end, its events, its iterations.
fn run(mechanism: &Mechanism, start: &State, duration: f64, kept: &[Rule]) -> (State, Vec<Event>, usize) {
    let steps = StepChoice::Fixed { stages: 5, step: 0.01 };
    let options = SimulationOptions { switched_off: kept, ..SimulationOptions::new(duration, steps) };
    let mut simulation = Simulation::new(mechanism, start.clone(), options).expect("a run");
    simulation.run().expect("steps");
    let iterations = simulation.summary().cost.iterations;
    let finished = simulation.finish();
    (finished.state, finished.events, iterations)
}

/// The work of the elimination on the tree of the program's choice.
fn work(mechanism: &Mechanism, start: &State) -> usize {
    let plane = Plane::of(mechanism).expect("a plane");
    let plan = |mechanism: &Mechanism| Elimination::new(mechanism, 3, &vec![2; mechanism.loops.len()], false).work();
    match other_tree(mechanism, &[], &[]) {
        Some((tree, _)) => plan(&OtherTree::new(mechanism, &tree, Some(&plane), start).expect("depth first").mechanism),
        None => plan(mechanism),
    }
}

/// Runs a row and the same as a path, which is cut somewhere else, and the path on its own tree: all come to the same end by the same events with the
/// same iterations. `bound` is how far ends may be apart (m, rad, and their rates).
fn alike(name: &str, all: [(Mechanism, State); 2], duration: f64, happens: bool, bound: f64) {
    let [(row, row_start), (path, path_start)] = all;
    assert!(other_tree(&path, &[], &[]).is_some(), "{name}: another tree");
    let (expected, row_events, row_iterations) = run(&row, &row_start, duration, &[]);
    let (own, events, iterations) = run(&path, &path_start, duration, &[]);
    let (kept, kept_events, kept_iterations) = run(&path, &path_start, duration, &[Rule::Tree]);
    assert!(!happens || !events.is_empty(), "{name}: something happens");
    let what = |events: &[Event], mechanism: &Mechanism| -> Vec<(String, String, f64)> {
        let joint = |event: &Event| mechanism.bodies[event.body].joint.name.clone();
        events.iter().map(|event| (format!("{:?}", event.kind), joint(event), event.time)).collect()
    };
    let own_events = what(&events, &path);
    for (other, of) in [(what(&kept_events, &path), "on its tree"), (what(&row_events, &row), "as a row")] {
        assert_eq!(own_events.len(), other.len(), "{name}, {of}: {own_events:?}, not {other:?}");
        for (own, other) in own_events.iter().zip(&other) {
            assert!((own.2 - other.2).abs() < bound, "{name}, {of}: {own:?}, not {other:?}");
        }
    }
    let pairs = own.position.iter().zip(&kept.position).chain(own.velocity.iter().zip(&kept.velocity));
    let off = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off < bound, "{name}: {off:e} from the path on its own tree");
    let off = apart((&path, &own), (&row, &expected));
    assert!(off < bound, "{name}: {off:e} m from the row");
    println!(
        "{name}: {iterations} iterations, {row_iterations} of the row, {kept_iterations} of the path on its own tree"
    );
    // Whichever way it is written it takes the same work within this factor; that of an iteration is counted below.
    assert!(
        iterations as f64 <= 1.5 * row_iterations as f64,
        "{name}: {iterations} iterations, {row_iterations} of the row"
    );
}

#[test]
fn rows_with_friction_and_motors_move_and_stick_the_same_whichever_way_they_are_written() {
    let position = MotorLaw::Position { kp: 60.0, kd: 6.0 };
    let [mut row, mut path] = written(8, 1.0);
    for (mechanism, _) in [&mut row, &mut path] {
        add(mechanism, "knee", |mechanism, knee| friction(mechanism, knee, 0.3));
    }
    alike("friction", [row.clone(), path.clone()], 0.5, false, 1e-8);
    for (mechanism, start) in [&mut row, &mut path] {
        let pin = coordinate(mechanism, "pin0");
        let at = start.position[pin.position];
        let swing = Target::table(&[(0.0, at), (0.3, at - 0.4), (0.6, at + 0.1)], Interpolation::Linear);
        motor(mechanism, pin, position, swing.expect("a target"), 25.0);
    }
    alike("friction and a motor at its bound", [row, path], 0.6, true, 1e-7);
}

#[test]
fn limits_hold_rows_that_motors_push_onto_them_whichever_way_they_are_written() {
    let mut both = written(8, 1.0);
    for (mechanism, start) in &mut both {
        let pin = coordinate(mechanism, "pin0");
        let at = start.position[pin.position];
        mechanism.nonsmooth.limits.push(JointLimit {
            coordinate: pin,
            lower: at - 0.3,
            upper: at + 0.3,
            restitution: 0.0,
        });
        // It lets go again.
        let push = Target::table(&[(0.0, -60.0), (0.4, -60.0), (0.6, 90.0)], Interpolation::Linear);
        motor(mechanism, pin, MotorLaw::Effort, push.expect("a target"), f64::INFINITY);
        add(mechanism, "knee", |mechanism, knee| friction(mechanism, knee, 0.1));
    }
    alike("a limit", both, 0.8, true, 1e-7);
}

#[test]
fn rows_that_fall_onto_a_floor_touch_it_at_the_same_instants_whichever_way_they_are_written() {
    for (mu, restitution) in [(0.0, 0.5), (0.4, 0.0)] {
        let mut both = written(6, 2.0);
        for (mechanism, _) in &mut both {
            let up = Rotation3::rotation_between(&Vector3::z(), &Vector3::y()).expect("no half turn");
            let floor = Pose::from_parts(Translation3::new(0.0, 0.5, 0.0), up);
            let body = mechanism.bodies.iter().position(|body| body.name == "coupler3");
            let shapes = [(None, floor, Shape::HalfSpace), (body, Pose::identity(), Shape::Sphere { radius: 0.1 })];
            for (body, pose, shape) in shapes {
                mechanism.nonsmooth.colliders.push(Collider::still(format!("{shape:?}"), body, pose, shape));
            }
            mechanism.nonsmooth.pairs.push(ContactPair::without_moments(0, [0, 1], mu, restitution));
        }
        alike(&format!("a floor, friction {mu}"), both, 0.6, true, 1e-7);
    }
}

/// Turns all hinges of these names back to where they began, `−kp (q − q₀) − kd q̇`.
struct Back<'s> {
    joints: &'s [&'s str],
    start: &'s State,
}

impl ContinuousController for Back<'_> {
    fn freedoms(&self, mechanism: &Mechanism) -> Vec<usize> {
        self.joints.iter().map(|name| coordinate(mechanism, name).freedom).collect()
    }

    fn efforts(&self, mechanism: &Mechanism, state: &State, efforts: &mut [f64]) {
        for (effort, name) in efforts.iter_mut().zip(self.joints) {
            let at = coordinate(mechanism, name);
            // Also on how another joint has turned, which may be one that is cut.
            let last = mechanism.velocity_count - 1;
            let turned = |entry: usize| state.position[entry] + state.compensation[entry] - self.start.position[entry];
            *effort = -40.0 * turned(at.position) - 4.0 * state.velocity[at.freedom] - 5.0 * turned(last).sin();
        }
    }

    fn derivatives(
        &self,
        mechanism: &Mechanism,
        state: &State,
        by_position: &mut DMatrix<f64>,
        by_rate: &mut DMatrix<f64>,
    ) {
        let last = mechanism.velocity_count - 1;
        for (row, name) in self.joints.iter().enumerate() {
            let at = coordinate(mechanism, name);
            by_position[(row, at.freedom)] -= 40.0;
            by_rate[(row, at.freedom)] -= 4.0;
            by_position[(row, last)] -= 5.0 * (state.position[last] - self.start.position[last]).cos();
        }
    }
}

#[test]
fn controllers_at_every_instant_steer_rows_the_same_whichever_joints_are_cut() {
    let (mechanism, start) = path(8, 6.0);
    let (tree, _) = other_tree(&mechanism, &[], &[]).expect("another tree");
    let cut = tree.cut_joints().next().expect("a joint that is cut");
    let cut = mechanism.bodies[cut].joint.name.clone();
    // One that stays, and one that is cut before.
    for joints in [&["pin0"][..], &["pin0", &cut]] {
        let run = |kept: &[Rule], push: f64| {
            let steps = StepChoice::Fixed { stages: 5, step: 0.01 };
            let options = SimulationOptions { switched_off: kept, ..SimulationOptions::new(0.4, steps) };
            let mut simulation = Simulation::new(&mechanism, start.clone(), options).expect("a run");
            if push == 0.0 {
                simulation.run().expect("steps");
            } else {
                simulation.run_under_continuous(&Back { joints, start: &start }).expect("steps");
            }
            (simulation.state().clone(), simulation.summary().cost.iterations)
        };
        let ((own, iterations), (kept, expected)) = (run(&[], 1.0), run(&[Rule::Tree], 1.0));
        let off = |a: &State, b: &State| {
            let pairs = a.position.iter().zip(&b.position).chain(a.velocity.iter().zip(&b.velocity));
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        assert!(off(&own, &kept) < 1e-8, "{joints:?}: {:e}", off(&own, &kept));
        assert!(off(&own, &run(&[], 0.0).0) > 1e-2, "the controller does something");
        assert!(
            iterations as f64 <= 1.5 * expected as f64,
            "{joints:?}: {iterations} iterations, {expected} on its tree"
        );
    }
}

#[test]
fn work_of_rows_with_friction_and_motors_grows_like_their_number_whichever_way_they_are_written() {
    let works = [10, 20, 40].map(|count| {
        written(count, 1.0).map(|(mut mechanism, start)| {
            add(&mut mechanism, "knee", |mechanism, knee| friction(mechanism, knee, 0.3));
            let pin = coordinate(&mechanism, "pin0");
            motor(&mut mechanism, pin, MotorLaw::Effort, Target::constant(5.0), f64::INFINITY);
            work(&mechanism, &start) as f64
        })
    });
    for [row, path] in works {
        assert!(path <= 1.5 * row, "{path} on the path, {row} on the row");
    }
    for [few, many] in [[works[0], works[1]], [works[1], works[2]]] {
        let powers = [0, 1].map(|way| (many[way] / few[way]).log2());
        assert!(powers.iter().all(|power| *power <= 1.1), "N^{powers:?}");
    }
}

#[test]
fn joints_carry_what_friction_motors_limits_and_contacts_exert_whichever_of_them_are_cut() {
    let (plain, start) = path(6, 1.0);
    let (tree, _) = other_tree(&plain, &[], &[Rule::Planar]).expect("another tree");
    let cut = tree.cut_joints().next().expect("a joint that is cut");
    let mut still = start.clone();
    still.velocity.fill(0.0);
    let mut rubbing = plain.clone();
    add(&mut rubbing, "knee", |mechanism, knee| friction(mechanism, knee, 0.7));
    // At rest on its limit, which holds it alone.
    let mut stopped = plain.clone();
    let joint = &stopped.bodies[cut].joint;
    let coordinate_of_cut = Coordinate { body: cut, position: joint.position_index, freedom: joint.velocity_index };
    let at = start.position[coordinate_of_cut.position];
    stopped.nonsmooth.limits.push(JointLimit {
        coordinate: coordinate_of_cut,
        lower: at - 1.0,
        upper: at,
        restitution: 0.0,
    });
    let mut touching = plain.clone();
    // Cranks that lean to the side press a level coupler onto a floor.
    let mut leaning = still.clone();
    for (body, own) in plain.bodies.iter().enumerate() {
        let down = |name: &str| if name.starts_with("crank") { 0.5 } else { 0.0 };
        leaning.position[body] -= down(&own.name) - own.parent.map_or(0.0, |parent| down(&plain.bodies[parent].name));
    }
    let up = Rotation3::rotation_between(&Vector3::z(), &Vector3::y()).expect("no half turn");
    let shapes = [
        (None, Pose::from_parts(Translation3::new(0.0, 0.5_f64.cos() - 0.1, 0.0), up), Shape::HalfSpace),
        (Some(3), Pose::identity(), Shape::Sphere { radius: 0.1 }),
    ];
    for (body, pose, shape) in shapes {
        touching.nonsmooth.colliders.push(Collider::still(format!("{shape:?}"), body, pose, shape));
    }
    touching.nonsmooth.pairs.push(ContactPair::without_moments(0, [0, 1], 0.0, 0.0));
    assert!(plain.bodies[3].name.starts_with("coupler"), "{}", plain.bodies[3].name);
    for (name, mut mechanism, state, push) in [
        ("friction", rubbing, &start, 5.0),
        ("a limit, pushed on", stopped.clone(), &still, 30.0),
        ("a limit, pushed on from the other side", stopped, &still, -30.0),
        ("a contact", touching, &leaning, 0.0),
    ] {
        let pin = coordinate(&mechanism, "pin0");
        motor(&mut mechanism, pin, MotorLaw::Effort, Target::constant(push), f64::INFINITY);
        let bodies = body_states(&mechanism, state);
        let (mut elsewhere, mut here) = (Reactions::new(&mechanism), Reactions::on_its_tree(&mechanism));
        let mut undriven = Reactions::new(&plain);
        elsewhere.drive(&[push]);
        here.drive(&[push]);
        let (joints, loops) = elsewhere.of_placed(&state.position, &state.velocity, &bodies);
        let (expected_joints, expected_loops) = here.of_placed(&state.position, &state.velocity, &bodies);
        let (bare, _) = undriven.of_placed(&state.position, &state.velocity, &bodies);
        for (own, expected) in joints.iter().zip(expected_joints) {
            let off = (own.force - expected.force).norm() + (own.torque - expected.torque).norm();
            // Of forces of some ten newtons each, added up over a dozen bodies.
            assert!(off < 1e-9, "{name}: {own:?}, not {expected:?}");
        }
        for (own, expected) in loops.iter().zip(expected_loops) {
            let off = (own.force - expected.force).norm() + (own.torque - expected.torque).norm();
            assert!(off < 1e-9, "{name}: {own:?}, not {expected:?}");
        }
        let acts = joints.iter().zip(bare).map(|(own, bare)| (own.force - bare.force).norm());
        assert!(acts.fold(0.0, f64::max) > 0.1, "{name}: it does something");
    }
}
