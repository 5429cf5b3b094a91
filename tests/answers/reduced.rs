//! What the comparator in joint coordinates claims: right accelerations, right reactions, right orders, and agreement
//! with published and independently computed motions.

#![allow(clippy::excessive_precision)] // Reference values stand as their sources print them.

use catena::invariants::momentum;
use catena::kinematics::{WORLD, body_states, forward_kinematics};
use catena::model::joint::rotation_from_wxyz;
use catena::model::{Body, FreeRotation, Joint, JointKind, Mechanism, Pose};
use catena::reduced::{ArticulatedBody, Dop853, Euler, Rk4, joint_reactions};
use catena::simulation::{Integrator, RunOptions, StepError, Summary, run};
use catena::state::State;
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Translation3, UnitQuaternion, Vector3};

const GRAVITY: f64 = 9.81;

fn pose(translation: [f64; 3], rotation_vector: [f64; 3]) -> Pose {
    Pose::from_parts(Translation3::from(Vector3::from(translation)), Rotation3::new(Vector3::from(rotation_vector)))
}

fn body(index: usize, parent: Option<usize>, mass: f64, inertia: [f64; 3], joint: (JointKind, Pose, Pose)) -> Body {
    let (kind, on_parent, on_child) = joint;
    Body {
        name: format!("body{index}"),
        parent,
        mass,
        inertia: inertia.into(),
        joint: Joint::new(&format!("joint{index}"), kind, on_parent, on_child),
    }
}

/// Numbers in (−1, 1) that look random and are the same on every machine.
struct Scatter(u64);

impl Scatter {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self) -> [f64; 3] {
        [self.next(), self.next(), self.next()]
    }

    fn pose(&mut self) -> Pose {
        pose(self.vector(), self.vector().map(|angle| 2.0 * angle))
    }
}

/// A tree with oblique joint frames: `kinds` gives the parent, the joint and whether the body has mass.
fn oblique_tree(kinds: &[(Option<usize>, JointKind, bool)]) -> Mechanism {
    let mut scatter = Scatter(7);
    let bodies = kinds.iter().enumerate().map(|(index, &(parent, kind, massive))| {
        let size = if massive { 1.0 } else { 0.0 };
        let mass = size * (1.2 + scatter.next());
        let inertia = scatter.vector().map(|value| size * (0.4 + 0.1 * value));
        body(index, parent, mass, inertia, (kind, scatter.pose(), scatter.pose()))
    });
    Mechanism::new("oblique tree", Vector3::new(0.3, -1.0, -9.7), bodies.collect()).expect("depth first")
}

fn scattered_state(mechanism: &Mechanism) -> State {
    let mut scatter = Scatter(11);
    let mut state = State::zero(mechanism);
    let increment: Vec<f64> = (0..mechanism.velocity_count).map(|_| scatter.next()).collect();
    state.displace(mechanism, &increment);
    state.velocity.iter_mut().for_each(|rate| *rate = 2.0 * scatter.next());
    state
}

/// Every joint kind on the world, and a branching tree with every kind inside, one body of it without mass.
fn every_kind() -> Vec<Mechanism> {
    use JointKind::{Floating, Planar, Prismatic, Revolute, Spherical};
    let mut mechanisms: Vec<Mechanism> = [Revolute, Prismatic, Planar, Spherical, Floating]
        .iter()
        .map(|&kind| oblique_tree(&[(None, kind, true), (Some(0), Revolute, true)]))
        .collect();
    mechanisms.push(oblique_tree(&[
        (None, Floating, true),
        (Some(0), Revolute, true),
        (Some(1), Spherical, true),
        (Some(1), Revolute, false),
        (Some(3), Planar, true),
        (Some(4), Prismatic, true),
        (Some(3), Revolute, true),
        (Some(0), Prismatic, true),
        (Some(7), Floating, true),
        (None, Revolute, true),
        (Some(9), Revolute, true),
        (Some(9), Spherical, true),
    ]));
    mechanisms
}

fn accelerations(mechanism: &Mechanism, state: &State, joint_force: Option<&[f64]>) -> Vec<f64> {
    let mut acceleration = vec![0.0; mechanism.velocity_count];
    ArticulatedBody::new(mechanism).accelerations(&state.position, &state.velocity, joint_force, &mut acceleration);
    acceleration
}

