//! What scene files say of contact becomes colliders and pairs: where shapes lie, which may touch, and how.

use super::{ONE, build, folder, refusal};
use catena::geometry::PairGeometry;
use catena::mechanism::description::contact::{Collider, Shape};
use catena::mechanism::motion::kinematics::body_states;
use catena::model::{Left, Model, NeverTouch, ReductionRule};
use nalgebra::{IsometryMatrix3, Rotation3, Vector3};
use std::path::{Path, PathBuf};

/// A trunk with a foot that is fixed to it, a leg that turns, and a shelf that the world holds.
const WALKER: &str = r#"<robot name="walker">
  <link name="trunk"><inertial><origin xyz="0.1 0.2 0.3" rpy="0.3 0.2 0.1"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.2" izz="0.15" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><origin xyz="0 0 1" rpy="0 0.5 0"/><geometry><box size="0.2 0.4 0.6"/></geometry></collision></link>
  <link name="foot"><collision><origin xyz="0 0 0.25"/><geometry><sphere radius="0.05"/></geometry></collision>
    <collision><geometry><cylinder radius="0.1" length="0.3"/></geometry></collision></link>
  <link name="leg"><inertial><mass value="1"/><inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><capsule radius="0.1" length="0.3"/></geometry></collision></link>
  <joint name="weld" type="fixed"><parent link="trunk"/><child link="foot"/><origin xyz="0.5 0 -1" rpy="0 0 0.7"/></joint>
  <joint name="hip" type="continuous"><parent link="trunk"/><child link="leg"/><axis xyz="0 1 0"/></joint>
</robot>"#;

/// Two tetrahedra that share nothing.
const TWINS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n\
                     v 5 0 0\nv 6 0 0\nv 5 1 0\nv 5 0 1\nf -4 -2 -3\nf -4 -3 -1\nf -4 -1 -2\nf -3 -2 -1\n";

fn with_walker(name: &str) -> PathBuf {
    let folder = folder(name);
    std::fs::write(folder.join("walker.urdf"), WALKER).expect("written");
    std::fs::write(folder.join("twins.obj"), TWINS).expect("written");
    let meshed =
        WALKER.replace("<capsule radius=\"0.1\" length=\"0.3\"/>", "<mesh filename=\"twins.obj\" scale=\"2 2 2\"/>");
    std::fs::write(folder.join("meshed.urdf"), meshed).expect("written");
    folder
}

const FLOATING: &str =
    "[[robot]]\nurdf = \"walker.urdf\"\nbase = \"floating\"\npose = { position = [1, 2, 3], rpy = [0.1, 0.2, 0.3] }\n";
const FLOOR: &str = "[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n";

/// The pairs as `a|b` with friction and restitution.
fn pairs(model: &Model) -> Vec<(String, f64, f64)> {
    let nonsmooth = &model.mechanism.nonsmooth;
    let name = |collider: usize| nonsmooth.colliders[collider].name.as_str();
    let numbers = nonsmooth.pairs.iter().map(|pair| pair.number);
    assert!(numbers.eq(0..nonsmooth.pairs.len()), "pairs are numbered in their order");
    let pairs = nonsmooth.pairs.iter();
    pairs.map(|pair| (format!("{}|{}", name(pair.a), name(pair.b)), pair.friction, pair.restitution)).collect()
}

fn model(folder: &Path, text: &str) -> Model {
    build(folder, text).0
}

