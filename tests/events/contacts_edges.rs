//! Edges that meet edges: several normals separate the two bodies, and the distance has one of them by roundings. Bodies meet along the normal along
//! which they approach slowest.

use crate::common::scratch;
use crate::scene_files::{apart, report, scene_of};

#[test]
fn a_wedge_whose_edge_meets_the_lower_edge_of_a_box_lifts_it_at_every_tolerance() {
    // The tip of the wedge and the lower edge of the box both lie on the floor: the side of the box and the slope of the wedge separate them alike. Runs
    // took one or the other, and ended 1.5e-2 m apart.
    let wedge = "<link name='wedge'><inertial><origin xyz='0.133 0 0.04'/><mass value='1.9'/>\
        <inertia ixx='0.02' ixy='0' ixz='0' iyy='0.02' iyz='0' izz='0.03'/></inertial>\
        <collision><geometry><mesh filename='wedge.obj'/></geometry></collision></link>";
    let text = "[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\nfriction = 0.13\n\
        [[body]]\nname = \"box\"\nshape = { type = \"box\", size = [0.6, 0.4, 0.4] }\nmass = 8\npose = { position = [0, 0, 0.2] }\n\
        [[robot]]\nname = \"wedge\"\nurdf = \"robot.urdf\"\nbase = \"floating\"\npose = { position = [-0.72, 0, 0] }\n\
        [[load]]\nlink = \"wedge\"\nposition = [0, 0, 0.01]\nforce = [75, 0, 0]\nfactor = [[0, 0], [0.5, 1], [2, 1]]\n\
        [contact]\nfriction = 0.11\n";
    let file = scene_of("wedge_under_a_box", wedge, text);
    let mesh = "v 0 -0.15 0\nv 0.4 -0.15 0\nv 0 -0.15 0.12\nv 0 0.15 0\nv 0.4 0.15 0\nv 0 0.15 0.12\n\
        f 1 2 3\nf 4 6 5\nf 1 4 5\nf 1 5 2\nf 2 5 6\nf 2 6 3\nf 1 3 6\nf 1 6 4\n";
    std::fs::write(file.with_file_name("wedge.obj"), mesh).expect("a mesh");
    let run = |tolerance: f64| report(&file, &[], &[], Some(0.2), tolerance);
    let fine = run(1e-9);
    let lifted = fine.links.iter().find(|(name, _)| name == "box").expect("the box").1.position[2] - 0.2;
    assert!(lifted > 1e-4, "the wedge is not under the box: {lifted:e} m");
    for tolerance in [1e-3, 1e-4, 1e-5, 1e-6, 1e-8] {
        let done = run(tolerance);
        let off = apart(&done, &fine);
        println!("{tolerance:e}: {off:e}");
        assert!(off <= tolerance, "{tolerance:e}: {off:e}");
    }
}

/// An ellipsoid of 1200 vertices as OBJ.
fn pebble() -> String {
    let (rings, around) = (30, 40);
    let at = |ring: usize, turn: usize| {
        let (polar, azimuth) = (
            std::f64::consts::PI * (ring as f64 + 0.5) / rings as f64,
            std::f64::consts::TAU * turn as f64 / around as f64,
        );
        [0.1 * polar.sin() * azimuth.cos(), 0.08 * polar.sin() * azimuth.sin(), 0.06 * polar.cos()]
    };
    let vertices = (0..rings).flat_map(|ring| (0..around).map(move |turn| at(ring, turn)));
    let vertices: String = vertices.map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let corner = |ring: usize, turn: usize| 1 + ring * around + turn % around;
    let quads = (0..rings - 1).flat_map(|ring| (0..around).map(move |turn| [ring, turn]));
    let faces = quads.map(|[ring, turn]| {
        let [a, b, c, d] =
            [corner(ring, turn), corner(ring + 1, turn), corner(ring + 1, turn + 1), corner(ring, turn + 1)];
        format!("f {a} {b} {c}\nf {a} {c} {d}\n")
    });
    vertices + &faces.collect::<String>()
}

#[test]
fn dense_hulls_that_start_deep_inside_each_other_are_moved_apart() {
    let file = scratch("pebbles").join("scene.toml");
    std::fs::write(file.with_file_name("pebble.obj"), pebble()).expect("a mesh");
    let link = |name: &str| {
        format!(
            "<robot name='{name}'><link name='{name}'><inertial><mass value='1'/><inertia ixx='0.004' iyy='0.004' izz='0.004' ixy='0' ixz='0' iyz='0'/>\
             </inertial><collision><geometry><mesh filename='pebble.obj'/></geometry></collision></link></robot>"
        )
    };
    let mut text = String::from("[contact]\npairs = \"all\"\n");
    for (name, x) in [("one", 0.0), ("two", 0.09)] {
        std::fs::write(file.with_file_name(format!("{name}.urdf")), link(name)).expect("a robot");
        text += &format!(
            "[[robot]]\nname = \"{name}\"\nurdf = \"{name}.urdf\"\nbase = \"floating\"\npose = {{ position = [{x}, 0.01, 1] }}\n"
        );
    }
    std::fs::write(&file, text).expect("a scene");
    let end = report(&file, &[], &[], Some(1e-3), 1e-6);
    let told: Vec<&String> = end.warnings.iter().filter(|line| line.contains("inside each other")).collect();
    assert_eq!(told.len(), 1, "{:?}", end.warnings);
    let [one, two] = [0, 1].map(|link: usize| end.links[link].1.position);
    let apart = (0..3).map(|axis| (two[axis] - one[axis]).powi(2)).sum::<f64>().sqrt();
    // They are 0.12 m thick where they are the thinnest, as polyhedra a little less.
    assert!((0.119..0.21).contains(&apart), "{apart}");
    // Roundings of a metre, and the bound to which starts are moved apart.
    assert!(end.contact.max_penetration <= 1e-12, "{:e}", end.contact.max_penetration);
}
