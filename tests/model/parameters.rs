//! Numbers set by their key paths give what the files would give with these numbers in them.

use crate::common::command;
use catena::model::{Model, ModelOptions};
use catena::scene::{FilesOnDisk, PackagePath, Quantity, Scene, read_urdf, scene_from_text};
use std::path::Path;

/// A robot and a scene in which every number that has a key path is written `<key=number>`.
const ROBOT: &str = r#"<robot name="arm">
  <link name="base"/>
  <link name="upper"><inertial><origin xyz="<link.upper.center_of_mass.x=0.1> 0 -0.5" rpy="0 0.1 <link.upper.inertia.yaw=0.2>"/><mass value="<link.upper.mass=1.5>"/>
    <inertia ixx="<link.upper.inertia.ixx=0.2>" iyy="0.2" izz="0.15" ixy="<link.upper.inertia.ixy=0.01>" ixz="0" iyz="0"/></inertial></link>
  <link name="lower"><inertial><origin xyz="0 0 -0.5"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="<link.lower.collision.1.origin.x=0.5> 0 0"/>
      <geometry><sphere radius="<link.lower.collision.1.radius=0.1>"/></geometry></collision>
    <collision><origin rpy="0.1 <link.lower.collision.2.origin.pitch=0.2> 0"/>
      <geometry><capsule radius="<link.lower.collision.2.radius=0.1>" length="<link.lower.collision.2.length=0.75>"/></geometry></collision></link>
  <link name="bob"><inertial><origin xyz="0 0 -0.2"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="finger"><inertial><origin xyz="0 0 -0.1"/><mass value="0.5"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.02" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="shoulder" type="continuous"><parent link="base"/><child link="upper"/><axis xyz="0 1 0"/></joint>
  <joint name="elbow" type="revolute"><parent link="upper"/><child link="lower"/><origin xyz="0 0 <joint.elbow.origin.z=-1>" rpy="0 <joint.elbow.origin.pitch=0.1> 0.3"/>
    <axis xyz="0 1 <joint.elbow.axis.z=0.7>"/><limit lower="-2" upper="2" effort="<joint.elbow.limit.effort=9>" velocity="<joint.elbow.limit.velocity=3>"/><dynamics friction="0.1" damping="0.3"/></joint>
  <joint name="ball" type="spherical"><parent link="lower"/><child link="bob"/><origin xyz="0 0 -1"/></joint>
  <joint name="finger" type="continuous"><parent link="upper"/><child link="finger"/><axis xyz="1 0 0"/>
    <mimic joint="shoulder" multiplier="<joint.finger.mimic.multiplier=0.5>" offset="<joint.finger.mimic.offset=0.1>"/></joint>
</robot>"#;