/// The joint forces for given joint accelerations: each joint's reaction on its own free directions.
fn joint_forces(mechanism: &Mechanism, state: &State, acceleration: &[f64]) -> Vec<f64> {
    let reactions = joint_reactions(mechanism, &state.position, &state.velocity, acceleration);
    let bodies = body_states(mechanism, state);
    let mut forces = Vec::new();
    for (index, (body, reaction)) in mechanism.bodies.iter().zip(reactions).enumerate() {
        let parent = body.parent.map_or(WORLD, |parent| bodies[parent]);
        let on_parent = parent.rotation * body.joint.on_parent.rotation.matrix();
        let on_child = bodies[index].rotation * body.joint.on_child.rotation.matrix();
        forces
            .extend(body.joint.kind.translation_axes().iter().map(|&axis| on_parent.column(axis).dot(&reaction.force)));
        let turns = match body.joint.kind.rotation() {
            FreeRotation::None => 0..0,
            FreeRotation::AboutZ => 2..3,
            FreeRotation::Ball => 0..3,
        };
        forces.extend(turns.map(|axis| on_child.column(axis).dot(&reaction.torque)));
    }
    forces
}

/// M(q) = Σ m Jᵀ J + Jωᵀ R J Rᵀ Jω with Jacobians column by column: the bodies' velocities at unit joint velocities.
fn mass_matrix(mechanism: &Mechanism, state: &State) -> DMatrix<f64> {
    let (count, degrees) = (mechanism.bodies.len(), mechanism.velocity_count);
    let mut root_mass_jacobian = DMatrix::zeros(6 * count, degrees);
    let mut bodies = vec![WORLD; count];
    for column in 0..degrees {
        let mut unit = vec![0.0; degrees];
        unit[column] = 1.0;
        forward_kinematics(mechanism, &state.position, &unit, &mut bodies);
        for (index, (body, moving)) in mechanism.bodies.iter().zip(&bodies).enumerate() {
            let spin = moving.rotation.transpose() * moving.angular_velocity;
            for axis in 0..3 {
                root_mass_jacobian[(6 * index + axis, column)] = body.mass.sqrt() * moving.velocity[axis];
                root_mass_jacobian[(6 * index + 3 + axis, column)] = body.inertia[axis].sqrt() * spin[axis];
            }
        }
    }
    root_mass_jacobian.transpose() * root_mass_jacobian
}

#[test]
fn accelerations_equal_the_dense_mass_matrix_solution_for_every_joint_kind() {
    for mechanism in every_kind() {
        let state = scattered_state(&mechanism);
        let mut scatter = Scatter(23);
        let applied: Vec<f64> = (0..mechanism.velocity_count).map(|_| 5.0 * scatter.next()).collect();
        let nothing = vec![0.0; mechanism.velocity_count];
        let bias = DVector::from_vec(joint_forces(&mechanism, &state, &nothing));
        let mass = mass_matrix(&mechanism, &state);
        for force in [None, Some(&applied[..])] {
            let pushed = DVector::from_row_slice(force.unwrap_or(&nothing)) - &bias;
            let expected = mass.clone().cholesky().expect("positive definite").solve(&pushed);
            let found = DVector::from_vec(accelerations(&mechanism, &state, force));
            // Both lose a few digits to the condition of M, below 1e3 in these trees.
            let error = (&found - &expected).amax() / expected.amax();
            assert!(error < 1e-12, "{}: {error:e}", mechanism.bodies[0].joint.kind.name());
        }
    }
}

#[test]
fn reactions_leave_the_free_directions_free() {
    for mechanism in every_kind() {
        let state = scattered_state(&mechanism);
        let acceleration = accelerations(&mechanism, &state, None);
        let largest = joint_forces(&mechanism, &state, &acceleration).iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        // The reactions themselves are tens of newtons: this is their rounding.
        assert!(largest < 1e-11, "{largest:e}");
    }
}

