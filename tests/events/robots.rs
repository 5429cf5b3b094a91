//! Whole robots: an arm held by stiff motors, a chain with friction everywhere, real robots limp and held.

use crate::common::{shared, stem, urdf_files};
use crate::exact::near;
use crate::mechanisms::*;
use catena::mechanism::description::forces::{JointDamper, JointSpring};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::nonsmooth::{MotorLaw, Nonsmooth};
use catena::mechanism::description::target::Target;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::integrator::{Integrator, Rejected};
use catena::mechanism::motion::state::State;
use catena::model::{Model, ModelOptions};
use catena::reduced::Dop853;
use catena::scene::{PackagePath, read_urdf};
use catena::simulation::{Simulation, SimulationOptions, StepChoice};
use nalgebra::Vector3;

fn robot(path: &std::path::Path) -> Option<Model> {
    let robot = read_urdf(path, &PackagePath::default()).ok()?;
    Model::new(robot, &ModelOptions::default()).ok()
}

/// The arm with seven joints, without its limits.
fn arm() -> Mechanism {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/arm7.urdf");
    let mut mechanism = robot(&path).expect("the arm").mechanism;
    mechanism.nonsmooth = Nonsmooth::default();
    mechanism
}

#[test]
fn an_arm_held_by_stiff_motors_is_where_springs_and_dampers_would_hold_it() {
    let (kp, kd, target) = (1000.0, 50.0, 0.3);
    let mut springs = arm();
    let mut motors = arm();
    for body in 0..springs.bodies.len() {
        let at = coordinate(&springs, body);
        springs.forces.joint_springs.push(JointSpring { coordinate: at, stiffness: kp, rest: target });
        springs.forces.joint_dampers.push(JointDamper { freedom: at.freedom, coefficient: kd });
        motor(&mut motors, body, MotorLaw::Position { kp, kd }, Target::constant(target), f64::INFINITY, 0.0);
    }
    // The same equations in joint coordinates, by another method.
    let mut exact = State::zero(&springs);
    let mut dop853 = Dop853::new(&springs, 1e-13);
    while exact.time < 0.5 {
        dop853.advance(&springs, &mut exact, 0.5).expect("a step");
    }
    for (steps, allowed) in
        [(fixed(9, 0.005), 1e-11), (StepChoice::Tolerance(1e-6), 1e-6), (StepChoice::Tolerance(1e-9), 1e-9)]
    {
        let done = run(&motors, &State::zero(&motors), 0.5, steps);
        for (found, &wanted) in done.state.position.iter().zip(&exact.position) {
            near(*found, wanted, allowed);
        }
    }
    // And it comes to rest in steps that are far longer than its fastest rates allow explicit ones, of which 5 s take more than 10⁵.
    let start = at_rest(&motors, &[target; 7]);
    let done = run(&motors, &start, 5.0, StepChoice::Tolerance(1e-6));
    assert!(done.summary.steps < 1000, "{:?}", done.summary);
    // What rings on with a motor a thousand times faster than the steps is nothing in position: 1e-4 rad/s over 1e5/s.
    assert!(done.state.velocity.iter().all(|rate| rate.abs() < 1e-3), "{:?}", done.state.velocity);
}

#[test]
fn an_arm_that_motors_drive_to_targets_is_located_at_their_bounds_as_closely_as_wanted_and_steps_grow_again_behind_them()
 {
    let mut arm = arm();
    for (body, target) in [0.2, -0.15, 0.25, -0.2, 0.12, 0.27, -0.2].into_iter().enumerate() {
        let law = MotorLaw::Position { kp: 1000.0, kd: 50.0 };
        motor(&mut arm, body, law, Target::constant(target), [200.0, 200.0, 120.0, 120.0, 60.0, 40.0, 20.0][body], 0.0);
    }
    let start = State::zero(&arm);
    let exact = run(&arm, &start, 0.5, StepChoice::Tolerance(1e-10).without_estimate());
    let coarse = run(&arm, &start, 0.5, StepChoice::Tolerance(1e-4).without_estimate());
    for (found, &wanted) in coarse.state.position.iter().zip(&exact.state.position) {
        near(*found, wanted, 1e-4);
    }
    let [found, wanted] = [&coarse, &exact].map(|run| run.summary.events.of(EventKind::Unsaturation));
    assert_eq!((found, wanted), (6, 6));
    let cost = coarse.summary.cost;
    // Location to roundings takes seven attempts.
    assert!(cost.located <= 3 * found, "{cost:?}");
    // Where the extrapolated guess fails beside hard dampers, the plain one leads to the solution of the same step. If each such step kept the next
    // one from growing, 106 would be.
    assert!(cost.rejected.of(Rejected::NotConverged) <= 10, "{cost:?}");
}

