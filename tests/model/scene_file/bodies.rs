//! A `[[body]]` is the robot of one link that a URDF would describe; copies and degrees are the same as written out.

use super::{ONE, build, folder, read, refusal};
use catena::mechanism::motion::kinematics::body_states;
use catena::model::Model;
use catena::scene::{Geometry, SceneBody, Surface, Weight};
use nalgebra::Vector3;
use std::path::Path;

/// Mass (kg), ∫ z² dm and ∫ (x² + y²) dm of a round shape along z, from discs: Gauss' rule with three points on each piece of 1/2000 of the height.
fn by_discs(radius_at: impl Fn(f64) -> f64, half_height: f64, density: f64) -> [f64; 3] {
    const PIECES: usize = 2000;
    let width = 2.0 * half_height / PIECES as f64;
    let mut sums = [0.0; 3];
    for piece in 0..PIECES {
        let middle = -half_height + (piece as f64 + 0.5) * width;
        for (node, weight) in [(-0.6_f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6_f64.sqrt(), 5.0 / 18.0)] {
            let z = middle + 0.5 * width * node;
            let square = radius_at(z).powi(2);
            let mass = density * std::f64::consts::PI * square * width * weight;
            sums[0] += mass;
            sums[1] += mass * z * z;
            sums[2] += 0.5 * mass * square;
        }
    }
    sums
}

#[test]
fn mass_and_moments_are_those_of_the_matter_in_the_shape() {
    let density = 700.0;
    let (r, l) = (0.3, 0.8);
    let body = |shape| SceneBody { shape, weight: Weight::Density(density), color: None, surface: Surface::default() };
    let cap = |z: f64| (r * r - (z.abs() - 0.5 * l).max(0.0).powi(2)).max(0.0).sqrt();
    let ball = |z: f64| (r * r - z * z).max(0.0).sqrt();
    let round = [
        (body(Geometry::Sphere { radius: r }), by_discs(ball, r, density)),
        (body(Geometry::Cylinder { radius: r, length: l }), by_discs(|_| r, 0.5 * l, density)),
        (body(Geometry::Capsule { radius: r, length: l }), by_discs(cap, 0.5 * l + r, density)),
    ];
    for (body, [mass, along, across]) in round {
        let moments = body.moments();
        let expected = Vector3::new(along + 0.5 * across, along + 0.5 * across, across);
        // The squared radius is piecewise quadratic in z, but for the one piece in which a round end begins: 1/2000 of the height, to the third power.
        assert!((body.mass() - mass).abs() < 1e-9 * mass, "{body:?}: {} {mass}", body.mass());
        assert!((moments - expected).amax() < 1e-9 * expected.amax(), "{body:?}: {moments} {expected}");
    }
    let block = body(Geometry::Box { size: Vector3::new(1.0, 2.0, 3.0) });
    assert_eq!((block.mass(), block.moments()), (4200.0, 350.0 * Vector3::new(13.0, 10.0, 5.0)));
    // A mass instead of a density scales them.
    let light = SceneBody { weight: Weight::Mass(2.1), ..block };
    assert_eq!(light.mass(), 2.1);
    let scaled: Vector3<f64> = light.moments() - 0.175 * Vector3::new(13.0, 10.0, 5.0);
    assert!(scaled.amax() < 1e-15);
}

const CAPSULE: &str = "[[body]]\nname = \"pill\"\nshape = { type = \"capsule\", radius = 0.1, length = 0.5 }\ndensity = 500\n\
    color = [1, 0.5, 0]\npose = { position = [0, 0, 1], rpy = [0, \"90 deg\", 0] }\n\
    velocity = { linear = [1, 0, 0], angular = [0, 0, \"180 deg/s\"] }\n";
const GROUND: &str = "[[obstacle]]\nname = \"ground\"\nshape = { type = \"half_space\" }\n";