#[test]
fn shapes_of_links_lie_in_their_bodies_where_the_urdf_puts_them_in_the_world() {
    let folder = with_walker("shapes_lie");
    let (model, _, state) = build(&folder, &format!("{FLOATING}{FLOOR}"));
    let bodies = body_states(&model.mechanism, &state);
    let colliders = &model.mechanism.nonsmooth.colliders;
    let names: Vec<&str> = colliders.iter().map(|collider| collider.name.as_str()).collect();
    assert_eq!(names, ["trunk", "foot", "foot", "leg", "floor"]);
    assert_eq!(model.mechanism.bodies.len(), 2, "the foot is part of the trunk");
    assert!(model.reductions.iter().any(|left| left.link == "foot" && left.rule == ReductionRule::FusedWithParent));
    let half = Vector3::new(0.1, 0.2, 0.3);
    assert_eq!(colliders[0].shape, Shape::Box { half });
    assert_eq!(colliders[1].shape, Shape::Sphere { radius: 0.05 });
    assert_eq!(colliders[2].shape, Shape::Cylinder { radius: 0.1, half: 0.15 });
    assert_eq!(colliders[3].shape, Shape::Capsule { radius: 0.1, half: 0.15 });
    // By hand: the frame of the link in the world, then that of the shape in it.
    for (collider, place, turn) in [
        (0, Vector3::new(0.0, 0.0, 1.0), Rotation3::from_euler_angles(0.0, 0.5, 0.0)),
        (1, Vector3::new(0.0, 0.0, 0.25), Rotation3::identity()),
        (2, Vector3::zeros(), Rotation3::identity()),
        (3, Vector3::zeros(), Rotation3::identity()),
    ] {
        let given = &colliders[collider];
        let (origin, frame) = model.link_pose(&bodies, model.link(&given.name).unwrap());
        let body = &bodies[given.body.unwrap()];
        let at = body.position + body.rotation * given.pose.translation.vector;
        // Some roundings of numbers of a few metres.
        assert!((at - (origin + frame * place)).norm() < 4e-15, "{}: {at}", given.name);
        let turned = body.rotation * given.pose.rotation.matrix();
        assert!((turned - frame * turn.matrix()).norm() < 4e-15, "{}: {turned}", given.name);
    }
    assert_eq!(colliders[4].body, None);
}

#[test]
fn obstacles_of_every_shape_are_in_the_world_and_have_the_defaults() {
    let folder = with_walker("obstacles");
    let text = format!(
        "{FLOATING}[[obstacle]]\nshape = {{ type = \"half_space\", normal = [0, -2, 0] }}\npose = {{ position = [0, 0, 1] }}\n\
         [[obstacle]]\nshape = {{ type = \"box\", size = [2, 4, 6] }}\npose = {{ position = [1, 2, 3], rpy = [0.1, 0.2, 0.3] }}\n\
         [[obstacle]]\nname = \"ball\"\nshape = {{ type = \"sphere\", radius = 0.5 }}\n\
         [[obstacle]]\nshape = {{ type = \"cylinder\", radius = 0.5, length = 3 }}\n\
         [[obstacle]]\nshape = {{ type = \"capsule\", radius = 0.5, length = 3 }}\n\
         [[obstacle]]\nshape = {{ type = \"mesh\", file = \"twins.obj\", scale = [1, 1, -1] }}\nfriction = 0.25\nrestitution = 0.75\n"
    );
    let model = model(&folder, &text);
    let obstacles = &model.mechanism.nonsmooth.colliders[4..];
    let names: Vec<&str> = obstacles.iter().map(|obstacle| obstacle.name.as_str()).collect();
    assert_eq!(names, ["obstacle1", "obstacle2", "ball", "obstacle4", "obstacle5", "obstacle6"]);
    assert_eq!(obstacles[0].shape, Shape::HalfSpace);
    let normal = obstacles[0].pose.rotation * Vector3::z();
    assert!((normal - Vector3::new(0.0, -1.0, 0.0)).norm() < 1e-15, "{normal}");
    assert_eq!(obstacles[0].pose.translation.vector, Vector3::z());
    assert_eq!(obstacles[1].shape, Shape::Box { half: Vector3::new(1.0, 2.0, 3.0) });
    assert_eq!(obstacles[1].pose.rotation, Rotation3::from_euler_angles(0.1, 0.2, 0.3));
    assert_eq!(obstacles[2].shape, Shape::Sphere { radius: 0.5 });
    assert_eq!(obstacles[3].shape, Shape::Cylinder { radius: 0.5, half: 1.5 });
    assert_eq!(obstacles[4].shape, Shape::Capsule { radius: 0.5, half: 1.5 });
    let Shape::Mesh(surface) = &obstacles[5].shape else { panic!("{:?}", obstacles[5].shape) };
    assert_eq!((surface.vertices.len(), surface.triangles.len()), (8, 8));
    assert_eq!(surface.vertices.iter().map(|vertex| vertex.z).fold(0.0, f64::min), -1.0);
    let pairs = pairs(&model);
    assert_eq!(pairs[0], ("trunk|obstacle1".to_string(), 0.5, 0.0));
    assert_eq!(pairs[5], ("trunk|obstacle6".to_string(), 0.25, 0.75));
    assert_eq!(pairs.len(), 4 * 6);
}

