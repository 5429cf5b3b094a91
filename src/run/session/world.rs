//! A model from a file: a URDF or a scene, with the user's options.
//!
//! Options override the scene file, and the scene file overrides the defaults ([`World::load`]).

use crate::mechanism::description::joint::Pose;
use crate::model::{Base, Left, Model, ModelOptions, Start};
use crate::scene::{
    ContactSettings, Obstacle, PackagePath, Quantity, Robot, Scene, SimulationSettings, Touching, Warning, read_input,
};
use crate::session::error::Error;
use crate::session::held_start::Hold;
use crate::session::loaded::Loaded;
use nalgebra::{Rotation3, Translation3, Vector3};
use std::path::{Path, PathBuf};

/// The user's options for a robot or scene. An option that is not given is as in the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct World {
    /// Whether the root link of the only robot is fixed in the world or floats.
    pub base: Option<Base>,
    /// Pose of that root link in the world: x, y, z, roll, pitch, yaw [m, rad].
    pub base_pose: Option<[f64; 6]>,
    /// Acceleration of gravity in the world [m/s²].
    pub gravity: Option<[f64; 3]>,
    /// Parts of the files that are left out of the simulation.
    pub without: Vec<Left>,
    /// Height of a floor (m).
    pub floor: Option<f64>,
    /// Which collision shapes may touch.
    pub contact: Option<Touching>,
    /// Motors that hold all joints without motors of their own where the run starts.
    pub hold: Option<Hold>,
    /// The keyframe of a model of MuJoCo with which it starts.
    pub keyframe: Option<String>,
    /// Numbers to set, by their key paths ([`crate::scene::Scene::parameters`]).
    pub set: Vec<(String, Quantity)>,
    /// Names of ROS packages and their folders.
    pub packages: Vec<(String, PathBuf)>,
    /// Names and values of arguments of xacro sources.
    pub xacro: Vec<(String, String)>,
}

impl World {
    /// Reads and reduces a robot or scene.
    ///
    /// # Errors
    /// An invalid file; the error names file, line, and link, joint or key.
    pub fn load(&self, input: &Path) -> Result<Loaded, Error> {
        let mut scene = self.scene(input)?;
        if scene.is_robot
            && let Some(only) = scene.robots.pop()
        {
            return self.place_robot(only.robot);
        }
        self.place_scene(scene)
    }

    /// Reads a scene, or a robot as a scene with one robot, so that its numbers have key paths. The numbers are those of the file.
    ///
    /// # Errors
    /// An invalid file; the error names file, line, and link, joint or key.
    pub fn scene(&self, input: &Path) -> Result<Scene, Error> {
        Ok(read_input(input, self.keyframe.as_deref(), &self.packages()?)?)
    }

    /// The ROS packages and their folders.
    pub(crate) fn packages(&self) -> Result<PackagePath, Error> {
        match self.packages.iter().find(|(_, folder)| !folder.is_dir()) {
            Some((name, folder)) => Err(Error::Package { name: name.clone(), folder: folder.clone() }),
            None => {
                let found = PackagePath::from_environment(self.packages.clone());
                Ok(PackagePath { xacro: self.xacro.clone(), ..found })
            }
        }
    }

    /// Sets the numbers.
    pub(crate) fn set_numbers(&self, scene: &mut Scene) -> Result<(), Error> {
        if self.set.is_empty() {
            return Ok(());
        }
        let all = scene.parameters();
        let numbers = self.set.iter().map(|(key, given)| {
            let parameter = scene.parameter_among(&all, key)?.clone();
            let number = scene.number_of(&parameter, *given)?;
            Ok((parameter, number))
        });
        let numbers: Vec<_> = numbers.collect::<Result<_, Error>>()?;
        Ok(scene.set(&numbers)?)
    }

    /// Reduces a robot that was read to a model.
    ///
    /// # Errors
    /// A robot that cannot be simulated.
    pub fn place_robot(&self, robot: Robot) -> Result<Loaded, Error> {
        self.check()?;
        if !self.set.is_empty() || self.hold.is_some() {
            return self.place_only(Scene::of_robot(robot));
        }
        let defaults = ModelOptions::default();
        let options = ModelOptions {
            base: self.base.unwrap_or(defaults.base),
            base_pose: self.base_pose.map_or(defaults.base_pose, pose),
            gravity: self.gravity.map_or(defaults.gravity, Vector3::from),
        };
        let mut model = Model::new(robot, &options)?;
        model.set_contact(&self.contact_settings(ContactSettings::default())?)?;
        model.leave_out_overlaps(&model.initial_state(&[], &[], None)?);
        model.without(&self.without);
        model.warnings.extend(nothing_moves(&model, "--base floating"));
        Ok(Loaded::new(model, Start::default(), SimulationSettings::default()))
    }

    /// Reduces the result of [`World::scene`] to a model. Its numbers are set.
    ///
    /// # Errors
    /// As of [`World::load`].
    pub(crate) fn place_read(&self, scene: Scene) -> Result<Loaded, Error> {
        if scene.is_robot { self.place_only(scene) } else { self.place_scene(scene) }
    }

