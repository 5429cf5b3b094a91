//! The URDF for viewers: the text as it was, with the addresses of meshes made absolute.
//!
//! A log is looked at elsewhere than where the robot was read from, and viewers know no `package://` folders. Only the
//! `filename` attributes are exchanged; everything else stays as its author wrote it.

use roxmltree::Document;
use std::path::{Path, PathBuf};

/// Replaces every mesh `filename` that `resolve` finds a file for by a `file://` address.
///
/// A text that is not XML is given back as it is.
pub fn with_absolute_meshes(urdf: &str, resolve: impl Fn(&str) -> Option<PathBuf>) -> String {
    let Ok(document) = Document::parse(urdf) else { return urdf.to_string() };
    let meshes = document.descendants().filter(|node| node.has_tag_name("mesh"));
    let filenames = meshes.filter_map(|mesh| mesh.attribute_node("filename"));
    let mut text = String::with_capacity(urdf.len());
    let mut copied = 0;
    for filename in filenames {
        let Some(file) = resolve(filename.value()) else { continue };
        let Ok(file) = std::path::absolute(file) else { continue };
        let range = filename.range_value();
        text.push_str(&urdf[copied..range.start]);
        text.push_str(&file_address(&file));
        copied = range.end;
    }
    text.push_str(&urdf[copied..]);
    text
}

/// The `file://` address of a path, with the characters escaped that an address or an attribute cannot hold.
fn file_address(path: &Path) -> String {
    let mut address = String::from("file://");
    for byte in path.to_string_lossy().bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'/' | b'-' | b'_' | b'.' | b'~' | b'+' | b':' => {
                address.push(byte.into());
            }
            _ => address.push_str(&format!("%{byte:02X}")),
        }
    }
    address
}

#[cfg(test)]
mod tests {
    use super::with_absolute_meshes;
    use std::path::PathBuf;

    #[test]
    fn only_the_addresses_of_found_meshes_change() {
        let urdf = "<robot name='r'><!-- mesh filename=\"a\" -->\n\
                    <mesh scale=\"1 1 1\" filename=\"package://r/a b.stl\"/><mesh filename='lost.stl'/></robot>";
        let found = with_absolute_meshes(urdf, |name| {
            (name == "package://r/a b.stl").then(|| PathBuf::from("/robots/a b.stl"))
        });
        assert_eq!(found, urdf.replace("package://r/a b.stl", "file:///robots/a%20b.stl"));
    }
}
