//! The meshes of a log: their triangles, and where their files were.
//!
//! `/visual_markers` has the triangles, or the address of each file; `/robot_description` has addresses, too. All are known before the first
//! sample.

use crate::output::log::encoding::definitions;
use crate::output::log::encoding::markers::TOPIC;
use crate::output::log::encoding::markers_reader::mesh_markers;
use crate::output::log::reading::decode;
use crate::output::log::reading::reader::{Item, LogChannel, read_log};
use crate::output::log::reading::records::ReadError;
use roxmltree::Document;
use std::collections::HashMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

/// A mesh of a link.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoggedMesh {
    /// The place of the file when the log was written, or of a copy for viewers.
    pub file: Option<PathBuf>,
    /// Its triangles, if the log carries them; the scale of the URDF is in them.
    pub parts: Vec<LoggedPart>,
}

/// Triangles of one colour.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoggedPart {
    /// Red, green, blue, opacity in 0..1.
    pub color: [f32; 4],
    /// Corners (m), three a triangle, in the frame of the visual.
    pub corners: Vec<[f32; 3]>,
}

/// The meshes of all links, by name of the link, in the order of its visuals.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LoggedMeshes {
    of_links: HashMap<String, Vec<LoggedMesh>>,
}

impl LoggedMeshes {
    /// Reads the beginning of a log.
    ///
    /// # Errors
    /// [`ReadError`] if it is not a log.
    pub fn read(log: &Path) -> Result<Self, ReadError> {
        let mut meshes = LoggedMeshes::default();
        read_log(log, |item| match item {
            Item::Message { channel, .. } if channel.topic == "/tf" => ControlFlow::Break(()),
            Item::Message { channel, data, .. } => {
                meshes.message(channel, data);
                ControlFlow::Continue(())
            }
            _ => ControlFlow::Continue(()),
        })?;
        Ok(meshes)
    }

    /// The mesh of the visual of this link that is its `number`-th with a mesh, from 0.
    pub fn get(&self, link: &str, number: usize) -> Option<&LoggedMesh> {
        self.of_links.get(link)?.get(number)
    }

    /// A damaged message leaves its meshes out, because a page without them is better than no page.
    fn message(&mut self, channel: &LogChannel, data: &[u8]) {
        if channel.topic.ends_with("/robot_description") {
            self.add_description(&decode::string(data).unwrap_or_default());
        } else if channel.topic == TOPIC && channel.schema == definitions::MARKER_ARRAY.name {
            self.add_markers(data);
        }
    }

    /// Adds the files that a URDF names.
    fn add_description(&mut self, description: &str) {
        let Ok(document) = Document::parse(description) else { return };
        let mut counts: HashMap<&str, usize> = HashMap::new();
        for node in document.descendants().filter(|node| node.has_tag_name("mesh")) {
            let mut above = node.ancestors();
            let is_seen = above.any(|above| above.has_tag_name("visual"));
            let link = above.find(|above| above.has_tag_name("link")).and_then(|link| link.attribute("name"));
            if let (true, Some(link)) = (is_seen, link) {
                let number = counts.entry(link).or_default();
                let file = node.attribute("filename").and_then(file_of);
                let mesh = self.entry(link, *number);
                mesh.file = mesh.file.take().or(file);
                *number += 1;
            }
        }
    }

    /// Adds the triangles of markers, or the files that they name, which are the files of the URDF and no copies.
    fn add_markers(&mut self, data: &[u8]) {
        // For each link the visual of the last marker, and how many meshes came before it.
        let mut last: HashMap<String, (u32, usize)> = HashMap::new();
        for marker in mesh_markers(data).unwrap_or_default() {
            let (visual, number) = last.entry(marker.link.clone()).or_insert((marker.visual, 0));
            if *visual != marker.visual {
                (*visual, *number) = (marker.visual, *number + 1);
            }
            let mesh = self.entry(&marker.link, *number);
            match file_of(&marker.address) {
                Some(file) => mesh.file = Some(file),
                None if marker.corners.is_empty() => {}
                None => mesh.parts.push(LoggedPart { color: marker.color, corners: marker.corners }),
            }
        }
    }

    fn entry(&mut self, link: &str, number: usize) -> &mut LoggedMesh {
        let meshes = self.of_links.entry(link.to_string()).or_default();
        if meshes.len() <= number {
            meshes.resize_with(number + 1, LoggedMesh::default);
        }
        &mut meshes[number]
    }
}

/// The file that an address names.
fn file_of(address: &str) -> Option<PathBuf> {
    address.strip_prefix("file://").map(PathBuf::from)
}