#[test]
fn a_chain_with_friction_in_all_its_joints_turns_all_that_it_loses_into_heat() {
    let bodies = (0..30).map(|index| {
        let parent = (index > 0).then(|| index - 1);
        let on_parent = if index > 0 { Vector3::new(0.0, 0.0, -0.1) } else { Vector3::zeros() };
        hinge(&format!("joint{index}"), parent, on_parent, 0.1, 0.3, 1e-3)
    });
    let mut chain = mechanism(bodies.collect());
    for body in 0..30 {
        friction(&mut chain, body, 0.3);
    }
    let mut start = State::zero(&chain);
    start.position[0] = 1.2;
    start.position[10] = -0.8;
    start.position[20] = 0.6;
    let done = run(&chain, &start, 3.0, StepChoice::Tolerance(1e-6));
    let events = &done.summary.events;
    println!("{} sticks, {} slips, {:?}", events.of(EventKind::Stick), events.of(EventKind::Slip), done.summary);
    assert!(events.of(EventKind::Slip) > 10, "{events:?}");
    assert!(done.summary.max_relative_energy_error < 1e-6, "{:?}", done.summary);
    let lost = done.summary.initial_energy.total() - done.summary.final_energy.total();
    near(done.summary.exchange.friction, lost, 1e-5 * lost);
}

/// Robots of the corpus with limits or friction.
const REAL: [&str; 10] =
    ["anymal_b", "hyq", "iiwa_pybullet", "kinova", "laikago", "panda", "so100", "solo12", "talos_reduced", "ur5"];

/// Runs real robots, held by motors for so long, and then dropped limp onto their limits.
fn run_real_robots(duration: f64) {
    let Some(folder) = shared("urdf-corpus/loads") else {
        println!("skipped: there is no ../shared/urdf-corpus");
        return;
    };
    let files = urdf_files(&folder);
    for name in REAL {
        let Some(path) = files.iter().find(|path| stem(path) == name) else {
            println!("skipped: no {name}");
            continue;
        };
        let model = robot(path).unwrap_or_else(|| panic!("{name} is read"));
        let mut start = State::zero(&model.mechanism);
        for limit in &model.mechanism.nonsmooth.limits {
            let slot = limit.coordinate.position;
            start.position[slot] = start.position[slot].max(limit.lower).min(limit.upper);
        }
        for mimic in &model.mechanism.mimics {
            start.position[mimic.follower.position] =
                mimic.multiplier * start.position[mimic.leader.position] + mimic.offset;
        }
        for held in [true, false] {
            let mut mechanism = model.mechanism.clone();
            let bodies = if held { mechanism.bodies.len() } else { 0 };
            for body in (0..bodies).filter(|&body| model.mechanism.bodies[body].joint.kind.velocity_count() == 1) {
                let target = Target::constant(start.position[mechanism.bodies[body].joint.position_index]);
                motor(&mut mechanism, body, MotorLaw::Position { kp: 1000.0, kd: 50.0 }, target, f64::INFINITY, 0.0);
            }
            let options = SimulationOptions::new(duration, StepChoice::Tolerance(1e-6));
            let mut simulation = Simulation::new(&mechanism, start.clone(), options).expect("a run");
            simulation.run().unwrap_or_else(|error| panic!("{name}, held {held}: {error}"));
            let done = simulation.finish();
            let summary = &done.summary;
            println!(
                "{name}, held {held}: {} steps, {} events, energy {:e}",
                summary.steps,
                summary.events.total(),
                summary.max_relative_energy_error
            );
            // The balance of a robot near rest is one of next to no energy.
            let allowed = if held { 1e-2 } else { 1e-5 };
            assert!(summary.max_relative_energy_error < allowed, "{name}, held {held}: {summary:?}");
            for limit in &mechanism.nonsmooth.limits {
                let position = done.state.position[limit.coordinate.position];
                let inside = position >= limit.lower - 1e-9 && position <= limit.upper + 1e-9;
                assert!(inside, "{name}, held {held}: {position} not in {} … {}", limit.lower, limit.upper);
            }
            // What was held is let go.
            start = State { time: 0.0, ..done.state };
        }
    }
}

#[test]
fn real_robots_stay_within_their_limits_held_by_motors_and_then_dropped_limp() {
    run_real_robots(1.0);
}

#[test]
#[ignore = "a minute: cargo test --release --test events real -- --ignored --nocapture"]
fn real_robots_stay_within_their_limits_for_ten_seconds() {
    run_real_robots(10.0);
}
