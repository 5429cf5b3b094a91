//! Reads a scene file: robots, their couplings, the forces on them, and the settings of the run.
//!
//! | table        | keys                                                                                          |
//! |--------------|-----------------------------------------------------------------------------------------------|
//! | `scene`      | `name`, `gravity` (world, m/s²)                                                               |
//! | `robot`      | `name`, `urdf`, `base`, `pose`, `velocity`, `positions`, `velocities`                          |
//! | `loop`       | `name`, `type`, `a` and `b` (each `link`, `position`, `axis` in the link frame), `length`       |
//! | `spring`     | `name`, `stiffness`, `damping`; between points `a`, `b`, `rest_length`; in a `joint` `rest`      |
//! | `load`       | `joint`, `effort`; or `link`, `position` (link frame), `force`, `torque` (world)                |
//! | `motor`      | `joint`, `kind`, `target`, `interpolation`, `kp`, `kd`, `max_effort`, `period`                |
//! | `joint`      | `name`; instead of the URDF's `limit`, `restitution`, `friction`, `damping`                     |
//! | `obstacle`   | `name`, `shape`, `pose`, `friction`, `restitution`                                             |
//! | `contact`    | `pairs`, `friction`, `restitution`; `[[contact.pair]]`: `a`, `b`, `friction`, `restitution`, `ignore` |
//! | `link`       | `name`, `collision`                                                                           |
//! | `simulation` | `duration`, `tolerance` or `stages` and `step`, `rate`                                        |
//!
//! Units: m, rad, s, kg, N. Links and joints are called `robot/name`; where there is one robot, `name` is enough. The link
//! `world` is the world. Names are resolved here; where links are is for the model to find out.

use crate::scene::description::{JointValues, Scene, SceneRobot, SimulationSettings};
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::robot::Pose;
use crate::scene::scene_reading::coupling_reader::CouplingReader;
use crate::scene::scene_reading::scene_files::{FilesOnDisk, SceneFiles};
use crate::scene::scene_reading::scene_numbers::STAGES;
use crate::scene::scene_reading::scene_schema::{
    BaseKey, FileTable, JointNumbers, RobotTable, SimulationTable, vector,
};
use crate::scene::scene_reading::toml_text::TomlText;
use crate::scene::text::read_text;
use crate::scene::urdf_reading::package_path::PackagePath;
use crate::scene::world::WORLD_LINK;
use nalgebra::{Rotation3, Translation3};
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

/// Reads and validates a scene file and the files it names.
///
/// # Errors
/// [`SceneError`] with file, line and key.
pub fn read_scene(path: &Path, packages: &PackagePath) -> Result<Scene, SceneError> {
    scene_from_text(&read_text(path)?, path, &mut FilesOnDisk(packages))
}

/// Reads and validates the text of a scene file; `path` names it in messages, and the files that it names are relative to it. The robots are read
/// first from `files`, one after the other, then the CSV files of targets, each once, then the meshes of obstacles.
///
/// # Errors
/// As [`read_scene`].
pub fn scene_from_text(source: &str, path: &Path, files: &mut dyn SceneFiles) -> Result<Scene, SceneError> {
    let text = TomlText { file: path, text: source.strip_prefix('\u{feff}').unwrap_or(source) };
    let file: FileTable = text.read()?;
    let robots = robots(&text, file.robot, files)?;
    let mut reader = CouplingReader { text: &text, robots: &robots, warnings: Vec::new() };
    let loops = reader.loops(file.loops)?;
    let springs = reader.springs(file.spring)?;
    let loads = reader.loads(file.load)?;
    let mut tables = Vec::new();
    let motors = reader.motors(file.motor, &loops, files, &mut tables)?;
    let joints = reader.joints(file.joint, &loops)?;
    let contact = reader.contact(file.contact, file.obstacle, file.link, files)?;
    let warnings = reader.warnings;
    let stem = || path.file_stem().map_or_else(|| "scene".to_string(), |stem| stem.to_string_lossy().into_owned());
    let (name, gravity) = file.scene.map_or((None, None), |scene| (scene.name, scene.gravity));
    Ok(Scene {
        name: name.filter(|name| !name.trim().is_empty()).unwrap_or_else(stem),
        path: path.to_path_buf(),
        source: source.to_string(),
        gravity: gravity.map(|g| vector(&g)),
        robots,
        loops,
        springs,
        loads,
        motors,
        joints,
        contact,
        tables,
        simulation: file.simulation.map_or(Ok(SimulationSettings::default()), |table| simulation(&text, &table))?,
        warnings,
    })
}

