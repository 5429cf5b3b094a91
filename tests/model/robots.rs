//! Claims about the example robots in `robots/`.

use nalgebra::Matrix3;
use std::path::PathBuf;

fn urdf_files() -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("robots");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "urdf"));
    files.sort();
    assert!(files.len() >= 12, "only {} URDF files", files.len());
    files
}

#[test]
fn every_robot_says_what_it_shows_and_how_to_run_it() {
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/robots/README.md")).unwrap();
    for file in urdf_files() {
        let text = std::fs::read_to_string(&file).unwrap();
        let comment = text.split_once("<!--").and_then(|(_, rest)| rest.split_once("-->")).unwrap().0;
        let name = file.file_stem().unwrap().to_str().unwrap();
        let command = format!("catena simulate robots/{name}.urdf");
        assert!(comment.contains(&command), "{name}");
        // An XML comment cannot hold the two dashes of an option: the page beside the robots has the whole command.
        assert!(page.contains(&command), "{name}: robots/README.md does not say how to run it");
        assert!(comment.contains("Look:") && comment.contains("Inertia:"), "{name}");
    }
}

/// The robots of the scenes.
fn parts() -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("robots/parts");
    let files = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    files.filter(|file| file.extension().is_some_and(|extension| extension == "urdf")).collect()
}

#[test]
fn every_link_has_an_inertia_that_a_body_can_have() {
    for file in urdf_files().into_iter().chain(parts()) {
        let robot = urdf_rs::read_file(&file).unwrap();
        for link in &robot.links {
            // What is fixed in the world.
            if ["base", "foot"].contains(&link.name.as_str()) {
                continue;
            }
            let inertia = &link.inertial.inertia;
            let tensor = Matrix3::new(
                inertia.ixx,
                inertia.ixy,
                inertia.ixz,
                inertia.ixy,
                inertia.iyy,
                inertia.iyz,
                inertia.ixz,
                inertia.iyz,
                inertia.izz,
            );
            // Second moments of a mass distribution cannot be negative; a thin disc has a zero, to the digits printed.
            let moments = Matrix3::identity() * (0.5 * tensor.trace()) - tensor;
            let smallest = moments.symmetric_eigenvalues().min();
            assert!(link.inertial.mass.value > 0.0, "{}: {}", robot.name, link.name);
            assert!(smallest >= -1e-9 * tensor.trace(), "{}: {} {smallest}", robot.name, link.name);
        }
    }
}
