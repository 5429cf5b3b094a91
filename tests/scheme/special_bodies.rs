//! Bodies with equations of their own take the steps of the general ones, in every vector that a kernel is compiled for.

use catena::kernels::step_for;
use catena::lobatto::numbers::lanes::Isa;
use catena::lobatto::plan::tree::Plan;
use catena::lobatto::stages::attempt::{Attempt, Guess, StopRule};
use catena::lobatto::tableau::butcher::Tableau;
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::state::State;
use nalgebra::{Rotation3, Translation3, Vector3};

/// Instruction sets and numbers of stages that take every vector type on x86-64; elsewhere the first is taken for all.
pub(crate) const VECTORS: [(Isa, usize); 8] = [
    (Isa::Portable, 5),
    (Isa::Portable, 9),
    (Isa::Avx2, 3),
    (Isa::Avx2, 5),
    (Isa::Avx2, 9),
    (Isa::Avx2, 13),
    (Isa::Avx512, 9),
    (Isa::Avx512, 13),
];

/// Two bodies on the world, one of which carries another, on frames that are aligned with nothing.
fn two_trees() -> (Mechanism, State) {
    let body = |name: &str, parent, askew: f64| {
        let frame = |at: f64| {
            let turn = Rotation3::from_euler_angles(at, askew - 0.4 * at, 0.5 - askew);
            Pose::from_parts(Translation3::new(0.3 * at, -0.1, 0.4 * askew), turn)
        };
        let joint = Joint::new(name, JointKind::Revolute, frame(0.7), frame(-0.5));
        Body { name: name.into(), parent, mass: 1.0 + askew, inertia: Vector3::new(0.05, 0.08, 0.1), joint }
    };
    let bodies = vec![body("held", None, 0.9), body("carried", Some(0), 0.2), body("also held", None, 0.5)];
    let mechanism = Mechanism::new("two trees", Vector3::new(1.0, -2.0, -9.0), bodies).unwrap();
    let mut state = State::zero(&mechanism);
    state.position.copy_from_slice(&[0.4, -0.9, 2.0]);
    state.velocity.copy_from_slice(&[3.0, -2.0, 5.0]);
    (mechanism, state)
}

/// A body held by a frame that is neither at its centre of mass nor along its axes.
fn thrown() -> (Mechanism, State) {
    let frame = |at: f64| {
        let turn = Rotation3::from_euler_angles(at, 0.9 - 0.4 * at, -0.4);
        Pose::from_parts(Translation3::new(0.3 * at, -0.1, 0.4), turn)
    };
    let joint = Joint::new("thrown", JointKind::Floating, frame(0.7), frame(-0.5));
    let inertia = Vector3::new(0.05, 0.08, 0.1);
    let body = Body { name: "body".into(), parent: None, mass: 1.4, inertia, joint };
    let mechanism = Mechanism::new("thrown", Vector3::new(1.0, -2.0, -9.0), vec![body]).unwrap();
    let mut state = State::zero(&mechanism);
    state.velocity.copy_from_slice(&[1.0, -2.0, 3.0, 4.0, -5.0, 6.0]);
    (mechanism, state)
}

/// Displacements of all freedoms at all stages of a step of 0.05 s, and the velocities at its end.
fn step(mechanism: &Mechanism, state: &State, (isa, stages): (Isa, usize), kept: &[Rule]) -> Vec<f64> {
    let mut kernel = step_for(mechanism, Tableau::of(stages).unwrap(), isa, kept);
    kernel.begin(mechanism, state);
    let attempt = kernel.attempt(mechanism, 0.05, &StopRule::ROUNDING, Guess::Plain);
    assert!(matches!(attempt, Attempt::Converged { .. }), "{attempt:?}");
    let mut end = state.clone();
    kernel.finish(mechanism, &mut end);
    let mut numbers = Vec::new();
    let mut sums = vec![[0.0; 2]; mechanism.velocity_count];
    for stage in 0..stages - 1 {
        let mut unit = vec![0.0; stages - 1];
        unit[stage] = 1.0;
        kernel.weigh_displacements([&unit, &unit], &mut sums);
        numbers.extend(sums.iter().map(|sum| sum[0]));
    }
    numbers.extend(end.velocity);
    numbers
}

/// Steps with and without a rule, and how far they are apart.
fn apart((mechanism, state): (Mechanism, State), rule: Rule) -> Vec<f64> {
    let mut all = Vec::new();
    for vectors in VECTORS {
        let (with, without) = (step(&mechanism, &state, vectors, &[]), step(&mechanism, &state, vectors, &[rule]));
        for (index, (with, without)) in with.iter().zip(&without).enumerate() {
            // Some roundings of displacements of a quarter, which the mixing of stages magnifies by up to a hundred.
            assert!((with - without).abs() < 1e-13, "{vectors:?}, number {index}: {with} and {without}");
        }
        all.extend(with);
    }
    all
}

#[test]
fn a_body_that_the_world_holds_takes_the_step_of_its_six_equations_in_every_vector() {
    let (mechanism, state) = two_trees();
    let [one, six] = [&[][..], &[Rule::Pivots]].map(|kept| Plan::lean(&mechanism, kept));
    assert_eq!(one.bodies.iter().map(|body| body.pivot).collect::<Vec<_>>(), [Some(0), None, Some(1)]);
    assert!(six.bodies.iter().all(|body| body.pivot.is_none()));
    // What there is to be told apart.
    assert!(apart((mechanism, state), Rule::Pivots).iter().all(|one| one.abs() > 1e-8));
}

#[test]
fn a_body_that_floats_freely_takes_the_step_of_its_six_equations_in_every_vector() {
    let (mechanism, state) = thrown();
    let [three, six] = [&[][..], &[Rule::Tumblers]].map(|kept| Plan::lean(&mechanism, kept));
    assert!(three.tumbles && !six.tumbles);
    // What there is to be told apart: within a step the body turns by 25 degrees, and gravity moves it by a centimetre.
    assert!(apart((mechanism, state), Rule::Tumblers).iter().any(|number| number.abs() > 0.2));
}