#[test]
fn reactions_change_the_momentum_as_newton_and_euler_say() {
    for mechanism in every_kind() {
        let state = scattered_state(&mechanism);
        let acceleration = accelerations(&mechanism, &state, None);
        // Momentum about the world origin a time δ away on the parabola of the motion, whose error is of order δ³.
        let later = |delta: f64| {
            let mut moved = state.clone();
            let rates = state.velocity.iter().zip(&acceleration);
            let increment: Vec<f64> = rates.map(|(v, a)| delta * v + 0.5 * delta * delta * a).collect();
            moved.displace(&mechanism, &increment);
            moved.velocity.iter_mut().zip(&acceleration).for_each(|(v, a)| *v += delta * a);
            momentum(&mechanism, &body_states(&mechanism, &moved))
        };
        let rate = |delta: f64| {
            let (after, before) = (later(delta), later(-delta));
            ((after.0 - before.0) / (2.0 * delta), (after.1 - before.1) / (2.0 * delta))
        };
        let (coarse, fine) = (rate(2e-3), rate(1e-3));
        let linear = (4.0 * fine.0 - coarse.0) / 3.0;
        let angular = (4.0 * fine.1 - coarse.1) / 3.0;
        let bodies = body_states(&mechanism, &state);
        let (mut force, mut torque) = (mechanism.gravity * mechanism.total_mass(), Vector3::zeros());
        for (body, moving) in mechanism.bodies.iter().zip(&bodies) {
            torque += moving.position.cross(&(mechanism.gravity * body.mass));
        }
        let reactions = joint_reactions(&mechanism, &state.position, &state.velocity, &acceleration);
        for (_, reaction) in mechanism.bodies.iter().zip(&reactions).filter(|(body, _)| body.parent.is_none()) {
            force += reaction.force;
            torque += reaction.torque + reaction.anchor.cross(&reaction.force);
        }
        // Extrapolated central differences: fourth order in 1e-3 with fifth derivatives of some 1e4 N s⁻⁴.
        assert!((linear - force).amax() < 1e-6, "force {:e}", (linear - force).amax());
        assert!((angular - torque).amax() < 1e-6, "torque {:e}", (angular - torque).amax());
    }
}

#[test]
fn a_chain_hanging_at_rest_carries_the_weight_below_each_joint() {
    let mechanism = chain(5, 2.0, 0.3, [0.01, 0.01, 0.001], |_| [1.0, 0.0, 0.0]);
    let state = State::zero(&mechanism);
    let acceleration = accelerations(&mechanism, &state, None);
    assert!(acceleration.iter().all(|value| value.abs() < 1e-13), "it is in equilibrium: {acceleration:?}");
    for (index, reaction) in
        joint_reactions(&mechanism, &state.position, &state.velocity, &acceleration).iter().enumerate()
    {
        let weight = 2.0 * (5 - index) as f64 * GRAVITY;
        assert!((reaction.force - Vector3::new(0.0, 0.0, weight)).amax() < 1e-12, "joint {index}: {reaction:?}");
        assert!(reaction.torque.amax() < 1e-12, "joint {index}: {reaction:?}");
        assert!((reaction.anchor.z + 0.3 * index as f64).abs() < 1e-14, "joint {index}: {reaction:?}");
    }
}

/// Equal links that hang along −z at zero displacement, each turning about `axis(index)`.
fn chain(count: usize, mass: f64, length: f64, inertia: [f64; 3], axis: impl Fn(usize) -> [f64; 3]) -> Mechanism {
    let bodies = (0..count).map(|index| {
        let turn = Rotation3::rotation_between(&Vector3::z(), &Vector3::from(axis(index))).expect("not antiparallel");
        let frame = |z: f64| Pose::from_parts(Translation3::new(0.0, 0.0, z), turn);
        let on_parent = frame(if index == 0 { 0.0 } else { -0.5 * length });
        body(index, index.checked_sub(1), mass, inertia, (JointKind::Revolute, on_parent, frame(0.5 * length)))
    });
    Mechanism::new("chain", Vector3::new(0.0, 0.0, -GRAVITY), bodies.collect()).expect("depth first")
}

fn integrate(mechanism: &Mechanism, state: &mut State, integrator: &mut dyn Integrator, duration: f64) -> Summary {
    let options = RunOptions { duration, rate: None, interrupt: None };
    let (summary, ended) = run(mechanism, state, integrator, &options, &mut []);
    ended.expect("the run reaches its end");
    summary
}

/// A double pendulum with crossed axes and a ball joint: every branch of the code, and no symmetry.
fn ball_pendulum() -> (Mechanism, State) {
    let mut mechanism =
        chain(3, 1.0, 1.0, [0.09, 0.07, 0.02], |i| if i == 0 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] });
    mechanism.bodies[1].joint.kind = JointKind::Spherical;
    let mechanism = Mechanism::new("ball pendulum", mechanism.gravity, mechanism.bodies).expect("same order");
    let mut state = State::zero(&mechanism);
    state.displace(&mechanism, &[1.2, 0.4, -0.3, 0.5, -0.7]);
    (mechanism, state)
}