#[test]
fn later_pairs_override_earlier_ones_key_by_key_and_in_either_order_of_names() {
    let folder = with_walker("overrides");
    let text = format!(
        "{FLOATING}{FLOOR}friction = 0.3\n[contact]\nfriction = 0.7\nrestitution = 0.2\n\
         [[contact.pair]]\na = \"floor\"\nb = \"f*t\"\nfriction = 0.9\n\
         [[contact.pair]]\na = \"foot\"\nb = \"*\"\nrestitution = 0.6\n\
         [[contact.pair]]\na = \"*\"\nb = \"*\"\nignore = true\n\
         [[contact.pair]]\na = \"*\"\nb = \"floor\"\nignore = false\n\
         [[contact.pair]]\na = \"leg\"\nb = \"floor\"\nignore = true\n"
    );
    let model = model(&folder, &text);
    let expected = [("trunk|floor", 0.3, 0.2), ("foot|floor", 0.9, 0.6), ("foot|floor", 0.9, 0.6)];
    assert_eq!(
        pairs(&model),
        expected.map(|(names, friction, restitution)| (names.to_string(), friction, restitution))
    );
    // The pairs of the robot with itself are ignored by their own line.
    let left_out: Vec<_> =
        model.contact.left_out.iter().filter(|left| left.because != NeverTouch::Ignored(20)).collect();
    assert_eq!(left_out.iter().map(|left| left.because).collect::<Vec<_>>(), [NeverTouch::Ignored(28)]);
    assert_eq!(model.mechanism.nonsmooth.colliders[left_out[0].pair.a].name, "leg");
}

#[test]
fn links_touch_links_of_other_robots_where_there_is_an_obstacle_or_all_pairs_are_wanted() {
    let folder = with_walker("all_pairs");
    let two = "[[robot]]\nname = \"a\"\nurdf = \"walker.urdf\"\nbase = \"floating\"\n[[robot]]\nname = \"b\"\nurdf = \"walker.urdf\"\n";
    let counted = |rest: &str| {
        let model = model(&folder, &format!("{two}{rest}"));
        (model.mechanism.nonsmooth.colliders.len(), pairs(&model), model.contact.left_out.len())
    };
    // Without obstacles nothing touches, and no shape is looked at.
    assert_eq!(counted(""), (0, Vec::new(), 0));
    let (colliders, of_all, left_out) = counted("[contact]\npairs = \"all\"\n");
    assert_eq!((colliders, of_all.len(), left_out), (8, 16, 10));
    assert_eq!(of_all[0], ("a/trunk|b/trunk".to_string(), 0.5, 0.0));
    assert!(of_all.iter().all(|(names, ..)| names.starts_with("a/") && names.contains("|b/")));
    // The trunk and the foot of the second robot are fixed in the world, as the floor is.
    let (_, with_floor, left_out) = counted(&format!("{FLOOR}[contact]\npairs = \"environment\"\n"));
    assert_eq!((with_floor.len(), left_out), (5, 13));
    assert_eq!(counted(&format!("{FLOOR}[contact]\npairs = \"none\"\n")), (0, Vec::new(), 0));
    // With an obstacle everything touches, unless it is said otherwise.
    for said in ["", "[contact]\npairs = \"all\"\n"] {
        let (colliders, of_all, left_out) = counted(&format!("{FLOOR}{said}"));
        assert_eq!((colliders, of_all.len(), left_out), (9, 21, 13));
    }
}

#[test]
fn what_a_fixed_robot_cannot_reach_is_left_out_until_its_limits_are() {
    let folder = with_walker("reach");
    let slides = WALKER.replace(
        "type=\"continuous\"><parent",
        "type=\"prismatic\"><limit lower=\"-0.5\" upper=\"0.2\" effort=\"1\" velocity=\"1\"/><parent",
    );
    std::fs::write(folder.join("slides.urdf"), slides).expect("written");
    let below = |height: f64| {
        let obstacle =
            FLOOR.replace("half_space\" }", &format!("half_space\" }}\npose = {{ position = [0, 0, {height}] }}"));
        model(&folder, &format!("[[robot]]\nurdf = \"slides.urdf\"\n{obstacle}"))
    };
    // The capsule ends 0.25 m from the origin of the leg, which slides by up to 0.5 m.
    for (height, count) in [(-0.74, 1), (-0.76, 0)] {
        let mut model = below(height);
        assert_eq!(pairs(&model).len(), count, "{height}");
        let reasons: Vec<NeverTouch> = model.contact.left_out.iter().map(|left| left.because).collect();
        assert_eq!(reasons.contains(&NeverTouch::OutOfReach), count == 0, "{reasons:?}");
        model.without(&[Left::Limits]);
        assert_eq!(pairs(&model).len(), 1, "{height}");
    }
}