    /// Reduces the only robot of a scene to a model.
    fn place_only(&self, scene: Scene) -> Result<Loaded, Error> {
        let mut loaded = self.place_scene(scene)?;
        // The file is the URDF; no scene file was read.
        loaded.model.scene = None;
        Ok(loaded)
    }

    /// Reduces a scene to a model.
    ///
    /// # Errors
    /// A scene that cannot be simulated, and options for one robot where there are several.
    pub fn place_scene(&self, mut scene: Scene) -> Result<Loaded, Error> {
        self.check()?;
        if let Some(hold) = self.hold {
            hold.add_to(&mut scene);
        }
        self.set_numbers(&mut scene)?;
        if let Some(gravity) = self.gravity {
            scene.gravity = Some(Vector3::from(gravity));
        }
        let count = scene.robots.iter().filter(|robot| robot.body.is_none()).count();
        let mut robots = scene.robots.iter_mut().filter(|robot| count == 0 || robot.body.is_none());
        match (robots.next(), robots.next()) {
            (Some(only), None) => {
                if let Some(base) = self.base {
                    only.floating = base == Base::Floating;
                    // A base that is fixed loses its velocity.
                    only.velocity = only.velocity.filter(|_| only.floating);
                }
                only.pose = self.base_pose.map_or(only.pose, pose);
            }
            _ => {
                if self.base.is_some() || self.base_pose.is_some() {
                    return Err(Error::SeveralRobots { file: scene.path.clone(), count: scene.robots.len() });
                }
            }
        }
        scene.contact = self.contact_settings(scene.contact)?;
        let (mut model, start) = Model::from_scene(&scene)?;
        model.without(&self.without);
        model.warnings.extend(nothing_moves(&model, "base = \"floating\" in its [[robot]]"));
        model.warnings.extend(self.hold.and_then(|_| nothing_to_hold(&scene)));
        Ok(Loaded::new(model, start, scene.simulation))
    }

    /// Refuses invalid numbers, which the command line never passes on.
    fn check(&self) -> Result<(), Error> {
        let gravity = self.gravity.iter().flatten().map(|&value| ("gravity", value));
        let pose = self.base_pose.iter().flatten().map(|&value| ("base pose", value));
        let floor = self.floor.iter().map(|&value| ("floor", value));
        let gains = self
            .hold
            .iter()
            .flat_map(|hold| [("hold kp", hold.kp), ("hold kd", hold.kd), ("hold gravity", hold.gravity)])
            .filter_map(|(option, gain)| Some((option, gain?)));
        if let Some((option, value)) = gains.clone().find(|(_, gain)| !gain.is_finite() || *gain < 0.0) {
            return Err(Error::Option { option, value, wanted: "give a gain that is finite and not negative" });
        }
        match gravity.chain(pose).chain(floor).find(|(_, value)| !value.is_finite()) {
            Some((option, value)) => Err(Error::Option { option, value, wanted: "give a finite number" }),
            None => Ok(()),
        }
    }

    /// The user's contact settings, or else the settings of the scene, with all parts that are left out of the simulation.
    fn contact_settings(&self, mut settings: ContactSettings) -> Result<ContactSettings, Error> {
        let without = self.without.contains(&Left::Contact);
        settings.touching = self.contact.or(settings.touching);
        if let Some(height) = self.floor {
            if settings.obstacles.iter().any(|obstacle| obstacle.name == Obstacle::FLOOR) {
                return Err(Error::FloorTwice(Obstacle::FLOOR));
            }
            if settings.touching() == Touching::None && !without {
                return Err(Error::FloorUntouched);
            }
            settings.obstacles.push(Obstacle::floor(height));
        }
        if without {
            // Without contact, its files are not read.
            settings.touching = Some(Touching::None);
        }
        Ok(settings)
    }
}

/// A warning for a robot without moving bodies, all of whose mass is fixed in the world; `remedy` is the option that would let it move.
fn nothing_moves(model: &Model, remedy: &str) -> Option<Warning> {
    let robot = model.robots.iter().find(|placed| !placed.robot.root_is_world())?;
    let has_mass = model.links[robot.links.clone()].iter().any(|link| link.mass > 0.0);
    (model.mechanism.bodies.is_empty() && has_mass).then(|| {
        let message = format!("nothing moves, because the root link is fixed in the world; {remedy} lets it move");
        Warning::odd(model.path(), None, None, message)
    })
}

/// A warning for a scene that has no joints to hold.
fn nothing_to_hold(scene: &Scene) -> Option<Warning> {
    let mut joints = scene.robots.iter().flat_map(|placed| &placed.robot.joints);
    let message = "--hold holds nothing, because no joint of the scene can be driven";
    joints.all(|joint| !joint.can_be_driven()).then(|| Warning::odd(&scene.path, None, None, message))
}

fn pose([x, y, z, roll, pitch, yaw]: [f64; 6]) -> Pose {
    Pose::from_parts(Translation3::new(x, y, z), Rotation3::from_euler_angles(roll, pitch, yaw))
}