/// Largest distance of the centres of mass from those of a reference.
fn distance(mechanism: &Mechanism, a: &State, b: &State) -> f64 {
    let pairs = body_states(mechanism, a).into_iter().zip(body_states(mechanism, b));
    pairs.map(|(a, b)| (a.position - b.position).norm()).fold(0.0, f64::max)
}

fn observed_order(
    (mechanism, start): (Mechanism, State),
    steps: [f64; 2],
    integrator: impl Fn(&Mechanism, f64) -> Box<dyn Integrator>,
) -> f64 {
    let mut reference = start.clone();
    integrate(&mechanism, &mut reference, &mut Dop853::new(&mechanism, 1e-14), 1.0);
    let errors = steps.map(|step| {
        let mut state = start.clone();
        integrate(&mechanism, &mut state, &mut *integrator(&mechanism, step), 1.0);
        distance(&mechanism, &state, &reference)
    });
    println!("steps {steps:?}: errors {errors:?}");
    (errors[0] / errors[1]).ln() / (steps[0] / steps[1]).ln()
}

#[test]
fn euler_has_order_one() {
    let order = observed_order(ball_pendulum(), [1e-3, 5e-4], |mechanism, step| Box::new(Euler::new(mechanism, step)));
    assert!((order - 1.0).abs() < 0.1, "{order}");
}

#[test]
fn rk4_has_order_four() {
    let order = observed_order(ball_pendulum(), [4e-3, 2e-3], |mechanism, step| Box::new(Rk4::new(mechanism, step)));
    assert!((order - 4.0).abs() < 0.2, "{order}");
}

#[test]
fn dop853_has_order_eight() {
    // Two rods with crossed axes: the light twist of the ball pendulum would need steps where rounding already shows.
    let mechanism = chain(2, 1.0, 1.0, [0.09, 0.09, 0.04], |i| if i == 0 { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] });
    let mut start = State::zero(&mechanism);
    start.position.copy_from_slice(&[1.2, -0.7]);
    let steps = [0.05, 0.025];
    let order =
        observed_order((mechanism, start), steps, |mechanism, step| Box::new(Dop853::with_fixed_step(mechanism, step)));
    // The errors are 2e-11 and 9e-14, the finer one with a tenth of rounding in it.
    assert!((order - 8.0).abs() < 0.5, "{order}");
}

#[test]
fn dop853_keeps_to_its_tolerance() {
    let (mechanism, start) = ball_pendulum();
    let mut reference = start.clone();
    integrate(&mechanism, &mut reference, &mut Dop853::new(&mechanism, 1e-14), 2.0);
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
        let mut state = start.clone();
        integrate(&mechanism, &mut state, &mut Dop853::new(&mechanism, tolerance), 2.0);
        let error = distance(&mechanism, &state, &reference);
        // Errors of many steps add up and this motion spreads them some hundredfold; a broken estimate is far off.
        assert!(error < 300.0 * tolerance && error > 1e-4 * tolerance, "tolerance {tolerance:e}: {error:e}");
    }
}

#[test]
fn dop853_at_the_tightest_tolerance_keeps_the_energy() {
    let (mechanism, mut state) = ball_pendulum();
    let summary = integrate(&mechanism, &mut state, &mut Dop853::new(&mechanism, 1e-13), 10.0);
    assert!(summary.max_relative_energy_error < 1e-11, "{:e}", summary.max_relative_energy_error);
    assert!(summary.max_violation.position < 1e-14, "joints hold by construction: {:?}", summary.max_violation);
}

#[test]
fn dense_output_of_dop853_is_as_good_as_its_steps() {
    let (mechanism, start) = ball_pendulum();
    let mut state = start.clone();
    let mut integrator = Dop853::with_fixed_step(&mechanism, 0.02);
    integrate(&mechanism, &mut state, &mut integrator, 0.5);
    for fraction in [0.0, 0.3, 0.7, 1.0] {
        let time = 0.48 + 0.02 * fraction;
        let mut inside = start.clone();
        integrator.dense(&mechanism, time, &mut inside.position, &mut inside.velocity);
        let mut reference = start.clone();
        integrate(&mechanism, &mut reference, &mut Dop853::new(&mechanism, 1e-14), time);
        // Order 7 in a step that makes 1e-10 itself; a cubic would be off by 1e-7.
        let error = distance(&mechanism, &inside, &reference);
        assert!(error < 1e-9, "position at {fraction} of the step: {error:e}");
        let velocities = inside.velocity.iter().zip(&reference.velocity);
        let worst = velocities.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-8, "velocity at {fraction} of the step: {worst:e}");
    }
}

