//! What joints carry along their axes is what motors, friction and limits exert.

use crate::mechanisms::{
    GRAVITY, at_rest, double_pendulum, fixed, friction, hinge, limit, mechanism, motor, pendulum, run, slide,
};
use catena::instant::exerting::reactions::Reactions;
use catena::instant::exerting::snapshots::View;
use catena::lobatto::instants::snapshot::{Instants, Snapshots};
use catena::mechanism::description::closure::{Attachment, LoopJoint, LoopKind};
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::nonsmooth::MotorLaw;
use catena::mechanism::description::target::Target;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use nalgebra::Vector3;

/// What the joints carry along their axes, under these efforts of motors.
fn along_axes(mechanism: &Mechanism, state: &State, motors: &[f64]) -> Vec<f64> {
    let mut view = View::new(mechanism, &[]);
    view.drive(motors);
    let mut out = Snapshots::new(mechanism, 0);
    view.look(&state.position, &state.velocity, 1, &mut out);
    out.efforts.iter().map(|row| row[0]).collect()
}

/// The accelerations of the joints that follow from the wrenches: those of a mechanism in which they are forces of joints.
fn accelerations(mechanism: &Mechanism, state: &State, efforts: &[f64]) -> Vec<f64> {
    let mut plain = mechanism.clone();
    plain.nonsmooth = Default::default();
    plain.forces.driven = true;
    let mut ode = catena::reduced::ReducedOde::new(&plain);
    ode.drive(catena::mechanism::motion::inputs::Inputs::constant(efforts));
    let mut out = vec![0.0; mechanism.velocity_count];
    ode.accelerations_of_placed(&state.position, &state.velocity, &body_states(mechanism, state), &mut out);
    out
}

#[test]
fn friction_that_holds_a_pendulum_carries_its_weight() {
    let mut held = pendulum();
    friction(&mut held, 0, 9.0);
    for angle in [-0.9, 0.1, 0.5, 1.1] {
        let carried = along_axes(&held, &at_rest(&held, &[angle]), &[])[0];
        let weight = 2.0 * GRAVITY * 0.5 * angle.sin();
        assert!((carried - weight).abs() < 1e-14, "{carried} and not {weight}");
    }
    // Beyond what friction can hold it carries the friction, and the pendulum accelerates.
    assert!((along_axes(&held, &at_rest(&held, &[1.3]), &[])[0] - 9.0).abs() < 1e-14);
}

#[test]
fn a_limit_carries_the_weight_of_what_rests_on_it_and_nothing_of_what_leaves_it() {
    let mut resting = pendulum();
    limit(&mut resting, 0, 0.4, 1.0, 0.5);
    let weight = 2.0 * GRAVITY * 0.5 * 0.4_f64.sin();
    assert!((along_axes(&resting, &at_rest(&resting, &[0.4]), &[])[0] - weight).abs() < 1e-14);
    assert!(along_axes(&resting, &at_rest(&resting, &[0.6]), &[])[0].abs() < 1e-14);
    let mut falling = pendulum();
    limit(&mut falling, 0, -1.0, 0.4, 0.5);
    assert!(along_axes(&falling, &at_rest(&falling, &[0.4]), &[])[0].abs() < 1e-14);
}

#[test]
fn sliding_friction_acts_against_the_rate_whatever_else_moves() {
    let mut arm = double_pendulum(0.0);
    (arm.nonsmooth.limits).clear();
    friction(&mut arm, 0, 0.7);
    friction(&mut arm, 1, 0.2);
    let mut state = at_rest(&arm, &[0.3, 0.8]);
    state.velocity.copy_from_slice(&[1.5, -2.0]);
    let carried = along_axes(&arm, &state, &[]);
    assert!((carried[0] + 0.7).abs() < 1e-13 && (carried[1] - 0.2).abs() < 1e-13, "{carried:?}");
}

#[test]
fn a_slide_on_a_slope_is_held_by_a_force() {
    let axis = Vector3::new(1.0, 0.0, 0.5).normalize();
    let mut block = mechanism(vec![slide("rail", axis, 3.0)]);
    friction(&mut block, 0, 20.0);
    let carried = along_axes(&block, &at_rest(&block, &[0.2]), &[])[0];
    assert!((carried - 3.0 * GRAVITY * axis.z).abs() < 1e-13, "{carried}");
}

#[test]
fn a_joint_that_slides_and_one_that_is_held_share_one_motion() {
    let mut arm = double_pendulum(0.0);
    arm.nonsmooth.limits.clear();
    friction(&mut arm, 0, 0.3);
    friction(&mut arm, 1, 50.0);
    let mut state = at_rest(&arm, &[0.7, 0.4]);
    state.velocity[0] = 2.0;
    let carried = along_axes(&arm, &state, &[]);
    assert!((carried[0] + 0.3).abs() < 1e-13, "{carried:?}");
    let accelerations = accelerations(&arm, &state, &carried);
    assert!(accelerations[1].abs() < 1e-12 && accelerations[0].abs() > 1.0, "{accelerations:?}");
}