const SCENE: &str = r#"
[scene]
gravity = [0, <scene.gravity.y=0.5>, -9.81]
[[robot]]
urdf = "arm.urdf"
pose = { position = [0, <robot.arm.pose.position.y=0.25>, 2], rpy = [0.1, <robot.arm.pose.rpy.pitch=1.5707963267948966>, 0.2] }
positions = { shoulder = <robot.arm.positions.shoulder=0.5>, ball = [0.1, 0.2, <robot.arm.positions.ball.yaw=0.3>] }
velocities = { elbow = <robot.arm.velocities.elbow=1.5>, ball = [0.1, <robot.arm.velocities.ball.wy=0.2>, 0] }
[[robot]]
name = "free"
urdf = "box.urdf"
base = "floating"
pose = { position = [5, 0, 3] }
velocity = { linear = [0, 0, <robot.free.velocity.linear.z=1>], angular = [<robot.free.velocity.angular.x=2>, 0, 0] }
[[robot]]
name = "puck"
urdf = "puck.urdf"
base = "floating"
pose = { position = [-5, 0, 3] }
[[robot]]
name = "disc"
urdf = "disc.urdf"
base = "floating"
pose = { position = [-9, 0, 3] }
[[loop]]
name = "hinge"
type = "revolute"
a = { link = "disc/disc", position = [0, 0, <loop.hinge.a.position.z=0.25>], axis = [0, <loop.hinge.a.axis.y=0.3>, 1] }
b = { link = "world", position = [-9, 0, 3], axis = [<loop.hinge.b.axis.x=0.2>, 0, 1] }
[[spring]]
name = "band"
a = { link = "arm/lower", position = [0, <spring.band.a.position.y=0.25>, 0] }
b = { link = "world", position = [<spring.band.b.position.x=4>, 0, 0] }
stiffness = <spring.band.stiffness=30>
damping = <spring.band.damping=0.5>
rest_length = <spring.band.rest_length=1.5>
[[spring]]
joint = "arm/shoulder"
stiffness = 2
rest = <spring.spring2.rest=0.1>
[[load]]
joint = "arm/elbow"
effort = <load.arm/elbow.effort=0.5>
[[load]]
link = "free/box"
position = [0, 0, <load.2.position.z=0.1>]
force = [<load.2.force.x=1>, 0, 0]
torque = [0, <load.2.torque.y=1>, 0]
[[load]]
link = "free/box"
force = [<load.3.force.x=2>, 0, 0]
[[motor]]
joint = "arm/shoulder"
kind = "position"
target = <motor.arm/shoulder.target=0.75>
kp = <motor.arm/shoulder.kp=10>
kd = <motor.arm/shoulder.kd=1>
max_effort = <motor.arm/shoulder.max_effort=20>
period = <motor.arm/shoulder.period=0.01>
[[motor]]
joint = "arm/elbow"
kind = "position"
target = [[0, 0.1], [<motor.arm/elbow.target.2.time=0.5>, 0.3], [2, <motor.arm/elbow.target.3.value=0.2>]]
interpolation = "cubic"
kp = 5
[[joint]]
name = "arm/elbow"
limit = [<joint.arm/elbow.limit.lower=-1.5>, <joint.arm/elbow.limit.upper=1.5>]
restitution = <joint.arm/elbow.restitution=0.5>
friction = <joint.arm/elbow.friction=0.25>
damping = <joint.arm/elbow.damping=0.125>
[[obstacle]]
name = "slope"
shape = { type = "half_space", normal = [0, <obstacle.slope.shape.normal.y=0.9>, 1] }
pose = { position = [0, 0, <obstacle.slope.pose.position.z=-9>], rpy = [0.1, 0, <obstacle.slope.pose.rpy.yaw=0.2>] }
friction = <obstacle.slope.friction=0.5>
restitution = <obstacle.slope.restitution=0.5>
[[obstacle]]
name = "post"
shape = { type = "cylinder", radius = <obstacle.post.shape.radius=0.5>, length = <obstacle.post.shape.length=2> }
pose = { position = [9, 0, 0] }
[[obstacle]]
name = "crate"
shape = { type = "box", size = [1, <obstacle.crate.shape.size.y=2>, 1] }
pose = { position = [0, 9, 0] }
[[obstacle]]
name = "wedge"
shape = { type = "mesh", file = "wedge.obj", scale = [1, <obstacle.wedge.shape.scale.y=2>, 1] }
pose = { position = [0, -9, 0] }
[contact]
friction = <contact.friction=0.4>
restitution = <contact.restitution=0.1>
[[contact.pair]]
a = "free/box"
b = "crate"
friction = <contact.pair.1.friction=0.7>
restitution = <contact.pair.1.restitution=0.25>
[simulation]
duration = <simulation.duration=2>
tolerance = <simulation.tolerance=1e-5>
rate = <simulation.rate=50>
"#;

const BOX: &str = r#"<robot name="box"><link name="box"><inertial><origin xyz="0 0.1 0"/><mass value="<link.free/box.mass=2>"/>
  <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
  <collision><geometry><box size="1 <link.free/box.collision.1.size.y=1> 1"/></geometry></collision>
  <collision><geometry><mesh filename="wedge.obj" scale="1 1 <link.free/box.collision.2.scale.z=0.5>"/></geometry></collision></link></robot>"#;

const PUCK: &str = r#"<robot name="puck"><link name="puck"><inertial><mass value="1"/>
  <inertia ixx="0.1" iyy="0.2" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <loop_joint name="slide" type="planar"><axis xyz="0 <loop.puck/slide.axis.y=0.2> 1"/>
    <link1 link="puck" xyz="0 0 <loop.puck/slide.a.position.z=0.5>" rpy="0 <loop.puck/slide.a.rpy.pitch=0.1> 0"/>
    <link2 link="world" xyz="0 <loop.puck/slide.b.position.y=0.3> 0.5" rpy="<loop.puck/slide.b.rpy.roll=0.1> 0 0"/></loop_joint></robot>"#;