#[test]
fn dense_output_of_the_fixed_step_methods_has_their_order() {
    let (mechanism, start) = ball_pendulum();
    let error = |integrator: &mut dyn Integrator, step: f64| {
        let mut state = start.clone();
        integrator.advance(&mechanism, &mut state, 1.0).expect("a step");
        let mut inside = start.clone();
        integrator.dense(&mechanism, 0.4 * step, &mut inside.position, &mut inside.velocity);
        let mut reference = start.clone();
        integrate(&mechanism, &mut reference, &mut Dop853::new(&mechanism, 1e-14), 0.4 * step);
        distance(&mechanism, &inside, &reference)
    };
    let ratio = |coarse: f64, fine: f64| (coarse / fine).log2();
    let rk4 = ratio(error(&mut Rk4::new(&mechanism, 0.04), 0.04), error(&mut Rk4::new(&mechanism, 0.02), 0.02));
    assert!(rk4 > 3.7, "inside a single step of order four: {rk4}");
    let euler = ratio(error(&mut Euler::new(&mechanism, 4e-3), 4e-3), error(&mut Euler::new(&mechanism, 2e-3), 2e-3));
    assert!(euler > 1.8, "inside a single step of order one: {euler}");
}

#[test]
fn every_integrator_lands_exactly_on_the_end() {
    let (mechanism, start) = ball_pendulum();
    let integrators: [Box<dyn Integrator>; 4] = [
        Box::new(Euler::new(&mechanism, 0.01)),
        Box::new(Rk4::new(&mechanism, 0.01)),
        Box::new(Dop853::new(&mechanism, 1e-8)),
        Box::new(Dop853::with_fixed_step(&mechanism, 0.01)),
    ];
    for mut integrator in integrators {
        let mut state = start.clone();
        let summary = integrate(&mechanism, &mut state, &mut *integrator, 0.3);
        assert_eq!(state.time, 0.3, "{:?}", integrator.description());
        if !integrator.description().adaptive {
            assert_eq!(summary.steps, 30, "no sliver of a step is left: {:?}", integrator.description());
        }
        let norm: f64 = state.joint_position(&mechanism, 1).iter().map(|c| c * c).sum();
        assert!((norm - 1.0).abs() < 4.0 * f64::EPSILON, "quaternions are of unit length: {norm}");
    }
}

#[test]
fn a_state_changed_between_steps_is_noticed() {
    let (mechanism, start) = ball_pendulum();
    let mut integrator = Dop853::new(&mechanism, 1e-10);
    let mut state = start.clone();
    integrator.advance(&mechanism, &mut state, 1.0).expect("a step");
    state = start.clone();
    state.velocity[0] = 1.0;
    let mut fresh = state.clone();
    integrate(&mechanism, &mut state, &mut integrator, 0.2);
    integrate(&mechanism, &mut fresh, &mut Dop853::new(&mechanism, 1e-10), 0.2);
    assert_eq!(state, fresh);
}

#[test]
fn failures_name_the_time_and_the_joint() {
    // A massless leaf has no acceleration.
    let mut mechanism = chain(2, 1.0, 1.0, [0.1, 0.1, 0.1], |_| [0.0, 1.0, 0.0]);
    mechanism.bodies[1].mass = 0.0;
    mechanism.bodies[1].inertia = Vector3::zeros();
    let integrators: [Box<dyn Integrator>; 3] = [
        Box::new(Euler::new(&mechanism, 0.01)),
        Box::new(Rk4::new(&mechanism, 0.01)),
        Box::new(Dop853::new(&mechanism, 1e-8)),
    ];
    for mut integrator in integrators {
        let mut state = State::zero(&mechanism);
        let before = state.clone();
        match integrator.advance(&mechanism, &mut state, 1.0) {
            Err(StepError::NotFinite { time, joint, .. }) => {
                assert!(time == 0.0 && joint == "joint1", "{time} {joint}");
            }
            other => panic!("{other:?}"),
        }
        assert_eq!(state, before, "the state stays that of the last accepted step");
    }
    // No step is short enough for a tolerance under the rounding of a double.
    let (mechanism, mut state) = ball_pendulum();
    let failure = Dop853::new(&mechanism, 1e-40).advance(&mechanism, &mut state, 1.0);
    assert!(matches!(failure, Err(StepError::NotConverged { time: 0.0, .. })), "{failure:?}");
}

