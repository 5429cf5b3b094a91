//! Attributes of `<compiler>`: masses of geoms in groups, bounds of masses, and what is told.

use crate::common::command;
use catena::session::Model;

#[test]
fn groups_and_bounds_of_masses_are_those_of_mujoco() {
    let text = "<mujoco><compiler inertiagrouprange='0 2' boundmass='0.3' boundinertia='0.002' balanceinertia='true'/><worldbody>
      <body name='a'><joint name='j' axis='0 1 0'/><geom type='capsule' fromto='0 0 0 0.3 0 0' size='0.02'/><geom size='.1' pos='.5 0 0' group='3'/>
       <body name='b' pos='0 0 1'><joint name='k' axis='0 1 0'/>
        <inertial pos='0 0 0' mass='0.1' fullinertia='0.01 0.02 0.05 0.003 0.001 0.002'/></body></body></worldbody></mujoco>";
    let scene = super::read("mjcf_bounds", text).expect("a scene");
    let links = &scene.robots[0].robot.links;
    // Masses and principal moments of MuJoCo 4.0.0, to the digits that it prints.
    for (name, mass, moments) in [("a", 0.41050144, [0.002, 0.00369987, 0.00369987]), ("b", 0.3, [0.02666667; 3])] {
        let of = links.iter().find(|link| link.name == name).and_then(|link| link.inertial.as_ref()).expect("a mass");
        let mut own: Vec<f64> = of.inertia.symmetric_eigenvalues().iter().copied().collect();
        own.sort_by(f64::total_cmp);
        let near = own.iter().zip(moments).all(|(own, wanted)| (own - wanted).abs() < 5e-9);
        assert!((of.mass - mass).abs() < 5e-9 && near, "{name}: {} {own:?}", of.mass);
    }
}

#[test]
fn every_attribute_of_the_compiler_is_read_or_told_with_its_line() {
    let text = "<mujoco>
      <compiler angle='radian' fitaabb='true' alignfree='true' discardvisual='true' usethread='false' coordinate='local' colour='red'/>
      <worldbody><body><joint/><geom size='.1'/></body></worldbody></mujoco>";
    let told: Vec<String> =
        super::read("mjcf_compiler", text).expect("a scene").warnings.iter().map(ToString::to_string).collect();
    for said in [
        "model.xml:2: fitaabb=\"true\" of <compiler> is not read",
        "model.xml:2: colour of <compiler> is not known, and not read",
        "discardvisual of <compiler>",
        "usethread of <compiler>",
    ] {
        assert!(told.iter().any(|line| line.contains(said)), "{said}: {told:#?}");
    }
    assert!(told.iter().all(|line| !line.contains("coordinate") && !line.contains("angle")), "{told:#?}");
}

#[test]
fn paths_of_meshes_are_stripped_where_the_compiler_says_so() {
    let folder = command::folder("mjcf_strip");
    std::fs::create_dir_all(folder.join("meshes")).expect("a folder");
    std::fs::write(
        folder.join("meshes/t.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n",
    )
    .expect("written");
    let text = "<mujoco><compiler meshdir='meshes' strippath='true'/><asset><mesh file='/elsewhere/t.obj'/></asset>
      <worldbody><body><joint/><geom type='mesh' mesh='t'/></body></worldbody></mujoco>";
    std::fs::write(folder.join("model.xml"), text).expect("written");
    let model = Model::load(folder.join("model.xml")).expect("a model");
    // A sixth of a cubic metre of 1000 kg/m³.
    let mass = model.description().links[0].mass;
    assert!((mass - 1000.0 / 6.0).abs() < 1e-11, "{mass}");
}
