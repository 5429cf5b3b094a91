//! A semicircular arch of 21 stones without mortar: one cone problem of 88 contacts decides whether it stands.

use crate::common::scratch;
use catena::model::Model;
use catena::scene::{PackagePath, read_scene};
use catena::simulation::{Finished, Simulation, SimulationOptions, StepChoice};
use std::f64::consts::PI;

/// Faces of a stone between corners that are numbered by angle, depth and radius.
const FACES: [[usize; 4]; 6] = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]];

/// The arch with this inner radius and an outer one of 1.1 m, after 0.2 s; and the heights of its keystone at both instants (m).
fn after(name: &str, inner: f64) -> (Finished, [f64; 2]) {
    let (count, outer, wide) = (21, 1.1, 0.3);
    let folder = scratch(name);
    let mut text = String::from(
        "[contact]\npairs = \"all\"\nfriction = 0.7\n[[obstacle]]\nname = \"floor\"\nshape = { type = \"half_space\" }\n",
    );
    let mut top = 0.0;
    for stone in 0..count {
        let angles = [stone, stone + 1].map(|joint| PI * f64::from(joint) / f64::from(count));
        let mut corners = Vec::new();
        for angle in angles {
            for y in [-0.5 * wide, 0.5 * wide] {
                corners.extend([inner, outer].map(|radius: f64| [radius * angle.cos(), y, radius * angle.sin()]));
            }
        }
        let centre = [0, 1, 2].map(|axis| corners.iter().map(|corner| corner[axis]).sum::<f64>() / 8.0);
        if stone == count / 2 {
            top = centre[2];
        }
        let points =
            corners.iter().map(|[x, y, z]| format!("v {} {} {}\n", x - centre[0], y - centre[1], z - centre[2]));
        let faces = FACES.iter().map(|[a, b, c, d]| format!("f {a} {b} {c}\nf {a} {c} {d}\n"));
        let mesh: String = points.chain(faces).collect();
        let mass = 1000.0 * (outer * outer - inner * inner) * (PI / f64::from(count)).sin() * wide;
        let moment = mass * (wide * wide + (outer - inner).powi(2)) / 12.0;
        let link = format!(
            "<link name=\"s\"><inertial><mass value=\"{mass}\"/><inertia ixx=\"{moment}\" iyy=\"{moment}\" izz=\"{moment}\" ixy=\"0\" ixz=\"0\" \
             iyz=\"0\"/></inertial><collision><geometry><mesh filename=\"{stone}.obj\"/></geometry></collision></link>"
        );
        std::fs::write(folder.join(format!("{stone}.obj")), mesh).expect("a file");
        std::fs::write(folder.join(format!("{stone}.urdf")), format!("<robot name=\"s\">{link}</robot>"))
            .expect("a file");
        text += &format!(
            "[[robot]]\nname = \"s{stone}\"\nurdf = \"{stone}.urdf\"\nbase = \"floating\"\npose = {{ position = {centre:?} }}\n"
        );
    }
    let file = folder.join("scene.toml");
    std::fs::write(&file, text).expect("a file");
    let scene = read_scene(&file, &PackagePath::default()).expect("a scene");
    let (model, start) = Model::from_scene(&scene).expect("a model");
    let start = model.initial_state(&start.positions, &start.velocities, None).expect("a start");
    let options = SimulationOptions::new(0.2, StepChoice::Tolerance(1e-3));
    let mut simulation = Simulation::new(&model.mechanism, start, options).expect("a run");
    simulation.run().expect("a run to its end");
    let key = simulation.state().position[7 * (count as usize / 2) + 2];
    (simulation.finish(), [top, key])
}

#[test]
fn an_arch_stands_if_it_is_thicker_than_a_semicircle_needs_and_falls_if_not() {
    // The least thickness is 0.1075 of the mean radius, for joints that do not slide (J. Heyman, The masonry arch, 1982).
    let (stands, [top, key]) = after("arch_stands", 0.98);
    // 0.115: nothing moves in any digit but roundings of the start.
    assert!((top - key).abs() < 1e-12, "{top} {key}");
    assert!(stands.summary.contact.penetration <= 1e-12, "{:?}", stands.summary.contact);
    let (falls, [top, key]) = after("arch_falls", 1.0);
    // 0.095: a hinge opens at the keystone, which falls more slowly than a free body: by some per cent of g t²/2 = 0.2 m.
    assert!(top - key > 1e-3 && top - key < 0.2, "{top} {key}");
    assert!(falls.summary.contact.penetration <= 1e-9, "{:?}", falls.summary.contact);
    assert!(falls.summary.max_relative_energy_error <= 1e-7, "{:e}", falls.summary.max_relative_energy_error);
}
