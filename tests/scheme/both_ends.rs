//! The ends of a run and its companion, worked out at once, held against one after the other: the same numbers, in every vector that a kernel is
//! compiled for.

use crate::models;
use crate::refinement::beside_lock;
use crate::special_bodies::VECTORS;
use catena::kernels::step_for;
use catena::lobatto::numbers::lanes::Isa;
use catena::lobatto::stages::attempt::{Attempt, Carrying, Guess, StopRule};
use catena::lobatto::step::interface::Step;
use catena::lobatto::tableau::butcher::Tableau;
use catena::mechanism::description::body_state::BodyState;
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::energy::Energy;
use catena::mechanism::motion::state::State;
use nalgebra::{Rotation3, Translation3, Vector3};

const CARRYING: Carrying = Carrying {
    apart: 1e-6,
    part: 0.02,
    most: 2,
    rest: 0.05,
    sprung: false,
    least: 0.0,
    exactly: false,
    truncation: 0.0,
};

/// Every way in which a body can be placed and eliminated, on frames that are aligned with nothing.
fn every_kind_of_body() -> (Mechanism, State) {
    use JointKind::{Floating, Planar, Prismatic, Revolute, Spherical};
    let inertia = Vector3::new(0.05, 0.08, 0.1);
    let kinds = [
        (Revolute, None, inertia),
        (Spherical, Some(0), Vector3::new(0.06, 0.07, 0.1)),
        (Revolute, Some(0), Vector3::repeat(0.04)),
        (Revolute, Some(2), Vector3::zeros()),
        (Prismatic, None, inertia),
        (Prismatic, Some(4), inertia),
        (Planar, Some(5), inertia),
        (Floating, None, inertia),
        (Prismatic, Some(7), inertia),
        (Revolute, Some(8), inertia),
    ];
    let bodies = kinds.iter().enumerate().map(|(index, &(kind, parent, inertia))| {
        let frame = |at: f64| {
            let turn = Rotation3::from_euler_angles(at, 0.4 * index as f64 - 0.3 * at, 0.5 - at);
            Pose::from_parts(Translation3::new(0.3 * at, -0.1, 0.05 * index as f64), turn)
        };
        let joint = Joint::new(&format!("joint {index}"), kind, frame(0.7), frame(-0.5));
        Body { name: format!("body {index}"), parent, mass: 1.0 + 0.1 * index as f64, inertia, joint }
    });
    let mechanism = Mechanism::new("every kind", Vector3::new(1.0, -2.0, -9.0), bodies.collect()).unwrap();
    let mut state = State::zero(&mechanism);
    for (index, rate) in state.velocity.iter_mut().enumerate() {
        *rate = 2.0 * (index as f64).sin();
    }
    (mechanism, state)
}

/// What a motion and the one beside it have become.
#[derive(Debug, PartialEq)]
struct Both {
    states: [State; 2],
    bodies: [Option<Vec<BodyState>>; 2],
    energy: Energy,
}

struct Motions {
    kernel: Box<dyn Step>,
    states: [State; 2],
}

impl Motions {
    /// Both begin at nearly the same state.
    fn new(mechanism: &Mechanism, state: &State, (isa, stages): (Isa, usize)) -> Self {
        let mut kernel = step_for(mechanism, Tableau::of(stages).unwrap(), isa, &[]);
        let mut beside = state.clone();
        beside.velocity.iter_mut().enumerate().for_each(|(index, rate)| *rate += 1e-6 * (1.0 + index as f64).cos());
        kernel.begin(mechanism, state);
        kernel.begin_to_carry(mechanism, &beside);
        Motions { kernel, states: [state.clone(), beside] }
    }

    fn solve(&mut self, mechanism: &Mechanism, length: f64, refined: bool) {
        let increment = if refined { 2e-16 } else { 1e-7 };
        let rule = StopRule { increment, ..StopRule::ROUNDING };
        let guess = if self.kernel.has_past() { Guess::Past } else { Guess::Plain };
        let attempt = self.kernel.attempt(mechanism, length, &rule, guess);
        assert!(matches!(attempt, Attempt::Converged { exact: false, .. }), "{attempt:?}");
    }

