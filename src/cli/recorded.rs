//! A run as its log describes it: the options it was made with and the input files it carries.
//!
//! The files are read from the log's own bytes and no other file is touched, whatever paths the log has: the robots and tables of a
//! scene are the attachments after it, in their order, then the meshes of its obstacles; meshes of links that may touch are named after
//! their robots. Other meshes, on which no motion depends, are left out.

use crate::cli::arguments::input::WorldArgs;
use crate::cli::{simulate, simulate_arguments};
use anyhow::{Context, anyhow, bail};
use catena::output::log::reading::reader::{Item, read_log};
use catena::output::log::{INPUTS, START, sha256};
use catena::scene::{
    Format, Geometry, Problem, Robot, Scene, SceneError, SceneFiles, robot_without_meshes, scene_from_text,
};
use catena::session::Loaded;
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

/// The run of a log.
pub struct Recorded {
    /// The options it was made with.
    pub arguments: simulate::Arguments,
    /// The simulated model, read from the log.
    pub loaded: Loaded,
    /// Its scene: all numbers of the input, before options change them.
    pub scene: Scene,
    /// The metadata record `simulation`.
    pub simulation: BTreeMap<String, String>,
}

impl Recorded {
    /// The time of the log at the start of the run, in nanoseconds; zero in logs of earlier versions.
    pub fn start(&self) -> u64 {
        self.simulation.get(START).and_then(|start| start.parse().ok()).unwrap_or(0)
    }

    /// Reads the beginning of a log.
    ///
    /// # Errors
    /// The missing or defective part of the log.
    pub fn open(log: &Path) -> anyhow::Result<Self> {
        let Beginning { simulation, inputs, files, missing } = Beginning::read(log)?;
        let lacks = |what: &str| {
            let why = missing.as_ref().map_or(String::new(), |reason| format!(": {reason}"));
            anyhow!("{}: it does not say how it was made: there is no {what}{why}", log.display())
        };
        let words = simulation.get("arguments").ok_or_else(|| lacks("record of its arguments"))?;
        let words: Vec<String> = serde_json::from_str(words).map_err(|_| lacks("readable record of its arguments"))?;
        let in_log = || format!("{}: the options it was made with", log.display());
        let arguments = simulate_arguments(&words).with_context(in_log)?;
        let mut carried = Vec::with_capacity(files.len());
        for (name, data) in files {
            let Some((hash, path)) = inputs.get(&name).and_then(|entry| entry.split_once(' ')) else { continue };
            if hash != sha256(&data) {
                bail!("{}: the attachment {name:?} is not what was written", log.display());
            }
            carried.push(Carried { name, path: path.to_string(), data });
        }
        let (meshes, texts) = carried.into_iter().partition(|file: &Carried| file.robot().is_some());
        let mut files = FilesInLog { files: Vec::into_iter(texts), meshes, robots: 0 };
        let main = files.files.next().ok_or_else(|| lacks("attachment"))?;
        // In messages files have paths as if the log were their folder.
        let path = log.join(&main.name);
        let text = as_text(main.data, &path).map_err(anyhow::Error::from);
        let loaded = text.and_then(|text| load(&path, &text, files, &arguments.input.world));
        let (scene, mut loaded) = loaded.with_context(|| format!("{}: its input", log.display()))?;
        loaded.model.keep(&arguments.input.keep);
        Ok(Recorded { arguments, loaded, scene, simulation })
    }
}

/// Loads the text of the main input, and the files it names.
fn load(path: &Path, text: &str, mut files: FilesInLog, world: &WorldArgs) -> anyhow::Result<(Scene, Loaded)> {
    if Format::of(path, text) != Format::Scene {
        let robot = files.with_meshes(robot_without_meshes(text, path)?);
        return Ok((Scene::of_robot(robot.clone()), world.world().place_robot(robot)?));
    }
    let scene = scene_from_text(text, path, &mut files)?;
    Ok((scene.clone(), world.world().place_scene(scene)?))
}

/// A file that a log carries.
struct Carried {
    name: String,
    /// Its path, or for a mesh of a robot its name in the URDF.
    path: String,
    data: Vec<u8>,
}

impl Carried {
    /// For a mesh of a robot's links: the robot and the mesh, as [`catena::scene::MeshSource`] names them.
    fn robot(&self) -> Option<(usize, &str)> {
        let (number, mesh) = self.path.strip_prefix("robot")?.split_once(": ")?;
        Some((number.parse().ok()?, mesh))
    }
}

/// The files that a log carries after the main input, in the order in which the scene was read, and the meshes of robots by their names.
struct FilesInLog {
    files: std::vec::IntoIter<Carried>,
    meshes: Vec<Carried>,
    /// How many robots were read.
    robots: usize,
}

impl FilesInLog {
    /// Puts the meshes that the log carries into the next robot.
    fn with_meshes(&mut self, mut robot: Robot) -> Robot {
        self.robots += 1;
        for shape in robot.links.iter_mut().flat_map(|link| &mut link.collisions) {
            let Geometry::Mesh(mesh) = &mut shape.geometry else { continue };
            let carried = self.meshes.iter().find(|file| file.robot() == Some((self.robots, &mesh.path)));
            mesh.carried = carried.map(|file| Arc::new(file.data.clone()));
        }
        robot
    }
}

impl SceneFiles for FilesInLog {
    fn robot(&mut self, urdf: &Path) -> Result<Robot, SceneError> {
        let robot = robot_without_meshes(&self.text(urdf)?, urdf)?;
        Ok(self.with_meshes(robot))
    }

    fn text(&mut self, file: &Path) -> Result<String, SceneError> {
        as_text(self.bytes(file)?, file)
    }

    fn bytes(&mut self, file: &Path) -> Result<Vec<u8>, SceneError> {
        let next = self.files.next().map(|file| file.data);
        next.ok_or_else(|| unreadable(file, "the log does not carry it".to_string()))
    }
}

fn as_text(bytes: Vec<u8>, file: &Path) -> Result<String, SceneError> {
    String::from_utf8(bytes).map_err(|error| unreadable(file, error.to_string()))
}

fn unreadable(file: &Path, reason: String) -> SceneError {
    let problem = Box::new(Problem::Unreadable(reason));
    SceneError { file: file.to_path_buf(), line: None, element: None, problem }
}

/// The records before the first sample.
#[derive(Default)]
struct Beginning {
    simulation: BTreeMap<String, String>,
    inputs: BTreeMap<String, String>,
    files: Vec<(String, Vec<u8>)>,
    /// The missing part of the log, if it is in its beginning.
    missing: Option<String>,
}

impl Beginning {
    fn read(log: &Path) -> anyhow::Result<Self> {
        let mut beginning = Beginning::default();
        let ended = read_log(log, |item| {
            match item {
                Item::Metadata { name: "simulation", entries } => beginning.simulation.clone_from(entries),
                Item::Metadata { name, entries } if name == INPUTS => beginning.inputs.clone_from(entries),
                Item::Attachment { name, data, .. } => beginning.files.push((name.to_string(), data.to_vec())),
                Item::Message { .. } => return ControlFlow::Break(()),
                _ => {}
            }
            ControlFlow::Continue(())
        })?;
        beginning.missing = ended.and_then(|completeness| completeness.missing());
        Ok(beginning)
    }
}
