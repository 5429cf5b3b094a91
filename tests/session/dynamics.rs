//! Mass matrix, Jacobians, inverse and forward dynamics and gravity, against the joint-coordinate oracle and differences.

use crate::robot;
use catena::mechanism::motion::state::State;
use catena::prelude::*;
use catena::reduced::{ReducedOde, joint_reactions};
use nalgebra::DVector;

fn numbers(count: usize, seed: f64) -> Vec<f64> {
    (0..count).map(|index| (seed + 1.7 * index as f64).sin()).collect()
}

/// Efforts along revolute and prismatic joints that carry the wrenches of Newton and Euler, less those of dampers and springs in them.
fn carried(model: &Model, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
    let mechanism = &model.description().mechanism;
    let bodies = {
        let state = State { position: q.to_vec(), velocity: v.to_vec(), ..State::zero(mechanism) };
        catena::mechanism::motion::kinematics::body_states(mechanism, &state)
    };
    let reactions = joint_reactions(mechanism, q, v, a);
    let mut own = vec![0.0; v.len()];
    catena::mechanism::forces::total::joint_efforts(mechanism, 0.0, (q, v), &bodies, &mut own);
    mechanism
        .bodies
        .iter()
        .enumerate()
        .map(|(index, body)| {
            let axis = bodies[index].rotation * body.joint.on_child.rotation.matrix().column(2);
            let turns = body.joint.kind == catena::mechanism::description::joint::JointKind::Revolute;
            let along = if turns { reactions[index].torque } else { reactions[index].force };
            along.dot(&axis) - own[body.joint.velocity_index]
        })
        .collect()
}

#[test]
fn inverse_dynamics_are_the_wrenches_that_joints_carry() {
    for name in ["arm7.urdf", "gantry.urdf", "chain_10.urdf"] {
        let model = Model::load(robot(name)).expect("a model");
        let n = model.coordinates().v_count();
        let (q, v, a) = (numbers(n, 0.3), numbers(n, 1.1), numbers(n, 2.5));
        let ours = model.inverse_dynamics(&q, &v, &a).expect("efforts");
        let theirs = DVector::from_vec(carried(&model, &q, &v, &a));
        // Both add some hundred products: roundings of the largest effort.
        assert!((&ours - &theirs).amax() < 1e-11 * theirs.amax(), "{name}: {ours} {theirs}");
    }
}

#[test]
fn rotors_add_their_inertia_to_the_mass_matrix_and_to_the_efforts_of_accelerations() {
    let folder = crate::folder("rotors");
    let urdf = robot("arm7.urdf");
    let bare = Model::load(&urdf).expect("a model");
    let joints: Vec<String> = bare.joint_names().iter().map(|name| name.to_string()).collect();
    let mut scene = format!("[[robot]]\nurdf = {urdf:?}\n");
    let rotor = |index: usize| 0.05 + 0.1 * index as f64;
    for (index, joint) in joints.iter().enumerate() {
        scene += &format!("[[joint]]\nname = {joint:?}\narmature = {}\n", rotor(index));
    }
    let file = folder.join("rotors.toml");
    std::fs::write(&file, scene).expect("a scene");
    let model = Model::load(&file).expect("a model");
    let n = model.coordinates().v_count();
    let (q, v, a) = (numbers(n, 0.3), numbers(n, 1.1), numbers(n, 2.5));
    let more = model.mass_matrix(&q).expect("a matrix") - bare.mass_matrix(&q).expect("a matrix");
    let efforts =
        model.inverse_dynamics(&q, &v, &a).expect("efforts") - bare.inverse_dynamics(&q, &v, &a).expect("efforts");
    let back = model
        .forward_dynamics(&q, &v, model.inverse_dynamics(&q, &v, &a).expect("efforts").as_slice())
        .expect("accelerations");
    for row in 0..n {
        for column in 0..n {
            let wanted = if row == column { rotor(row) } else { 0.0 };
            // Roundings of entries of some kg m².
            assert!((more[(row, column)] - wanted).abs() < 1e-14, "{row} {column}: {more}");
        }
        assert!((efforts[row] - rotor(row) * a[row]).abs() < 1e-11, "{row}: {efforts}");
        assert!((back[row] - a[row]).abs() < 1e-10, "{row}: {back}");
    }
}

