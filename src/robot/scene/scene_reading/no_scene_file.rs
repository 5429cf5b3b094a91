//! Replaces scene files in builds without the feature `scene`: reading one is an error.

use crate::scene::description::Scene;
use crate::scene::error::{Problem, SceneError};
use crate::scene::urdf_reading::package_path::PackagePath;
use std::path::Path;

/// Refuses a scene file.
///
/// # Errors
/// Always [`Problem::NotBuilt`].
pub fn read_scene(path: &Path, _: &PackagePath) -> Result<Scene, SceneError> {
    Err(SceneError { file: path.to_path_buf(), line: None, element: None, problem: Box::new(Problem::NotBuilt) })
}