#[test]
fn meshes_of_links_are_hulls_or_the_hulls_of_their_parts_or_nothing() {
    let folder = with_walker("meshes_of_links");
    let hulls = |keys: &str| -> Vec<usize> {
        let text = FLOATING.replace("walker", "meshed") + FLOOR + keys;
        let model = model(&folder, &text);
        assert_eq!(model.contact.meshes.len(), usize::from(!keys.contains("none")));
        let of_leg = model.mechanism.nonsmooth.colliders.iter().filter(|collider| collider.name == "leg");
        of_leg
            .map(|collider| match &collider.shape {
                Shape::Hull(points) => {
                    assert!(points.iter().all(|point| point.x <= 12.0) && points.iter().any(|point| point.x >= 2.0));
                    points.len()
                }
                other => panic!("{other:?}"),
            })
            .collect()
    };
    let link = |choice: &str| format!("[[link]]\nname = \"leg\"\ncollision = \"{choice}\"\n");
    assert_eq!(hulls(""), [8]);
    assert_eq!(hulls(&link("hull")), [8]);
    assert_eq!(hulls(&link("decompose")), [4, 4]);
    assert_eq!(hulls(&link("none")), [0; 0]);
}

#[test]
fn a_decomposed_hook_has_room_for_a_ball_inside() {
    let folder = with_walker("hook");
    // An L of three by three by one: limbs one thick, the inner corner at the origin.
    let outline = [(-1, -1), (2, -1), (2, 0), (0, 0), (0, 2), (-1, 2)];
    let mut text: String =
        outline.iter().map(|(x, y)| format!("v {x} {y} 0\nv {x} {y} 1\n")).collect::<Vec<_>>().concat();
    for side in 0..6 {
        let (here, next) = (2 * side + 1, 2 * ((side + 1) % 6) + 1);
        text += &format!("f {here} {next} {} {}\n", next + 1, here + 1);
    }
    text += "f 2 4 6\nf 2 6 8\nf 2 8 10\nf 2 10 12\nf 1 5 3\nf 1 7 5\nf 1 9 7\nf 1 11 9\n";
    std::fs::write(folder.join("hook.obj"), text).expect("written");
    let meshed = std::fs::read_to_string(folder.join("meshed.urdf")).expect("there");
    std::fs::write(folder.join("hooked.urdf"), meshed.replace("twins.obj", "hook.obj")).expect("written");
    // The mesh is scaled by two, so there is room for a ball that touches no limb.
    let place = IsometryMatrix3::translation(1.0, 1.0, 1.0);
    let distances = |choice: &str| -> Vec<f64> {
        let text = format!("{FLOATING}{FLOOR}[[link]]\nname = \"leg\"\ncollision = \"{choice}\"\n");
        let model = model(&folder, &text.replace("walker", "hooked"));
        let colliders = model.mechanism.nonsmooth.colliders.iter().filter(|collider| collider.name == "leg");
        let distance = |collider: &Collider| {
            let hook = Collider { pose: IsometryMatrix3::identity(), ..collider.clone() };
            let ball = Collider { shape: Shape::Sphere { radius: 0.9 }, ..hook.clone() };
            let pair = PairGeometry::new(&hook, &ball).expect("a pair");
            pair.distance(&IsometryMatrix3::identity(), &place).distance
        };
        colliders.map(distance).collect()
    };
    let hull = distances("hull");
    assert!(hull.len() == 1 && hull[0] < 0.0, "the hull fills the corner: {hull:?}");
    // The ball is 0.1 from each limb; voxels are a 64th of six metres.
    let pieces = distances("decompose");
    assert!(pieces.len() >= 2 && pieces.iter().all(|distance| *distance > 0.1 - 6.0 / 64.0), "{pieces:?}");
    assert!(pieces.iter().any(|distance| *distance < 0.1 + 6.0 / 64.0), "{pieces:?}");
}

/// A folder with the walker whose leg has this mesh; its element is on line 8.
fn with_mesh(folder: &Path, file: &str) {
    let meshed = std::fs::read_to_string(folder.join("meshed.urdf")).expect("there");
    std::fs::write(folder.join("bad.urdf"), meshed.replace("twins.obj", file)).expect("written");
}

