//! A run as its log describes it: the options it was made with and the input files it carries.
//!
//! The files are read from the log's own bytes and no other file is touched, whatever paths the log has: the robots and tables of a
//! scene are the attachments after it, in their order, and meshes, on which no motion depends, are left out.

use crate::cli::input::{Loaded, WorldArgs, is_scene};
use crate::cli::{simulate, simulate_arguments};
use anyhow::{Context, anyhow, bail};
use catena::output::log::reader::{Item, read_log};
use catena::output::log::{INPUTS, sha256};
use catena::scene::{Problem, Robot, SceneError, SceneFiles, robot_without_meshes, scene_from_text};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;

/// The run of a log.
pub struct Recorded {
    /// The options it was made with.
    pub arguments: simulate::Arguments,
    /// What was simulated, read from the log.
    pub loaded: Loaded,
    /// The metadata record `simulation`.
    pub simulation: BTreeMap<String, String>,
}

impl Recorded {
    /// Reads the beginning of a log.
    ///
    /// # Errors
    /// What the log lacks, or what is wrong with what it has.
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
        let mut texts = Vec::with_capacity(files.len());
        for (name, data) in files {
            let Some((hash, _)) = inputs.get(&name).and_then(|entry| entry.split_once(' ')) else { continue };
            if hash != sha256(&data) {
                bail!("{}: the attachment {name:?} is not what was written", log.display());
            }
            let text =
                String::from_utf8(data).with_context(|| format!("{}: the attachment {name:?}", log.display()))?;
            texts.push((name, text));
        }
        let mut texts = texts.into_iter();
        let (main, text) = texts.next().ok_or_else(|| lacks("attachment"))?;
        // In messages files have paths as if the log were their folder.
        let loaded = load(&log.join(main), &text, texts.map(|(_, text)| text), &arguments.input.world);
        let loaded = loaded.with_context(|| format!("{}: its input", log.display()))?;
        Ok(Recorded { arguments, loaded, simulation })
    }
}

/// What the text of the main input says, and the texts of the files it names if it is a scene.
fn load(path: &Path, text: &str, others: impl Iterator<Item = String>, world: &WorldArgs) -> anyhow::Result<Loaded> {
    if !is_scene(path) {
        return world.place_robot(robot_without_meshes(text, path)?);
    }
    world.place_scene(scene_from_text(text, path, &mut FilesInLog { texts: others })?)
}

/// The files that a log carries after the scene file, in the order in which the scene was read.
struct FilesInLog<I> {
    texts: I,
}

impl<I: Iterator<Item = String>> SceneFiles for FilesInLog<I> {
    fn robot(&mut self, urdf: &Path) -> Result<Robot, SceneError> {
        robot_without_meshes(&self.text(urdf)?, urdf)
    }

    fn text(&mut self, file: &Path) -> Result<String, SceneError> {
        self.texts.next().ok_or_else(|| {
            let problem = Box::new(Problem::Unreadable("the log does not carry it".to_string()));
            SceneError { file: file.to_path_buf(), line: None, element: None, problem }
        })
    }
}

/// What comes before the first sample.
#[derive(Default)]
struct Beginning {
    simulation: BTreeMap<String, String>,
    inputs: BTreeMap<String, String>,
    files: Vec<(String, Vec<u8>)>,
    /// What is missing of the log, if that is in its beginning.
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
