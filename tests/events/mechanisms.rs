//! The mechanisms of the exact answers, and runs of them.

use catena::mechanism::description::closure::{Coordinate, JointLimit};
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::description::nonsmooth::{DryFriction, Motor, MotorLaw};
use catena::mechanism::description::target::Target;
use catena::mechanism::motion::event::{Event, EventKind};
use catena::mechanism::motion::state::State;
use catena::simulation::{
    Finished, Observer, ObserverError, Sample, Simulation, SimulationOptions, StepChoice, StepEnd,
};
use nalgebra::{Matrix3, Rotation3, Translation3, Vector3};
use std::sync::atomic::{AtomicBool, Ordering};

/// m/s².
pub const GRAVITY: f64 = 9.81;

/// A hinge about the world's +y at a point of the parent, with the child's centre of mass below it.
pub fn hinge(name: &str, parent: Option<usize>, on_parent: Vector3<f64>, down: f64, mass: f64, inertia: f64) -> Body {
    // z of the joint frame is +y of the world.
    let turn = Rotation3::from_matrix_unchecked(Matrix3::new(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0));
    let on_parent = Pose::from_parts(Translation3::from(on_parent), turn);
    let on_child = Pose::from_parts(Translation3::new(0.0, 0.0, down), turn);
    let joint = Joint::new(name, JointKind::Revolute, on_parent, on_child);
    Body { name: name.into(), parent, mass, inertia: Vector3::repeat(inertia), joint }
}

/// A slide along an axis of the world.
pub fn slide(name: &str, axis: Vector3<f64>, mass: f64) -> Body {
    let turn = Rotation3::rotation_between(&Vector3::z(), &axis)
        .unwrap_or_else(|| Rotation3::from_axis_angle(&Vector3::x_axis(), std::f64::consts::PI));
    let frame = Pose::from_parts(Translation3::identity(), turn);
    let joint = Joint::new(name, JointKind::Prismatic, frame, frame);
    Body { name: name.into(), parent: None, mass, inertia: Vector3::repeat(0.01), joint }
}

/// The mechanism of some bodies under gravity along −z.
pub fn mechanism(bodies: Vec<Body>) -> Mechanism {
    Mechanism::new("exact", Vector3::new(0.0, 0.0, -GRAVITY), bodies).expect("depth first")
}

/// The pendulum of J1 and J2: mass 2, centre of mass 0.5 below, inertia 0.02.
pub fn pendulum() -> Mechanism {
    mechanism(vec![hinge("hinge", None, Vector3::zeros(), 0.5, 2.0, 0.02)])
}

/// The double pendulum of D1 to D3, with its knee.
pub fn double_pendulum(restitution: f64) -> Mechanism {
    let upper = hinge("hip", None, Vector3::zeros(), 0.25, 1.2, 0.03);
    let lower = hinge("knee", Some(0), Vector3::new(0.0, 0.0, 0.25 - 0.6), 0.3, 0.8, 0.02);
    let mut mechanism = mechanism(vec![upper, lower]);
    limit(&mut mechanism, 1, -0.1, f64::INFINITY, restitution);
    mechanism
}

/// The wheel of J5 to J7 is made where it is needed: a hinge through the centre of mass.
pub fn wheel(inertia: f64) -> Mechanism {
    mechanism(vec![hinge("axle", None, Vector3::zeros(), 0.0, 1.0, inertia)])
}

/// The only coordinate of a body.
pub fn coordinate(mechanism: &Mechanism, body: usize) -> Coordinate {
    let joint = &mechanism.bodies[body].joint;
    Coordinate { body, position: joint.position_index, freedom: joint.velocity_index }
}

pub fn limit(mechanism: &mut Mechanism, body: usize, lower: f64, upper: f64, restitution: f64) {
    let coordinate = coordinate(mechanism, body);
    mechanism.nonsmooth.limits.push(JointLimit { coordinate, lower, upper, restitution });
}

pub fn friction(mechanism: &mut Mechanism, body: usize, effort: f64) {
    let coordinate = coordinate(mechanism, body);
    mechanism.nonsmooth.friction.push(DryFriction { coordinate, effort });
}

pub fn motor(mechanism: &mut Mechanism, body: usize, law: MotorLaw, target: Target, max_effort: f64, period: f64) {
    let coordinate = coordinate(mechanism, body);
    mechanism.nonsmooth.motors.push(Motor { coordinate, law, target, max_effort, period, held: None });
}

/// A state at rest.
pub fn at_rest(mechanism: &Mechanism, positions: &[f64]) -> State {
    let mut state = State::zero(mechanism);
    state.position.copy_from_slice(positions);
    state
}

/// Runs to a time.
pub fn run(mechanism: &Mechanism, start: &State, duration: f64, steps: StepChoice) -> Finished {
    catena::events::check_certificates();
    let options = SimulationOptions::new(duration, steps);
    let mut simulation = Simulation::new(mechanism, start.clone(), options).expect("a run");
    simulation.run().expect("to the end");
    simulation.finish()
}

/// The same in so many steps at most, those before a restart with them: a run that does not get on fails, instead of going on for hours.
pub fn run_within(most: usize, mechanism: &Mechanism, start: &State, duration: f64, steps: StepChoice) -> Finished {
    catena::events::check_certificates();
    let stop = AtomicBool::new(false);
    let mut counter = Counter { left: most, stop: &stop };
    let options = SimulationOptions { interrupt: Some(&stop), ..SimulationOptions::new(duration, steps) };
    let mut simulation = Simulation::new(mechanism, start.clone(), options).expect("a run");
    simulation.observe(&mut counter);
    simulation.run().unwrap_or_else(|error| panic!("not done in {most} steps: {error}"));
    simulation.finish()
}

/// Stops a run after some steps.
struct Counter<'c> {
    left: usize,
    stop: &'c AtomicBool,
}

impl Observer for Counter<'_> {
    fn sample(&mut self, _sample: &Sample) -> Result<(), ObserverError> {
        Ok(())
    }

    fn step(&mut self, _end: &StepEnd) {
        self.left = self.left.saturating_sub(1);
        if self.left == 0 {
            self.stop.store(true, Ordering::Relaxed);
        }
    }
}

/// With this many stages and fixed steps.
pub fn fixed(stages: usize, step: f64) -> StepChoice {
    StepChoice::Fixed { stages, step }
}

/// The events of one kind.
pub fn of_kind(finished: &Finished, kind: EventKind) -> Vec<Event> {
    finished.events.iter().copied().filter(|event| event.kind == kind).collect()
}
