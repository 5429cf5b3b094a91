//! What several tests share: reproducible numbers, and the URDF evaluated literally, link by link.

#![allow(dead_code, reason = "each program of tests uses its own part")]

pub mod command;

use catena::mechanism::description::mechanism::Mechanism;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::motion::integrator::Integrator;
use catena::mechanism::motion::state::State;
use catena::model::{Base, Model, ModelError, ModelOptions};
use catena::scene::{PackagePath, Robot, UrdfJointKind, read_urdf};
use catena::simulation::{Accuracy, RunOptions, Simulation, SimulationOptions, StepChoice, Summary, run};
use catena::stepping::integrator::Lobatto;
use nalgebra::{IsometryMatrix3, Matrix3, Rotation3, Translation3, Unit, Vector3};
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A small reproducible generator (xorshift64*): tests must not differ from run to run.
pub struct Numbers(u64);

impl Numbers {
    pub fn new(seed: u64) -> Self {
        Numbers(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// A number between the bounds.
    pub fn next(&mut self, low: f64, high: f64) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let unit = (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64;
        low + (high - low) * unit
    }
}

/// The frame of every link in the world, by the definition of URDF alone: parent frame, then joint origin, then joint
/// displacement about or along the axis. `positions` are user coordinates; joints without any are at zero.
pub fn literal_link_poses(
    robot: &Robot,
    root: &IsometryMatrix3<f64>,
    positions: &[(String, Vec<f64>)],
) -> Vec<IsometryMatrix3<f64>> {
    let given: HashMap<&str, &[f64]> = positions.iter().map(|(name, p)| (name.as_str(), p.as_slice())).collect();
    robot.links.iter().map(|link| literal_link_pose(robot, &link.name, root, &given)).collect()
}

fn literal_link_pose(
    robot: &Robot,
    link: &str,
    root: &IsometryMatrix3<f64>,
    given: &HashMap<&str, &[f64]>,
) -> IsometryMatrix3<f64> {
    let Some(joint) = robot.joints.iter().find(|joint| joint.child == link) else { return *root };
    let parent = literal_link_pose(robot, &joint.parent, root, given);
    let Some(p) = given.get(joint.name.as_str()) else { return parent * joint.origin };
    let turn = |angle| Rotation3::from_axis_angle(&Unit::new_normalize(joint.axis), angle);
    let at = |v: Vector3<f64>, rotation| IsometryMatrix3::from_parts(Translation3::from(v), rotation);
    let displacement = match joint.kind {
        UrdfJointKind::Revolute | UrdfJointKind::Continuous => at(Vector3::zeros(), turn(p[0])),
        UrdfJointKind::Prismatic => at(joint.axis * p[0], Rotation3::identity()),
        UrdfJointKind::Planar => {
            // The plane's x is the coordinate axis after the axis' largest entry, made orthogonal to it.
            let n = joint.axis;
            let next = Vector3::ith((n.iamax() + 1) % 3, 1.0);
            let x = (next - n * n.dot(&next)).normalize();
            at(x * p[0] + n.cross(&x) * p[1], turn(p[2]))
        }
        UrdfJointKind::Spherical => at(Vector3::zeros(), Rotation3::from_euler_angles(p[0], p[1], p[2])),
        UrdfJointKind::Floating => at(Vector3::new(p[0], p[1], p[2]), Rotation3::from_euler_angles(p[3], p[4], p[5])),
        UrdfJointKind::Fixed => IsometryMatrix3::identity(),
    };
    parent * joint.origin * displacement
}

/// Angle between two rotations [rad], exact for small angles.
pub fn rotation_angle(a: &Matrix3<f64>, b: &Matrix3<f64>) -> f64 {
    (a - b).norm() / std::f64::consts::SQRT_2
}

/// An empty folder of this test's own. What is left in it afterwards is in the folder of the build.
pub fn scratch(name: &str) -> PathBuf {
    // The thread of a test has its name, with that of its module.
    let thread = std::thread::current();
    let test = thread.name().expect("the thread of a test").replace("::", "/");
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(env!("CARGO_CRATE_NAME")).join(test).join(name);
    // It is not there the first time.
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).expect("a folder for the test");
    folder
}

/// A folder of the shared test data; `None`, with the reason printed, where it is not there.
pub fn shared(folder: &str) -> Option<PathBuf> {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared").join(folder);
    if path.is_dir() {
        return Some(path);
    }
    println!("skipped: {} does not exist", path.display());
    None
}

/// The URDF files of a folder, in order of name.
pub fn urdf_files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|file| file.extension().is_some_and(|extension| extension == "urdf"));
    files.sort();
    files
}

/// The name of a file without folder and ending.
pub fn stem(file: &Path) -> &str {
    file.file_stem().and_then(|name| name.to_str()).unwrap()
}

/// Runs to the time `until` and returns the figures of the run; the state is then the one at that time exactly.
pub fn run_until(mechanism: &Mechanism, state: &mut State, integrator: &mut dyn Integrator, until: f64) -> Summary {
    let options = RunOptions { duration: until - state.time, rate: None, interrupt: None };
    let (summary, ended) = run(mechanism, state, integrator, &options, &mut []);
    ended.unwrap_or_else(|error| panic!("{}: {error}", mechanism.name));
    summary
}

/// The integrator of `catena simulate --tolerance`: the steps with which a run ends that estimates its error as it goes along.
pub fn by_tolerance(mechanism: &Mechanism, start: &State, duration: f64, tolerance: f64) -> Lobatto {
    let Accuracy { stop, stages, .. } = accuracy_of(mechanism, start, duration, tolerance);
    Lobatto::adaptive_with_stages(mechanism, tolerance, stop, stages)
}

/// How accurate a run of the whole mechanism says that it was.
pub fn accuracy_of(mechanism: &Mechanism, start: &State, duration: f64, tolerance: f64) -> Accuracy {
    let options = SimulationOptions {
        switched_off: &Rule::ALL,
        ..SimulationOptions::new(duration, StepChoice::Tolerance(tolerance))
    };
    let mut simulation = Simulation::new(mechanism, start.clone(), options).expect("a simulation");
    simulation.run().unwrap_or_else(|error| panic!("{}: {error}", mechanism.name));
    simulation.accuracies()[0].clone().expect("an accuracy")
}

/// The models of a robot with a fixed base and, where it can float, with a floating one.
pub fn models_of(file: &Path) -> Vec<(Base, Model)> {
    let model = |base| {
        let robot = read_urdf(file, &PackagePath::default()).unwrap();
        match Model::new(robot, &ModelOptions { base, ..Default::default() }) {
            Ok(model) => Some((base, model)),
            // Attached to the world by its URDF, or with a root link without mass or inertia: it cannot float.
            Err(ModelError::BaseIsWorld { .. } | ModelError::NoInertia { .. }) if base == Base::Floating => None,
            Err(error) => panic!("{error}"),
        }
    };
    [Base::Fixed, Base::Floating].into_iter().filter_map(model).collect()
}