#[test]
fn a_body_is_the_same_mechanism_as_its_urdf_written_out() {
    let folder = folder("body_long");
    let scene = read(&folder, CAPSULE).unwrap();
    let urdf = scene.robots[0].body.as_ref().unwrap().urdf("pill");
    std::fs::write(folder.join("pill.urdf"), urdf).unwrap();
    let long = "[[robot]]\nurdf = \"pill.urdf\"\nbase = \"floating\"\n\
        pose = { position = [0, 0, 1], rpy = [0, 1.5707963267948966, 0] }\n\
        velocity = { linear = [1, 0, 0], angular = [0, 0, 3.141592653589793] }\n";
    let (short, _, start) = build(&folder, &format!("{CAPSULE}{GROUND}"));
    let (written, _, long_start) = build(&folder, &format!("{long}{GROUND}"));
    assert_eq!(start, long_start);
    // The joint of its base has the name of the body; everything else is equal to the last digit.
    let as_urdf =
        |model: &Model| format!("{:?}", model.mechanism).replace("name: \"pill\", kind", "name: \"base\", kind");
    assert_eq!(as_urdf(&short), as_urdf(&written));
    assert_eq!(short.robots[0].robot.links[0].visuals[0].color, Some([1.0, 0.5, 0.0, 1.0]));
    assert_eq!(short.moving_joints().collect::<Vec<_>>(), ["pill"]);
}

#[test]
fn bodies_have_plain_names_beside_a_robot_and_leave_its_names_plain() {
    let folder = folder("body_names");
    let text = format!("{ONE}{CAPSULE}[[contact.pair]]\na = \"pill\"\nb = \"ground\"\nfriction = 0.1\n{GROUND}");
    let (model, _, _) = build(&folder, &text);
    let links: Vec<&str> = model.links.iter().map(|link| link.name.as_str()).collect();
    assert_eq!(links, ["base", "upper", "lower", "weight", "sensor", "lens", "pill"]);
    assert_eq!(model.moving_joints().collect::<Vec<_>>(), ["shoulder", "elbow", "pill"]);
    assert_eq!(model.mechanism.nonsmooth.pairs.at(0).friction, 0.1);
    for (name, what) in [("lower", "has a link"), ("elbow", "has a joint"), ("base", "has a link"), ("double", "taken")]
    {
        let text = format!("{ONE}{}", CAPSULE.replace("pill", name));
        let message = refusal(&folder, &text);
        assert!(message.starts_with("scene.toml:3: body ") && message.contains(what), "{message}");
    }
}

#[test]
fn copies_stand_a_spacing_apart_and_are_numbered_along_x_first() {
    let folder = folder("copies");
    let grid = format!("{CAPSULE}grid = [2, 1, 3]\nspacing = [1, 5, 2]\n");
    let (model, _, state) = build(&folder, &grid);
    let bodies = body_states(&model.mechanism, &state);
    for (number, (x, z)) in [(0, 0), (1, 0), (0, 1), (1, 1), (0, 2), (1, 2)].into_iter().enumerate() {
        let link = model.link(&format!("pill{}", number + 1)).expect("numbered from 1");
        let place = model.link_pose(&bodies, link).0;
        assert_eq!(place, Vector3::new(f64::from(x), 0.0, 1.0 + 2.0 * f64::from(z)), "copy {number}");
    }
    let row = format!("{ONE}count = 3\nspacing = [0, 1.5, 0.5]\npositions = {{ elbow = 0.2 }}\n");
    let (model, start, _) = build(&folder, &row);
    let places: Vec<_> = model.robots.iter().map(|placed| placed.base_pose.translation.vector).collect();
    assert_eq!(places, [0.0, 1.0, 2.0].map(|step| Vector3::new(0.0, 1.5 * step, 0.5 * step)));
    let named: Vec<&str> = start.positions.iter().map(|(joint, _)| joint.as_str()).collect();
    assert_eq!(named, ["double1/elbow", "double2/elbow", "double3/elbow"]);
}

