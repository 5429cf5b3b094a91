//! Convex pieces of concave meshes, from files that the tests write: what rests in them, what passes through them, and what is refused.

use crate::common::command::{assert_one_error, folder, run, text};
use serde_json::Value;
use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A triangle of a surface.
type Triangle = [[f64; 3]; 3];

/// The surface of the blocks of a grid that are filled, between these coordinates (m).
fn blocks(lines: [&[f64]; 3], filled: impl Fn([usize; 3]) -> bool) -> Vec<Triangle> {
    let counts = lines.map(|line| line.len() - 1);
    let mut triangles = Vec::new();
    for number in 0..counts.iter().product() {
        let block = [number % counts[0], number / counts[0] % counts[1], number / counts[0] / counts[1]];
        for (axis, side) in (0..3).flat_map(|axis| [(axis, 0), (axis, 1)]) {
            let mut neighbour = block;
            neighbour[axis] = (block[axis] + 2 * side).wrapping_sub(1);
            let is_filled = |block: [usize; 3]| (0..3).all(|axis| block[axis] < counts[axis]) && filled(block);
            if !is_filled(block) || is_filled(neighbour) {
                continue;
            }
            let corner = |one: usize, other: usize| {
                let mut corner = block;
                corner[axis] += side;
                corner[(axis + 1) % 3] += one;
                corner[(axis + 2) % 3] += other;
                [0, 1, 2].map(|axis| lines[axis][corner[axis]])
            };
            let mut square = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            if side == 0 {
                square.reverse();
            }
            triangles.extend([[square[0], square[1], square[2]], [square[0], square[2], square[3]]]);
        }
    }
    triangles
}

/// A cup with walls of 0.02 m on a bottom of 0.03 m that stands on z = 0.
fn cup() -> Vec<Triangle> {
    let across = [-0.1, -0.08, 0.08, 0.1];
    blocks([&across, &across, &[0.0, 0.03, 0.15]], |[i, j, k]| k == 0 || [i, j] != [1, 1])
}

/// A U with a gap of 0.06 m between its arms, which end at z = 0.2.
fn fork() -> Vec<Triangle> {
    blocks([&[-0.1, -0.03, 0.03, 0.1], &[-0.05, 0.05], &[0.0, 0.04, 0.2]], |[i, _, k]| k == 0 || i != 1)
}

fn write_mesh(folder: &Path, triangles: &[Triangle]) {
    let mut stl = "solid mesh\n".to_string();
    for corners in triangles {
        stl += "facet normal 0 0 0\nouter loop\n";
        corners.iter().for_each(|[x, y, z]| writeln!(stl, "vertex {x:?} {y:?} {z:?}").expect("text"));
        stl += "endloop\nendfacet\n";
    }
    std::fs::write(folder.join("mesh.stl"), stl + "endsolid\n").expect("written");
}

fn link(name: &str, geometry: &str) -> String {
    format!(
        "<robot name=\"{name}\"><link name=\"{name}\">\n<inertial><origin xyz=\"0 0 0.05\"/><mass value=\"1.5\"/>\
         <inertia ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.012\" iyz=\"0\" izz=\"0.014\"/></inertial>\n\
         <collision><geometry>{geometry}</geometry></collision></link></robot>"
    )
}

/// A folder with a mesh as a robot, a shape that is let go over it at a height (m), and a floor; the shapes of the mesh are chosen.
fn over(name: &str, triangles: &[Triangle], [geometry, height, choice]: [&str; 3]) -> PathBuf {
    let folder = folder(name);
    write_mesh(&folder, triangles);
    std::fs::write(folder.join("under.urdf"), link("under", "<mesh filename=\"mesh.stl\"/>")).expect("written");
    std::fs::write(folder.join("over.urdf"), link("over", geometry)).expect("written");
    let scene = format!(
        "[[robot]]\nurdf = \"under.urdf\"\nbase = \"floating\"\n[[robot]]\nurdf = \"over.urdf\"\nbase = \"floating\"\n\
         pose = {{ position = [0, 0, {height}] }}\n[[obstacle]]\nname = \"floor\"\nshape = {{ type = \"half_space\" }}\n\
         [contact]\npairs = \"all\"\n[[link]]\nname = \"under/under\"\ncollision = \"{choice}\"\n"
    );
    std::fs::write(folder.join("scene.toml"), scene).expect("written");
    folder
}

