//! Reads a scene file: robots, their couplings, the forces on them, and the settings of the run.
//!
//! | table        | keys                                                                                          |
//! |--------------|-----------------------------------------------------------------------------------------------|
//! | `scene`      | `name`, `gravity` (world, m/s²)                                                               |
//! | `robot`      | `name`, `urdf`, `base`, `pose`, `velocity`, `positions`, `velocities`, `count` or `grid`, `spacing` |
//! | `body`       | `name`, `shape`, `density` or `mass`, `color`, `friction`, `restitution`, `pose`, `velocity`, `count` or `grid`, `spacing` |
//! | `loop`       | `name`, `type`, `a` and `b` (each `link`, `position`, `axis` in the link frame), `length`       |
//! | `spring`     | `name`, `stiffness`, `damping`; between points `a`, `b`, `rest_length`; in a `joint` `rest`      |
//! | `load`       | `joint`, `effort`; or `link`, `position` (link frame), `force`, `torque` (world)                |
//! | `motor`      | `joint`, `kind`, `target`, `interpolation`, `kp`, `kd`, `max_effort`, `period`, `gravity_compensation` |
//! | `motion`     | `joint`, `position`                                                                          |
//! | `joint`      | `name`; instead of the URDF's `limit`, `restitution`, `friction`, `damping`                     |
//! | `obstacle`   | `name`, `shape`, `pose`, `friction`, `restitution`                                             |
//! | `contact`    | `pairs`, `friction`, `restitution`; `[[contact.pair]]`: `a`, `b`, `friction`, `restitution`, `ignore` |
//! | `link`       | `name`, `shape`, `collision`, `friction`, `restitution`                                         |
//! | `simulation` | `duration`, `tolerance` or `stages` and `step`, `rate`                                        |
//!
//! Units: m, rad, s, kg, N. Links and joints are called `robot/name`; where there is one robot, `name` is enough. The link
//! `world` is the world. Names are resolved here; where links are is for the model to find out.

use crate::scene::coupling::LinkReference;
use crate::scene::description::{JointValues, Scene, SceneRobot, SimulationSettings};
use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::numbers::turn;
use crate::scene::robot::{Pose, Robot};
use crate::scene::scene_reading::base_velocity::base_velocity;
use crate::scene::scene_reading::body_schema::BodyTable;
use crate::scene::scene_reading::copies::{CopyKeys, copies};
use crate::scene::scene_reading::coupling_reader::CouplingReader;
use crate::scene::scene_reading::rope_reader::Ropes;
use crate::scene::scene_reading::scene_files::{FilesOnDisk, SceneFiles};
use crate::scene::scene_reading::scene_numbers::STAGES;
use crate::scene::scene_reading::scene_schema::{
    BaseKey, FileTable, JointNumbers, RobotTable, SimulationTable, vector,
};
use crate::scene::scene_reading::toml_text::TomlText;
use crate::scene::taken::TakenNumber;
use crate::scene::text::read_text;
use crate::scene::urdf_reading::package_path::PackagePath;
use crate::scene::world::WORLD_LINK;
use nalgebra::Translation3;
use std::collections::BTreeMap;
use std::path::Path;
use toml::Spanned;

