//! What is wrong with an obstacle, a pair or a link's shapes is said in one line, with file, line and key or name.

use super::{ONE, TWO, folder, refusal};

const SHAPED: &str = r#"<robot name="shaped">
  <link name="base"><collision><geometry><box size="1 1 1"/></geometry></collision></link>
  <link name="arm"><inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
    <collision><geometry><SHAPE/></geometry></collision></link>
  <joint name="hinge" type="continuous"><parent link="base"/><child link="arm"/></joint>
</robot>"#;

/// On two lines.
const ROBOT: &str = "[[robot]]\nurdf = \"shaped.urdf\"\n";

#[track_caller]
fn check(folder: &std::path::Path, cases: Vec<(String, &[&str])>) {
    for (text, parts) in cases {
        let message = refusal(folder, &text);
        assert!(message.lines().count() == 1, "{message}");
        for part in parts {
            assert!(message.contains(part), "{part:?} is not in {message:?} of\n{text}");
        }
    }
}

#[test]
fn wrong_obstacles_are_refused_with_file_line_and_key() {
    let folder = folder("obstacle_errors");
    std::fs::write(folder.join("empty.obj"), "# nothing\n").expect("written");
    std::fs::write(folder.join("line.obj"), "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n").expect("written");
    std::fs::write(folder.join("cut.stl"), "solid a\nfacet\nouter loop\nvertex 0 0 0\n").expect("written");
    std::fs::write(folder.join("mesh.ply"), "ply").expect("written");
    std::fs::write(folder.join("good.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").expect("written");
    // Line 3 is [[obstacle]] and line 4 its shape.
    let of = |shape: &str, keys: &str| format!("{ONE}[[obstacle]]\nshape = {{ {shape} }}\n{keys}");
    let half_space = |keys: &str| of("type = \"half_space\"", keys);
    let mesh = |file: &str| of(&format!("type = \"mesh\", file = \"{file}\""), "");
    let cases: Vec<(String, &[&str])> = vec![
        (format!("{ONE}[[obstacle]]\n"), &["scene.toml:3: obstacle: missing field `shape`"]),
        (of("radius = 1", ""), &["scene.toml:4: obstacle.shape: missing field `type`"]),
        (of("type = \"cone\"", ""), &["scene.toml:4: obstacle.shape.type: unknown variant `cone`", "`half_space`"]),
        (of("type = \"sphere\", radus = 1", ""), &["scene.toml:4: obstacle.shape.radus: unknown field"]),
        (half_space("frictoin = 1"), &["scene.toml:5: obstacle.frictoin: unknown field"]),
        // Numbers.
        (half_space("friction = -0.1"), &["scene.toml:5: obstacle.friction: -0.1 must not be negative"]),
        (half_space("friction = nan"), &["scene.toml:5: obstacle.friction: NaN is not finite"]),
        (half_space("friction = 1.1e4"), &["scene.toml:5: obstacle.friction: 1.1e4 must be at most 1e4"]),
        (half_space("friction = \"abc\""), &["scene.toml:5: obstacle.friction: ", "\"abc\", expected a number"]),
        (half_space("pose = { position = [0, 0] }"), &["scene.toml:5: obstacle.pose.position: ", "expected 3 numbers"]),
        (
            format!("{ONE}[[obstacle]]\nname = \"ramp\"\nshape = \"box\"\n"),
            &["scene.toml:5: obstacle \"ramp\": obstacle.shape: ", "expected a table"],
        ),
        (format!("{ONE}[[obstacle]]\nname = \"ramp\"\n"), &["scene.toml:3: obstacle \"ramp\": ", "field `shape`"]),
        // An obstacle that has a name is called by it.
        (
            format!(
                "{}\n[[obstacle]]\nname = \"ramp\"\nfriction = nan\nshape = {{ type = \"half_space\" }}\n",
                half_space("")
            ),
            &["scene.toml:8: obstacle \"ramp\": obstacle.friction: NaN is not finite"],
        ),
        (
            of("type = \"sphere\", radius = 0", "name = \"stone\"\n"),
            &["scene.toml:4: obstacle \"stone\": obstacle.shape.radius: 0 must be greater than zero"],
        ),
        (half_space("restitution = 1.1"), &["scene.toml:5: obstacle.restitution: 1.1 must be from 0 to 1"]),
        (half_space("restitution = nan"), &["scene.toml:5: obstacle.restitution: NaN must be from 0 to 1"]),
        (half_space("pose = { position = [0, inf, 0] }"), &["scene.toml:5: obstacle.pose.position: inf is not finite"]),
        (
            of("type = \"half_space\", normal = [0, 0, 0]", ""),
            &["scene.toml:4: obstacle \"obstacle1\": the normal of a half space must not be zero"],
        ),
        (
            of("type = \"sphere\", radius = 0", ""),
            &["scene.toml:4: obstacle.shape.radius: 0 must be greater than zero"],
        ),
        (of("type = \"sphere\", radius = -1", ""), &["scene.toml:4: obstacle.shape.radius: -1 must be greater"]),
        (
            of("type = \"box\", size = [1, 0, 1]", ""),
            &["scene.toml:4: obstacle.shape.size: 0 must be greater than zero"],
        ),
        (
            of("type = \"cylinder\", radius = 1, length = nan", ""),
            &["scene.toml:4: obstacle.shape.length: NaN is not finite"],
        ),
        // Keys that a shape lacks, or has not.
        (of("type = \"box\"", ""), &["scene.toml:4: obstacle \"obstacle1\": a box needs its size"]),
        (of("type = \"sphere\"", ""), &["scene.toml:4: ", "a sphere needs its radius"]),
        (of("type = \"cylinder\", radius = 1", ""), &["scene.toml:4: ", "need a radius and a length"]),
        (of("type = \"capsule\", length = 1", ""), &["scene.toml:4: ", "need a radius and a length"]),
        (of("type = \"mesh\"", ""), &["scene.toml:4: ", "a mesh needs its file"]),
        (of("type = \"box\", size = [1, 1, 1], radius = 1", ""), &["scene.toml:4: ", "only spheres, cylinders and"]),
        (of("type = \"sphere\", radius = 1, length = 1", ""), &["scene.toml:4: ", "only cylinders and capsules"]),
        (of("type = \"sphere\", radius = 1, normal = [0, 0, 1]", ""), &["scene.toml:4: ", "only a half space has a"]),
        (of("type = \"half_space\", size = [1, 1, 1]", ""), &["scene.toml:4: ", "only a box has a size"]),
        (of("type = \"half_space\", file = \"a\"", ""), &["scene.toml:4: ", "only a mesh has a file"]),
        (of("type = \"half_space\", scale = [1, 1, 1]", ""), &["scene.toml:4: ", "only a mesh has a scale"]),
        // Names.
        (half_space("name = \"\""), &["scene.toml:5: obstacle \"\": the name of an obstacle"]),
        (half_space("name = \"world\""), &["scene.toml:5: obstacle \"world\": the name of an obstacle"]),
        (half_space("name = \"a|b\""), &["scene.toml:5: obstacle \"a|b\": the name of an obstacle"]),
        (half_space("name = \"a*\""), &["scene.toml:5: obstacle \"a*\": the name of an obstacle"]),
        (half_space("name = \"upper\""), &["scene.toml:5: ", "obstacle \"upper\" has the name of a link"]),
        (
            half_space(&format!("name = \"a\"\n{}name = \"a\"", &half_space("")[ONE.len()..])),
            &["scene.toml:8: obstacle \"a\": the name is already taken on line 5"],
        ),
        // Meshes.
        (mesh("none.obj"), &["scene.toml:4: obstacle \"obstacle1\": obstacle.shape.file: none.obj: cannot be read"]),
        (mesh("empty.obj"), &["scene.toml:4: ", "empty.obj: there is no triangle in it"]),
        (mesh("line.obj"), &["scene.toml:4: ", "line.obj: none of its triangles has an area"]),
        (of("type = \"sphere\", radius = 1e200", ""), &["scene.toml:4: ", "obstacle.shape: ", "below 1e150 m"]),
        (mesh("cut.stl"), &["scene.toml:4: ", "cut.stl: it is cut off within a facet"]),
        (mesh("mesh.ply"), &["scene.toml:4: ", "mesh.ply: meshes are read from .stl, .obj and .dae"]),
        (mesh("double.urdf"), &["scene.toml:4: ", "double.urdf: meshes are read from"]),
        (
            of("type = \"mesh\", file = \"good.obj\", scale = [1, 0, 1]", ""),
            &["scene.toml:4: ", "the scale of a mesh must not be zero"],
        ),
        (
            of("type = \"mesh\", file = \"good.obj\", scale = [1, nan, 1]", ""),
            &["scene.toml:4: obstacle.shape.scale: NaN is not finite"],
        ),
    ];
    check(&folder, cases);
}

#[test]
fn wrong_pairs_and_links_are_refused_with_file_line_and_name() {
    let folder = folder("pair_errors");
    let shaped =
        |shape: &str| std::fs::write(folder.join("shaped.urdf"), SHAPED.replace("SHAPE", shape)).expect("written");
    shaped("sphere radius=\"0.1\"");
    // Line 3 is [contact] or [[link]], or line 3 to 5 are a pair.
    let contact = |keys: &str| format!("{ROBOT}[contact]\n{keys}");
    let pair = |a: &str, keys: &str| format!("{ROBOT}[[contact.pair]]\na = \"{a}\"\nb = \"arm\"\n{keys}");
    let link = |keys: &str| format!("{ROBOT}[[link]]\n{keys}");
    let cases: Vec<(String, &[&str])> = vec![
        (contact("pairs = \"some\""), &["scene.toml:4: contact.pairs: unknown variant `some`", "`environment`"]),
        (contact("friction = -1"), &["scene.toml:4: contact.friction: -1 must not be negative"]),
        (contact("friction = 1e300"), &["scene.toml:4: contact.friction: 1e300 must be at most 1e4"]),
        (
            pair("base", "friction = 1e5"),
            &["scene.toml:6: contact of \"base\" and \"arm\": ", "1e5 must be at most 1e4"],
        ),
        (contact("friction = nan"), &["scene.toml:4: contact.friction: NaN is not finite"]),
        (contact("restitution = 2"), &["scene.toml:4: contact.restitution: 2 must be from 0 to 1"]),
        (contact("fiction = 1"), &["scene.toml:4: contact.fiction: unknown field"]),
        (pair("base", ""), &["scene.toml:3: contact of \"base\" and \"arm\": give its friction"]),
        (
            pair("base", "friction = -1"),
            &["scene.toml:6: contact of \"base\" and \"arm\": contact.pair.friction: -1 must not be negative"],
        ),
        (
            pair("base", "restitution = -1"),
            &["scene.toml:6: contact of \"base\" and \"arm\": contact.pair.restitution: -1 must be from 0 to 1"],
        ),
        (pair("base", "ignore = 1"), &["scene.toml:6: contact of \"base\" and \"arm\": contact.pair.ignore: "]),
        (
            pair("base", "ignored = true"),
            &["scene.toml:6: contact of \"base\" and \"arm\": contact.pair.ignored: unknown field"],
        ),
        (
            format!("{ROBOT}[[contact.pair]]\na = \"base\"\nfriction = 1"),
            &["scene.toml:3: contact.pair: missing field `b`"],
        ),
        (
            pair("foot*", "friction = 1"),
            &["scene.toml:3: contact of \"foot*\" and \"arm\": \"foot*\" names no link", "\"base\", \"arm\""],
        ),
        (pair("world", "friction = 1"), &["scene.toml:3: ", "\"world\" names no link with a collision shape"]),
        (
            format!("{TWO}[[contact.pair]]\na = \"*\"\nb = \"*\"\nfriction = 1"),
            &["scene.toml:7: ", "names no link with a collision shape and no obstacle; there are none"],
        ),
        (
            link("name = \"arm\""),
            &[
                "scene.toml:3: link \"arm\": give its collision, friction, restitution, rolling_friction, spinning_friction or surface_velocity",
            ],
        ),
        (
            link("name = \"arm\"\ncollision = \"box\""),
            &["scene.toml:5: link \"arm\": link.collision: unknown variant `box`", "`hull`"],
        ),
        (
            link("name = \"leg\"\ncollision = \"hull\""),
            &["scene.toml:4: link \"leg\": there is no link \"leg\"; there are \"base\", \"arm\""],
        ),
        (link("name = \"world\"\ncollision = \"hull\""), &["scene.toml:4: link \"world\": ", "no collision shape"]),
        (
            link("name = \"arm\"\ncollision = \"hull\"\n[[link]]\nname = \"shaped/arm\"\ncollision = \"none\""),
            &["scene.toml:7: link \"shaped/arm\": ", "the [[link]] of line 4"],
        ),
    ];
    check(&folder, cases);
    // A shape without size is an error where it could touch.
    let floor = format!("{ROBOT}[[obstacle]]\nshape = {{ type = \"half_space\" }}\n");
    for (shape, what) in [
        ("sphere radius=\"0\"", "radius of its sphere is 0 m"),
        ("box size=\"1 -1 1\"", "size of its box is -1 m"),
        ("cylinder radius=\"1\" length=\"0\"", "length of its cylinder is 0 m"),
        ("cylinder radius=\"0\" length=\"1\"", "radius of its cylinder is 0 m"),
        ("capsule radius=\"1\" length=\"-2\"", "length of its capsule is -2 m"),
    ] {
        shaped(shape);
        check(&folder, vec![(floor.clone(), &["shaped.urdf:4: link \"arm\": the ", what])]);
        super::build(&folder, ROBOT);
    }
}
