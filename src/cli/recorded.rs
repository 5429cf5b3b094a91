//! A run as its log describes it: the options it was made with and the input files it carries.

use super::input::Loaded;
use super::{simulate, simulate_arguments};
use anyhow::{Context, anyhow, bail};
use catena::log::reader::{Item, read_log};
use catena::log::{INPUTS, sha256};
use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Component, Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// How deep the main input lies in the folder it is unpacked into, so that `..` does not lead out of it.
const DEPTH: usize = 8;

/// The run of a log.
pub struct Recorded {
    /// The options it was made with; the input is the log's.
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
        let Beginning { simulation, inputs, files } = Beginning::read(log)?;
        let lacks = |what: &str| anyhow!("{}: it does not say how it was made: there is no {what}", log.display());
        let words = simulation.get("arguments").ok_or_else(|| lacks("record of its arguments"))?;
        let words: Vec<String> = serde_json::from_str(words).map_err(|_| lacks("readable record of its arguments"))?;
        let in_log = || format!("{}: the options it was made with", log.display());
        let mut arguments = simulate_arguments(&words).with_context(in_log)?;
        let (main, _) = files.first().ok_or_else(|| lacks("attachment"))?;
        let folder = Unpacked::new()?;
        let mut input = folder.deep.join(main);
        for (name, data) in &files {
            let Some((hash, path)) = inputs.get(name).and_then(|entry| entry.split_once(' ')) else { continue };
            if hash != sha256(data) {
                bail!("{}: the attachment {name:?} is not what was written", log.display());
            }
            let path = folder.place(Path::new(path)).with_context(|| {
                format!("{}: the attachment {name:?} was read from {path}, which is not below the input", log.display())
            })?;
            if name == main {
                input.clone_from(&path);
            }
            std::fs::create_dir_all(path.parent().unwrap_or(&folder.deep))?;
            std::fs::write(&path, data).with_context(|| format!("cannot unpack {}", path.display()))?;
        }
        arguments.input.input = input;
        let loaded = arguments.input.load().with_context(|| format!("{}: its input", log.display()))?;
        Ok(Recorded { arguments, loaded, simulation })
    }
}

/// What comes before the first sample.
#[derive(Default)]
struct Beginning {
    simulation: BTreeMap<String, String>,
    inputs: BTreeMap<String, String>,
    files: Vec<(String, Vec<u8>)>,
}

impl Beginning {
    fn read(log: &Path) -> anyhow::Result<Self> {
        let mut beginning = Beginning::default();
        read_log(log, |item| {
            match item {
                Item::Metadata { name: "simulation", entries } => beginning.simulation.clone_from(entries),
                Item::Metadata { name, entries } if name == INPUTS => beginning.inputs.clone_from(entries),
                Item::Attachment { name, data, .. } => beginning.files.push((name.to_string(), data.to_vec())),
                Item::Message { .. } => return ControlFlow::Break(()),
                _ => {}
            }
            ControlFlow::Continue(())
        })?;
        Ok(beginning)
    }
}

/// A folder that is removed in the end.
struct Unpacked {
    top: PathBuf,
    /// Where the main input lies.
    deep: PathBuf,
}

impl Unpacked {
    fn new() -> anyhow::Result<Self> {
        static NUMBER: AtomicUsize = AtomicUsize::new(0);
        let number = NUMBER.fetch_add(1, Ordering::Relaxed);
        let top = std::env::temp_dir().join(format!("catena-{}-{number}", std::process::id()));
        let deep = (0..DEPTH).fold(top.clone(), |folder, _| folder.join("d"));
        std::fs::create_dir_all(&deep).with_context(|| format!("cannot make the folder {}", deep.display()))?;
        Ok(Unpacked { top, deep })
    }

    /// Where a file belongs that was at this path, relative to the main input; an error if it would be outside.
    fn place(&self, path: &Path) -> anyhow::Result<PathBuf> {
        let ups = path.components().filter(|part| matches!(part, Component::ParentDir)).count();
        let is_plain = path
            .components()
            .all(|part| matches!(part, Component::Normal(_) | Component::ParentDir | Component::CurDir));
        if !is_plain || ups >= DEPTH {
            bail!("its path leads elsewhere");
        }
        Ok(self.deep.join(path))
    }
}

impl Drop for Unpacked {
    fn drop(&mut self) {
        // A folder that cannot be removed is no reason to fail; the system clears its temporary files.
        let _ = std::fs::remove_dir_all(&self.top);
    }
}
