//! Joints that a `[[motion]]` moves in time, and formulas of time, against closed forms and independent integrations.

use crate::common::{run_until, scratch};
use crate::scene_files::{joint, report};
use catena::mechanism::description::closure::{Coordinate, Mimic};
use catena::mechanism::description::formula::Formula;
use catena::mechanism::description::joint::{Joint, JointKind, Pose};
use catena::mechanism::description::mechanism::{Body, Mechanism};
use catena::mechanism::description::target::Target;
use catena::mechanism::motion::state::State;
use catena::prelude::{Error, Model};
use catena::stepping::integrator::Lobatto;
use nalgebra::{Rotation3, Translation3, Vector3};
use std::path::{Path, PathBuf};

const GRAVITY: f64 = 9.81;

/// A pivot that slides along z, and a pendulum of 0.5 kg on it: 0.02 kg m² about its centre of mass, 0.3 m below the hinge; with more tables.
fn kapitza(folder: &Path, name: &str, more: &str) -> PathBuf {
    let urdf = "<robot name='r'><link name='base'/>\
        <link name='pivot'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial></link>\
        <link name='rod'><inertial><origin xyz='0 0 -0.3'/><mass value='0.5'/>\
        <inertia ixx='0.02' iyy='0.02' izz='0.02' ixy='0' ixz='0' iyz='0'/></inertial></link>\
        <joint name='shaker' type='prismatic'><parent link='base'/><child link='pivot'/><axis xyz='0 0 1'/>\
        <limit lower='-1' upper='1' effort='1' velocity='100'/></joint>\
        <joint name='hinge' type='continuous'><parent link='pivot'/><child link='rod'/><axis xyz='0 1 0'/></joint></robot>";
    std::fs::write(folder.join("kapitza.urdf"), urdf).expect("a robot");
    let file = folder.join(format!("{name}.toml"));
    std::fs::write(&file, format!("[[robot]]\nurdf = \"kapitza.urdf\"\n{more}")).expect("a scene");
    file
}

fn shaken(amplitude: f64, frequency: f64) -> String {
    format!(
        "[[motion]]\njoint = \"shaker\"\nposition = {{ formula = \"a*cos(w*t)\", a = {amplitude}, w = {frequency} }}\n"
    )
}

/// Moment of inertia about the hinge [kg m²], and m l [kg m].
const ABOUT: f64 = 0.02 + 0.5 * 0.09;
const ARM: f64 = 0.5 * 0.3;

/// The pendulum on a pivot with the acceleration z̈(t): `I θ̈ = −m l (g + z̈) sin θ`, by the classical method of Runge and Kutta.
fn reduced(start: f64, duration: f64, steps: usize, acceleration: impl Fn(f64) -> f64) -> (f64, f64) {
    let second = |time: f64, angle: f64| -ARM * (GRAVITY + acceleration(time)) * angle.sin() / ABOUT;
    let (mut angle, mut rate) = (start, 0.0);
    let h = duration / steps as f64;
    for step in 0..steps {
        let time = step as f64 * h;
        let (k1, l1) = (rate, second(time, angle));
        let (k2, l2) = (rate + 0.5 * h * l1, second(time + 0.5 * h, angle + 0.5 * h * k1));
        let (k3, l3) = (rate + 0.5 * h * l2, second(time + 0.5 * h, angle + 0.5 * h * k2));
        let (k4, l4) = (rate + h * l3, second(time + h, angle + h * k3));
        angle += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        rate += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
    }
    (angle, rate)
}

#[test]
fn a_pendulum_on_a_shaken_pivot_moves_as_its_equation_says() {
    let (a, w) = (0.02, 60.0);
    let folder = scratch("motions_kapitza");
    let end = report(&kapitza(&folder, "shaken", &shaken(a, w)), &[("hinge", 1.0)], &[], Some(1.0), 1e-11);
    let (angle, rate) = joint(&end, "hinge");
    let (wanted, wanted_rate) = reduced(1.0, 1.0, 200_000, |time| -a * w * w * (w * time).cos());
    println!("angle off by {:.1e}, rate by {:.1e}", angle - wanted, rate - wanted_rate);
    // The tolerance, and (w h)⁴ = 8e-15 of the other method a second.
    assert!(
        (angle - wanted).abs() < 1e-10 && (rate - wanted_rate).abs() < 1e-9,
        "{angle} {wanted}, {rate} {wanted_rate}"
    );
    let (place, speed) = joint(&end, "shaker");
    assert!((place - a * w.cos()).abs() < 1e-15 && (speed + a * w * w.sin()).abs() < 1e-13, "{place}, {speed}");
    // The drive puts in the energy that the pendulum and the pivot gain.
    assert!(end.energy.max_relative_error < 1e-10, "{:?}", end.energy);
}

