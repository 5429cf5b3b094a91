//! The input files as attachments, so that a run can be made again from its log alone.
//!
//! The main input (the scene file, or else the URDF) comes first, then the robots of a scene in their order, then the CSV files of its
//! targets in the order in which they were read: that, and no path, tells which is which. Attachments have the names of their files, with a
//! number where another attachment has that name already. The metadata record `inputs` has for each attachment the SHA-256 of its bytes and, for people, the path
//! it was read from, relative to the folder of the main input if it is below that: `HASH PATH`.

use crate::model::Model;
use crate::output::log::error::LogError;
use crate::output::log::file::LogFile;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::Path;

/// The name of the metadata record.
pub const INPUTS: &str = "inputs";

/// A file that was read.
pub(crate) struct Input<'m> {
    name: String,
    relative: &'m Path,
    media_type: &'static str,
    text: &'m str,
    /// SHA-256 of its bytes.
    pub hash: String,
}

/// What was read, the main input first.
pub(crate) fn inputs(model: &Model) -> Vec<Input<'_>> {
    let scene = model.scene.iter().map(|scene| (String::new(), &*scene.path, &*scene.text, "application/toml"));
    let robots =
        model.robots.iter().enumerate().map(|(index, placed)| {
            (model.prefix(index), &*placed.robot.path, &*placed.robot.source, "application/xml")
        });
    let tables = model.tables.iter().map(|table| (String::new(), &*table.path, &*table.text, "text/csv"));
    let mut main_folder = None;
    let mut all: Vec<Input> = Vec::new();
    for (prefix, path, text, media_type) in scene.chain(robots).chain(tables) {
        let folder = *main_folder.get_or_insert(path.parent().unwrap_or(Path::new("")));
        let name = format!("{prefix}{}", path.file_name().unwrap_or(path.as_os_str()).to_string_lossy());
        all.push(Input {
            name: unique(name, &all),
            relative: path.strip_prefix(folder).unwrap_or(path),
            media_type,
            text,
            hash: sha256(text.as_bytes()),
        });
    }
    all
}

/// The name, with a number if one of these has it.
fn unique(name: String, taken: &[Input]) -> String {
    let is_free = |name: &String| taken.iter().all(|input| input.name != *name);
    let numbered = (2..).map(|number| format!("{name} ({number})"));
    [name.clone()].into_iter().chain(numbered).find(is_free).unwrap_or(name)
}

/// Attaches what was read.
pub(crate) fn attach_inputs(file: &mut LogFile, inputs: &[Input]) -> Result<(), LogError> {
    let mut entries = BTreeMap::new();
    for Input { name, relative, media_type, text, hash } in inputs {
        file.attach(name, media_type, text.as_bytes())?;
        entries.insert(name.clone(), format!("{hash} {}", relative.display()));
    }
    file.metadata(INPUTS, entries)
}

/// The SHA-256 of some bytes, in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
