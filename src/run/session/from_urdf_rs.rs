//! Models of robots that another program has read by `urdf-rs`, or has made.
//!
//! `urdf-rs` accepts numbers that are none, links without parents and joints of unknown links. So its robot is written as XML by `urdf-rs` and read by
//! the reader of files, with all its checks and warnings. Numbers are written with all their digits: the model is the one of the file, to the last bit.
//! Lines in messages count in the written text; messages name the link or joint, too.

use crate::scene::{Problem, Scene, SceneError, robot_from_text};
use crate::session::error::Error;
use crate::session::model::{Loader, Model};
use std::path::PathBuf;

impl Loader {
    /// Takes a robot of `urdf-rs`. Relative names of meshes are looked for in the current folder.
    ///
    /// # Errors
    /// A robot that cannot be simulated; the error names the link or joint.
    pub fn load_urdf_rs(self, robot: &urdf_rs::Robot) -> Result<Model, Error> {
        let path = PathBuf::from(format!("{}.urdf", robot.name.replace(['/', '\\'], "_")));
        let text = urdf_rs::write_to_string(robot).map_err(|error| SceneError {
            file: path.clone(),
            line: None,
            element: None,
            problem: Box::new(Problem::Xml(error.to_string())),
        })?;
        let read = robot_from_text(&text, &path, &self.world().packages()?)?;
        let scene = Scene::of_robot(read.clone());
        Ok(Model::of_loaded(self.world().place_robot(read)?, path, self.world().clone()).of_scene(scene))
    }
}

impl Model {
    /// A robot of `urdf-rs`, with a fixed base. [`Model::loader`] has options.
    ///
    /// ```
    /// # std::env::set_current_dir("../..").unwrap();
    /// use catena::prelude::*;
    ///
    /// let robot = urdf_rs::read_file("robots/arm7.urdf").expect("a robot");
    /// let model = Model::from_urdf_rs(&robot)?;
    /// assert_eq!(model.joint_names().len(), 7);
    /// # Ok::<(), catena::session::Error>(())
    /// ```
    ///
    /// # Errors
    /// A robot that cannot be simulated; the error names the link or joint.
    pub fn from_urdf_rs(robot: &urdf_rs::Robot) -> Result<Self, Error> {
        Model::loader().load_urdf_rs(robot)
    }
}
