//! The format of an input, by its ending or else by how it begins.

use crate::scene::bounded::STANDARD_INPUT;
use crate::scene::description::Scene;
use crate::scene::error::{Problem, SceneError};
#[cfg(feature = "scene")]
use crate::scene::mjcf_reading::mjcf::read_mjcf;
use crate::scene::text::read_text;
use crate::scene::urdf_reading::package_path::PackagePath;
use crate::scene::urdf_reading::urdf::robot_or_xacro;
use std::ffi::OsStr;
use std::path::Path;

#[cfg(not(feature = "scene"))]
use crate::scene::scene_reading::no_scene_file::read_scene;
#[cfg(feature = "scene")]
use crate::scene::scene_reading::scene_file::scene_from_text;
#[cfg(feature = "scene")]
use crate::scene::scene_reading::scene_files::FilesOnDisk;

/// What an input is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A scene file: TOML.
    Scene,
    /// A robot.
    Urdf,
    /// A model of MuJoCo.
    Mjcf,
}

impl Format {
    /// The format of a file: `.toml` is a scene, and so is standard input that does not begin as XML does. The outermost element tells models of
    /// MuJoCo from URDFs.
    pub fn of(path: &Path, text: &str) -> Self {
        let ending = |wanted: &str| has_ending(path, wanted);
        let may_be_either = path.file_name() == Some(OsStr::new(STANDARD_INPUT)) || ending("xml") || ending("mjcf");
        match () {
            () if ending("toml") => Format::Scene,
            // A log has the scene that was made of a model under the name of the model.
            () if may_be_either && !begins_as_xml(text) && !text.trim().is_empty() => Format::Scene,
            () if outermost(text) == Some("mujoco") => Format::Mjcf,
            () => Format::Urdf,
        }
    }
}

fn has_ending(path: &Path, wanted: &str) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case(wanted))
}

/// Whether a text begins with an element, a comment or a declaration.
fn begins_as_xml(text: &str) -> bool {
    text.trim_start_matches(['\u{feff}', ' ', '\t', '\r', '\n']).starts_with('<')
}

/// The name of the outermost element of XML; `None` where the text does not begin with elements, comments and declarations.
fn outermost(text: &str) -> Option<&str> {
    let mut rest = text;
    loop {
        rest = rest[rest.find('<')?..].trim_start_matches('<');
        let end = match rest {
            comment if comment.starts_with("!--") => "-->",
            other if other.starts_with(['?', '!']) => ">",
            name => return name.split(|c: char| c.is_whitespace() || matches!(c, '>' | '/')).next(),
        };
        rest = &rest[rest.find(end)?..];
    }
}

/// Reads an input of any format as a scene; with `keyframe` a model of MuJoCo starts there; of a URDF as the only robot of one.
///
/// # Errors
/// [`SceneError`] with file, line, and link, joint or key.
pub fn read_input(path: &Path, keyframe: Option<&str>, packages: &PackagePath) -> Result<Scene, SceneError> {
    let text = read_text(path)?;
    let format = Format::of(path, &text);
    if keyframe.is_some() && format != Format::Mjcf {
        let problem = Box::new(Problem::Keys("only a model of MuJoCo has keyframes; leave out --keyframe"));
        return Err(SceneError { file: path.to_path_buf(), line: None, element: None, problem });
    }
    let is_named_so = ["urdf", "xml", "xacro", "sdf"].iter().any(|ending| has_ending(path, ending));
    if format == Format::Urdf && !is_named_so && !begins_as_xml(&text) && !text.trim().is_empty() {
        let problem = Box::new(Problem::OtherFile);
        return Err(SceneError { file: path.to_path_buf(), line: None, element: None, problem });
    }
    match format {
        #[cfg(feature = "scene")]
        Format::Mjcf => read_mjcf(path, &text, keyframe, packages),
        #[cfg(feature = "scene")]
        Format::Scene => scene_from_text(&text, path, &mut FilesOnDisk(packages)),
        #[cfg(not(feature = "scene"))]
        Format::Mjcf | Format::Scene => read_scene(path, packages),
        Format::Urdf => Ok(Scene::of_robot(robot_or_xacro(&text, path, packages)?)),
    }
}