/// Until when lengths of ropes in time are looked at if the file says no duration (s).
const LOOKED_AT: f64 = 10.0;

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
    let mut robots = robots(&text, file.robot, files)?;
    let has_bodies = !file.body.is_empty();
    bodies(&text, file.body, &mut robots, files)?;
    let mut reader = CouplingReader { text: &text, robots: &robots, warnings: Vec::new() };
    let loops = reader.loops(file.loops)?;
    let springs = reader.springs(file.spring)?;
    let mut tables = Vec::new();
    let settings = file.simulation.map_or(Ok(SimulationSettings::default()), |table| simulation(&text, &table))?;
    let Ropes { ropes, winches, motions: paid_out } =
        reader.ropes(file.rope, settings.duration.unwrap_or(LOOKED_AT), files, &mut tables)?;
    let loads = reader.loads(file.load, files, &mut tables)?;
    let drags = reader.drags(file.drag)?;
    let couplings = reader.relations(file.coupling)?;
    let mut motors = reader.motors(file.motor, &loops, files, &mut tables)?;
    let mut motions = reader.motions(file.motion, &loops, &mut motors, files, &mut tables)?;
    motions.extend(paid_out);
    let joints = reader.joints(file.joint, &loops)?;
    let contact = reader.contact(has_bodies, file.contact, file.obstacle, file.link, files)?;
    let warnings = reader.warnings;
    for winch in winches {
        robots.push(winch.robot(path)?);
    }
    for said in &contact.links {
        if let LinkReference::Link { robot, link } = said.link {
            let placed = &mut robots[robot];
            // A body is made anew from what it is described by when one of its numbers is set.
            if let Some(body) = &mut placed.body {
                body.surface = said.surface.or(&body.surface);
            }
            let robot = &mut placed.robot;
            if said.shape.is_none() && said.surface.friction.is_some() {
                let link = Element::Link(robot.links[link].name.clone());
                robot.forget_taken(TakenNumber::Friction, &link);
            }
            let link = &mut robot.links[link];
            let surface = match said.shape {
                Some(number) => &mut link.collisions[number - 1].surface,
                None => &mut link.surface,
            };
            *surface = said.surface.or(surface);
        }
    }
    for said in joints.iter().filter(|said| said.armature.is_some()) {
        let joint = Element::Joint(said.joint.joint.clone());
        robots[said.joint.robot].robot.forget_taken(TakenNumber::Armature, &joint);
    }
    let stem = || path.file_stem().map_or_else(|| "scene".to_string(), |stem| stem.to_string_lossy().into_owned());
    let (name, gravity) = file.scene.map_or((None, None), |scene| (scene.name, scene.gravity));
    Ok(Scene {
        name: name.filter(|name| !name.trim().is_empty()).unwrap_or_else(stem),
        path: path.to_path_buf(),
        source: source.to_string(),
        is_robot: false,
        gravity: gravity.map(|g| vector(&g)),
        robots,
        loops,
        springs,
        ropes,
        loads,
        drags,
        couplings,
        motors,
        motions,
        joints,
        contact,
        tables,
        simulation: settings,
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
        for robot in robot(text, table, files)? {
            if let Some(first) = robots.iter().find(|other| other.name == robot.name) {
                let problem = Problem::DuplicateName { first_line: first.line };
                return Err(text.error(&span, Some(Element::Robot(robot.name)), problem));
            }
            robots.push(robot);
        }
    }
    if robots.len() > 1 {
        robots.iter_mut().for_each(|robot| robot.prefix = format!("{}/", robot.name));
    }
    Ok(robots)
}

/// Adds the bodies to the robots.
fn bodies(
    text: &TomlText,
    tables: Vec<Spanned<BodyTable>>,
    robots: &mut Vec<SceneRobot>,
    files: &mut dyn SceneFiles,
) -> Result<(), SceneError> {
    for (index, table) in tables.into_iter().enumerate() {
        let span = table.span();
        let reader = CouplingReader { text, robots, warnings: Vec::new() };
        for body in reader.bodies(table, index, files)? {
            let refuse = |problem| Err(text.error(&span, Some(Element::Body(body.name.clone())), problem));
            if let Some(first) = robots.iter().find(|other| other.name == body.name) {
                return refuse(Problem::DuplicateName { first_line: first.line });
            }
            for placed in robots.iter().filter(|placed| placed.body.is_none() && placed.prefix.is_empty()) {
                let named = |what| Problem::BodyNamedAs { what, robot: placed.name.clone() };
                if placed.robot.link(&body.name).is_some() {
                    return refuse(named("link"));
                }
                // The joint of a floating base of a URDF.
                if body.name == "base" || placed.robot.joints.iter().any(|joint| joint.name == body.name) {
                    return refuse(named("joint"));
                }
            }
            robots.push(body);
        }
    }
    if robots.is_empty() {
        return Err(text.error(&(0..0), None, Problem::NoRobots));
    }
    Ok(())
}