fn json(folder: &Path, arguments: &[&str]) -> Value {
    let output = run(folder, arguments);
    serde_json::from_slice(&output.stdout).unwrap_or_else(|error| panic!("{error}: {}", text(&output.stderr)))
}

/// The contacts at the end between the mesh and what is over it: heights of their points (m).
fn heights(report: &Value) -> Vec<f64> {
    let points = report["contact"]["points"].as_array().expect("a list");
    let between = points.iter().filter(|point| point["a"] == "under/under" && point["b"] == "over/over");
    between.map(|point| point["position"][2].as_f64().expect("a height")).collect()
}

#[test]
fn a_ball_rests_on_the_bottom_of_a_cup_in_pieces_and_on_the_mouth_of_its_hull() {
    for (choice, wanted) in [("decompose", 0.03), ("hull", 0.15)] {
        let folder = over("ball_in_cup", &cup(), ["<sphere radius=\"0.025\"/>", "0.3", choice]);
        let report = json(&folder, &["simulate", "scene.toml", "--duration", "1", "--no-log", "--json"]);
        let heights = heights(&report);
        assert_eq!(heights.len(), 1, "{choice}: {}", report["contact"]);
        assert!((heights[0] - wanted).abs() < 1e-12, "{choice}: {} for {wanted}", heights[0]);
        assert!(report["contact"]["max_penetration"].as_f64().expect("a number") < 1e-12, "{}", report["contact"]);
    }
}

#[test]
fn a_peg_falls_through_the_gap_of_a_u_that_is_wider_by_a_tenth_of_a_millimetre_and_not_into_one_that_is_narrower() {
    // Its lower end is 0.01 m over the arms; in 0.15 s it falls by 0.11 m.
    for (width, falls) in [(0.0599, true), (0.0601, false)] {
        let peg = format!("<box size=\"{width} 0.2 0.1\"/>");
        let folder = over("peg_in_fork", &fork(), [&peg, "0.26", "decompose"]);
        let report = json(&folder, &["simulate", "scene.toml", "--duration", "0.15", "--no-log", "--json"]);
        let kinetic = report["energy"]["parts"]["kinetic"].as_f64().expect("a number");
        let wanted = if falls { 0.5 * 1.5 * (9.81_f64 * 0.15).powi(2) } else { 0.0 };
        assert!((kinetic - wanted).abs() < 1e-12, "{width}: {kinetic} J for {wanted} J");
        let heights = heights(&report);
        assert!(heights.is_empty() == falls && heights.iter().all(|z| (z - 0.2).abs() < 1e-12), "{width}: {heights:?}");
    }
}

#[test]
fn pieces_are_listed_and_leave_masses_as_they_are() {
    let [whole, pieces] = ["hull", "decompose"].map(|choice| {
        let folder = over("listed_pieces", &cup(), ["<sphere radius=\"0.025\"/>", "0.3", choice]);
        json(&folder, &["model", "--json", "scene.toml"])
    });
    assert_eq!(whole["bodies"], pieces["bodies"]);
    assert_eq!(whole["warnings"], pieces["warnings"]);
    let hulls = |model: &Value| {
        let shapes = model["contact"]["shapes"].as_array().expect("a list");
        shapes.iter().filter(|shape| shape["name"] == "under/under" && shape["shape"] == "hull").count()
    };
    // A bottom and four walls.
    assert_eq!([hulls(&whole), hulls(&pieces)], [1, 5]);
}

#[test]
fn pieces_of_a_mesh_that_is_flat_or_not_closed_are_refused_with_file_line_and_name_and_nothing_is_written() {
    let mut open = cup();
    open.pop();
    let flat = [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]];
    for (triangles, part) in [(&open[..], "the mesh is not closed (3 edges"), (&flat[..], "the mesh is flat")] {
        let folder = over("no_pieces", triangles, ["<sphere radius=\"0.025\"/>", "0.3", "decompose"]);
        for verb in ["simulate", "model"] {
            let output = run(&folder, &[verb, "scene.toml"]);
            assert_one_error(&output, 2, part);
            let said = text(&output.stderr);
            let place =
                "under.urdf:3: link \"under\": its collision mesh \"mesh.stl\" cannot be cut into convex pieces: ";
            assert!(said.contains(&format!("{place}{part}")), "{said}");
        }
        assert!(!folder.join("scene.mcap").exists());
    }
}