#[test]
fn degrees_are_read_wherever_an_angle_is_and_refused_where_none_is() {
    let folder = folder("degrees");
    let scene = |angle: &str, rate: &str| {
        format!(
            "[[robot]]\nurdf = \"limbs.urdf\"\npose = {{ rpy = [0, 0, {angle}] }}\n\
             positions = {{ hinge = {angle}, ball = [{angle}, 0, 0], sheet = [1, 2, {angle}] }}\nvelocities = {{ wheel = {rate} }}\n\
             [[joint]]\nname = \"hinge\"\nlimit = [\"-90 deg\", {angle}]\n\
             [[motor]]\njoint = \"wheel\"\nkind = \"velocity\"\nkd = 1\ntarget = [[0, 0], [1, {rate}]]\n\
             [[motor]]\njoint = \"hinge\"\nkind = \"position\"\nkp = 1\ntarget = {angle}\n\
             [[spring]]\njoint = \"hinge\"\nstiffness = 1\nrest = {angle}\n"
        )
    };
    let degrees = read(&folder, &scene("\"45 deg\"", "\"90 deg/s\"")).unwrap();
    let radians = read(&folder, &scene("0.7853981633974483", "1.5707963267948966")).unwrap();
    assert_eq!(degrees.robots[0].positions, radians.robots[0].positions);
    assert_eq!(degrees.robots[0].velocities, radians.robots[0].velocities);
    assert_eq!(degrees.robots[0].pose, radians.robots[0].pose);
    assert_eq!((&degrees.joints, &degrees.springs), (&radians.joints, &radians.springs));
    assert_eq!(degrees.motors, radians.motors);
    let limbed = "[[robot]]\nurdf = \"limbs.urdf\"\n";
    for (rest, said) in [
        ("positions = { slide = \"1 deg\" }\n", "scene.toml:3: robot \"limbs\": joint \"slide\": it is no angle"),
        ("velocities = { hinge = \"1 deg\" }\n", "scene.toml:3: robot \"limbs\": joint \"hinge\": it is a rate"),
        ("positions = { sheet = [\"1 deg\", 0, 0] }\n", "joint \"sheet\": it is no angle"),
        (
            "[[joint]]\nname = \"slide\"\nlimit = [0, \"1 deg\"]\n",
            "scene.toml:4: joint \"slide\": joint \"slide\": it is no angle",
        ),
        ("[[motor]]\njoint = \"hinge\"\nkind = \"effort\"\ntarget = \"1 deg\"\n", "it is no angle"),
        ("positions = { hinge = \"1 degree\" }\n", "is no number with a unit"),
    ] {
        let message = refusal(&folder, &format!("{limbed}{rest}"));
        assert!(message.contains(said) && message.lines().count() == 1, "{rest}: {message}");
    }
}

#[test]
fn numbers_of_a_body_are_set_as_if_its_table_said_them() {
    let folder = folder("body_numbers");
    let mut set = read(&folder, CAPSULE).unwrap();
    let numbers = [("body.pill.density", 800.0), ("pill.shape.radius", 0.2), ("pill.pose.rpy.roll", 0.3)];
    let numbers = numbers.map(|(key, number)| (set.parameter(key).unwrap(), number));
    set.set(&numbers).unwrap();
    let said = CAPSULE.replace("500", "800").replace("radius = 0.1", "radius = 0.2").replace("rpy = [0", "rpy = [0.3");
    let said = read(&folder, &said).unwrap();
    let mechanism = |scene| format!("{:?}", Model::from_scene(scene).unwrap().0.mechanism);
    assert_eq!(mechanism(&set), mechanism(&said));
    assert_eq!(set.robots[0].robot.description, said.robots[0].robot.description);
}

#[test]
fn a_body_that_cannot_be_is_refused_in_one_line() {
    let folder = folder("body_errors");
    let sphere = "[[body]]\nname = \"b\"\nshape = { type = \"sphere\", radius = 1 }\n";
    for (text, said) in [
        (sphere.to_string(), "scene.toml:1: body \"b\": a body needs its density"),
        (format!("{sphere}density = 1\nmass = 1"), "scene.toml:5: body \"b\": give either the density or the mass"),
        (format!("{sphere}mass = 0"), "scene.toml:4: body \"b\": body.mass: 0 must be greater than zero"),
        (format!("{sphere}mass = 1\ncolor = [1, 2, 3]"), "scene.toml:5: body \"b\": body.color: 2 must be from 0 to 1"),
        (format!("{sphere}mass = 1\ncolor = [1, 0]"), "scene.toml:5: body \"b\": a color is"),
        (format!("{sphere}mass = 1\ncount = 2"), "scene.toml:5: body \"b\": copies need their spacing"),
        (format!("{sphere}mass = 1\nspacing = [1, 0, 0]"), "scene.toml:5: body \"b\": a spacing needs"),
        (
            format!("{sphere}mass = 1\ngrid = [100, 100, 2]\nspacing = [1, 1, 1]"),
            "scene.toml:5: body \"b\": it must be there",
        ),
        (sphere.replace("\"b\"", "\"a/b\""), "scene.toml:2: body \"a/b\": the name of a body"),
        (sphere.replace("sphere\", radius = 1", "half_space\""), "scene.toml:3: body \"b\": a body is a sphere"),
        (sphere.replace("radius = 1", "radius = 1e200") + "density = 1e200", "scene.toml:1: body \"b\": "),
    ] {
        let message = refusal(Path::new(&folder), &text);
        assert!(message.starts_with(said) && message.lines().count() == 1, "{text}: {message}");
    }
}