#[test]
fn forward_dynamics_are_those_of_the_articulated_body_algorithm_and_undo_inverse_ones() {
    for name in ["arm7.urdf", "gantry.urdf", "humanoid.urdf", "spherical_chain.urdf", "planar_slider.urdf"] {
        let model =
            Model::loader().floating().load(robot(name)).or_else(|_| Model::load(robot(name))).expect("a model");
        let (q, v) = coordinates(&model);
        let n = v.len();
        let tau = numbers(n, 0.7);
        let a = model.forward_dynamics(&q, &v, &tau).expect("accelerations");
        let back = model.inverse_dynamics(&q, &v, a.as_slice()).expect("efforts");
        assert!((&back - DVector::from_vec(tau.clone())).amax() < 1e-9, "{name}: M is well conditioned to 1e6");
        if model.coordinates().q_count() == n {
            let mut expected = vec![0.0; n];
            let mut driven = model.description().mechanism.clone();
            driven.forces.driven = true;
            let mut ode = ReducedOde::new(&driven);
            ode.drive(catena::mechanism::motion::inputs::Inputs::constant(&tau));
            ode.accelerations(&q, &v, &mut expected);
            let expected = DVector::from_vec(expected);
            assert!((&a - &expected).amax() < 1e-10 * expected.amax(), "{name}: {a} {expected}");
        }
    }
}

/// Some q and v with unit quaternions.
fn coordinates(model: &Model) -> (Vec<f64>, Vec<f64>) {
    let places = model.coordinates();
    let (mut q, v) = (numbers(places.q_count(), 0.4), numbers(places.v_count(), 1.9));
    for joint in places.joints() {
        let turn = match joint.q.len() {
            4 => joint.q.clone(),
            7 => joint.q.start + 3..joint.q.end,
            _ => continue,
        };
        let length = q[turn.clone()].iter().map(|number| number * number).sum::<f64>().sqrt();
        q[turn].iter_mut().for_each(|number| *number /= length);
    }
    (q, v)
}

#[test]
fn the_quadratic_form_of_the_mass_matrix_is_twice_the_kinetic_energy_in_every_kind_of_coordinates() {
    for name in ["arm7.urdf", "humanoid.urdf", "spherical_chain.urdf", "planar_slider.urdf", "tumbling_body.urdf"] {
        let model =
            Model::loader().floating().load(robot(name)).or_else(|_| Model::load(robot(name))).expect("a model");
        let (q, v) = coordinates(&model);
        let rates = DVector::from_vec(v.clone());
        let twice = (rates.transpose() * model.mass_matrix(&q).expect("a matrix") * &rates)[0];
        let simulation = Simulation::new(&model).start_from(&q, &v);
        // Starts outside limits are moved in, which is not what is looked at here.
        let Ok(simulation) = simulation else { continue };
        let (moved, _) = simulation.coordinates().expect("coordinates");
        if moved.iter().zip(&q).any(|(a, b)| (a - b).abs() > 1e-12) {
            continue;
        }
        let kinetic = simulation.energy().expect("an energy").kinetic;
        assert!((twice - 2.0 * kinetic).abs() < 1e-12 * kinetic, "{name}: {twice} {kinetic}");
    }
}

#[test]
fn jacobians_give_the_velocities_of_links() {
    for (name, link) in [("arm7.urdf", "flange"), ("spherical_chain.urdf", ""), ("tumbling_body.urdf", "")] {
        let model =
            Model::loader().floating().load(robot(name)).or_else(|_| Model::load(robot(name))).expect("a model");
        let link =
            if link.is_empty() { model.link_names().last().expect("links").to_string() } else { link.to_string() };
        let (q, v) = coordinates(&model);
        let moving = model.jacobian(&link, &q).expect("a Jacobian") * DVector::from_vec(v.clone());
        let simulation = Simulation::new(&model).start_from(&q, &v).expect("a start");
        let at = simulation.link(&link).expect("a link");
        let origin = at.linear_velocity + at.angular_velocity.cross(&(at.position - at.center_of_mass));
        assert!((moving.fixed_rows::<3>(0) - origin).norm() < 1e-12, "{name}: {moving} {origin}");
        assert!((moving.fixed_rows::<3>(3) - at.angular_velocity).norm() < 1e-12, "{name}");
    }
}

