//! The source of the files that a scene names: the file system, or a log that carries them.

use crate::scene::error::SceneError;
use crate::scene::robot::Robot;
use crate::scene::text::{read_bytes, read_text};
use crate::scene::urdf_reading::package_path::PackagePath;
use crate::scene::urdf_reading::urdf::read_urdf;
use std::path::Path;

/// The source of the files that a scene names.
pub trait SceneFiles {
    /// A robot.
    ///
    /// # Errors
    /// [`SceneError`] if there is no such file, or it is no robot.
    fn robot(&mut self, urdf: &Path) -> Result<Robot, SceneError>;

    /// The text of a file.
    ///
    /// # Errors
    /// [`SceneError`] if there is no such file, or it is not text.
    fn text(&mut self, file: &Path) -> Result<String, SceneError>;

    /// The bytes of a mesh.
    ///
    /// # Errors
    /// [`SceneError`] if there is no such file.
    fn bytes(&mut self, file: &Path) -> Result<Vec<u8>, SceneError>;
}

/// The files that the file system has.
#[derive(Debug)]
pub struct FilesOnDisk<'p>(pub &'p PackagePath);

impl SceneFiles for FilesOnDisk<'_> {
    fn robot(&mut self, urdf: &Path) -> Result<Robot, SceneError> {
        read_urdf(urdf, self.0)
    }

    fn text(&mut self, file: &Path) -> Result<String, SceneError> {
        read_text(file)
    }

    fn bytes(&mut self, file: &Path) -> Result<Vec<u8>, SceneError> {
        read_bytes(file)
    }
}
