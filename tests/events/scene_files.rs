//! Runs of scene files and robots, by their reports.

use crate::common::scratch;
use catena::mechanism::description::rules::Rule;
use catena::prelude::*;
use catena::report::{LinkReport, Numbers, Report};
use std::path::{Path, PathBuf};

/// Positions and velocities of joints at the start, by name.
pub type Given<'g> = [(&'g str, f64)];

/// A scene file with this text beside `robot.urdf`, a robot of these links and joints, in a folder of its own.
pub fn scene_of(folder: &str, robot: &str, text: &str) -> PathBuf {
    let file = written(folder, text);
    std::fs::write(file.with_file_name("robot.urdf"), format!("<robot name='r'>{robot}</robot>")).expect("a robot");
    file
}

/// A scene file with this text, in a folder of its own.
pub fn written(folder: &str, text: &str) -> PathBuf {
    let file = scratch(folder).join("scene.toml");
    std::fs::write(&file, text).expect("a scene");
    file
}

/// The report of a run with a tolerance (m), from a start, for a duration (s); without one that of the file.
pub fn report(file: &Path, positions: &Given, velocities: &Given, duration: Option<f64>, tolerance: f64) -> Report {
    let failed = |error: Error| -> ! { panic!("{}: {error}", file.display()) };
    let model = Model::load(file).unwrap_or_else(|error| failed(error));
    let simulation = Simulation::new(&model).tolerance(tolerance);
    let simulation = simulation.start(positions.iter().copied()).unwrap_or_else(|error| failed(error));
    let mut simulation = simulation.velocities(velocities.iter().copied()).unwrap_or_else(|error| failed(error));
    if let Some(duration) = duration {
        simulation = simulation.duration(duration);
    }
    simulation.run().unwrap_or_else(|error| failed(error));
    simulation.finish().expect("a report")
}

/// A run in which all bodies that may ever touch have the same steps.
pub fn report_in_one(file: &Path, duration: f64, tolerance: f64) -> Report {
    let model = Model::load(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    let mut simulation = Simulation::new(&model).tolerance(tolerance).duration(duration).keep(Rule::Islands);
    simulation.run().unwrap_or_else(|error| panic!("{}: {error}", file.display()));
    simulation.finish().expect("a report")
}

/// A link at the end.
pub fn link<'r>(report: &'r Report, name: &str) -> &'r LinkReport {
    &report.links.iter().find(|(of, _)| of == name).expect("a link").1
}

/// Position and velocity of a joint with one coordinate at the end.
pub fn joint(report: &Report, name: &str) -> (f64, f64) {
    let (_, joint) = report.joints.iter().find(|(of, _)| of == name).expect("a joint");
    match (&joint.position, &joint.velocity) {
        (Numbers::One(position), Numbers::One(velocity)) => (*position, *velocity),
        other => panic!("{name}: {other:?}"),
    }
}

/// The largest distance of two links of the same name at the end (m).
pub fn apart(one: &Report, other: &Report) -> f64 {
    assert_eq!(one.links.len(), other.links.len());
    let distance = |(a, b): (&[f64; 3], &[f64; 3])| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let links = one.links.iter().zip(&other.links);
    links.map(|((_, a), (_, b))| distance((&a.center_of_mass, &b.center_of_mass))).fold(0.0, f64::max)
}