/// IFToMM benchmark A01: a point of 1 kg on a massless metre, released level at (−1, 0); t, x, y, ẋ, ẏ.
#[test]
fn the_simple_pendulum_follows_the_table_of_the_iftomm_library() {
    let table = [
        (1.0, 0.98629175113187528, -0.16501085312554117, 0.29690551591631581, 1.7746436411126556),
        (2.0, -0.79356619534332173, -0.60848393044379157, -2.1024378744361258, 2.7419353930105093),
        (5.0, -0.9423054350437573, -0.3347543384140006, 0.85790425688594907, -2.4149286543704886),
        (9.99, -0.31643646991303231, -0.94861370457577654, 4.0924519914940207, -1.3651511202403046),
        (10.0, -0.27508746257611688, -0.96141920509912504, 4.1755981009517287, -1.1947490545604753),
    ];
    let joint = (JointKind::Revolute, Pose::identity(), pose([1.0, 0.0, 0.0], [0.0; 3]));
    let bodies = vec![body(0, None, 1.0, [0.0; 3], joint)];
    let mechanism = Mechanism::new("A01", Vector3::new(0.0, -GRAVITY, 0.0), bodies).expect("a pendulum");
    let mut state = State::zero(&mechanism);
    let mut integrator = Dop853::new(&mechanism, 1e-13);
    for (time, x, y, vx, vy) in table {
        let rest = time - state.time;
        integrate(&mechanism, &mut state, &mut integrator, rest);
        let tip = body_states(&mechanism, &state)[0];
        let error =
            (tip.position - Vector3::new(x, y, 0.0)).amax().max((tip.velocity - Vector3::new(vx, vy, 0.0)).amax());
        // The tolerance times the growth of phase errors over ten seconds; speeds reach 4.4 m/s.
        assert!(error < 1e-10, "t = {time}: {error:e}");
    }
}

/// The fast heavy top of Géradin and Cardona 2001; 150 rad/s, so 24 turns in the second that is compared.
#[test]
fn the_heavy_top_follows_its_reference() {
    let joint = (JointKind::Spherical, Pose::identity(), pose([0.0, -1.0, 0.0], [0.0; 3]));
    let bodies = vec![body(0, None, 15.0, [0.234375, 0.46875, 0.234375], joint)];
    let mechanism = Mechanism::new("heavy top", Vector3::new(0.0, 0.0, -GRAVITY), bodies).expect("a top");
    let fast = [
        (0.1, [0.42129665892540202, 0.89457197434559299, -0.14916470056189962]),
        (0.5, [-0.70246829705658564, -0.021165184701923325, -0.71140025765173442]),
        (1.0, [0.17334396409838604, 0.64008859207056878, -0.7484907911335813]),
    ];
    let slow = [
        (0.5, [0.0072227982418607084, 0.40584229862183535, -0.91391458016321325]),
        (1.0, [-0.03116864706262382, -0.9833836814196768, -0.17884364835735481]),
    ];
    let quaternion = [0.73294398067966371, -0.2782857193376127, 0.53182461133416259, -0.32017614273624928];
    for (rate, table) in [([0.0, 150.0, -4.61538], &fast[..]), ([0.0, 1.5, -0.0461538], &slow[..])] {
        let mut state = State::zero(&mechanism);
        state.velocity.copy_from_slice(&rate);
        let mut integrator = Dop853::new(&mechanism, 1e-13);
        for &(time, expected) in table {
            let rest = time - state.time;
            integrate(&mechanism, &mut state, &mut integrator, rest);
            let top = body_states(&mechanism, &state)[0];
            // Some 1e4 steps at 1e-13.
            assert!((top.position - Vector3::from(expected)).amax() < 1e-9, "{rate:?} at {time}: {}", top.position);
            let spin = (top.rotation.transpose() * top.angular_velocity).y;
            assert!((spin - rate[1]).abs() < 1e-9 * rate[1], "the spin of a symmetric top is constant: {spin}");
        }
        if rate[1] == 150.0 {
            let turned = body_states(&mechanism, &state)[0].rotation;
            assert!((turned - rotation_from_wxyz(&quaternion)).amax() < 1e-8, "{turned}");
        }
    }
}

