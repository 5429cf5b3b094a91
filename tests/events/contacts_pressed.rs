//! Mechanisms that motors press against something: forces at rest against statics that share no code with them.

use crate::common::literal_link_poses;
use crate::exact::near;
use crate::mechanisms::GRAVITY;
use catena::instant::exerting::reactions::Reactions;
use catena::mechanism::description::nonsmooth::Motor;
use catena::mechanism::motion::contact_point::ContactPoint;
use catena::mechanism::motion::event::EventKind;
use catena::mechanism::motion::kinematics::body_states;
use catena::model::Model;
use catena::scene::{PackagePath, Robot, read_scene, read_urdf};
use catena::simulation::{Finished, Simulation, SimulationOptions, StepChoice};
use nalgebra::{IsometryMatrix3, Point3, SMatrix, SVector, Vector3};
use std::path::{Path, PathBuf};

fn robots() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("robots")
}

/// The model of a scene of `robots/` with this friction, and a run of it.
fn rests(name: &str, friction: f64, duration: f64, steps: StepChoice) -> (Model, Finished) {
    let scene = read_scene(&robots().join(format!("{name}.toml")), &PackagePath::default()).expect("a scene");
    let (mut model, start) = Model::from_scene(&scene).expect("a model");
    model.mechanism.nonsmooth.pairs.retain_mut(|pair| {
        pair.friction = friction;
        true
    });
    let start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
    let options = SimulationOptions::new(duration, steps);
    let mut simulation = Simulation::new(&model.mechanism, start, options).expect("a run");
    simulation.run().expect("to the end");
    let finished = simulation.finish();
    (model, finished)
}

/// What `robots/arm_presses_table.toml` says: motors, the height of the table (m), and the ball at the end of the last link (m).
const TARGETS: [f64; 7] = [0.3, 0.2, 0.2, 0.9, 0.3, 1.2, 0.4];
const STIFFNESS: f64 = 1000.0;
const TABLE: f64 = 0.05;
const BALL: (f64, f64) = (0.1, 0.0325);

/// The arm by the definition of URDF alone.
struct Arm(Robot);

/// At some positions: what motors and gravity exert on the joints [N m], the motion of the point that touches with each joint (m/rad), and its gap (m).
struct Statics {
    efforts: SVector<f64, 7>,
    motions: SMatrix<f64, 3, 7>,
    gap: f64,
}

impl Arm {
    fn read() -> Arm {
        Arm(read_urdf(&robots().join("arm7.urdf"), &PackagePath::default()).expect("an arm"))
    }

    fn statics(&self, positions: &SVector<f64, 7>) -> Statics {
        let named: Vec<_> = (0..7).map(|number| (format!("joint{}", number + 1), vec![positions[number]])).collect();
        let poses = literal_link_poses(&self.0, &IsometryMatrix3::identity(), &named);
        let link = |name: &str| self.0.links.iter().position(|link| link.name == name).expect("a link");
        let centre = poses[link("flange")] * Point3::new(0.0, 0.0, BALL.0);
        let touching = centre.coords - Vector3::z() * BALL.1;
        let mut statics = Statics { efforts: SVector::zeros(), motions: SMatrix::zeros(), gap: touching.z - TABLE };
        for (number, joint) in self.0.joints.iter().enumerate() {
            // The arm is a chain in the order of its links: all from this joint's child on are moved by it.
            let first = link(&joint.child);
            let (axis, anchor) = (poses[first] * joint.axis, poses[first].translation.vector);
            statics.efforts[number] = STIFFNESS * (TARGETS[number] - positions[number]);
            for (pose, link) in poses.iter().zip(&self.0.links).skip(first) {
                let Some(inertial) = &link.inertial else { continue };
                let arm = pose * Point3::from(inertial.origin.translation.vector) - Point3::from(anchor);
                let weight = Vector3::z() * (-inertial.mass * GRAVITY);
                statics.efforts[number] += axis.dot(&arm.cross(&weight));
            }
            statics.motions.set_column(number, &axis.cross(&(touching - anchor)));
        }
        statics
    }

