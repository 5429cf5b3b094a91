//! Edges that meet edges: several normals separate the two bodies, and the distance has one of them by roundings. Bodies meet along the normal along
//! which they approach slowest.

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