/// The pendulum chains of ConstrainedDynamics.jl (WAFR 2020): straight, 45° from hanging, at rest; time, tip x, tip z.
#[test]
fn pendulum_chains_follow_their_references() {
    let slender = 1.0 / 12.0;
    let cylinder = 0.5 * (0.05 * 0.05 + 1.0 / 6.0);
    let table = [
        (1, slender, 10.0, 0.51702394091770754, -0.85597093672502855),
        (2, slender, 10.0, 1.0728298206051816, -1.640155336197975),
        (5, slender, 10.0, -3.1795454449721978, -3.7776517651265764),
        (10, slender, 1.0, 3.9378119839602022, -8.8552619087095543),
        (10, slender, 10.0, 4.5987504311334506, -8.4776573542354932),
        (2, cylinder, 3.0, 0.11532083836514852, -1.9954794058718262),
        (5, cylinder, 3.0, 0.71897703839699123, -4.9444562136688237),
    ];
    for (count, inertia, time, x, z) in table {
        let mechanism = chain(count, 1.0, 1.0, [inertia; 3], |_| [0.0, 1.0, 0.0]);
        let mut state = State::zero(&mechanism);
        // A positive angle about y swings −z towards −x.
        state.position[0] = -std::f64::consts::FRAC_PI_4;
        integrate(&mechanism, &mut state, &mut Dop853::new(&mechanism, 1e-13), time);
        let last = body_states(&mechanism, &state)[count - 1];
        let tip = last.position - last.rotation * Vector3::z() * 0.5;
        let error = (tip - Vector3::new(x, 0.0, z)).amax();
        // Errors grow at most sevenfold in ten seconds (same source), and lengths reach ten metres.
        assert!(error < 1e-9, "{count} links at {time} s: {error:e}");
    }
}

/// The free box of scpeters/benchmark, spinning near its intermediate axis while it falls.
#[test]
fn a_free_box_keeps_its_momentum_and_follows_its_reference() {
    let joint = (JointKind::Floating, Pose::identity(), Pose::identity());
    let inertia = [10.0 / 12.0 * (0.16 + 0.81), 10.0 / 12.0 * (0.01 + 0.81), 10.0 / 12.0 * (0.01 + 0.16)];
    let gravity = Vector3::new(0.0, 0.0, -9.8);
    let mechanism = Mechanism::new("box", gravity, vec![body(0, None, 10.0, inertia, joint)]).expect("a box");
    let mut state = State::zero(&mechanism);
    let thrown = Vector3::new(-2.0, 2.0, 8.0);
    state.velocity.copy_from_slice(&[thrown.x, thrown.y, thrown.z, 0.1, 5.0, 0.1]);
    let spin = |state: &State| {
        let moving = body_states(&mechanism, state)[0];
        momentum(&mechanism, &[moving]).1 - 10.0 * moving.position.cross(&moving.velocity)
    };
    let before = spin(&state);
    integrate(&mechanism, &mut state, &mut Dop853::new(&mechanism, 1e-13), 10.0);
    let expected = UnitQuaternion::new_normalize(nalgebra::Quaternion::new(
        0.22516456341395816,
        -0.61992756249945247,
        -0.27702915068719458,
        0.69874572364031018,
    ));
    let moving = body_states(&mechanism, &state)[0];
    let error = (moving.rotation - expected.to_rotation_matrix().matrix()).amax();
    // The unstable axis spreads errors over three flips in ten seconds.
    assert!(error < 1e-9, "attitude {error:e}");
    assert!(
        (spin(&state) - before).amax() < 1e-11,
        "angular momentum of 3.4 N m s: {:e}",
        (spin(&state) - before).amax()
    );
    let flight = thrown * 10.0 + gravity * 50.0;
    assert!((moving.position - flight).amax() < 1e-10, "the parabola reaches 410 m: {}", moving.position - flight);
}

