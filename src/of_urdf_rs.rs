//! Models of robots that another program has read by `urdf-rs`, or has made.
//!
//! `urdf-rs` accepts numbers that are none, links without parents and joints of unknown links. So its robot is written as XML by `urdf-rs` and read by
//! the reader of files, with all its checks and warnings. Numbers are written with all their digits: the model is the one of the file, to the last bit.
//! Lines in messages count in the written text; messages name the link or joint, too.

use crate::scene::{Problem, SceneError};
use crate::session::{Error, Loader, Model};
use std::path::PathBuf;

/// Models of robots of `urdf-rs`.
pub trait FromUrdfRs: Sized {
    /// A robot of `urdf-rs`, with a fixed base. [`LoadUrdfRs`] has options.
    ///
    /// ```
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
    fn from_urdf_rs(robot: &urdf_rs::Robot) -> Result<Self, Error>;
}

/// Models of robots of `urdf-rs`, with the options of a [`Loader`].
pub trait LoadUrdfRs {
    /// Takes a robot of `urdf-rs`. Relative names of meshes are looked for in the current folder.
    ///
    /// # Errors
    /// A robot that cannot be simulated; the error names the link or joint.
    fn load_urdf_rs(self, robot: &urdf_rs::Robot) -> Result<Model, Error>;
}

impl FromUrdfRs for Model {
    fn from_urdf_rs(robot: &urdf_rs::Robot) -> Result<Self, Error> {
        Model::loader().load_urdf_rs(robot)
    }
}

impl LoadUrdfRs for Loader {
    fn load_urdf_rs(self, robot: &urdf_rs::Robot) -> Result<Model, Error> {
        let path = PathBuf::from(format!("{}.urdf", robot.name.replace(['/', '\\'], "_")));
        let text = urdf_rs::write_to_string(robot).map_err(|error| SceneError {
            file: path.clone(),
            line: None,
            element: None,
            problem: Box::new(Problem::Xml(error.to_string())),
        })?;
        self.load_urdf_text(&text, path)
    }
}