#[test]
fn motors_in_their_steady_state_carry_the_weight_of_the_arm() {
    let mut arm = double_pendulum(0.0);
    arm.nonsmooth.limits.clear();
    let targets = [0.9, -0.4];
    for (body, target) in targets.into_iter().enumerate() {
        let law = MotorLaw::Position { kp: 300.0, kd: 30.0 };
        motor(&mut arm, body, law, Target::constant(target), f64::INFINITY, 0.0);
    }
    let finished = run(&arm, &at_rest(&arm, &targets), 4.0, fixed(3, 0.01));
    let state = finished.state;
    let efforts: Vec<f64> = arm
        .nonsmooth
        .motors
        .iter()
        .map(|motor| {
            motor.effort(
                state.time,
                state.position[motor.coordinate.position],
                state.velocity[motor.coordinate.freedom],
            )
        })
        .collect();
    let carried = along_axes(&arm, &state, &efforts);
    let (hip, knee) = (state.position[0], state.position[0] + state.position[1]);
    let lower = 0.8 * GRAVITY * 0.3 * knee.sin();
    let upper = 1.2 * GRAVITY * 0.25 * hip.sin() + 0.8 * GRAVITY * 0.6 * hip.sin() + lower;
    for ((carried, effort), weight) in carried.iter().zip(&efforts).zip([upper, lower]) {
        assert!((carried - effort).abs() < 1e-12, "{carried} and not the effort {effort}");
        assert!((carried - weight).abs() < 1e-9, "{carried} and not the weight {weight}");
    }
}

#[test]
fn the_accelerations_are_those_under_the_efforts_that_the_joints_carry() {
    // Newton and Euler backwards: what the axes carry, as efforts of a mechanism without friction and limits, makes the same motion.
    let mut count = 0_usize;
    for round in 0..60 {
        let number = |seed: usize| ((round * 37 + seed * 101) as f64 * 0.618_033_988_749_895).fract() * 2.0 - 1.0;
        let bodies = (0..5).map(|index: usize| {
            let at = Vector3::new(0.1, 0.0, -0.4);
            hinge(&format!("joint{index}"), index.checked_sub(1), at, 0.2 + 0.02 * index as f64, 1.0, 0.02)
        });
        let mut chain = mechanism(bodies.collect());
        for body in 0..5 {
            friction(&mut chain, body, 3.0 * (1.0 + number(body)));
        }
        limit(&mut chain, 2, number(12), 3.0, 0.0);
        let law = MotorLaw::Effort;
        motor(&mut chain, 1, law, Target::constant(2.0), f64::INFINITY, 0.0);
        let mut state = at_rest(&chain, &[number(10), number(11), number(12), number(13), number(14)]);
        for freedom in 0..5 {
            // Some are at rest.
            state.velocity[freedom] = if number(20 + freedom) > 0.3 { number(30 + freedom) } else { 0.0 };
        }
        let carried = along_axes(&chain, &state, &[2.0]);
        let moves = accelerations(&chain, &state, &carried);
        for freedom in 0..5 {
            let friction = chain.nonsmooth.friction[freedom].effort;
            let own = carried[freedom] - if freedom == 1 { 2.0 } else { 0.0 };
            let rate = state.velocity[freedom];
            let (low, high) = (-friction, if freedom == 2 { f64::INFINITY } else { friction });
            let case = format!("{round}, {freedom}: {own} of {low} to {high}, {rate}, {}", moves[freedom]);
            if rate != 0.0 {
                assert!((own + friction * rate.signum()).abs() < 1e-11, "{case}");
            } else if moves[freedom] > 1e-9 {
                assert!((own - low).abs() < 1e-11, "{case}");
            } else if moves[freedom] < -1e-9 {
                assert!((own - high).abs() < 1e-11, "{case}");
            } else {
                assert!(own > low - 1e-11 && own < high + 1e-11, "{case}");
                count += 1;
            }
        }
    }
    assert!(count > 50, "{count} held");
}

#[test]
fn a_four_bar_that_friction_holds_does_not_accelerate_and_carries_its_weight() {
    // Two hinges on the ground 1 m apart, a coupler between; closed by a point.
    let bodies = vec![
        hinge("left", None, Vector3::zeros(), 0.25, 1.0, 0.02),
        hinge("coupler", Some(0), Vector3::new(0.0, 0.0, -0.25), 0.5, 1.5, 0.1),
        hinge("right", None, Vector3::new(-1.0, 0.0, 0.0), 0.25, 1.0, 0.02),
    ];
    let mut four_bar = mechanism(bodies);
    let end = |body, z| Attachment { body: Some(body), frame: Pose::translation(0.0, 0.0, z) };
    four_bar.loops.push(LoopJoint {
        name: "closure".into(),
        kind: LoopKind::Spherical,
        a: end(1, -0.5),
        b: end(2, -0.25),
    });
    for body in 0..3 {
        friction(&mut four_bar, body, 15.0);
    }
    // The left crank and the right one turn together, the coupler stays level.
    let angle = 0.6;
    let state = at_rest(&four_bar, &[angle, std::f64::consts::FRAC_PI_2 - angle, angle]);
    let mut reactions = Reactions::new(&four_bar);
    let bodies = body_states(&four_bar, &state);
    let (carried, _) = reactions.of_placed(&state.position, &state.velocity, &bodies);
    let torques: Vec<f64> = carried.iter().map(|reaction| reaction.torque.y).collect();
    // Virtual work of a turn of the cranks: the coupler moves with them, and turns back against the left one.
    let work = torques[0] - torques[1] + torques[2];
    let weight = GRAVITY * angle.sin() * (0.25 + 0.25 + 1.5 * 0.5);
    assert!((work - weight).abs() < 1e-12, "{work} and not {weight}: {torques:?}");
    assert!(torques.iter().all(|torque| torque.abs() <= 15.0));
}
