//! A scene as it was read: robots, what couples them, and how to run them.

use crate::scene::body::SceneBody;
use crate::scene::contact_settings::ContactSettings;
use crate::scene::coupling::{SceneCoupling, SceneLoop, SceneRope, SceneSpring};
use crate::scene::joint_settings::{SceneJoint, SceneMotion, SceneMotor, TableFile};
use crate::scene::loads::{SceneDrag, SceneLoad};
use crate::scene::robot::{Pose, Robot};
use crate::scene::warning::Warning;
use nalgebra::Vector3;
use std::path::PathBuf;

/// The default acceleration of gravity in the world [m/s²].
pub const STANDARD_GRAVITY: Vector3<f64> = Vector3::new(0.0, 0.0, -9.81);

/// A scene, validated: every number is finite and every name refers to something.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Its name; the name of the file unless it gives one.
    pub name: String,
    /// The file.
    pub path: PathBuf,
    /// The text of the file.
    pub source: String,
    /// Whether it is a robot alone, without a scene file.
    pub is_robot: bool,
    /// Acceleration of gravity in the world [m/s²], if given.
    pub gravity: Option<Vector3<f64>>,
    /// The robots, then the bodies: at least one.
    pub robots: Vec<SceneRobot>,
    /// The joints that close loops.
    pub loops: Vec<SceneLoop>,
    /// The springs.
    pub springs: Vec<SceneSpring>,
    /// The ropes.
    pub ropes: Vec<SceneRope>,
    /// The loads.
    pub loads: Vec<SceneLoad>,
    /// The drag of links.
    pub drags: Vec<SceneDrag>,
    /// Linear relations of joints.
    pub couplings: Vec<SceneCoupling>,
    /// The motors.
    pub motors: Vec<SceneMotor>,
    /// The joints that are moved in time.
    pub motions: Vec<SceneMotion>,
    /// Settings that replace the URDFs' limits, friction and damping of joints.
    pub joints: Vec<SceneJoint>,
    /// Obstacles, and which shapes may touch.
    pub contact: ContactSettings,
    /// The CSV files that were read, in the order of reading.
    pub tables: Vec<TableFile>,
    /// How to run it.
    pub simulation: SimulationSettings,
    /// Repairs of the scene file; the robots have their own warnings.
    pub warnings: Vec<Warning>,
}

impl Scene {
    /// A robot alone, fixed in the world where its URDF puts it. The text of the scene is what a scene file beside the URDF would say.
    pub fn of_robot(robot: Robot) -> Self {
        let file = robot.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
        Scene {
            name: robot.name.clone(),
            path: robot.path.clone(),
            source: format!("[[robot]]\nurdf = {file:?}\n"),
            is_robot: true,
            gravity: None,
            loops: Vec::new(),
            springs: Vec::new(),
            ropes: Vec::new(),
            loads: Vec::new(),
            drags: Vec::new(),
            couplings: Vec::new(),
            motors: Vec::new(),
            motions: Vec::new(),
            joints: Vec::new(),
            contact: ContactSettings::default(),
            tables: Vec::new(),
            simulation: SimulationSettings::default(),
            warnings: Vec::new(),
            robots: vec![SceneRobot {
                name: robot.name.clone(),
                prefix: String::new(),
                body: None,
                copy: false,
                robot,
                floating: false,
                pose: Pose::identity(),
                rpy: [0.0; 3],
                velocity: None,
                positions: Vec::new(),
                velocities: Vec::new(),
                line: 1,
            }],
        }
    }
}

/// A robot or body of a scene, and how it starts.
#[derive(Clone, Debug)]
pub struct SceneRobot {
    /// Name, unique in the scene.
    pub name: String,
    /// Prefix of the names of its links and joints: its name and a slash if there are several robots.
    pub prefix: String,
    /// The description of a `[[body]]`: its only link and the joint of its base have its name.
    pub body: Option<SceneBody>,
    /// Whether it is made from the file of the robot before it, as another copy.
    pub copy: bool,
    /// The URDF.
    pub robot: Robot,
    /// Whether the root link moves freely.
    pub floating: bool,
    /// The frame of the root link in the world.
    pub pose: Pose,
    /// Roll, pitch and yaw of the pose, as they were given (rad).
    pub rpy: [f64; 3],
    /// Velocity of the origin of a floating root link's frame in the world (linear, angular), and its line.
    pub velocity: Option<([f64; 6], usize)>,
    /// Initial joint positions, as users give them.
    pub positions: Vec<JointValues>,
    /// Initial joint velocities, as users give them.
    pub velocities: Vec<JointValues>,
    /// Line of the `[[robot]]`.
    pub line: usize,
}

/// Numbers given for a joint of a robot.
#[derive(Clone, Debug, PartialEq)]
pub struct JointValues {
    /// Name of the joint in its robot.
    pub joint: String,
    /// The numbers.
    pub values: Vec<f64>,
    /// Their line.
    pub line: usize,
}

/// The settings of the run that a scene asks for; the caller chooses missing ones.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SimulationSettings {
    /// Simulated time (s).
    pub duration: Option<f64>,
    /// Wanted accuracy of positions (m).
    pub tolerance: Option<f64>,
    /// Whether a run with a tolerance estimates its error.
    pub estimate: Option<bool>,
    /// Number of stages and step (s), instead of a tolerance.
    pub fixed: Option<(usize, f64)>,
    /// Samples in the log per simulated second.
    pub rate: Option<f64>,
}