#[test]
fn a_shaken_pendulum_stands_on_its_head_if_the_shaking_is_fast_enough() {
    // Stable if a² w² > 2 g l with the reduced length l = I/(m l).
    let (a, length) = (0.02_f64, ABOUT / ARM);
    let critical = (2.0 * GRAVITY * length).sqrt() / a;
    let folder = scratch("motions_upright");
    for (part, stands) in [(0.8, false), (1.3, true)] {
        let file = kapitza(&folder, if stands { "fast" } else { "slow" }, &shaken(a, part * critical));
        let start = std::f64::consts::PI - 0.05;
        let end = report(&file, &[("hinge", start)], &[], Some(1.5), 1e-7);
        let (angle, _) = joint(&end, "hinge");
        let lean = (angle - std::f64::consts::PI).abs();
        // It swings about the upright position with the amplitude of its start and some shaking.
        assert!(if stands { lean < 0.15 } else { lean > 0.5 }, "{part}: {angle}");
    }
}

#[test]
fn the_effort_of_the_drive_is_that_of_inverse_dynamics() {
    let folder = scratch("motions_effort");
    let turned = "[[motion]]\njoint = \"hinge\"\nposition = { formula = \"0.4 + 2*t + 0.3*sin(5*t)\" }\n\
                  [[motion]]\njoint = \"shaker\"\nposition = 0.1\n";
    let end = report(&kapitza(&folder, "turned", turned), &[], &[], Some(0.7), 1e-10);
    let (time, (angle, rate)) = (0.7_f64, joint(&end, "hinge"));
    assert!((angle - (0.4 + 2.0 * time + 0.3 * (5.0 * time).sin())).abs() < 1e-14);
    assert!((rate - (2.0 + 1.5 * (5.0 * time).cos())).abs() < 1e-13);
    let effort = ABOUT * -7.5 * (5.0 * time).sin() + ARM * GRAVITY * angle.sin();
    let (_, hinge) = end.joints.iter().find(|(name, _)| name == "hinge").expect("a hinge");
    // Roundings of 1 N m.
    assert!((hinge.reaction_torque[1] - effort).abs() < 1e-13, "{:?} and {effort}", hinge.reaction_torque);
    let (_, shaker) = end.joints.iter().find(|(name, _)| name == "shaker").expect("a shaker");
    let (sine, cosine) = angle.sin_cos();
    let second = -7.5 * (5.0 * time).sin();
    // z = −l cos q.
    let lift = 1.5 * GRAVITY + ARM * (cosine * rate * rate + sine * second);
    assert!((shaker.reaction_force[2] - lift).abs() < 1e-12, "{:?} and {lift}", shaker.reaction_force);
    assert!(end.energy.max_relative_error < 1e-11, "{:?}", end.energy);
}

/// A leaning hinge that is moved, a hinge with another axis that is free, and a slide.
fn moved_arm() -> Mechanism {
    let body = |name: &str, parent, kind, at: Vector3<f64>, axis: Vector3<f64>| {
        let turn = Rotation3::rotation_between(&Vector3::z(), &axis).expect("not opposite");
        let frame = |at: Vector3<f64>| Pose::from_parts(Translation3::from(at), turn);
        let joint = Joint::new(name, kind, frame(at), frame(Vector3::new(-0.2, 0.1, 0.3)));
        Body { name: name.into(), parent, mass: 1.3, inertia: Vector3::new(0.03, 0.05, 0.04), joint }
    };
    let (x, y) = (Vector3::x(), Vector3::y());
    let bodies = vec![
        body("moved", None, JointKind::Revolute, Vector3::zeros(), y + 0.3 * x),
        body("free", Some(0), JointKind::Revolute, Vector3::new(0.4, 0.1, 0.2), x + y),
        body("slide", Some(1), JointKind::Prismatic, Vector3::new(0.1, 0.0, 0.2), x + Vector3::z()),
    ];
    let mut mechanism = Mechanism::new("moved", Vector3::new(0.0, 0.0, -GRAVITY), bodies).expect("depth first");
    let motion = Target::formula(Formula::new("0.3*sin(4*t) + 0.5*t^2", &[]).expect("a formula"));
    let first = Coordinate { body: 0, position: 0, freedom: 0 };
    mechanism.mimics.push(Mimic::moved("moved".into(), first, motion));
    mechanism
}