#[test]
fn floating_accelerations_are_how_velocities_change() {
    // Its centre of mass is not the origin of its frame, which is thus accelerated by turning alone.
    let folder = crate::folder("eccentric");
    let file = folder.join("eccentric.urdf");
    let text = r#"<robot name="eccentric"><link name="body"><inertial><origin xyz="0.3 0.1 -0.2"/><mass value="2"/>
        <inertia ixx="0.1" ixy="0.01" ixz="0" iyy="0.2" iyz="0" izz="0.25"/></inertial></link></robot>"#;
    std::fs::write(&file, text).expect("written");
    let model = Model::loader().floating().load(&file).expect("a model");
    std::fs::remove_dir_all(folder).expect("removed");
    let (q, v) = coordinates(&model);
    let a = model.forward_dynamics(&q, &v, &[0.0; 6]).expect("accelerations");
    let step = 1e-5;
    let mut simulation =
        Simulation::new(&model).duration(2.0 * step).fixed(4, step).start_from(&q, &v).expect("a start");
    simulation.run().expect("it runs");
    let (_, after) = simulation.coordinates().expect("coordinates");
    let forward: Vec<f64> = after.iter().zip(&v).map(|(after, before)| (after - before) / (2.0 * step)).collect();
    // A one-sided difference over 2e-5 s of rates that change by some 10 per second squared.
    assert!((DVector::from_vec(forward.clone()) - &a).amax() < 1e-3, "{forward:?} {a}");
}

#[test]
fn gravity_efforts_are_inverse_dynamics_at_rest_where_nothing_else_acts() {
    let model = Model::load(robot("arm7.urdf")).expect("a model");
    let q = numbers(7, 0.9);
    let (gravity, inverse) = (
        model.gravity_efforts(&q).expect("efforts"),
        model.inverse_dynamics(&q, &[0.0; 7], &[0.0; 7]).expect("efforts"),
    );
    assert!((&gravity - &inverse).amax() < 1e-12 * gravity.amax(), "{gravity} {inverse}");
}

#[test]
fn linear_equations_have_rotors_and_relations_of_several_joints() {
    // Two pendulums of 2 kg at 0.5 m, whose angles add up to twice the angle of a flywheel with a rotor; they swing against each other and together.
    let folder = crate::folder("linear-rotors");
    let pendulum = |name: &str| {
        format!(
            "<link name='{name}_rod'><inertial><origin xyz='0 0 -0.5'/><mass value='2'/><inertia ixx='0' iyy='0' izz='0' ixy='0' ixz='0' \
             iyz='0'/></inertial></link><joint name='{name}' type='continuous'><parent link='base'/><child link='{name}_rod'/>\
             <axis xyz='0 1 0'/></joint>"
        )
    };
    let wheel = "<link name='wheel'><inertial><mass value='1'/><inertia ixx='0.1' iyy='0.1' izz='0.1' ixy='0' ixz='0' iyz='0'/></inertial>\
                 </link><joint name='shaft' type='continuous'><parent link='base'/><child link='wheel'/><axis xyz='0 1 0'/>\
                 <dynamics armature='0.3'/></joint>";
    let urdf = format!("<robot name='r'><link name='base'/>{}{}{wheel}</robot>", pendulum("left"), pendulum("right"));
    std::fs::write(folder.join("two.urdf"), urdf).expect("a robot");
    let file = folder.join("two.toml");
    let scene = "[[robot]]\nurdf = \"two.urdf\"\n[[coupling]]\njoints = { shaft = -2, left = 1, right = 1 }\n";
    std::fs::write(&file, scene).expect("a scene");
    let linear = Model::load(&file).expect("a model").linearize_at_rest(None).expect("linear equations");
    // Against each other the shaft stays: ω² = g/l. Together it turns as they do: ω² = 2 m g l / (2 m l² + I + A).
    let mut wanted =
        [(9.81_f64 / 0.5).sqrt(), (2.0 * 9.81 / (1.0 + 0.4_f64)).sqrt()].map(|rate| rate / std::f64::consts::TAU);
    wanted.sort_by(f64::total_cmp);
    assert_eq!(linear.modes.len(), 2);
    for (mode, wanted) in linear.modes.iter().zip(wanted) {
        assert!((mode.frequency - wanted).abs() < 1e-12, "{} instead of {wanted}", mode.frequency);
    }
    std::fs::write(&file, format!("{scene}[[drag]]\nlink = \"wheel\"\nangular = 1\n")).expect("a scene");
    let error = Model::load(&file).expect("a model").linearize_at_rest(None).expect_err("drag").to_string();
    assert!(error.contains("no drag") && !error.contains('\n'), "{error}");
}
