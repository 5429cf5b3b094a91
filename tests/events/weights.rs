//! Motors with `gravity_compensation`: the effort besides their law holds the weight beyond the joint, in every pose, at every stage of a step.

use crate::common::{run_until, scratch};
use crate::scene_files::{joint, report, scene_of};
use catena::mechanism::description::forces::GravityCompensation;
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::prelude::{Error, Model, Simulation};
use catena::reduced::Dop853;
use catena::stepping::integrator::Lobatto;
use nalgebra::{Rotation3, Translation3, Vector3};
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// An arm in space: two hinges with other axes, and a hand that slides; with these tables.
fn arm(folder: &Path, name: &str, more: &str) -> PathBuf {
    let link = |name: &str, at: &str, mass: f64| {
        format!(
            "<link name='{name}'><inertial><origin xyz='{at}'/><mass value='{mass}'/><inertia ixx='0.02' iyy='0.03' izz='0.01' ixy='0' \
             ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let joint = |index: usize, kind: &str, parent: &str, axis: &str, at: &str| {
        format!(
            "<joint name='j{index}' type='{kind}'><parent link='{parent}'/><child link='l{index}'/><origin xyz='{at}'/><axis xyz='{axis}'/>\
             <limit lower='-inf' upper='inf' effort='inf' velocity='inf'/></joint>"
        )
    };
    let urdf = [
        "<robot name='r'><link name='base'/>".to_string(),
        link("l0", "0.1 0.05 0.2", 2.0),
        link("l1", "0.3 0 -0.02", 1.0),
        link("l2", "0.05 0 0", 0.4),
        joint(0, "revolute", "base", "1 0.2 0.1", "0 0 1"),
        joint(1, "revolute", "l0", "0 1 0", "0.1 0 0.4"),
        joint(2, "prismatic", "l1", "1 0 0.3", "0.5 0 0"),
        "</robot>".to_string(),
    ];
    std::fs::write(folder.join("arm.urdf"), urdf.concat()).expect("a robot");
    let file = folder.join(format!("{name}.toml"));
    std::fs::write(&file, format!("[[robot]]\nurdf = \"arm.urdf\"\n{more}")).expect("a scene");
    file
}

/// Motors in all joints that go to their targets within a second or two.
fn motors(held: &str) -> String {
    let motor = |index: usize, target: f64, kp: f64, kd: f64| {
        format!(
            "[[motor]]\njoint = \"j{index}\"\nkind = \"position\"\ntarget = {target}\nkp = {kp}\nkd = {kd}\n{held}\n"
        )
    };
    motor(0, 0.7, 60.0, 12.0) + &motor(1, -0.4, 40.0, 5.0) + &motor(2, 0.2, 90.0, 12.0)
}

const TARGETS: [f64; 3] = [0.7, -0.4, 0.2];

#[test]
fn an_arm_comes_to_stand_at_its_targets_exactly_and_without_the_weights_held_sags_as_statics_says() {
    let folder = scratch("weights_stand");
    let file = arm(&folder, "held", &motors("gravity_compensation = true"));
    let model = Model::load(&file).expect("a model");
    let mut simulation = Simulation::new(&model).duration(20.0).fixed(6, 0.02);
    simulation.run().expect("to the end");
    let held = simulation.finish().expect("a report");
    for (index, target) in TARGETS.iter().enumerate() {
        let (position, rate) = joint(&held, &format!("j{index}"));
        // The slowest of the three has a rate of 1.5 /s or more: e⁻³⁰ of a radian is left.
        assert!((position - target).abs() < 1e-12 && rate.abs() < 1e-12, "j{index}: {position}, {rate}");
    }
    let file = arm(&folder, "free", &motors(""));
    let free = report(&file, &[], &[], Some(40.0), 1e-9);
    let model = Model::load(&file).expect("a model");
    let rest: Vec<f64> = (0..3).map(|index| joint(&free, &format!("j{index}")).0).collect();
    let weights = model.gravity_efforts(&rest).expect("efforts");
    for (index, kp) in [60.0, 40.0, 90.0].into_iter().enumerate() {
        let sag = TARGETS[index] - rest[index];
        assert!(sag.abs() > 1e-3, "j{index} does not sag");
        // kp (r − q) holds the weight, up to kp times the tolerance.
        assert!((kp * sag - weights[index]).abs() < 1e-8, "j{index}: {} and {}", kp * sag, weights[index]);
    }
    // Half of the weight: half of the effort is left to the motor.
    let half = report(&arm(&folder, "half", &motors("gravity_compensation = 0.5")), &[], &[], Some(40.0), 1e-9);
    let rest: Vec<f64> = (0..3).map(|index| joint(&half, &format!("j{index}")).0).collect();
    let weights = model.gravity_efforts(&rest).expect("efforts");
    for (index, kp) in [60.0, 40.0, 90.0].into_iter().enumerate() {
        assert!((kp * (TARGETS[index] - rest[index]) - 0.5 * weights[index]).abs() < 1e-8, "j{index}");
    }
}

#[test]
fn the_work_of_held_weights_is_accounted_for_on_the_way() {
    let folder = scratch("weights_energy");
    for (name, held) in [("all", "gravity_compensation = true"), ("none", "")] {
        let end = report(&arm(&folder, name, &motors(held)), &[], &[], Some(0.6), 1e-11);
        // The tolerance leaves 1e-11 of the energies.
        assert!(end.energy.max_relative_error < 1e-10, "{name}: {:?}", end.energy);
    }
}

/// A body with a joint at `at` of its parent; its centre of mass is at `arm` from the joint.
fn body(parent: Option<usize>, kind: JointKind, at: Vector3<f64>, axis: Vector3<f64>, arm: Vector3<f64>) -> Body {
    let turn = Rotation3::rotation_between(&Vector3::z(), &axis).expect("not opposite");
    let frame = |at: Vector3<f64>| Pose::from_parts(Translation3::from(at), turn);
    let name = format!("{kind:?}{parent:?}");
    let joint = Joint::new(&name, kind, frame(at), frame(-arm));
    Body { name, parent, mass: 1.3, inertia: Vector3::new(0.03, 0.05, 0.04), joint }
}

/// In a plane: two hinges, one about −y, and a slide. In space: hinges with three axes and a slide. On a free base: an arm.
fn mechanisms() -> Vec<Mechanism> {
    let gravity = Vector3::new(1.0, 0.0, -9.0);
    let (y, x) = (Vector3::y(), Vector3::x());
    let hinge = JointKind::Revolute;
    let arm = Vector3::new(0.2, 0.0, -0.3);
    let across = |parent, axis| body(parent, hinge, Vector3::new(0.4, 0.1, 0.2), axis, Vector3::new(0.1, 0.2, 0.3));
    let flat = vec![
        body(None, hinge, Vector3::zeros(), y, arm),
        body(Some(0), hinge, arm, -y, arm),
        body(Some(1), JointKind::Prismatic, arm, x + Vector3::z(), arm),
    ];
    let leaning = vec![
        across(None, y),
        across(Some(0), x + y),
        body(Some(1), JointKind::Prismatic, arm, x + Vector3::z(), arm),
        across(Some(2), x - y),
    ];
    let free =
        vec![body(None, JointKind::Floating, Vector3::zeros(), Vector3::z(), Vector3::zeros()), across(Some(0), y)];
    [("flat", flat), ("leaning", leaning), ("free", free)]
        .map(|(name, bodies)| Mechanism::new(name, gravity, bodies).expect("depth first"))
        .into()
}

#[test]
fn steps_hold_weights_as_an_integrator_in_joint_coordinates_does() {
    for mut mechanism in mechanisms() {
        let mut start = State::zero(&mechanism);
        for (index, rate) in start.velocity.iter_mut().enumerate() {
            *rate = 0.4 - 0.3 * index as f64;
        }
        let floating = mechanism.bodies[0].joint.kind == JointKind::Floating;
        // Not in all joints, so that the efforts have no potential.
        let freedoms: &[usize] = if floating { &[6] } else { &[0, 2] };
        let held = freedoms.iter().map(|&freedom| GravityCompensation { freedom, factor: 0.8 });
        mechanism.forces.gravity_compensations = held.collect();
        let (mut ours, mut theirs, mut bare) = (start.clone(), start.clone(), start.clone());
        let summary = run_until(&mechanism, &mut ours, &mut Lobatto::fixed(&mechanism, 9, 0.02).expect("steps"), 0.8);
        run_until(&mechanism, &mut theirs, &mut Dop853::new(&mechanism, 1e-13), 0.8);
        mechanism.forces.gravity_compensations.clear();
        run_until(&mechanism, &mut bare, &mut Dop853::new(&mechanism, 1e-13), 0.8);
        let off = |other: &State| {
            let apart = |(a, b): (&f64, &f64)| (a - b).abs();
            ours.position.iter().zip(&other.position).map(apart).fold(0.0, f64::max)
        };
        println!("{}: {:.1e}, without {:.1e}", mechanism.name, off(&theirs), off(&bare));
        // Both have 1e-13 and some magnification.
        assert!(off(&theirs) < 1e-11 && off(&bare) > 1e-2, "{}", mechanism.name);
        assert!(summary.max_relative_energy_error < 1e-11, "{}: {summary:?}", mechanism.name);
    }
}

#[test]
fn the_held_weight_is_minus_the_generalised_force_of_gravity() {
    let file = arm(&scratch("weights_effort"), "arm", "");
    let model = Model::load(&file).expect("a model");
    let wanted = model.gravity_efforts(&[0.3, 0.8, -0.2]).expect("efforts");
    let mechanism = &model.description().mechanism;
    let mut state = State::zero(mechanism);
    state.position.copy_from_slice(&[0.3, 0.8, -0.2]);
    let bodies = body_states(mechanism, &state);
    for freedom in 0..3 {
        let effort = GravityCompensation { freedom, factor: 1.0 }.effort(mechanism, &bodies);
        // A few roundings of 20 N m.
        assert!((effort - wanted[freedom]).abs() < 1e-13, "{freedom}: {effort} and {}", wanted[freedom]);
    }
}

#[test]
fn a_weight_that_a_loop_carries_too_is_refused_with_the_line() {
    let rod = "[[loop]]\nname = \"rod\"\ntype = \"distance\"\na = { link = \"l2\", position = [0.1, 0, 0] }\n\
               b = { link = \"world\", position = [0.2, 0.9, 0.5] }\n";
    let file = arm(&scratch("weights_loop"), "arm", &(rod.to_string() + &motors("gravity_compensation = true")));
    let refused = Model::load(&file).err().map(|error: Error| error.to_string()).expect("refused");
    assert!(refused.contains(":9: motor on \"j0\": loop \"rod\" leads around joint \"j0\""), "{refused}");
    assert_eq!(refused.lines().count(), 1);
}

#[test]
fn the_key_path_switches_it_on() {
    let folder = scratch("weights_key");
    let (with, without) =
        (arm(&folder, "with", &motors("gravity_compensation = true")), arm(&folder, "free", &motors("")));
    let set = |index: usize| (format!("motor.j{index}.gravity_compensation"), 1.0);
    let mut loader = Model::loader();
    for (key, number) in (0..3).map(set) {
        loader = loader.set(&key, number);
    }
    let model = loader.load(&without).expect("a model");
    let compensations = &model.description().mechanism.forces.gravity_compensations;
    assert_eq!(
        compensations,
        &Model::load(&with).expect("a model").description().mechanism.forces.gravity_compensations
    );
    assert_eq!(compensations.len(), 3);
}

/// An arm of three hinges, askew, which starts on their lower limits; motors hold it there with its weight.
fn arm_on_limits(folder: &str, seed: u32, more: &str) -> PathBuf {
    let mut angle = f64::from(seed);
    let mut number = |size: f64| {
        angle += 1.7;
        format!("{:.3}", size * angle.sin())
    };
    let mut robot = "<link name='l0'/>".to_string();
    for link in 1..=3 {
        let [at, origin, axis] = [0.2, 0.3, 1.0].map(|size| [(); 3].map(|()| number(size)).join(" "));
        let parent = link - 1;
        write!(
            robot,
            "<link name='l{link}'><inertial><origin xyz='{at}'/><mass value='0.9'/><inertia ixx='0.0025' iyy='0.0022' izz='0.0028' ixy='0' \
             ixz='0' iyz='0'/></inertial></link><joint name='j{link}' type='revolute'><parent link='l{parent}'/><child link='l{link}'/>\
             <origin xyz='{origin}'/><axis xyz='{axis}'/><limit lower='0' upper='1.7' effort='500' velocity='10'/></joint>"
        )
        .expect("text");
    }
    let motor = "[[motor]]\njoint = \"*\"\nkind = \"position\"\ntarget = \"start\"\nkp = 100\nkd = 10\ngravity_compensation = 1\n";
    scene_of(folder, &robot, &format!("[[robot]]\nurdf = \"robot.urdf\"\n{motor}{more}"))
}

#[test]
fn limits_that_carry_roundings_of_held_weights_neither_let_go_nor_come_to_rest_again() {
    for seed in 0..8 {
        let ended = report(&arm_on_limits(&format!("weights_limits_{seed}"), seed, ""), &[], &[], Some(10.0), 1e-6);
        // Some had tens of thousands.
        assert_eq!((ended.events.list.len(), ended.steps), (0, 1), "arm {seed}");
        // A pull of 1 N m lets go, and ends where the spring of 100 N m/rad holds it, after ten times its time constant.
        let pulled = "[[load]]\njoint = \"j3\"\neffort = 1\n";
        let ended = report(&arm_on_limits(&format!("weights_pulled_{seed}"), seed, pulled), &[], &[], Some(1.0), 1e-6);
        let (angle, _) = joint(&ended, "j3");
        assert!((angle - 0.01).abs() <= 1e-5, "arm {seed}: {angle}");
    }
}
