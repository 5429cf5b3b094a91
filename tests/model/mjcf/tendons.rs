//! Tendons, friction of all its ways, and ellipsoids of MJCF files.

use super::read;
use catena::scene::{LimitChoice, WarningGroup};
use catena::session::{Model, Simulation};

/// A ball on a string under a hook, and an arm of two joints.
const TENDONS: &str = "<mujoco><compiler angle='radian'/><default><tendon stiffness='20'/></default><worldbody>
  <site name='hook' pos='0 0 2'/>
  <body name='ball' pos='0.3 0 1.2'><freejoint/><geom size='0.1' mass='1'/><site name='eye' pos='0 0 0.1'/></body>
  <body name='arm' pos='2 0 2'><joint name='a' axis='0 1 0'/><geom size='.03' mass='1'/>
    <body name='fore' pos='0 0 -.5'><joint name='b' axis='0 1 0' ref='0.2'/><geom size='.03' mass='1' pos='0 0 -.5'/></body></body>
  </worldbody>
  <tendon>
    <spatial name='string' range='0.2 1.1'><site site='hook'/><site site='eye'/></spatial>
    <fixed name='sum' stiffness='0'><joint joint='a' coef='1'/><joint joint='b' coef='2'/></fixed>
    <fixed name='one' stiffness='0'><joint joint='b' coef='0.5'/></fixed>
    <spatial name='over'><site site='hook'/><pulley divisor='2'/><site site='eye'/></spatial>
  </tendon>
  <equality><tendon tendon1='sum' polycoef='0.1'/></equality>
  <actuator><motor tendon='sum' gear='3'/></actuator>
  <keyframe><key name='k' qpos='0.3 0 1.2 1 0 0 0 0.5 0' ctrl='0.5'/></keyframe></mujoco>";

#[test]
fn a_tendon_through_two_sites_is_a_rope_with_a_spring_that_is_free_where_it_is_described() {
    let scene = read("mjcf_tendons", TENDONS).expect("a scene");
    let [rope] = scene.ropes.as_slice() else { panic!("{:?}", scene.ropes) };
    assert_eq!((rope.name.as_str(), rope.length), ("string", 1.1));
    assert_eq!([rope.points[0].name.as_str(), rope.points[1].name.as_str()], ["world", "ball/ball"]);
    assert_eq!(rope.points[0].position.as_slice(), [0.0, 0.0, 2.0]);
    // 0.1 above a ball at the height 1.2, as 1.3 − 1.2 rounds.
    assert!((rope.points[1].position.z - 0.1).abs() < 1e-15, "{:?}", rope.points[1]);
    let [spring] = scene.springs.as_slice() else { panic!("{:?}", scene.springs) };
    let catena::scene::SpringPlace::Points { rest_length, .. } = &spring.place else { panic!("{spring:?}") };
    assert_eq!(spring.stiffness, 20.0);
    assert!((rest_length - 0.3_f64.hypot(0.7)).abs() < 1e-15, "{rest_length}");
    let said = |what: &str| {
        let all: Vec<String> = scene.warnings.iter().map(|warning| warning.to_string()).collect();
        assert!(all.iter().any(|line| line.contains(what)), "{what}: {all:#?}");
    };
    said("model.xml:8: the least length of a tendon is not simulated");
    said("model.xml:11: tendons around geoms and over pulleys");
}

