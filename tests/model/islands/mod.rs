//! Islands: what nothing connects is simulated apart, as if it were alone, and what rests in equilibrium not at all.

mod graph;
mod runs;
mod sleep;

use crate::models::Model;
use crate::{common, models};
use catena::mechanism::description::closure::{Attachment, LoopJoint};
use catena::mechanism::description::forces::{Forces, PointSpring};
use catena::mechanism::description::joint::{Joint, JointKind};
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::motion::state::State;
use catena::simulation::parallel::islands::Islands;
use catena::simulation::parallel::partition::Plan;
use catena::simulation::parallel::threads::Threads;
use catena::simulation::{Observer, ObserverError, RunOptions, Sample, Summary};
use catena::stepping::integrator::Lobatto;
use nalgebra::Vector3;

/// All of them in one mechanism, one after the other.
fn side_by_side(parts: Vec<(Mechanism, State)>) -> Model {
    let mut bodies = Vec::new();
    let mut state = State { time: 0.0, position: vec![], compensation: vec![], velocity: vec![] };
    let (mut loops, mut forces) = (Vec::new(), Forces::default());
    for (part, own) in parts {
        let (first, freedom, position) = (bodies.len(), state.velocity.len(), state.position.len());
        let there = |end: Attachment| Attachment { body: end.body.map(|body| body + first), ..end };
        bodies.extend(part.bodies.into_iter().map(|mut body| {
            body.parent = body.parent.map(|parent| parent + first);
            body
        }));
        loops.extend(part.loops.into_iter().map(|joint| LoopJoint { a: there(joint.a), b: there(joint.b), ..joint }));
        let theirs = part.forces;
        forces.joint_dampers.extend(theirs.joint_dampers.into_iter().map(|mut damper| {
            damper.freedom += freedom;
            damper
        }));
        forces.joint_springs.extend(theirs.joint_springs.into_iter().map(|mut spring| {
            spring.coordinate.body += first;
            spring.coordinate.position += position;
            spring.coordinate.freedom += freedom;
            spring
        }));
        forces.joint_loads.extend(theirs.joint_loads.into_iter().map(|mut load| {
            load.freedom += freedom;
            load
        }));
        forces.wrenches.extend(theirs.wrenches.into_iter().map(|mut wrench| {
            wrench.body += first;
            wrench
        }));
        forces.point_springs.extend(theirs.point_springs.into_iter().map(|spring| PointSpring {
            a: there(spring.a),
            b: there(spring.b),
            ..spring
        }));
        state.position.extend(own.position);
        state.velocity.extend(own.velocity);
        state.compensation.extend(own.compensation);
    }
    let mut mechanism = Mechanism::new("side_by_side", models::gravity(), bodies).expect("depth first");
    (mechanism.loops, mechanism.forces) = (loops, forces);
    Model { mechanism, state }
}

fn parts(model: Model) -> (Mechanism, State) {
    (model.mechanism, model.state)
}

fn spring_between(a: usize, b: usize) -> PointSpring {
    PointSpring {
        name: format!("spring {a} {b}"),
        a: models::point_of(Some(a), [0.1, 0.0, 0.2]),
        b: models::point_of(Some(b), [0.0, -0.1, 0.1]),
        stiffness: 30.0,
        damping: 0.3,
        rest_length: 0.4,
    }
}

/// Time, positions and velocities of a sample.
type Sampled = (f64, Vec<f64>, Vec<f64>);

/// What an observer saw.
#[derive(Clone, Debug, Default, PartialEq)]
struct Seen {
    samples: Vec<Sampled>,
}

impl Observer for Seen {
    fn sample(&mut self, sample: &Sample) -> Result<(), ObserverError> {
        self.samples.push((sample.time, sample.position.to_vec(), sample.velocity.to_vec()));
        Ok(())
    }
}

/// How the islands of a test are integrated.
#[derive(Clone, Copy)]
enum Way {
    Fixed(usize, f64),
    Tolerance(f64),
}

impl Way {
    fn integrator(self, mechanism: &Mechanism, state: &State, duration: f64) -> Lobatto {
        match self {
            Way::Fixed(stages, step) => {
                Lobatto::fixed(mechanism, stages, step).expect("a number of stages from 2 to 16")
            }
            Way::Tolerance(tolerance) => common::by_tolerance(mechanism, state, duration, tolerance),
        }
    }
}

fn run_islands(model: &Model, way: Way, options: &RunOptions, threads: usize) -> (State, Summary, Seen) {
    let plan = Plan::new(&model.mechanism, &model.state, &[]);
    let make = |part: &Mechanism, state: &State| Ok::<_, ()>((way.integrator(part, state, options.duration), ()));
    let (mut all, _) = Islands::new(plan, &model.state, Threads::Exactly(threads), make).expect("integrators");
    let (mut state, mut seen) = (model.state.clone(), Seen::default());
    let (summary, ended) = all.run(&model.mechanism, &mut state, options, &mut [&mut seen]);
    ended.unwrap_or_else(|error| panic!("{error}"));
    (state, Summary { solve_cpu_seconds: 0.0, ..summary }, seen)
}

/// A box on a hinge about y, its centre of mass 0.5 m below it at zero.
fn pendulum(angle: f64) -> (Mechanism, State) {
    let joint = Joint::new(
        "hinge",
        JointKind::Revolute,
        models::frame(Vector3::zeros(), Vector3::y()),
        models::frame(Vector3::new(0.0, 0.0, 0.5), Vector3::y()),
    );
    let inertia = models::box_inertia(1.0, Vector3::new(0.1, 0.1, 1.0));
    let mechanism = Mechanism::new("pendulum", models::gravity(), vec![models::body("rod", None, 1.0, inertia, joint)])
        .expect("one");
    let mut state = State::zero(&mechanism);
    state.position[0] = angle;
    (mechanism, state)
}
