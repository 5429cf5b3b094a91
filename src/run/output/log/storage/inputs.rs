//! The input files as attachments, so that a run can be repeated from its log alone.
//!
//! The main input (the scene file, or else the URDF) comes first, then the robots of a scene in their order, one of several copies. The CSV files of
//! its targets follow in the order in which they were read, and then the meshes of its obstacles. This order, and no path, identifies the files. The
//! meshes of links that may touch come last; in place of a path the record `inputs` has `robotN: ` and the name of the mesh in the URDF of robot N.
//! Attachments have the names of their files, with a number if another attachment has that name already. The metadata record `inputs` has for each
//! attachment the SHA-256 of its bytes and, for people, the path it was read from, relative to the folder of the main input if it is below that:
//! `HASH PATH`.

use crate::model::Model;
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::LogFile;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::Path;

/// The name of the metadata record.
pub const INPUTS: &str = "inputs";

/// The media type of meshes, whatever their format.
const MESH: &str = "application/octet-stream";

/// A file that was read.
pub(crate) struct Input<'m> {
    name: String,
    relative: &'m Path,
    media_type: &'static str,
    bytes: &'m [u8],
    /// SHA-256 of its bytes.
    pub hash: String,
}

/// The files that were read, the main input first.
pub(crate) fn inputs(model: &Model) -> Vec<Input<'_>> {
    let scene = model.scene.iter().map(|scene| (String::new(), &*scene.path, &*scene.text, "application/toml"));
    let of_files = model.robots.iter().filter(|placed| !placed.is_body && !placed.is_copy);
    let robots =
        of_files.map(|placed| (placed.prefix.clone(), &*placed.robot.path, &*placed.robot.source, "application/xml"));
    let tables = model.tables.iter().map(|table| (String::new(), &*table.path, &*table.text, "text/csv"));
    let texts =
        scene.chain(robots).chain(tables).map(|(prefix, path, text, kind)| (prefix, path, path, text.as_bytes(), kind));
    let obstacles = model.contact.settings.obstacles.iter().filter_map(|obstacle| obstacle.mesh.as_ref());
    let obstacles = obstacles.map(|mesh| (String::new(), &*mesh.path, &*mesh.path, &mesh.bytes[..], MESH));
    let of_links = model.contact.meshes.iter();
    let of_links = of_links.map(|mesh| (String::new(), &*mesh.path, Path::new(&mesh.name), &mesh.bytes[..], MESH));
    let mut main_folder = None;
    let mut all: Vec<Input> = Vec::new();
    for (prefix, path, named, bytes, media_type) in texts.chain(obstacles).chain(of_links) {
        let folder = *main_folder.get_or_insert(path.parent().unwrap_or(Path::new("")));
        let name = format!("{prefix}{}", path.file_name().unwrap_or(path.as_os_str()).to_string_lossy());
        all.push(Input {
            name: unique(name, &all),
            relative: named.strip_prefix(folder).unwrap_or(named),
            media_type,
            bytes,
            hash: sha256(bytes),
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

/// Attaches the files that were read.
pub(crate) fn attach_inputs(file: &mut LogFile, inputs: &[Input]) -> Result<(), LogError> {
    let mut entries = BTreeMap::new();
    for Input { name, relative, media_type, bytes, hash } in inputs {
        file.attach(name, media_type, bytes)?;
        entries.insert(name.clone(), format!("{hash} {}", relative.display()));
    }
    file.metadata(INPUTS, entries)
}

/// The SHA-256 of some bytes, in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
