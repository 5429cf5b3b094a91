//! Meshes in the file itself, several actuators of one joint, and coefficients that are not linear.

use crate::common::command;
use catena::session::{Model, Simulation};

#[test]
fn a_mesh_of_vertices_in_the_file_is_their_hull_or_its_triangles() {
    let text = "<mujoco><asset><mesh name='t' vertex='0 0 0 .2 0 0 0 .2 0 0 0 .2 .05 .05 .05' scale='1 2 1'/>
       <mesh name='u' vertex='0 0 0 .2 0 0 0 .2 0 0 0 .2' face='0 2 1 0 1 3 0 3 2 1 2 3'/></asset>
      <worldbody><geom name='floor' type='plane' size='9 9 .1'/><geom name='stone' type='mesh' mesh='u' pos='5 0 0'/>
       <body name='a'><freejoint/><geom type='mesh' mesh='t'/></body>
       <body name='b' pos='2 0 0'><freejoint/><geom type='mesh' mesh='u'/></body></worldbody></mujoco>";
    let folder = command::folder("mjcf_vertices");
    std::fs::write(folder.join("model.xml"), text).expect("written");
    let model = Model::load(folder.join("model.xml")).expect("a model");
    assert!(model.warnings().iter().all(|line| !line.contains("mesh")), "{:#?}", model.warnings());
    let links = &model.description().links;
    // A sixth of 0.2 · 0.4 · 0.2 m³ and of 0.2³ m³, of 1000 kg/m³.
    for (name, mass) in [("a/a", 16.0 / 6.0), ("b/b", 8.0 / 6.0)] {
        let own = links[model.description().link(name).expect("a link")].mass;
        assert!((own - mass).abs() < 1e-14, "{name}: {own} {mass}");
    }
    let colliders = &model.description().mechanism.nonsmooth.colliders;
    assert_eq!(colliders.iter().map(|one| one.name.as_str()).collect::<Vec<_>>(), ["a/a", "b/b", "floor", "stone"]);
    // They lie on their sides, and stay there.
    let mut simulation = Simulation::new(&model).duration(0.1);
    simulation.run().expect("a run");
    assert!(simulation.position("a/base").expect("a joint")[2].abs() < 1e-9);
    let straight = text.replace("0 0 0 .2 0 0 0 .2 0 0 0 .2 .05 .05 .05", "0 0 0 .1 0 0 .2 0 0 .3 0 0");
    let error = super::read("mjcf_vertices", &straight).expect_err("points of a line").to_string();
    assert!(error.contains("model.xml:1: <mesh vertex="), "{error}");
    let wrong = super::read("mjcf_vertices", &text.replace("1 2 3'/></asset>", "1 2 4'/></asset>"));
    assert!(wrong.expect_err("no fifth vertex").to_string().contains("model.xml:2: <mesh face="));
}

#[test]
fn actuators_of_one_joint_are_one_motor_together_with_their_rotors_and_damping() {
    let text = "<mujoco><compiler angle='radian'/><worldbody><body name='b'><joint name='j' axis='0 1 0' damping='0.2 0.1'/>
       <inertial pos='0.1 0 0' mass='1' diaginertia='0.02 0.02 0.02'/></body></worldbody>
      <actuator><position joint='j' kp='3' gear='2' armature='0.05' damping='0.1'/><velocity joint='j' kv='.5'/><motor joint='j'/>
       <motor joint='j' forcerange='-1 1'/></actuator>
      <keyframe><key name='k' qpos='.3' qvel='.2' ctrl='.5 .7 .1 1'/></keyframe></mujoco>";
    let folder = command::folder("mjcf_several_actuators");
    std::fs::write(folder.join("model.xml"), text).expect("written");
    let model = Model::loader().keyframe("k").load(folder.join("model.xml")).expect("a model");
    let mechanism = &model.description().mechanism;
    // MuJoCo 4.0.0 without the last one.
    let effort = mechanism.nonsmooth.motors[0].effort(0.0, 0.3, 0.2);
    assert!(mechanism.nonsmooth.motors.len() == 1 && (effort + 0.25).abs() < 1e-15, "{effort}");
    assert!((mechanism.forces.joint_dampers[0].coefficient - 0.6).abs() < 1e-15);
    let (q, _) = model.start().expect("a start");
    let inertia = model.mass_matrix(&q).expect("a mass matrix")[(0, 0)];
    // The body, and four times the rotor.
    assert!((inertia - (0.02 + 0.01 + 0.2)).abs() < 1e-15, "{inertia}");
    for said in [
        "model.xml:1: damping that is not linear is not simulated; its first number is",
        "model.xml:4: a second actuator on joint \"j\" with a range of its force or dynamics of its own on either is not simulated",
    ] {
        assert!(model.warnings().iter().any(|line| line.contains(said)), "{said}: {:#?}", model.warnings());
    }
}

#[test]
fn a_simple_shape_of_a_mesh_is_fitted_to_its_moments_and_one_without_a_solid_is_refused_with_its_reason() {
    let text = "<mujoco><asset><mesh name='t' vertex='0 0 0 1 0 0 0 2 0 0 0 3'/></asset>
      <worldbody><body name='b'><freejoint/><geom type='box' mesh='t' pos='1 1 1'/></body></worldbody></mujoco>";
    let scene = super::read("mjcf_fitted", text).expect("a scene");
    let of = scene.robots[0].robot.links[0].inertial.as_ref().expect("a mass");
    // `body_mass` and `body_ipos` of MuJoCo 4.0.0: 1000 kg/m³ in a box of its half sides.
    let wanted = 8000.0 * 0.2599943 * 0.63965268 * 1.047973;
    assert!((of.mass / wanted - 1.0).abs() < 1e-7, "{}", of.mass);
    let center = of.origin.translation.vector;
    assert!((center - nalgebra::Vector3::new(1.25, 1.5, 1.75)).amax() < 1e-14, "{center}");
    let error = super::read("mjcf_fitted", &text.replace("mesh='t'", "mesh='u'")).expect_err("no mesh").to_string();
    assert!(error.contains("model.xml:2: <geom mesh=\"u\">: there is no such mesh"), "{error}");
}