#[test]
fn steps_with_a_moved_joint_keep_the_order_of_the_scheme() {
    let mechanism = moved_arm();
    let mut start = State::zero(&mechanism);
    start.velocity.copy_from_slice(&[1.2, 0.4, -0.1]);
    let run = |stages: usize, step: f64| {
        let mut state = start.clone();
        let summary =
            run_until(&mechanism, &mut state, &mut Lobatto::fixed(&mechanism, stages, step).expect("steps"), 0.8);
        (state, summary)
    };
    let (exact, summary) = run(9, 0.02);
    assert!(summary.max_relative_energy_error < 1e-12, "{summary:?}");
    for (stages, step) in [(2, 0.01), (3, 0.04), (4, 0.08)] {
        let off = |step: f64| {
            let (state, _) = run(stages, step);
            state.position.iter().zip(&exact.position).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let order = (off(step) / off(0.5 * step)).log2();
        println!("{stages} stages: order {order:.2}, error {:.1e}", off(step));
        // The order is 2 s − 2, and the steps are not infinitely short.
        assert!((order - (2 * stages - 2) as f64).abs() < 0.35, "{stages} stages: {order}");
    }
}

#[test]
fn a_table_is_followed_smoothly_from_rest_to_rest() {
    let folder = scratch("motions_table");
    let table = "[[motion]]\njoint = \"shaker\"\nposition = [[0.2, 0], [0.5, 0.1], [1.0, -0.2]]\n";
    let file = kapitza(&folder, "table", table);
    std::fs::write(folder.join("place.csv"), "0.2,0\n0.5,0.1\n1.0,-0.2\n").expect("a table");
    let csv = kapitza(&folder, "csv", "[[motion]]\njoint = \"shaker\"\nposition = \"place.csv\"\n");
    for file in [&file, &csv] {
        for (time, place) in [(0.2, 0.0), (0.5, 0.1), (1.0, -0.2), (1.3, -0.2)] {
            let end = report(file, &[("hinge", 0.3)], &[], Some(time), 1e-9);
            let (position, rate) = joint(&end, "shaker");
            assert!((position - place).abs() < 1e-14, "at {time}: {position}");
            assert!(time == 0.5 || rate.abs() < 1e-13, "at {time}: {rate}");
            assert!(end.energy.max_relative_error < 1e-8, "{:?}", end.energy);
        }
    }
}

#[test]
fn a_crank_that_is_turned_drives_its_slider_as_geometry_says() {
    // A crank of 0.3 m, a rod of 1 m, and a slider on x.
    let folder = scratch("motions_crank");
    let link = |name: &str, at: f64| {
        format!(
            "<link name='{name}'><inertial><origin xyz='{at} 0 0'/><mass value='1'/><inertia ixx='0.02' iyy='0.02' izz='0.02' ixy='0' \
             ixz='0' iyz='0'/></inertial></link>"
        )
    };
    let urdf = [
        "<robot name='r'><link name='base'/>".to_string(),
        link("crank", 0.15),
        link("rod", 0.5),
        link("slider", 0.0),
        "<joint name='turn' type='continuous'><parent link='base'/><child link='crank'/><axis xyz='0 -1 0'/></joint>".to_string(),
        "<joint name='pin' type='continuous'><parent link='crank'/><child link='rod'/><origin xyz='0.3 0 0'/><axis xyz='0 -1 0'/></joint>"
            .to_string(),
        "<joint name='rail' type='prismatic'><parent link='base'/><child link='slider'/><origin xyz='1.3 0 0'/><axis xyz='1 0 0'/>\
         <limit lower='-2' upper='2' effort='1' velocity='9'/></joint></robot>"
            .to_string(),
    ];
    std::fs::write(folder.join("crank.urdf"), urdf.concat()).expect("a robot");
    let file = folder.join("crank.toml");
    let scene = "[[robot]]\nurdf = \"crank.urdf\"\n[[loop]]\nname = \"wrist\"\ntype = \"revolute\"\n\
                 a = { link = \"rod\", position = [1, 0, 0], axis = [0, 1, 0] }\nb = { link = \"slider\", axis = [0, 1, 0] }\n\
                 [[motion]]\njoint = \"turn\"\nposition = { formula = \"w*t\", w = 7 }\n";
    std::fs::write(&file, scene).expect("a scene");
    let end = report(&file, &[], &[], Some(1.1), 1e-9);
    let angle = 7.0 * 1.1_f64;
    let (sine, cosine) = angle.sin_cos();
    let leg = (1.0 - 0.09 * sine * sine).sqrt();
    let (place, speed) = joint(&end, "rail");
    assert!((place - (0.3 * cosine + leg - 1.3)).abs() < 1e-13, "{place}");
    let wanted = -7.0 * (0.3 * sine + 0.09 * sine * cosine / leg);
    assert!((speed - wanted).abs() < 1e-11, "{speed} and {wanted}");
    assert!(end.energy.max_relative_error < 1e-9, "{:?}", end.energy);
}

fn refused(file: &Path) -> String {
    let error = Model::load(file).err().map(|error: Error| error.to_string()).expect("refused");
    assert_eq!(error.lines().count(), 1, "{error}");
    error
}

#[test]
fn a_motion_that_cannot_be_is_refused_with_the_line() {
    let folder = scratch("motions_refused");
    let motor = "[[motor]]\njoint = \"shaker\"\nkind = \"effort\"\ntarget = 1\n";
    let cases = [
        (shaken(0.1, 2.0) + motor, ":4: motion of \"shaker\": the joint has a [[motor]], too"),
        (
            shaken(0.1, 2.0) + &shaken(0.1, 3.0),
            ":7: motion of \"shaker\": the joint already has the [[motion]] of line 4",
        ),
        ("[[motion]]\njoint = \"shaker\"\nposition = \"start\"\n".into(), ":5: motion of \"shaker\": its position is"),
        (
            "[[motion]]\njoint = \"shaker\"\nposition = { formula = \"sin(t\" }\n".into(),
            ":5: motion of \"shaker\": formula",
        ),
        ("[[motion]]\njoint = \"shaker\"\nposition = { formula = \"1/t\" }\n".into(), "at t = 0 its value is inf"),
        (
            "[[motion]]\njoint = \"shaker\"\nposition = { formula = \"b*t\", a = 1 }\n".into(),
            "character 1: \"b\" is unknown",
        ),
        ("[[motion]]\njoint = \"shaker\"\nposition = { a = 1 }\n".into(), "missing field `formula`"),
    ];
    for (number, (more, wanted)) in cases.iter().enumerate() {
        let error = refused(&kapitza(&folder, &format!("case{number}"), more));
        assert!(error.contains(wanted), "{error}");
    }
}

#[test]
fn a_start_that_contradicts_a_motion_is_refused() {
    let file = kapitza(&scratch("motions_start"), "shaken", &shaken(0.1, 2.0));
    let model = Model::load(&file).expect("a model");
    let start = catena::prelude::Simulation::new(&model).start([("shaker", 0.5)]);
    let error = start.err().map(|error| error.to_string()).or_else(|| {
        let mut simulation = catena::prelude::Simulation::new(&model).start([("shaker", 0.5)]).ok()?;
        simulation.run().err().map(|error| error.to_string())
    });
    assert!(error.expect("refused").contains("starts where its [[motion]] puts it"));
}

#[test]
fn a_run_takes_the_coordinates_of_a_moved_joint_at_the_time_of_its_start_and_no_others() {
    let (a, w, begin) = (0.1, 2.0, 0.7);
    let file = kapitza(&scratch("motions_coordinates"), "shaken", &shaken(a, w));
    let model = Model::load(&file).expect("a model");
    let new = || catena::prelude::Simulation::new(&model).begin_at(begin);
    let (place, rate) = (a * f64::cos(w * begin), -a * w * f64::sin(w * begin));
    let mut simulation = new().start_from(&[place, 0.4], &[rate, 0.2]).expect("it is there");
    simulation.step_to(begin + 0.2).expect("it runs");
    let (q, v) = simulation.coordinates().expect("coordinates");
    simulation.place(begin + 0.2, &q, &v).expect("it is where it is");
    simulation.step_to(begin + 0.3).expect("it goes on");
    let shaker = simulation.position("shaker").expect("a position")[0];
    assert!((shaker - a * f64::cos(w * (begin + 0.3))).abs() < 1e-15, "{shaker}");
    // The joints of the file alone start where the motion is then, too.
    let (start, _) = new().coordinates().expect("coordinates");
    assert!((start[0] - place).abs() < 1e-15, "{start:?}");
    let refused = |error: Option<Error>| error.expect("refused").to_string().contains("starts where its [[motion]]");
    assert!(refused(new().start_from(&[place, 0.4], &[rate + 1e-6, 0.2]).err()));
    assert!(refused(new().start_from(&[place + 1e-6, 0.4], &[rate, 0.2]).err()));
    assert!(refused(simulation.place(begin + 0.2, &[place, 0.4], &[rate, 0.2]).err()));
}

#[test]
fn limits_and_friction_of_a_moved_joint_are_left_out_with_a_warning() {
    let more = shaken(0.1, 2.0) + "[[joint]]\nname = \"shaker\"\nfriction = 3.0\n";
    let model = Model::load(kapitza(&scratch("motions_limits"), "shaken", &more)).expect("a model");
    let nonsmooth = &model.description().mechanism.nonsmooth;
    assert!(nonsmooth.limits.is_empty() && nonsmooth.friction.is_empty());
    let warnings: Vec<String> = model.description().warnings.iter().map(ToString::to_string).collect();
    for what in ["limits are not simulated", "friction is not simulated"] {
        assert!(warnings.iter().any(|warning| warning.contains(what)), "{warnings:?}");
    }
}

#[test]
fn parameters_and_tables_of_motions_have_key_paths() {
    let folder = scratch("motions_keys");
    let (one, other) = (kapitza(&folder, "one", &shaken(0.1, 2.0)), kapitza(&folder, "other", &shaken(0.3, 2.0)));
    let set = |file: &Path, key: &str, number: f64| Model::loader().set(key, number).load(file).expect("a model");
    let motion = |model: &Model| model.description().mechanism.mimics[0].motion(0.0, 0.4);
    let changed = set(&one, "motion.shaker.position.a", 0.3);
    assert_eq!(motion(&changed), motion(&Model::load(&other).expect("a model")));
    let table = |value: f64| format!("[[motion]]\njoint = \"shaker\"\nposition = [[0, 0], [1, {value}]]\n");
    let (one, other) = (kapitza(&folder, "first", &table(0.1)), kapitza(&folder, "second", &table(0.2)));
    let changed = set(&one, "motion.shaker.position.2.value", 0.2);
    assert_eq!(motion(&changed), motion(&Model::load(&other).expect("a model")));
}

/// A cart of 2 kg on rails, with more tables.
fn cart(folder: &Path, name: &str, more: &str) -> PathBuf {
    let urdf = "<robot name='r'><link name='base'/><link name='cart'><inertial><mass value='2'/><inertia ixx='1' iyy='1' izz='1' ixy='0' \
                ixz='0' iyz='0'/></inertial></link><joint name='rail' type='prismatic'><parent link='base'/><child link='cart'/>\
                <axis xyz='1 0 0'/><limit lower='-inf' upper='inf' effort='inf' velocity='inf'/></joint></robot>";
    std::fs::write(folder.join("cart.urdf"), urdf).expect("a robot");
    let file = folder.join(format!("{name}.toml"));
    std::fs::write(&file, format!("[[robot]]\nurdf = \"cart.urdf\"\n{more}")).expect("a scene");
    file
}

#[test]
fn loads_and_motors_follow_formulas_without_events() {
    let folder = scratch("motions_formulas");
    let formula = "{ formula = \"0.5 + 2*sin(w*t + 0.3)\", w = 5 }";
    let load = format!("[[load]]\njoint = \"rail\"\neffort = 3.0\nfactor = {formula}\n");
    let motor = "[[motor]]\njoint = \"rail\"\nkind = \"effort\"\ntarget = { formula = \"1.5 + 6*sin(5*t + 0.3)\" }\n";
    // m ẍ = 3 (0.5 + 2 sin(5 t + 0.3)).
    let cosine = 0.3_f64.cos();
    let speed = 0.75 * 2.0 + 3.0 / 5.0 * (cosine - 10.3_f64.cos());
    let place = 0.375 * 4.0 + 0.6 * (cosine * 2.0 - (10.3_f64.sin() - 0.3_f64.sin()) / 5.0);
    for (name, more) in [("load", load.as_str()), ("motor", motor)] {
        let end = report(&cart(&folder, name, more), &[], &[], Some(2.0), 1e-11);
        let (x, v) = joint(&end, "rail");
        assert!((v - speed).abs() < 1e-10 && (x - place).abs() < 1e-10, "{name}: {x} {place}, {v} {speed}");
        assert!(end.events.list.is_empty(), "{name}: {:?}", end.events);
    }
    let set = Model::loader().set("load.rail.factor.w", 7.0).load(cart(&folder, "keys", &load)).expect("a model");
    let courses = &set.description().mechanism.forces.joint_courses;
    assert!((courses[0].course.value(0.0, 0.2) - (0.5 + 2.0 * 1.7_f64.sin())).abs() < 1e-15);
}

#[test]
fn a_ball_on_a_plate_that_is_shaken_rides_hops_and_is_struck_with_its_energy_accounted() {
    let folder = scratch("motions_plate");
    let urdf = "<robot name='r'><link name='base'/><link name='plate'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' \
                ixz='0' iyz='0'/></inertial><collision><geometry><box size='1 1 0.1'/></geometry></collision></link>\
                <joint name='lift' type='prismatic'><parent link='base'/><child link='plate'/><axis xyz='0 0 1'/>\
                <limit lower='-1' upper='1' effort='1' velocity='9'/></joint></robot>";
    std::fs::write(folder.join("plate.urdf"), urdf).expect("a robot");
    let scene = |frequency: f64| {
        format!(
            "[[robot]]\nurdf = \"plate.urdf\"\n[[body]]\nname = \"ball\"\nshape = {{ type = \"sphere\", radius = 0.1 }}\nmass = 2\n\
             pose = {{ position = [0, 0, 0.15] }}\n[contact]\npairs = \"all\"\n\
             [[motion]]\njoint = \"r/lift\"\nposition = {{ formula = \"a*sin(w*t)\", a = 0.02, w = {frequency} }}\n"
        )
    };
    let file = folder.join("plate.toml");
    // a w² = 4.5 m/s² < g: it rides, and the contact carries m (g + z̈).
    std::fs::write(&file, scene(15.0)).expect("a scene");
    let end = report(&file, &[], &[], Some(0.05), 1e-9);
    let force = 2.0 * (GRAVITY - 4.5 * 0.75_f64.sin());
    let points = &end.contact.points;
    assert!((points[0].force[2].abs() - force).abs() < 1e-9, "{points:?} and {force}");
    assert!(end.energy.max_relative_error < 1e-9, "{:?}", end.energy);
    // a w² = 18 m/s² > g: it hops, and each blow takes energy from the drive.
    std::fs::write(&file, scene(30.0)).expect("a scene");
    let end = report(&file, &[], &[], Some(1.0), 1e-8);
    let impacts = end.events.list.iter().filter(|event| event.kind == "contact_impact").count();
    assert!(impacts > 3, "{:?}", end.events);
    assert!(end.energy.max_relative_error < 1e-7, "{:?}", end.energy);
    // The first blow, from rest onto a speed of 0.6 m/s, loses as much as it gives: ½ m u².
    assert!(end.energy.impacts > 0.5 * 2.0 * 0.36, "{:?}", end.energy);
}

#[test]
fn a_box_rides_on_a_table_that_is_moved_and_slips_on_it_where_its_friction_is_not_enough() {
    // A table of 5 kg that slides along x, whose top is at 0.05 m, and a box on it with four corners.
    let urdf = "<robot name='r'><link name='base'/><link name='table'><inertial><mass value='5'/><inertia ixx='0.1' iyy='0.1' izz='0.1' ixy='0' \
                ixz='0' iyz='0'/></inertial><collision><geometry><box size='9 2 0.1'/></geometry></collision></link>\
                <joint name='slide' type='prismatic'><parent link='base'/><child link='table'/><axis xyz='1 0 0'/>\
                <limit lower='-9' upper='9' effort='0' velocity='0'/></joint></robot>";
    let folder = scratch("on_a_moved_table");
    std::fs::write(folder.join("table.urdf"), urdf).expect("a robot");
    let end = |formula: &str, speed: f64, duration: f64| {
        let text = format!(
            "[[robot]]\nurdf = \"table.urdf\"\n[[motion]]\njoint = \"slide\"\nposition = {{ formula = \"{formula}\" }}\n\
             [[body]]\nname = \"box\"\nshape = {{ type = \"box\", size = [0.2, 0.2, 0.2] }}\nmass = 1\npose.position = [0, 0, 0.15]\n\
             velocity.linear = [{speed}, 0, 0]\n[contact]\nfriction = 0.3\n"
        );
        let file = folder.join("scene.toml");
        std::fs::write(&file, text).expect("a scene");
        let end = report(&file, &[], &[], Some(duration), 1e-9);
        assert_eq!(end.method.crowd.steps, 0, "{formula}");
        end.links.iter().find(|(name, _)| name == "box").expect("a box").1.position[0]
    };
    let near =
        |formula: &str, is: f64, wanted: f64| assert!((is - wanted).abs() < 1e-10, "{formula}: {is}, not {wanted}");
    near("even", end("0.5*t", 0.5, 1.0), 0.5);
    near("faster", end("0.5*t^2", 0.0, 1.0), 0.5);
    near("sine below the grip", end("0.05*sin(7*t)", 0.35, 1.0), 0.05 * 7.0_f64.sin());
    // 0.1 sin(7 t) needs 4.9 m/s² of a grip of 2.943: it slips where that is not enough, and sticks where their speeds meet.
    let (amplitude, rate, grip) = (0.1, 7.0, 0.3 * GRAVITY);
    let table = |time: f64| amplitude * (rate * time).sin();
    let speed = |time: f64| amplitude * rate * (rate * time).cos();
    let slips = (grip / (amplitude * rate * rate)).asin() / rate;
    let own = |time: f64| speed(slips) - grip * (time - slips);
    let (mut low, mut high) = (0.3, 0.6);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if own(middle) > speed(middle) { low = middle } else { high = middle }
    }
    let slid = 0.5 * (speed(slips) + own(low)) * (low - slips);
    near("sine beyond the grip", end("0.1*sin(7*t)", 0.7, 0.53), slid + table(slips) + table(0.53) - table(low));
}

/// The motion has a rate at the start that is no part of the gaps that the start is moved by.
#[test]
fn a_start_beyond_a_limit_is_moved_onto_it_whatever_the_rate_of_a_motion_beside_it() {
    let folder = scratch("motion_beside_limit");
    let text = |amplitude: f64| {
        let beside = "[[joint]]\nname = \"hinge\"\nlimit = [-1, 0.5]\n";
        format!("{beside}[[motion]]\njoint = \"shaker\"\nposition = {{ formula = \"a*sin(20*t)\", a = {amplitude} }}\n")
    };
    for amplitude in [0.02, 0.1, 0.4] {
        let file = kapitza(&folder, &format!("beside_{amplitude}"), &text(amplitude));
        let start = report(&file, &[("hinge", 0.8)], &[], Some(1e-9), 1e-9);
        // In 1e-9 s the hinge moves by less than its rate at the limit, some rad/s, allows.
        let (angle, _) = joint(&start, "hinge");
        assert!((angle - 0.5).abs() < 1e-7, "{amplitude}: {angle}");
    }
}