#[test]
fn a_spring_without_a_length_is_free_where_joints_are_at_their_springref() {
    let text = "<mujoco><worldbody><site name='w' pos='0 0 1'/><body name='far' pos='3 1 0'><freejoint/><geom size='.1'/><site name='o'/></body>
      <body name='a' pos='.6 0 .5'><joint name='h' axis='0 1 0' pos='-.6 0 0' ref='20'/><geom size='.1'/>
       <body name='b' pos='.3 .1 0' euler='0 0 30'><joint name='s' type='slide' axis='1 1 0' ref='.1' springref='.4'/>
        <joint name='k' axis='1 0 1' pos='0 .2 0' springref='50' stiffness='1'/><geom size='.1'/>
        <body name='c' pos='0 0 .4'><joint type='ball'/><geom size='.1'/><site name='s' pos='.1 .2 .3'/></body></body></body></worldbody>
      <tendon><spatial stiffness='3'><site site='w'/><site site='s'/></spatial><spatial stiffness='3'><site site='s'/><site site='o'/></spatial>
       <spatial stiffness='3' springlength='.7'><site site='w'/><site site='s'/></spatial></tendon></mujoco>";
    let scene = read("mjcf_springref", text).expect("a scene");
    // `tendon_lengthspring` of MuJoCo 4.0.0; the sums have some ten terms below 4 m.
    let lengths: Vec<f64> = scene
        .springs
        .iter()
        .filter_map(|spring| match &spring.place {
            catena::scene::SpringPlace::Points { rest_length, .. } => Some(*rest_length),
            _ => None,
        })
        .collect();
    let wanted = [1.1237799642847273, 2.60414844918904, 0.7];
    let near = lengths.iter().zip(wanted).all(|(own, wanted)| (own - wanted).abs() < 1e-14);
    assert!(lengths.len() == 3 && near, "{lengths:?}");
}

#[test]
fn a_tendon_between_points_of_one_rigid_body_is_left_out_with_a_warning() {
    let text =
        "<mujoco><worldbody><site name='w'/><body name='a'><joint axis='0 1 0'/><geom size='.1'/><site name='s'/>
      <body name='b' pos='0 0 .2'><geom size='.1'/><site name='t'/></body></body></worldbody>
      <tendon><spatial stiffness='3'><site site='s'/><site site='t'/></spatial>
      <spatial range='0 3'><site site='s'/><site site='t'/></spatial>
      <spatial stiffness='3'><site site='s'/><site site='w'/></spatial></tendon></mujoco>";
    let scene = read("mjcf_rigid_tendon", text).expect("a scene");
    assert_eq!((scene.springs.len(), scene.ropes.len()), (1, 0));
    let told: Vec<String> = scene.warnings.iter().map(|warning| warning.to_string()).collect();
    let said =
        "model.xml:3: the sites of a tendon never move against each other; it is left out; the same for 1 more element";
    assert!(told.iter().any(|line| line.contains(said)), "{told:#?}");
}

#[test]
fn a_tendon_through_several_sites_is_a_rope_through_eyelets_on_all_their_bodies() {
    let text = TENDONS.replace(
        "<spatial name='over'><site site='hook'/><pulley divisor='2'/><site site='eye'/></spatial>",
        "<spatial name='over' stiffness='0' range='0 3'><site site='hook'/><site site='eye'/><site site='wrist'/></spatial>
         <spatial name='band'><site site='hook'/><site site='eye'/><site site='wrist'/></spatial>",
    );
    let text =
        text.replace("pos='0 0 -.5'/></body></body>", "pos='0 0 -.5'/><site name='wrist' pos='0 0 -1'/></body></body>");
    let scene = read("mjcf_reeved_tendon", &text).expect("a scene");
    let rope = scene.ropes.iter().find(|rope| rope.name == "over").expect("a rope");
    assert_eq!(rope.length, 3.0);
    let links: Vec<&str> = rope.points.iter().map(|point| point.name.as_str()).collect();
    assert_eq!(links, ["world", "ball/ball", "arm/fore"]);
    assert_eq!(rope.points[2].position.as_slice(), [0.0, 0.0, -1.0]);
    let told: Vec<String> = scene.warnings.iter().map(|warning| warning.to_string()).collect();
    let band = "model.xml:12: stiffness and damping of a tendon through more than two sites are not simulated";
    assert!(told.iter().any(|line| line.contains(band)), "{told:#?}");
}

