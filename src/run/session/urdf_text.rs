//! Models of robots that a program has as text, without a file: of xacro, of a parameter of ROS, of a program that makes robots.

use crate::scene::{Scene, robot_from_text};
use crate::session::error::Error;
use crate::session::model::{Loader, Model};
use std::path::Path;

impl Loader {
    /// Reads the text of a URDF as if it were in the file of this name, which need not exist: messages name it, and names of meshes are relative to its
    /// folder.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use catena::prelude::*;
    ///
    /// let text = std::fs::read_to_string("robots/arm7.urdf")?;
    /// let model = Model::loader().load_urdf_text(&text, "arm7.urdf")?;
    /// assert_eq!(model.joint_names().len(), 7);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A robot that cannot be simulated; the error names line, and link or joint.
    pub fn load_urdf_text(self, text: &str, name: impl AsRef<Path>) -> Result<Model, Error> {
        let path = name.as_ref();
        let read = robot_from_text(text, path, &self.world().packages()?)?;
        let scene = Scene::of_robot(read.clone());
        let placed = self.world().place_robot(read)?;
        Ok(Model::of_loaded(placed, path.to_path_buf(), self.world().clone()).of_scene(scene))
    }
}
