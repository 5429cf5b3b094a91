//! The descriptions that viewers draw the robots from: the URDF of each robot, the looks of all of them, and the shapes that may touch.
//!
//! A viewer that draws from the URDF reads the mesh files that it names, and not all of them read Collada and OBJ files rightly: rerun
//! leaves out polygons, turns files that say that y points up, and knows one colour a mesh. Such files are written once more as
//! GLB, into the folder `NAME.meshes` beside the log `NAME.mcap`, and the description names these. Their names have the hash of their
//! content, so that no file that another log needs is overwritten. Collision shapes are left out of the description: rerun draws them, too,
//! over the looks. The URDF as it was read is attached to the log.

use crate::meshes::glb;
use crate::model::Model;
use crate::output::log::encoding::cdr::CdrWriter;
use crate::output::log::encoding::definitions::{MARKER_ARRAY, STRING};
use crate::output::log::encoding::durability::Durability;
use crate::output::log::encoding::markers::{TOPIC, encode_markers};
use crate::output::log::messages::collision_shapes;
use crate::output::log::messages::collision_shapes::CollisionShapes;
use crate::output::log::messages::options::{LogOptions, Meshes};
use crate::output::log::messages::standin::{standins, with_standins};
use crate::output::log::messages::visual::Looks;
use crate::output::log::storage::error::LogError;
use crate::output::log::storage::file::MessageSink;
use crate::output::log::storage::inputs::sha256;
use std::io;
use std::path::{Path, PathBuf};

/// Gives viewers each robot's URDF and the looks of all of them; says which parts could not be put into the log. If there are several robots, all
/// names have the robot's before them, as in the transforms. Files go beside the log, if it is one.
pub(crate) fn describe(
    sink: &mut dyn MessageSink,
    model: &Model,
    options: &LogOptions,
    beside: Option<&Path>,
) -> Result<Vec<String>, LogError> {
    let mut buffer = Vec::new();
    let mut looks = Looks::new(options.meshes);
    let mut descriptions = Vec::new();
    for placed in &model.robots {
        let (prefix, robot) = (placed.prefix.clone(), &placed.robot);
        let standins = standins(model, placed);
        let description =
            if prefix.is_empty() { robot.description.clone() } else { robot.prefixed_description(&prefix) };
        let description = without_collisions(&description);
        descriptions.push((
            if placed.is_body {
                format!("/{}/robot_description", placed.name)
            } else {
                format!("/{prefix}robot_description")
            },
            with_standins(&description, &prefix, &standins, &|link| robot.links[link].name.clone()),
        ));
        if options.meshes != Meshes::None {
            looks.add(&robot.links, &prefix, &standins);
        }
    }
    let mut warnings = looks.warnings();
    let wants_description = options.topics.has("/robot_description");
    if let Some(log) = beside.filter(|_| wants_description) {
        match write_meshes(&looks, &log.with_extension("meshes")) {
            Ok(written) => {
                for (old, new) in written {
                    descriptions.iter_mut().for_each(|(_, text)| *text = text.replace(&old, &new));
                }
            }
            Err(reason) => warnings.push(format!(
                "the meshes could not be written beside the log, so that rerun may draw some of them wrongly: {reason}"
            )),
        }
    }
    for (topic, description) in descriptions.iter().filter(|_| wants_description) {
        let channel = sink.channel(topic, &STRING, Durability::Latched)?;
        CdrWriter::begin(&mut buffer).string(description);
        sink.message(channel, options.start, &buffer)?;
    }
    let shapes = CollisionShapes::new(model, options);
    warnings.extend(shapes.warnings);
    let looks = Some((TOPIC, &looks.markers)).filter(|_| options.topics.has(TOPIC));
    for (topic, markers) in looks.into_iter().chain([(collision_shapes::TOPIC, &shapes.markers)]) {
        if !markers.is_empty() {
            let channel = sink.channel(topic, &MARKER_ARRAY, Durability::Latched)?;
            encode_markers(markers, options.start, &mut buffer);
            sink.message(channel, options.start, &buffer)?;
        }
    }
    Ok(warnings)
}

/// A description without its collision shapes. It was written by this program: there are no comments, and no brackets in attributes.
fn without_collisions(description: &str) -> String {
    const START: &str = "<collision";
    const END: &str = "</collision>";
    let (mut text, mut rest) = (String::with_capacity(description.len()), description);
    while let Some(start) = rest.find(START) {
        let (before, element) = rest.split_at(start);
        let head = element.find('>').unwrap_or(element.len());
        let is_empty = element[..head].ends_with('/');
        let end = if is_empty { Some(head + 1) } else { element.find(END).map(|end| end + END.len()) };
        // An element without an end is left as it is.
        let Some(end) = end.filter(|end| *end <= element.len()) else { break };
        text.push_str(before);
        rest = &element[end..];
    }
    text + rest
}

/// Writes what not every viewer reads rightly as GLB into a folder; returns the addresses in the description, in quotes, with those that
/// stand for them.
fn write_meshes(looks: &Looks, folder: &Path) -> io::Result<Vec<(String, String)>> {
    let is_plain = |file: &Path| file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("stl"));
    let mut written = Vec::new();
    for (file, surface) in looks.surfaces().filter(|(file, _)| !is_plain(file)) {
        std::fs::create_dir_all(folder)?;
        let bytes = glb(surface, None);
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        let copy = std::path::absolute(folder)?.join(format!("{stem}-{}.glb", &sha256(&bytes)[..12]));
        if std::fs::metadata(&copy).map_or(true, |there| there.len() != bytes.len() as u64) {
            std::fs::write(&copy, &bytes)?;
        }
        written.push((address(file)?, address(&copy)?));
    }
    Ok(written)
}

/// The address of a file, as it is in an attribute of a description.
fn address(file: &Path) -> io::Result<String> {
    let absolute: PathBuf = std::path::absolute(file)?;
    let escaped = absolute.display().to_string().replace('&', "&amp;").replace('<', "&lt;").replace('"', "&quot;");
    Ok(format!("\"file://{escaped}\""))
}

#[cfg(test)]
mod tests {
    use super::without_collisions;

    #[test]
    fn collision_shapes_are_left_out_whether_they_have_content_or_not() {
        let description = "<link name=\"a\"><visual/><collision/><collision name=\"&lt;collision\"><geometry><box size=\"1 1 1\"/>\
                           </geometry></collision><inertial/></link>";
        assert_eq!(without_collisions(description), "<link name=\"a\"><visual/><inertial/></link>");
        for broken in ["<link><collision", "<link><collision><geometry/>"] {
            assert_eq!(without_collisions(broken), broken);
        }
    }
}