/// The copies of a robot, of which there is one unless its table says otherwise.
fn robot(
    text: &TomlText,
    table: Spanned<RobotTable>,
    files: &mut dyn SceneFiles,
) -> Result<Vec<SceneRobot>, SceneError> {
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
        Some(velocity) => Some(base_velocity(text, &velocity)),
        None => None,
    };
    let rpy = table.pose.angles();
    let reader = RobotReader { text, robot: &robot, owner: Element::Robot(name.clone()) };
    let positions = reader.joint_values(table.positions, false)?;
    let velocities = reader.joint_values(table.velocities, true)?;
    let keys = CopyKeys { count: &table.count, grid: &table.grid, spacing: &table.spacing };
    let mut all = Vec::new();
    for (number, displacement) in copies(text, &keys, &reader.owner)? {
        let translation = Translation3::from(vector(&table.pose.position) + displacement);
        all.push(SceneRobot {
            name: format!("{name}{number}"),
            prefix: String::new(),
            body: None,
            copy: !all.is_empty(),
            robot: robot.clone(),
            floating,
            pose: Pose::from_parts(translation, turn(rpy)),
            rpy,
            velocity,
            positions: positions.clone(),
            velocities: velocities.clone(),
            line: text.line(&span),
        });
    }
    Ok(all)
}

/// What the numbers of a robot's joints need.
struct RobotReader<'r> {
    text: &'r TomlText<'r>,
    robot: &'r Robot,
    owner: Element,
}

impl RobotReader<'_> {
    /// Positions or velocities of joints, in the order of the file.
    fn joint_values(
        &self,
        table: BTreeMap<Spanned<String>, JointNumbers>,
        rates: bool,
    ) -> Result<Vec<JointValues>, SceneError> {
        let mut given: Vec<(Spanned<String>, JointNumbers)> = table.into_iter().collect();
        given.sort_by_key(|(name, _)| name.span().start);
        let mut values = Vec::with_capacity(given.len());
        for (name, numbers) in given {
            // Of a joint that does not exist the model says so.
            let joint = self.robot.joints.iter().find(|joint| joint.name == *name.get_ref());
            let angle = |number: usize| joint.is_none_or(|joint| joint.kind.is_angle(number));
            let numbers = numbers.0.iter().enumerate().map(|(number, given)| given.value(angle(number), rates));
            let numbers: Result<Vec<f64>, String> = numbers.collect();
            let numbers = numbers.map_err(|reason| {
                let problem = Problem::JointNumber { joint: name.get_ref().clone(), reason };
                self.text.error(&name.span(), Some(self.owner.clone()), problem)
            })?;
            values.push(JointValues { line: self.text.line(&name.span()), joint: name.into_inner(), values: numbers });
        }
        Ok(values)
    }
}

/// The settings of a table `[simulation]`.
pub fn simulation(text: &TomlText, table: &Spanned<SimulationTable>) -> Result<SimulationSettings, SceneError> {
    let SimulationTable { duration, tolerance, estimate, stages, step, rate } = table.get_ref();
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
                return refuse(stages.span(), "simulation.stages must be 1 to 16");
            }
            Some((*stages.get_ref(), step.get_ref().0))
        }
    };
    if let (Some(estimate), Some(_)) = (estimate, fixed) {
        return refuse(estimate.span(), "simulation.estimate goes with tolerance, not with stages and step");
    }
    if let Some(rate) = rate.as_ref().filter(|rate| rate.get_ref().0 > 1e6) {
        return refuse(rate.span(), "simulation.rate must be at most 1e6");
    }
    Ok(SimulationSettings {
        duration: duration.map(|duration| duration.0),
        tolerance: tolerance.as_ref().map(|tolerance| tolerance.get_ref().0),
        estimate: estimate.as_ref().map(|estimate| *estimate.get_ref()),
        fixed,
        rate: rate.as_ref().map(|rate| rate.get_ref().0),
    })
}