const DISC: &str = r#"<robot name="disc"><link name="disc"><inertial><mass value="1"/>
  <inertia ixx="0.1" iyy="0.2" izz="0.3" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"#;

const WEDGE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";

/// The text with all numbers, but for one key the other one; and all keys with their numbers.
fn filled(template: &str, other: Option<(&str, f64)>) -> (String, Vec<(String, f64)>) {
    let (mut text, mut keys) = (String::new(), Vec::new());
    let mut rest = template;
    // A key holds no white space; tags of the URDF hold no number after `=`.
    while let Some(start) = rest.find('<') {
        let (before, tail) = rest.split_at(start);
        text += before;
        let inside = tail.find('>').map(|end| &tail[1..end]);
        let token = inside
            .and_then(|inside| inside.split_once('='))
            .and_then(|(key, number)| Some((key, number.parse::<f64>().ok()?)));
        match token {
            Some((key, number)) => {
                let number = other.filter(|(of, _)| *of == key).map_or(number, |(_, number)| number);
                text += &number.to_string();
                keys.push((key.to_string(), number));
                rest = &tail[tail.find('>').unwrap() + 1..];
            }
            None => {
                text.push('<');
                rest = &tail[1..];
            }
        }
    }
    (text + rest, keys)
}

/// The scene of these files, in which one number is another.
fn scene(folder: &Path, other: Option<(&str, f64)>) -> Scene {
    std::fs::write(
        folder.join("arm.urdf"),
        filled(&ROBOT.replace("link.", "link.arm/").replace("joint.", "joint.arm/"), other).0,
    )
    .unwrap();
    for (file, template) in [("box.urdf", BOX), ("puck.urdf", PUCK), ("disc.urdf", DISC), ("wedge.obj", WEDGE)] {
        std::fs::write(folder.join(file), filled(template, other).0).unwrap();
    }
    let text = filled(SCENE, other).0;
    scene_from_text(&text, &folder.join("scene.toml"), &mut FilesOnDisk(&PackagePath::default()))
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Everything that a run is made from.
fn meaning(scene: &Scene) -> String {
    let (model, start) = Model::from_scene(scene).unwrap_or_else(|error| panic!("{error}"));
    let state = model.initial_state(&start.positions, &start.velocities, None).unwrap();
    format!("{:?}\n{:?}\n{:?}", model.mechanism, state, scene.simulation)
}

#[test]
fn a_number_set_by_its_key_path_is_that_of_a_file_that_says_it() {
    let folder = command::folder("parameters_set");
    let templates =
        [ROBOT.replace("link.", "link.arm/").replace("joint.", "joint.arm/"), BOX.into(), PUCK.into(), SCENE.into()];
    let keys: Vec<(String, f64)> = templates.iter().flat_map(|template| filled(template, None).1).collect();
    assert_eq!(keys.len(), 76, "all of them were found");
    let base = scene(&folder, None);
    let all = base.parameters();
    for (key, said) in keys {
        let parameter = base.parameter_among(&all, &key).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(parameter.said(), Some(said), "{key}");
        let other = 0.9 * said;
        let mut set = base.clone();
        set.set(&[(parameter.clone(), other)]).unwrap_or_else(|error| panic!("{error}"));
        let edited = scene(&folder, Some((&key, other)));
        // What it means differs, and to the last bit as in the edited files.
        assert!(meaning(&set) != meaning(&base), "{key} changes nothing");
        assert!(meaning(&set) == meaning(&edited), "{key}\n{}\n{}", meaning(&set), meaning(&edited));
    }
}

#[test]
fn an_unknown_key_path_is_named_with_the_nearest_and_a_short_one_must_mean_one_number() {
    let folder = command::folder("parameters_unknown");
    let scene = scene(&folder, None);
    let refused =
        |key: &str| scene.parameter(key).unwrap_err().to_string().replace(&format!("{}/", folder.display()), "");
    let nearest = refused("link.arm/uper.mass");
    assert!(nearest.starts_with(r#"scene.toml: no number of the scene is called "link.arm/uper.mass"; the nearest are "link.arm/upper.mass""#), "{nearest}");
    let strange = refused("§");
    assert!(strange.contains("`catena model INPUT --parameters` lists all"), "{strange}");
    assert_eq!(scene.parameter("gravity.z").unwrap().key(), "scene.gravity.z");
    assert_eq!(scene.parameter("positions.shoulder").unwrap().key(), "robot.arm.positions.shoulder");
    assert_eq!(scene.parameter("arm/upper.mass").unwrap().key(), "link.arm/upper.mass");
    let both = refused("velocity.linear.x");
    assert!(
        both.ends_with(
            r#""velocity.linear.x" may mean "robot.free.velocity.linear.x", "robot.puck.velocity.linear.x", "robot.disc.velocity.linear.x"; write it whole"#
        ),
        "{both}"
    );
}

#[test]
fn a_number_that_cannot_be_is_refused_with_file_line_and_reason() {
    let folder = command::folder("parameters_refused");
    let scene = scene(&folder, None);
    let refused = |numbers: &[(&str, f64)]| {
        let numbers: Vec<_> = numbers.iter().map(|&(key, number)| (scene.parameter(key).unwrap(), number)).collect();
        scene.clone().set(&numbers).unwrap_err().to_string().replace(&format!("{}/", folder.display()), "")
    };
    assert_eq!(
        refused(&[("link.arm/upper.mass", -1.0)]),
        "arm.urdf:3: link \"upper\": link.arm/upper.mass = -1: -1 must not be negative"
    );
    assert_eq!(
        refused(&[("spring.band.stiffness", f64::NAN)]),
        "scene.toml:30: spring \"band\": spring.band.stiffness = NaN: NaN is not finite"
    );
    assert!(refused(&[("joint.arm/elbow.restitution", 1.5)]).ends_with("1.5 must be from 0 to 1"));
    assert!(refused(&[("simulation.duration", 0.0)]).ends_with("0 must be greater than zero"));
    assert!(
        refused(&[("joint.arm/elbow.limit.lower", 1.75)])
            .ends_with("the lower limit 1.75 is above the upper limit 1.5; swap them")
    );
    // Both together are in order.
    let (lower, upper) = ("joint.arm/elbow.limit.lower", "joint.arm/elbow.limit.upper");
    let numbers = [(scene.parameter(lower).unwrap(), 1.75), (scene.parameter(upper).unwrap(), 2.0)];
    assert!(scene.clone().set(&numbers).is_ok());
}

#[test]
fn numbers_that_belong_together_are_looked_at_when_all_are_set() {
    let folder = command::folder("parameters_together");
    let scene = scene(&folder, None);
    let set = |numbers: &[(&str, f64)]| {
        let numbers: Vec<_> = numbers.iter().map(|&(key, number)| (scene.parameter(key).unwrap(), number)).collect();
        let mut set = scene.clone();
        set.set(&numbers)
            .map(|()| set)
            .map_err(|error| error.to_string().replace(&format!("{}/", folder.display()), ""))
    };
    // An axis is turned through zero by its numbers one after the other, and its length does not count.
    let axis = ["joint.arm/elbow.axis.x", "joint.arm/elbow.axis.y", "joint.arm/elbow.axis.z"];
    let turned = set(&[(axis[1], 0.0), (axis[2], 0.0), (axis[0], 3.0)]).unwrap();
    let elbow = turned.robots[0].robot.joints.iter().find(|joint| joint.name == "elbow").unwrap();
    assert_eq!(elbow.axis.as_slice(), [1.0, 0.0, 0.0]);
    let refused = set(&[(axis[1], 0.0), (axis[2], 0.0)]).unwrap_err();
    assert_eq!(
        refused,
        "arm.urdf:16: joint \"elbow\": joint.arm/elbow.axis.y = 0: the axis is zero, so the joint has no direction to move in"
    );
    // The times of a table must increase, all of them taken together.
    let times = ["motor.arm/elbow.target.2.time", "motor.arm/elbow.target.3.time"];
    assert!(set(&[(times[0], 2.5), (times[1], 3.0)]).is_ok());
    let refused = set(&[(times[0], 2.5)]).unwrap_err();
    assert!(refused.starts_with("scene.toml:"), "{refused}");
    assert!(
        refused.contains(
            "motor.arm/elbow.target.2.time = 2.5: its table over time: the time 2 s of entry 3 is not after 2.5 s"
        ),
        "{refused}"
    );
    for (key, number, reason) in [
        ("obstacle.wedge.shape.scale.y", 0.0, "the scale of a mesh must not be zero"),
        ("link.free/box.collision.2.scale.z", 0.0, "the scale of a mesh must not be zero"),
        ("link.arm/lower.collision.1.radius", 0.0, "0 must be greater than zero"),
        ("joint.arm/elbow.limit.effort", -1.0, "-1 must not be negative; write inf for no bound"),
        ("joint.arm/finger.mimic.multiplier", f64::INFINITY, "inf is not finite"),
    ] {
        let refused = set(&[(key, number)]).unwrap_err();
        assert!(refused.contains(&format!("{key} = {number}")) && refused.ends_with(reason), "{refused}");
    }
}

#[test]
fn the_number_of_stages_is_a_whole_number() {
    let folder = command::folder("parameters_stages");
    std::fs::write(folder.join("box.urdf"), filled(BOX, None).0).unwrap();
    std::fs::write(folder.join("wedge.obj"), WEDGE).unwrap();
    let text = "[[robot]]\nurdf = \"box.urdf\"\nbase = \"floating\"\n[simulation]\nstages = 4\nstep = 0.01\n";
    let read = scene_from_text(text, &folder.join("scene.toml"), &mut FilesOnDisk(&PackagePath::default())).unwrap();
    let stages = read.parameter("simulation.stages").unwrap();
    assert_eq!(stages.said(), Some(4.0));
    let set = |number: f64| {
        let mut set = read.clone();
        set.set(&[(stages.clone(), number)]).map(|()| set.simulation.fixed)
    };
    assert_eq!(set(5.0).unwrap(), Some((5, 0.01)));
    for number in [0.0, 17.0, 4.5, -4.0, f64::NAN, 1e300] {
        let refused = set(number).unwrap_err().to_string();
        assert!(refused.ends_with("must be a whole number from 1 to 16"), "{refused}");
    }
}

#[test]
fn a_link_without_mass_can_be_given_one_and_an_impossible_inertia_is_said() {
    let folder = command::folder("parameters_mass");
    let mut scene = Scene::of_robot(read_urdf(&folder.join("pendulum.urdf"), &PackagePath::default()).unwrap());
    let mass =
        |scene: &Scene| Model::from_scene(scene).unwrap().0.mechanism.bodies.iter().map(|body| body.mass).sum::<f64>();
    assert_eq!(mass(&scene), 1.0);
    let (tip, moment) = (scene.parameter("tip.mass").unwrap(), scene.parameter("rod.inertia.ixx").unwrap());
    assert_eq!(tip.said(), Some(0.0));
    scene.set(&[(tip, 0.5), (moment, 3.0)]).unwrap();
    assert_eq!(mass(&scene), 1.5);
    let (model, _) = Model::from_scene(&scene).unwrap();
    let warnings: Vec<String> = model.warnings.iter().map(ToString::to_string).collect();
    assert!(
        warnings.iter().any(|warning| warning.contains("link \"rod\": its inertia violates the triangle inequality")),
        "{warnings:?}"
    );
}

#[test]
fn a_robot_alone_is_the_same_as_a_scene_of_it() {
    for robot in ["pendulum.urdf", "arm7.urdf", "humanoid.urdf", "planar_slider.urdf", "quadruped.urdf"] {
        let read = || read_urdf(&Path::new("robots").join(robot), &PackagePath::default()).unwrap();
        let alone = Model::new(read(), &ModelOptions::default()).unwrap();
        let (of_scene, _) = Model::from_scene(&Scene::of_robot(read())).unwrap();
        assert_eq!(format!("{:?}", alone.mechanism), format!("{:?}", of_scene.mechanism), "{robot}");
    }
}

/// The model of a body is made anew when one of its numbers is set.
#[test]
fn what_a_link_table_says_of_a_body_holds_when_another_number_of_the_body_is_set() {
    let folder = command::folder("parameters_of_bodies");
    for shape in ["", "shape = 1\n"] {
        let text = |mass: f64, friction: f64| {
            format!(
                "[[body]]\nname = \"weight\"\nshape = {{ type = \"sphere\", radius = 0.1 }}\nmass = {mass:?}\nfriction = 0.9\n\
                 [[link]]\nname = \"weight\"\n{shape}friction = {friction:?}\nrestitution = 0.3\n"
            )
        };
        let read = |text: &str| {
            scene_from_text(text, &folder.join("s.toml"), &mut FilesOnDisk(&PackagePath::default())).expect("a scene")
        };
        let mechanism = |scene: &Scene| format!("{:?}", Model::from_scene(scene).expect("a model").0.mechanism);
        let mut set = read(&text(1.0, 0.2));
        set.set(&[(set.parameter("body.weight.mass").expect("a key"), 3.0)]).expect("a mass");
        assert_eq!(mechanism(&set), mechanism(&read(&text(3.0, 0.2))), "{shape}");
        set.set(&[(set.parameter("body.weight.friction").expect("a key"), 0.4)]).expect("a coefficient");
        assert_eq!(mechanism(&set), mechanism(&read(&text(3.0, 0.4))), "{shape}");
    }
}

#[test]
fn keys_that_can_never_be_set_are_not_listed() {
    let folder = command::folder("parameters_without_effect");
    let text = "[[body]]\nname = \"weight\"\nshape = { type = \"sphere\", radius = 0.1 }\nmass = 1\n[[robot]]\nname = \"arm\"\nurdf = \"arm.urdf\"\n\
        [[rope]]\nname = \"rope\"\npoints = [{ link = \"world\", position = [0, 0, 2] }, { link = \"weight\", position = [0, 0, 0] }]\n\
        length = { formula = \"a + b*t\", a = 2, b = 0.1 }\nlongest = 9\n[[motion]]\njoint = \"arm/hinge\"\nposition = 0.5\n";
    let arm = "<robot name='arm'><link name='base'/><link name='rod'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial></link>\
        <joint name='hinge' type='continuous'><parent link='base'/><child link='rod'/><axis xyz='0 1 0'/></joint></robot>";
    std::fs::write(folder.join("arm.urdf"), arm).unwrap();
    let read = scene_from_text(text, &folder.join("s.toml"), &mut FilesOnDisk(&PackagePath::default())).unwrap();
    let keys: Vec<String> = read.parameters().iter().map(|one| one.key().to_string()).collect();
    let innards = |key: &&String| {
        let of_winch = ["robot.rope", "link.rope", "joint.rope"].iter().any(|start| key.starts_with(start));
        of_winch || ["robot.arm.positions.hinge", "robot.arm.velocities.hinge"].contains(&key.as_str())
    };
    assert_eq!(keys.iter().find(innards), None);
    let mut moved = read.clone();
    moved.set(&[(moved.parameter("rope.rope.points.1.position.z").unwrap(), 3.0)]).unwrap();
    let other = text.replace("position = [0, 0, 2]", "position = [0, 0, 3]");
    let written = scene_from_text(&other, &folder.join("s.toml"), &mut FilesOnDisk(&PackagePath::default())).unwrap();
    assert!(meaning(&moved) == meaning(&written), "a winch stands where its rope begins");
    for wanted in ["rope.rope.length.b", "motion.arm/hinge.position", "link.rod.mass", "body.weight.mass"] {
        assert!(keys.iter().any(|key| key == wanted), "{wanted}: {keys:#?}");
    }
}

#[test]
fn a_number_of_an_angle_may_have_its_unit_and_no_other_may() {
    let folder = command::folder("parameters_units");
    let scene = scene(&folder, None);
    let number = |key: &str, text: &str| {
        let given = Quantity::parse(text).expect("a number with a unit");
        scene.number_of(&scene.parameter(key).expect("a key"), given).map_err(|error| error.to_string())
    };
    let close = |key: &str, text: &str, wanted: f64| {
        let found = number(key, text);
        // Rounding of one product.
        assert!(found.as_ref().is_ok_and(|found| (found - wanted).abs() < 1e-15), "{key}: {found:?}");
    };
    close("robot.arm.positions.shoulder", "10 deg", 10_f64.to_radians());
    close("robot.arm.velocities.shoulder", "10 deg/s", 10_f64.to_radians());
    close("joint.arm/shoulder.limit.upper", "90 deg", 90_f64.to_radians());
    close("joint.arm/shoulder.origin.roll", "0.5 rad", 0.5);
    close("robot.free.velocity.angular.x", "90 deg/s", 90_f64.to_radians());
    for (key, text, said) in [
        ("link.arm/upper.mass", "10 deg", "it is no angle"),
        ("robot.arm.positions.shoulder", "10 deg/s", "it is an angle, not a rate"),
        ("robot.arm.velocities.shoulder", "10 deg", "it is a rate"),
        ("robot.free.velocity.linear.x", "10 deg/s", "it is no angle"),
    ] {
        let error = number(key, text).expect_err("another unit");
        assert!(error.contains(key) && error.contains(said), "{error}");
    }
}