#[test]
fn a_mesh_of_a_link_that_is_not_found_touches_nothing_with_a_warning_where_it_could_touch() {
    let folder = with_walker("missing_mesh");
    // In its place, in a package that is not installed, and at an address.
    for file in ["none.obj", "package://none/leg.stl", "https://none/leg.stl"] {
        with_mesh(&folder, file);
        let text = FLOATING.replace("walker", "bad");
        let said = |model: &Model| {
            let all: Vec<String> = model.warnings.iter().map(ToString::to_string).collect();
            let about = all.into_iter().filter(|warning| warning.contains("so this shape touches nothing"));
            about.collect::<Vec<_>>()
        };
        let touching = model(&folder, &format!("{text}{FLOOR}"));
        let warnings = said(&touching);
        assert_eq!(warnings.len(), 1, "{file}: {warnings:?}");
        for part in ["bad.urdf:8: link \"leg\": ", file, "was not found"] {
            assert!(warnings[0].contains(part), "{part:?} in {}", warnings[0]);
        }
        assert!(touching.mechanism.nonsmooth.colliders.iter().all(|collider| collider.name != "leg"));
        // Where nothing can touch, nobody looks.
        assert_eq!(said(&model(&folder, &text)), [""; 0], "{file}");
        assert_eq!(said(&model(&folder, &format!("{text}{FLOOR}[contact]\npairs = \"none\"\n"))), [""; 0], "{file}");
    }
}