    /// The positions (rad) and the force of the table (N) at which a ball without friction rests on it, by Newton's method: f(q) + λ Jᵀ n = 0, gap(q) = 0.
    fn pressed(&self) -> (SVector<f64, 7>, f64) {
        let residual = |unknown: &SVector<f64, 8>| {
            let statics = self.statics(&unknown.fixed_rows::<7>(0).into_owned());
            let mut residual = SVector::<f64, 8>::zeros();
            let carried = statics.efforts + statics.motions.row(2).transpose() * unknown[7];
            residual.fixed_rows_mut::<7>(0).copy_from(&carried);
            // In newtons and metres alike: the gap as the effort that a motor has for it.
            residual[7] = STIFFNESS * statics.gap;
            residual
        };
        let mut unknown = SVector::<f64, 8>::zeros();
        unknown.fixed_rows_mut::<7>(0).copy_from_slice(&TARGETS);
        for _ in 0..20 {
            let mut matrix = SMatrix::<f64, 8, 8>::zeros();
            for column in 0..8 {
                let nudge = SVector::<f64, 8>::ith(column, 1e-5);
                matrix.set_column(column, &((residual(&(unknown + nudge)) - residual(&(unknown - nudge))) / 2e-5));
            }
            unknown -= matrix.lu().solve(&residual(&unknown)).expect("a stiff arm");
        }
        let left = residual(&unknown).norm();
        assert!(left < 1e-11, "statics: {left:e} N m are left");
        (unknown.fixed_rows::<7>(0).into_owned(), unknown[7])
    }
}

#[test]
fn an_arm_presses_on_a_table_with_the_force_of_statics() {
    let (positions, force) = Arm::read().pressed();
    // With a tolerance it stops where its rates are below a tenth of it, at 20 rad/s; its motors answer 1e-9 rad with 1e-6 N m.
    let choices = [
        (StepChoice::Fixed { stages: 9, step: 5e-3 }, 1e-8, 1e-11),
        (StepChoice::Tolerance(1e-9), 1e-7, 1e-9),
        (StepChoice::Tolerance(1e-6), 1e-4, 1e-6),
    ];
    for (steps, allowed, apart) in choices {
        let (_, finished) = rests("arm_presses_table", 0.0, 6.0, steps);
        let [point] = finished.contacts[..] else { panic!("{:?}", finished.contacts) };
        println!("{steps:?}: force {} N, off by {:e}", point.force.norm(), point.force.norm() - force);
        near(point.force.dot(&point.normal).abs(), force, allowed);
        assert!((point.force - point.normal * point.normal.dot(&point.force)).norm() <= 1e-12, "{point:?}");
        assert!(point.gap.abs() <= 1e-15, "{point:?}");
        for (found, wanted) in finished.state.position.iter().zip(&positions) {
            near(*found, *wanted, apart);
        }
    }
}

#[test]
fn an_arm_that_friction_holds_on_a_table_is_in_balance() {
    let arm = Arm::read();
    let (_, finished) = rests("arm_presses_table", 0.5, 6.0, StepChoice::Tolerance(1e-9));
    let [point] = finished.contacts[..] else { panic!("{:?}", finished.contacts) };
    let statics = arm.statics(&SVector::from_column_slice(&finished.state.position));
    // Seven equations for the three components of the force.
    let force = (statics.motions * statics.motions.transpose()).try_inverse().expect("three directions")
        * statics.motions
        * -statics.efforts;
    let left = (statics.efforts + statics.motions.transpose() * force).norm();
    let off = (point.force * point.normal.z.signum() - force).norm();
    println!("{:?}: {left:e} N m are left, force off by {off:e} N", point);
    assert!(point.sticks && left <= 1e-8 && off <= 1e-8, "{left:e} N m, {off:e} N");
    assert!(point.cone_violation(0.5) <= 1e-10, "{point:?}");
}