fn robots(
    text: &TomlText,
    tables: Vec<Spanned<RobotTable>>,
    files: &mut dyn SceneFiles,
) -> Result<Vec<SceneRobot>, SceneError> {
    let mut robots: Vec<SceneRobot> = Vec::with_capacity(tables.len());
    for table in tables {
        let span = table.span();
        let robot = robot(text, table, files)?;
        if let Some(first) = robots.iter().find(|other| other.name == robot.name) {
            let problem = Problem::DuplicateName { first_line: first.line };
            return Err(text.error(&span, Some(Element::Robot(robot.name)), problem));
        }
        robots.push(robot);
    }
    if robots.is_empty() {
        return Err(text.error(&(0..0), None, Problem::NoRobots));
    }
    Ok(robots)
}

fn robot(text: &TomlText, table: Spanned<RobotTable>, files: &mut dyn SceneFiles) -> Result<SceneRobot, SceneError> {
    let span = table.span();
    let table = table.into_inner();
    let folder = text.file.parent().unwrap_or(Path::new(""));
    let urdf = folder.join(table.urdf.get_ref());
    let robot = match files.robot(&urdf) {
        // Whose fault it is that there is no such file stands in the scene.
        Err(error) if matches!(*error.problem, Problem::Unreadable(_)) => {
            let message = error.to_string();
            let problem = Problem::Toml { key: Some("robot.urdf".to_string()), message };
            let named = table.name.map(|name| Element::Robot(name.into_inner()));
            return Err(text.error(&table.urdf.span(), named, problem));
        }
        read => read?,
    };
    let name = table.name.as_ref().map_or_else(|| robot.name.clone(), |name| name.get_ref().clone());
    if name.is_empty() || name == WORLD_LINK || name.contains('/') {
        let span = table.name.map_or(span, |name| name.span());
        return Err(text.error(&span, Some(Element::Robot(name)), Problem::RobotName));
    }
    let floating = table.base == BaseKey::Floating;
    let velocity = match table.velocity {
        Some(velocity) if !floating => {
            let problem = Problem::Keys("a velocity of the base needs base = \"floating\"");
            return Err(text.error(&velocity.span(), Some(Element::Robot(name)), problem));
        }
        Some(velocity) => {
            let line = text.line(&velocity.span());
            let [vx, vy, vz] = velocity.get_ref().linear.map(|number| number.0);
            let [wx, wy, wz] = velocity.get_ref().angular.map(|number| number.0);
            Some(([vx, vy, vz, wx, wy, wz], line))
        }
        None => None,
    };
    let [roll, pitch, yaw] = table.pose.rpy.map(|number| number.0);
    let translation = Translation3::from(vector(&table.pose.position));
    Ok(SceneRobot {
        name,
        robot,
        floating,
        pose: Pose::from_parts(translation, Rotation3::from_euler_angles(roll, pitch, yaw)),
        rpy: [roll, pitch, yaw],
        velocity,
        positions: joint_values(text, table.positions),
        velocities: joint_values(text, table.velocities),
        line: text.line(&span),
    })
}

/// In the order of the file.
fn joint_values(text: &TomlText, table: BTreeMap<Spanned<String>, JointNumbers>) -> Vec<JointValues> {
    let mut given: Vec<(Spanned<String>, JointNumbers)> = table.into_iter().collect();
    given.sort_by_key(|(name, _)| name.span().start);
    let values = given.into_iter().map(|(name, numbers)| JointValues {
        line: text.line(&name.span()),
        joint: name.into_inner(),
        values: numbers.0,
    });
    values.collect()
}

/// The settings of a table `[simulation]`.
pub(crate) fn simulation(text: &TomlText, table: &Spanned<SimulationTable>) -> Result<SimulationSettings, SceneError> {
    let SimulationTable { duration, tolerance, stages, step, rate } = table.get_ref();
    let refuse = |span, message| Err(text.error(&span, None, Problem::Keys(message)));
    let fixed = match (stages, step, tolerance) {
        (None, None, _) => None,
        (Some(_), Some(_), Some(tolerance)) => {
            return refuse(tolerance.span(), "simulation: give either tolerance, or stages and step");
        }
        (Some(stages), None, _) => return refuse(stages.span(), "simulation.stages needs a step"),
        (None, Some(step), _) => return refuse(step.span(), "simulation.step needs stages"),
        (Some(stages), Some(step), None) => {
            if !STAGES.contains(stages.get_ref()) {
                return refuse(stages.span(), "simulation.stages must be 2 to 16");
            }
            Some((*stages.get_ref(), step.get_ref().0))
        }
    };
    if let Some(rate) = rate.as_ref().filter(|rate| rate.get_ref().0 > 1e6) {
        return refuse(rate.span(), "simulation.rate must be at most 1e6");
    }
    Ok(SimulationSettings {
        duration: duration.map(|duration| duration.0),
        tolerance: tolerance.as_ref().map(|tolerance| tolerance.get_ref().0),
        fixed,
        rate: rate.as_ref().map(|rate| rate.get_ref().0),
    })
}