    /// A step, in which the ends are worked out at once where they can be, if that is wanted; whether they were.
    fn step(&mut self, mechanism: &Mechanism, length: f64, refined: bool, carrying: &Carrying, at_once: bool) -> bool {
        self.solve(mechanism, length, refined);
        let Motions { kernel, states: [state, beside] } = self;
        let energy = if at_once { kernel.finish_both(mechanism, state, beside, carrying) } else { None };
        match energy {
            Some(_) => kernel.keep_carried(),
            None => {
                kernel.finish(mechanism, state);
                kernel.carry_on(mechanism, beside, carrying);
            }
        }
        kernel.accept();
        energy.is_some()
    }

    fn now(&self) -> Both {
        let bodies =
            [self.kernel.bodies(), self.kernel.carried_bodies()].map(|bodies| bodies.map(<[BodyState]>::to_vec));
        Both { states: self.states.clone(), bodies, energy: self.kernel.energy() }
    }
}

/// Steps of three kinds of a motion and the one beside it, at once and one after the other.
fn are_the_same(name: &str, mechanism: &Mechanism, state: &State, length: f64) {
    for vectors in VECTORS {
        let [mut at_once, mut apart] = [0, 1].map(|_| Motions::new(mechanism, state, vectors));
        for (step, &(refined, truncation)) in
            [(false, 0.0), (true, 0.0), (false, 1e-7)].iter().cycle().take(9).enumerate()
        {
            let carrying = Carrying { truncation, ..CARRYING };
            // Now and then one after the other, also here.
            let were = at_once.step(mechanism, length, refined, &carrying, step != 4);
            assert_eq!(were, step != 4, "{name}, {vectors:?}");
            apart.step(mechanism, length, refined, &carrying, false);
            assert_eq!(at_once.now(), apart.now(), "{name}, {vectors:?}, step {step}");
        }
        let Both { states: [first, second], .. } = at_once.now();
        assert_ne!(first.position, second.position, "{name}, {vectors:?}: the motions part");
    }
}

#[test]
fn ends_of_a_run_and_its_companion_that_are_worked_out_at_once_have_the_bits_of_each_alone() {
    let (mechanism, state) = every_kind_of_body();
    are_the_same("every kind", &mechanism, &state, 0.02);
    for model in [models::chain(6), models::floating_tree(), models::spatial_pendulum()] {
        are_the_same(&model.mechanism.name, &model.mechanism, &model.state, 0.01);
    }
}

#[test]
fn and_so_they_have_beside_a_gimbal_lock_where_their_velocities_are_refined() {
    let (mechanism, state) = beside_lock(1e-5);
    are_the_same("gimbals", &mechanism, &state, 1e-7);
}

#[test]
fn a_step_of_both_that_is_thrown_away_leaves_nothing() {
    for (mechanism, state) in [every_kind_of_body(), beside_lock(1e-5)] {
        let length = if mechanism.bodies.len() > 4 { 0.02 } else { 1e-7 };
        let [mut thrown, mut straight] = [0, 1].map(|_| Motions::new(&mechanism, &state, (Isa::detect(), 9)));
        for motions in [&mut thrown, &mut straight] {
            motions.step(&mechanism, length, false, &CARRYING, true);
        }
        let states = thrown.states.clone();
        thrown.solve(&mechanism, 1.1 * length, false);
        let [state, beside] = &mut thrown.states;
        thrown.kernel.finish_both(&mechanism, state, beside, &CARRYING).expect("both");
        thrown.states = states;
        for _ in 0..3 {
            for motions in [&mut thrown, &mut straight] {
                motions.step(&mechanism, length, false, &CARRYING, true);
            }
            assert_eq!(thrown.now(), straight.now(), "{}", mechanism.name);
        }
    }
}

#[test]
fn one_free_body_and_what_moves_in_a_plane_end_one_after_the_other() {
    for model in [models::free_body(), models::planar_chain(3)] {
        let mut motions = Motions::new(&model.mechanism, &model.state, (Isa::detect(), 9));
        assert!(!motions.step(&model.mechanism, 0.01, false, &CARRYING, true), "{}", model.mechanism.name);
    }
}