#[test]
fn contacts_whose_forces_are_told_load_joints_and_loops_as_those_that_are_worked_out() {
    for (name, friction, duration) in [("arm_presses_table", 0.5, 6.0), ("four_bar_presses_box", 0.0, 2.0)] {
        let (model, finished) = rests(name, friction, duration, StepChoice::Tolerance(1e-9));
        let (mechanism, state) = (&model.mechanism, &finished.state);
        let effort = |motor: &Motor| {
            let at = motor.coordinate;
            motor.effort(state.time, state.position[at.position], state.velocity[at.freedom])
        };
        let efforts: Vec<f64> = mechanism.nonsmooth.motors.iter().map(effort).collect();
        let loads = |points: Option<&[ContactPoint]>| {
            let mut reactions = Reactions::new(mechanism);
            reactions.drive(&efforts);
            reactions.touch(points);
            let (joints, loops) = reactions.at(&state.position, &state.velocity);
            let joints = joints.iter().map(|joint| (joint.force, joint.torque));
            joints.chain(loops.iter().map(|closed| (closed.force, closed.torque))).collect::<Vec<_>>()
        };
        let apart = |one: &[(Vector3<f64>, Vector3<f64>)], other: &[(Vector3<f64>, Vector3<f64>)]| {
            one.iter().zip(other).map(|(a, b)| (a.0 - b.0).norm().max((a.1 - b.1).norm())).fold(0.0, f64::max)
        };
        let (told, worked_out, without) = (loads(Some(&finished.contacts)), loads(None), loads(Some(&[])));
        println!("{name}: {:e} apart, {:e} without", apart(&told, &worked_out), apart(&without, &worked_out));
        // Some ten newtons; motors answer 1e-9 rad with 1e-6 N m.
        assert!(apart(&told, &worked_out) <= 1e-8 && apart(&without, &worked_out) > 1.0, "{name}");
    }
}

#[test]
fn what_a_four_bar_mechanism_presses_to_a_wall_is_carried_exactly() {
    let (model, finished) = rests("four_bar_presses_box", 0.0, 2.0, StepChoice::Tolerance(1e-6));
    let mechanism = &model.mechanism;
    assert!(finished.events.iter().any(|event| event.kind == EventKind::Rest), "{:?}", finished.events);
    // Bars of l = 0.5 m and 0.5 kg that lean by asin 0.6, 0.4 m apart; a coupler of 1 kg with its centre 0.3 m from the first pin, and the ball in line
    // with both pins; 12 N m.
    let (sine, cosine, length, bar, coupler, box_mass) = (0.6, 0.8, 0.5, 0.5 * GRAVITY, GRAVITY, 1.5 * GRAVITY);
    let wall = (12.0 - (coupler + bar) * length * sine) / (length * cosine);
    let rear_z = 0.75 * coupler;
    // The rear bar has no motor: the moment about its upper pin is zero.
    let rear = Vector3::new(-(rear_z + 0.5 * bar) * sine / cosine, 0.0, rear_z);
    let front = Vector3::new(wall - rear.x, 0.0, coupler - rear_z);
    let weight = Vector3::z() * bar;

    let body = |name: &str| mechanism.bodies.iter().position(|body| body.joint.name == name).expect("a joint");
    let state = &finished.state;
    let mut reactions = Reactions::new(mechanism);
    reactions.drive(&[12.0]);
    let (joints, loops) = reactions.of_placed(&state.position, &state.velocity, &body_states(mechanism, state));
    // Rounding of some tens of newtons.
    let same = |found: Vector3<f64>, wanted: Vector3<f64>| {
        assert!((found - wanted).norm() <= 1e-12, "{found} for {wanted}");
    };
    same(joints[body("bars/front")].force, front + weight);
    same(joints[body("bars/rear")].force, rear + weight);
    same(joints[body("bars/coupler")].force, front);
    same(loops[0].force, rear);
    near(joints[body("bars/front")].torque.norm(), 12.0, 1e-12);

    // The forces on the box by what exerts them, and their moments about the middle of it.
    let nonsmooth = &mechanism.nonsmooth;
    let middle = Vector3::new(1.1, 0.0, 0.1);
    let mut forces = [Vector3::zeros(); 3];
    let mut moment = Vector3::zeros();
    for point in &finished.contacts {
        let pair = nonsmooth.pairs.iter().find(|pair| pair.number == point.pair).expect("its pair");
        let [a, b] = [pair.a, pair.b].map(|collider| nonsmooth.colliders[collider].name.as_str());
        let on_box = if a.starts_with("box") { point.force } else { -point.force };
        let by = ["coupler", "wall", "floor"].iter().position(|name| a.ends_with(name) || b.ends_with(name));
        forces[by.expect("something that touches")] += on_box;
        moment += (point.position - middle).cross(&on_box);
    }
    println!("on the box: {forces:?}, moment {moment:?}");
    same(forces[0], Vector3::x() * wall);
    same(forces[1], Vector3::x() * -wall);
    same(forces[2], Vector3::z() * box_mass);
    same(moment, Vector3::zeros());
    for (found, wanted) in state.position[mechanism.bodies[body("box/base")].joint.position_range()].iter().zip(&middle)
    {
        near(*found, *wanted, 1e-12);
    }
}