/// Reads a scene of serial revolute links, as far as these tests need it: a world link and the tree below it.
fn scene(name: &str) -> Option<(Mechanism, State, serde_json::Value)> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/reference");
    let urdf = folder.join(format!("scenes/{name}.urdf"));
    let Ok(text) = std::fs::read_to_string(folder.join(format!("answers/{name}.json"))) else {
        println!("skipped: there is no reference data at {}", folder.display());
        return None;
    };
    let answer: serde_json::Value = serde_json::from_str(&text).expect("an answer in JSON");
    let robot = urdf_rs::read_file(urdf).expect("a scene in URDF");
    let link = |name: &str| robot.links.iter().find(|link| link.name == name).expect("a link of that name");
    // The principal frame of a link, seen from its own frame, and the principal moments.
    let principal = |name: &str| {
        let inertial = &link(name).inertial;
        let i = &inertial.inertia;
        let tensor = Matrix3::new(i.ixx, i.ixy, i.ixz, i.ixy, i.iyy, i.iyz, i.ixz, i.iyz, i.izz);
        let eigen = tensor.symmetric_eigen();
        let mut axes = eigen.eigenvectors;
        axes *= axes.determinant().signum();
        let r = inertial.origin.rpy.0;
        let rotation = Rotation3::from_euler_angles(r[0], r[1], r[2]) * Rotation3::from_matrix_unchecked(axes);
        let centre = Translation3::from(Vector3::from(inertial.origin.xyz.0));
        (Pose::from_parts(centre, rotation), eigen.eigenvalues, inertial.mass.value)
    };
    let bodies = robot.joints.iter().enumerate().map(|(index, joint)| {
        let parent = robot.joints.iter().position(|other| other.child.link == joint.parent.link);
        let r = joint.origin.rpy.0;
        let origin = Pose::from_parts(
            Translation3::from(Vector3::from(joint.origin.xyz.0)),
            Rotation3::from_euler_angles(r[0], r[1], r[2]),
        );
        let axis = Vector3::from(joint.axis.xyz.0);
        let turn = Rotation3::rotation_between(&Vector3::z(), &axis)
            .unwrap_or_else(|| Rotation3::new(Vector3::x() * std::f64::consts::PI));
        let turn = Pose::from_parts(Translation3::identity(), turn);
        let on_parent = match parent {
            Some(_) => principal(&joint.parent.link).0.inverse() * origin * turn,
            None => origin * turn,
        };
        let (frame, moments, mass) = principal(&joint.child.link);
        let mut body =
            body(index, parent, mass, moments.into(), (JointKind::Revolute, on_parent, frame.inverse() * turn));
        body.joint.name.clone_from(&joint.name);
        body
    });
    let gravity = Vector3::from_iterator(answer["gravity"].as_array()?.iter().filter_map(|value| value.as_f64()));
    let mechanism = Mechanism::new(name, gravity, bodies.collect()).expect("joints listed depth first");
    let mut state = State::zero(&mechanism);
    for body in &mechanism.bodies {
        let initial = &answer["initial"][&body.joint.name];
        state.position[body.joint.position_index] = initial["position"].as_f64()?;
        state.velocity[body.joint.velocity_index] = initial["velocity"].as_f64()?;
    }
    Some((mechanism, state, answer))
}

#[test]
fn scenes_end_where_three_independent_codes_end() {
    // Bounds: the arm is chaotic and the heavy tip weighs 1e4 links, which spread rounding errors to these lengths.
    for (name, bound) in
        [("pendulum3d_double_T3", 1e-11), ("arm7_T1", 1e-8), ("chain_10_T05", 1e-9), ("heavy_tip_T05", 1e-7)]
    {
        let Some((mechanism, mut state, answer)) = scene(name) else { return };
        let duration = answer["duration"].as_f64().expect("a duration");
        let summary = integrate(&mechanism, &mut state, &mut Dop853::new(&mechanism, 1e-13), duration);
        let last = answer["com"].as_array().and_then(|rows| rows.last()).expect("centres of mass");
        let mut worst = 0.0_f64;
        for (index, moving) in body_states(&mechanism, &state).iter().enumerate() {
            for axis in 0..3 {
                let expected = last[index][axis].as_f64().expect("a coordinate");
                worst = worst.max((moving.position[axis] - expected).abs());
            }
        }
        println!("{name}: {worst:.1e} m after {} steps, {} rejected", summary.steps, summary.rejected_steps);
        assert!(worst < bound, "{name}: {worst:e}");
    }
}