#[test]
fn a_mesh_of_a_link_that_is_there_and_cannot_be_used_is_an_error_where_it_could_touch() {
    let folder = with_walker("bad_meshes");
    let write = |file: &str, text: &str| std::fs::write(folder.join(file), text).expect("written");
    let tetrahedron =
        |far: &str| format!("v 0 0 0\nv {far} 0 0\nv 0 {far} 0\nv 0 0 {far}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
    write("nothing.stl", "");
    write("no faces.obj", "v 0 0 0\n");
    write("point.obj", &tetrahedron("0"));
    write("line.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    write("thin.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1e-8\nf 1 2 3\nf 2 4 3\n");
    write("nan.obj", &tetrahedron("nan"));
    write("infinite.obj", &tetrahedron("inf"));
    write("overflows.obj", &tetrahedron("1e200"));
    write("kilometres.obj", &tetrahedron("5.1e5"));
    write("index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n");
    write("cut.dae", "<COLLADA>");
    write("other.ply", "ply");
    write("pointer.stl", "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12345\n");
    // One triangle is said, and is not there; the header is 84 bytes.
    let mut cut = vec![0; 90];
    cut[80] = 1;
    std::fs::write(folder.join("cut.stl"), &cut).expect("written");
    for (file, reason) in [
        ("nothing.stl", "neither a binary STL file nor one of text"),
        ("no faces.obj", "there is no triangle in it"),
        ("point.obj", "there is no triangle in it"),
        ("line.obj", "none of its triangles has an area"),
        ("thin.obj", "m of one plane"),
        ("nan.obj", "is not finite"),
        ("infinite.obj", "is not finite"),
        ("overflows.obj", "is not finite"),
        // The scale is 2.
        ("kilometres.obj", "reaches 1020000 m from its origin, farther than 1e6 m"),
        ("index.obj", "line 4: a polygon has a corner that does not exist"),
        ("cut.stl", "it has 90 bytes, and says that it has 134"),
        ("cut.dae", "is not well-formed XML"),
        ("other.ply", ".stl, .obj and .dae"),
        ("pointer.stl", "git lfs pull"),
    ] {
        with_mesh(&folder, file);
        let text = FLOATING.replace("walker", "bad");
        // What is thin has a border, which is what its pieces are refused for.
        let choices = ["", "[[link]]\nname = \"leg\"\ncollision = \"decompose\"\n"];
        for choice in choices.iter().take(if file == "thin.obj" { 1 } else { 2 }) {
            let message = refusal(&folder, &format!("{text}{FLOOR}{choice}"));
            assert!(message.lines().count() == 1, "{message}");
            let place = format!("bad.urdf:8: link \"leg\": its collision mesh {file:?} cannot be used: ");
            for part in [place.as_str(), reason, "[[link]] with name = \"leg\", shape = 1, collision = \"none\""] {
                assert!(message.contains(part), "{part:?} in {message}");
            }
        }
        // What the message proposes helps, and where nothing can touch nobody looks.
        model(&folder, &format!("{text}{FLOOR}[[link]]\nname = \"leg\"\nshape = 1\ncollision = \"none\"\n"));
        model(&folder, &format!("{text}{FLOOR}[[link]]\nname = \"leg\"\ncollision = \"none\"\n"));
        model(&folder, &text);
        model(&folder, &format!("{text}{FLOOR}[contact]\npairs = \"none\"\n"));
    }
}

#[test]
fn a_flat_mesh_of_a_link_is_a_plate_and_has_no_pieces() {
    let folder = with_walker("plates");
    let meshed = std::fs::read_to_string(folder.join("meshed.urdf")).expect("there");
    std::fs::write(folder.join("flat.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 4 3\n").expect("written");
    std::fs::write(folder.join("plate.urdf"), meshed.replace("twins.obj", "flat.obj")).expect("written");
    let scene = format!("{}{FLOOR}", FLOATING.replace("walker", "plate"));
    let model = model(&folder, &scene);
    let plates = model.mechanism.nonsmooth.colliders.iter().filter(|collider| collider.name == "leg");
    assert_eq!(plates.count(), 1);
    assert!(model.warnings.iter().all(|warning| !warning.message.contains("mesh")), "{:?}", model.warnings);
    let message = refusal(&folder, &format!("{scene}[[link]]\nname = \"leg\"\ncollision = \"decompose\"\n"));
    assert!(message.contains("link \"leg\": its collision mesh \"flat.obj\" cannot be cut into convex"), "{message}");
}

#[test]
fn a_scene_without_contact_has_no_shapes_and_is_smooth() {
    let folder = with_walker("smooth");
    for text in [FLOATING.to_string(), format!("{FLOATING}[contact]\nfriction = 0.1\n"), ONE.to_string()] {
        let model = model(&folder, &text);
        let nonsmooth = &model.mechanism.nonsmooth;
        assert!(nonsmooth.is_empty() && nonsmooth.colliders.is_empty(), "{text}");
        assert!(model.warnings.iter().all(|warning| !warning.message.contains("contact")), "{:?}", model.warnings);
    }
}

#[test]
fn bodies_that_touch_alike_are_one_entry_of_the_list_and_every_pair_has_its_own_laws() {
    let folder = with_walker("alike");
    let bodies = "[[body]]\nname = \"ball\"\nshape = { type = \"sphere\", radius = 0.1 }\nmass = 1\ncount = 30\nspacing = [1, 0, 0]\n\
        [[body]]\nname = \"box\"\nshape = { type = \"box\", size = [1, 1, 1] }\nmass = 1\nfriction = 0.3\ncount = 20\nspacing = [0, 2, 0]\n\
        pose = { position = [0, 9, 0] }\n";
    let rules = "[contact]\nfriction = 0.5\n[[contact.pair]]\na = \"ball7\"\nb = \"box*\"\nignore = true\n\
        [[contact.pair]]\na = \"ball3\"\nb = \"*\"\nfriction = 0.9\n";
    let model = model(&folder, &format!("{bodies}{FLOATING}{FLOOR}{rules}"));
    let balls = (1..=30).map(|number| format!("ball{number}"));
    let boxes = (1..=20).map(|number| format!("box{number}"));
    let walker = ["trunk", "foot", "foot", "leg"].map(|link| model.links.iter().find(|own| own.name.ends_with(link)));
    let walker = walker.map(|link| link.expect("a link of the walker").name.clone());
    let all: Vec<String> = walker.into_iter().chain(balls).chain(boxes).chain(["floor".to_string()]).collect();
    let friction = |names: [&str; 2]| match names {
        _ if names.contains(&"ball3") => 0.9,
        _ if names.iter().any(|name| name.starts_with("box")) => 0.3,
        _ => 0.5,
    };
    let mut wanted = Vec::new();
    for (number, a) in all.iter().enumerate() {
        for b in &all[number + 1..] {
            // A trunk with its foot is one body, and the leg is joined to it.
            let of_walker = [a, b].iter().all(|name| ["trunk", "foot", "leg"].iter().any(|link| name.ends_with(link)));
            let ignored = a == "ball7" && b.starts_with("box");
            if !of_walker && !ignored {
                wanted.push((format!("{a}|{b}"), friction([a, b]), 0.0));
            }
        }
    }
    assert_eq!(pairs(&model), wanted);
    assert_eq!(model.contact.left_out.iter().filter(|left| matches!(left.because, NeverTouch::Ignored(_))).count(), 20);
    // Each of 54 shapes has the balls up to the third, it, those up to the seventh, it, the others, the boxes and the floor.
    let (runs, shapes) = (model.mechanism.nonsmooth.pairs.runs().len(), all.len());
    assert!(runs < 8 * shapes && 6 * runs < wanted.len(), "{runs} runs for {} pairs", wanted.len());
}
