//! Reads a URDF into a [`Robot`].

use crate::scene::error::{Element, Problem, SceneError};
use crate::scene::robot::{Robot, UrdfLoop};
use crate::scene::text::{XmlText, read_text};
use crate::scene::urdf_reading::clean::{Cleaned, clean, error_at};
use crate::scene::urdf_reading::convert::Converter;
use crate::scene::urdf_reading::element::CleanElement;
use crate::scene::urdf_reading::mesh_files::MeshFiles;
use crate::scene::urdf_reading::package_path::PackagePath;
use crate::scene::urdf_reading::schema::ROBOT;
use crate::scene::urdf_reading::screws::expand_screws;
use crate::scene::urdf_reading::surface_friction::take_friction;
use crate::scene::urdf_reading::transmissions::take_rotors;
use crate::scene::urdf_reading::tree::find_root;
use crate::scene::urdf_reading::unsimulated::unsimulated;
use crate::scene::urdf_reading::xacro::{expanded, is_source};
use crate::scene::warning::Warning;
use std::path::Path;

/// Reads and validates a URDF file.
///
/// # Errors
/// [`SceneError`] with the line and the link or joint, when the file is not one robot with sound numbers.
pub fn read_urdf(path: &Path, packages: &PackagePath) -> Result<Robot, SceneError> {
    robot_or_xacro(&read_text(path)?, path, packages)
}

/// The same of the text of the file, which may be a source of xacro.
///
/// # Errors
/// As [`read_urdf`].
pub(crate) fn robot_or_xacro(text: &str, path: &Path, packages: &PackagePath) -> Result<Robot, SceneError> {
    if is_source(path) {
        return robot_from_text(&expanded(path, text, None, &packages.xacro)?, path, packages);
    }
    match robot_from_text(text, path, packages) {
        Err(SceneError { line, problem, .. }) if matches!(*problem, Problem::Xacro(_)) => {
            robot_from_text(&expanded(path, text, line, &packages.xacro)?, path, packages)
        }
        read => read,
    }
}

/// Reads and validates the text of a URDF; `path` names it in messages and is where relative meshes are looked for.
///
/// # Errors
/// As [`read_urdf`].
pub fn robot_from_text(source: &str, path: &Path, packages: &PackagePath) -> Result<Robot, SceneError> {
    read_robot(source, path, |robot| MeshFiles::find(path, robot, packages))
}

/// The same without looking for meshes, which only viewers need: no file is touched; `path` only names it in messages.
///
/// # Errors
/// As [`read_urdf`].
pub fn robot_without_meshes(source: &str, path: &Path) -> Result<Robot, SceneError> {
    read_robot(source, path, |_| Default::default())
}

fn read_robot(
    source: &str,
    path: &Path,
    find_meshes: impl FnOnce(&CleanElement) -> (MeshFiles, Vec<Warning>),
) -> Result<Robot, SceneError> {
    let xml = XmlText::new(path, source)?;
    let Cleaned { mut robot, warnings: repairs, ignored } = clean(&xml, &ROBOT)?;
    // Viewers do not know joints that close loops.
    let (closing, children) = std::mem::take(&mut robot.children).into_iter().partition(|e| e.name == "loop_joint");
    let closing: Vec<CleanElement> = closing;
    robot.children = children;
    expand_screws(path, &mut robot)?;
    let (meshes, missing_meshes) = find_meshes(&robot);

    let mut converter = Converter {
        file: path,
        meshes: &meshes,
        robot: &robot,
        quaternions: robot.attribute("version").is_some_and(knows_quaternions),
        warnings: Vec::new(),
        impossible_inertias: Vec::new(),
    };
    let mut links = robot.children_named("link").map(|link| converter.link(link)).collect::<Result<Vec<_>, _>>()?;
    let mut joints =
        robot.children_named("joint").map(|joint| converter.joint(joint)).collect::<Result<Vec<_>, _>>()?;
    let mut loops: Vec<UrdfLoop> = Vec::with_capacity(closing.len());
    for element in &closing {
        let closing = converter.closing_joint(element, &links)?;
        if let Some(first) = loops.iter().find(|other| other.name == closing.name) {
            let problem = Problem::DuplicateName { first_line: first.line };
            return Err(error_at(path, closing.line, Some(Element::Loop(closing.name)), problem));
        }
        loops.push(closing);
    }
    let root = find_root(path, &links, &joints, robot.line)?;
    let (mut taken, of_friction) = take_friction(&xml, xml.document()?.root_element(), &mut links);
    let (rotors, of_rotors) = take_rotors(&xml, xml.document()?.root_element(), &mut joints);
    taken.extend(rotors);

    let mut warnings = xml.warnings;
    warnings.extend(of_friction);
    warnings.extend(of_rotors);
    warnings.extend(repairs);
    warnings.extend(converter.warnings);
    warnings.extend(Warning::of_kind(converter.impossible_inertias, "link", "links"));
    warnings.extend(missing_meshes);
    warnings.extend(unsimulated(path, &joints, &ignored));
    let name = robot.attribute("name").map_or_else(|| file_stem(path), str::to_string);
    meshes.make_absolute(&mut robot);
    let description = write(&robot);
    let mut robot = Robot {
        name,
        links,
        joints,
        loops,
        root,
        path: path.to_path_buf(),
        source: source.to_string(),
        description,
        warnings,
        taken,
    };
    robot.tell_taken();
    Ok(robot)
}

impl Robot {
    /// [`Robot::description`] with `prefix` before the names of all links and joints, for viewers that show several
    /// robots: their frames in the log have the same names.
    pub fn prefixed_description(&self, prefix: &str) -> String {
        let read = XmlText::new(&self.path, &self.description).and_then(|xml| clean(&xml, &ROBOT));
        // The reader accepts every file that this program writes.
        let Ok(Cleaned { mut robot, .. }) = read else { return self.description.clone() };
        for element in &mut robot.children {
            let names: &[(&str, &str)] = match element.name {
                "link" => &[("link", "name")],
                "joint" => &[("joint", "name"), ("parent", "link"), ("child", "link"), ("mimic", "joint")],
                _ => continue,
            };
            for (of, attribute) in names {
                let own = element.name == *of;
                let holder = if own { Some(&mut *element) } else { element.child_mut(of) };
                if let Some(holder) = holder
                    && let Some(name) = holder.attribute(attribute).map(|name| format!("{prefix}{name}"))
                {
                    holder.set(attribute, name);
                }
            }
        }
        write(&robot)
    }
}

fn write(robot: &CleanElement) -> String {
    let mut text = String::from("<?xml version=\"1.0\"?>\n");
    robot.write(0, &mut text);
    text
}

/// Whether a URDF version is 1.1 or later.
fn knows_quaternions(version: &str) -> bool {
    let mut numbers = version.trim().split('.').map(|number| number.parse::<u32>().unwrap_or(0));
    (numbers.next().unwrap_or(1), numbers.next().unwrap_or(0)) >= (1, 1)
}

fn file_stem(path: &Path) -> String {
    path.file_stem().map_or_else(|| "robot".to_string(), |stem| stem.to_string_lossy().into_owned())
}