#[test]
fn a_held_fixed_tendon_is_a_coupling_and_its_motor_drives_all_its_joints() {
    let folder = crate::common::command::folder("mjcf_fixed_tendons");
    let path = folder.join("model.xml");
    std::fs::write(&path, TENDONS).expect("written");
    let model = Model::loader().keyframe("k").load(&path).expect("a model");
    let (q, v) = model.start().expect("a start");
    let &[.., a, b] = q.as_slice() else { panic!("{q:?}") };
    // Positions are counted from `ref`, and the sum of the tendon from the start: 1 · a + 2 · b = 0.1.
    assert!((a + 2.0 * b - 0.1).abs() < 1e-15, "{a} {b}");
    let motors = &model.description().mechanism.nonsmooth.motors;
    let efforts: Vec<f64> = motors.iter().map(|motor| motor.effort(0.0, q[0], v[0])).collect();
    // The gear 3, the control 0.5 and the coefficients 1 and 2.
    assert_eq!(efforts, [1.5, 3.0]);
    // A tendon of one joint that is held locks it at a/c = 0.1/0.5.
    let locked = TENDONS.replace("tendon1='sum'", "tendon1='one'");
    let scene = read("mjcf_locked_tendon", &locked).expect("a scene");
    assert!(scene.couplings.is_empty());
    assert!(matches!(scene.joints[0].limit, Some(LimitChoice::Range(0.2, 0.2))), "{:?}", scene.joints[0].limit);
    // Two tendons keep their relation: (a + 2 b) − 2 · b/2 = 0.1.
    let tied = TENDONS.replace("tendon1='sum' polycoef='0.1'", "tendon1='sum' tendon2='one' polycoef='0.1 2'");
    let scene = read("mjcf_tied_tendons", &tied).expect("a scene");
    let terms: Vec<(&str, f64)> =
        scene.couplings[0].terms.iter().map(|(joint, own)| (joint.joint.as_str(), *own)).collect();
    assert_eq!((terms, scene.couplings[0].offset), (vec![("a", 1.0), ("b", 1.0)], 0.1));
    // An actuator that depends on the length of a tendon of several joints is not simulated.
    let sprung = TENDONS.replace("<motor tendon='sum' gear='3'/>", "<position tendon='sum' kp='3'/>");
    let scene = read("mjcf_sprung_tendon", &sprung).expect("a scene");
    assert!(scene.motors.is_empty());
    assert!(scene.warnings.iter().any(|warning| warning.group == WarningGroup::NotSimulated));
}

#[test]
fn two_geoms_have_the_larger_friction_of_the_ways_that_either_resists_or_that_of_the_higher_priority() {
    let ball =
        |name: &str, more: &str| format!("<body name='{name}'><freejoint/><geom size='0.1' mass='1' {more}/></body>");
    let text = format!(
        "<mujoco><worldbody><geom name='ice' type='plane' size='1 1 1' condim='1' friction='0.4'/>
        <geom name='rug' type='plane' size='1 1 1' condim='6' friction='0.2 0.03 0.002'/>
        <geom name='oil' type='plane' size='1 1 1' condim='3' friction='0.1' priority='1'/>{}{}{}</worldbody></mujoco>",
        ball("plain", "friction='0.7'"),
        ball("smooth", "condim='1'"),
        ball("pin", "condim='4' friction='0.3 0.02 0.01'"),
    );
    let folder = crate::common::command::folder("mjcf_grips");
    std::fs::write(folder.join("model.xml"), text).expect("written");
    let model = Model::load(folder.join("model.xml")).expect("a model");
    let nonsmooth = &model.description().mechanism.nonsmooth;
    // μ, ρ and σ, from the rule of MuJoCo by hand. The defaults are 1, 0.0001 and 0.005.
    let wanted = [
        ("plain/plain", "ice", [0.7, 0.0, 0.0]),
        ("plain/plain", "rug", [0.7, 0.002, 0.03]),
        ("plain/plain", "oil", [0.1, 0.0, 0.0]),
        ("smooth/smooth", "ice", [0.0, 0.0, 0.0]),
        ("smooth/smooth", "rug", [1.0, 0.002, 0.03]),
        ("smooth/smooth", "oil", [0.1, 0.0, 0.0]),
        ("pin/pin", "ice", [0.4, 0.0, 0.02]),
        ("pin/pin", "rug", [0.3, 0.01, 0.03]),
        ("pin/pin", "oil", [0.1, 0.0, 0.0]),
        ("plain/plain", "smooth/smooth", [1.0, 0.0, 0.0]),
        ("plain/plain", "pin/pin", [0.7, 0.0, 0.02]),
        ("smooth/smooth", "pin/pin", [1.0, 0.0, 0.02]),
    ];
    let found = |a: &str, b: &str| {
        let named = |number: usize| nonsmooth.colliders[number].name.as_str();
        let pair = nonsmooth.pairs.iter().find(|pair| [(a, b), (b, a)].contains(&(named(pair.a), named(pair.b))));
        let pair = pair.unwrap_or_else(|| panic!("{a} and {b} never touch"));
        [pair.friction, pair.moments.rolling, pair.moments.spinning]
    };
    for (a, b, wanted) in wanted {
        assert_eq!(found(a, b), wanted, "{a} {b}");
    }
    assert_eq!(nonsmooth.pairs.len(), wanted.len());
}

#[test]
fn ellipsoids_of_a_file_that_switches_contact_off_are_no_warning() {
    let parts = "<worldbody><geom type='ellipsoid' size='1 1 .5'/>
      <body name='egg' pos='0 0 3'><freejoint/><geom type='ellipsoid' size='0.2 0.1 0.05' mass='1'/></body>
      <body name='both' pos='0 0 5'><freejoint/><geom type='ellipsoid' size='0.2 0.1 0.05'/><geom type='sphere' size='.1'/></body></worldbody>";
    let folder = crate::common::command::folder("mjcf_ellipsoids_without_contact");
    let warnings = |option: &str| {
        std::fs::write(folder.join("model.xml"), format!("<mujoco>{option}{parts}</mujoco>")).expect("written");
        let model = Model::load(folder.join("model.xml")).expect("a model");
        let pairs = model.description().mechanism.nonsmooth.pairs.iter().count();
        (pairs, model.warnings().iter().filter(|line| line.contains("llipsoid")).count())
    };
    assert_eq!(warnings("<option><flag contact='disable'/></option>"), (0, 0));
    // The sphere touches nothing else.
    assert_eq!(warnings("").1, 3);
}

#[test]
fn an_ellipsoid_touches_planes_and_rests_on_its_shortest_axis() {
    let text = "<mujoco><worldbody><geom name='floor' type='plane' size='1 1 1'/><geom name='step' type='box' size='1 1 .1' pos='3 0 0'/>
      <body name='egg' pos='0 0 0.3'><freejoint/><geom type='ellipsoid' size='0.2 0.1 0.05' mass='1'/></body></worldbody></mujoco>";
    let folder = crate::common::command::folder("mjcf_ellipsoid");
    std::fs::write(folder.join("model.xml"), text).expect("written");
    let model = Model::load(folder.join("model.xml")).expect("a model");
    let contact = &model.description().mechanism.nonsmooth;
    let others: Vec<&str> =
        contact.pairs.iter().map(|pair| contact.colliders[pair.a.max(pair.b)].name.as_str()).collect();
    assert_eq!(others, ["floor"]);
    let warnings = model.warnings();
    assert!(
        warnings.iter().any(|line| line.contains("model.xml:2: a body of ellipsoids touches planes")),
        "{warnings:?}"
    );
    let mut simulation = Simulation::new(&model).duration(1.0);
    simulation.run().expect("a run");
    // It falls 0.25 m without rebound, and lies on its shortest axis, up to the rounding of the gap's equation.
    let height = simulation.pose("egg").expect("a link").translation.z;
    assert!((height - 0.05).abs() < 1e-12, "{height}");
}
