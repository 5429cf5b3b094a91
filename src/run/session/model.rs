//! A model in the library: read from a file once, run many times.

use crate::derivatives::forward::failure::SensitivityError;
use crate::mechanism::description::joint::Pose;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::model::{Base, Left, LinkState};
use crate::output::report::{pair_count, pair_name};
use crate::scene::{Parameter, Problem, Scene, Touching, Warning};
use crate::session::between_ticks::hold;
use crate::session::coordinates::Coordinates;
use crate::session::error::Error;
use crate::session::held_start::Hold;
use crate::session::loaded::Loaded;
use crate::session::world::World;
use nalgebra::{Rotation3, Translation3};
use std::borrow::Borrow;
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

/// A robot or scene, ready to be simulated. It is cheap to clone and never changes.
///
/// ```
/// # std::env::set_current_dir("../..").unwrap();
/// use catena::prelude::*;
///
/// let model = Model::load("robots/arm7.urdf")?;
/// assert_eq!(model.joint_names().len(), 7);
/// let holding = model.gravity_efforts(&model.start()?.0)?;
/// assert_eq!(holding.len(), 7);
/// # Ok::<(), catena::session::Error>(())
/// ```
#[derive(Clone, Debug)]
pub struct Model {
    shared: Arc<Shared>,
}

#[derive(Clone, Debug)]
pub(crate) struct Shared {
    loaded: Loaded,
    coordinates: Coordinates,
    path: PathBuf,
    world: World,
    /// The scene of the file with its own numbers; read when other numbers are first requested.
    scene: OnceLock<Arc<Scene>>,
}

/// Options for reading a file: the pose of its robot, gravity, contact, parts to leave out. The default is the file as it is.
#[derive(Clone, Debug, Default)]
pub struct Loader {
    world: World,
}

impl Loader {
    /// The root link of the only robot floats.
    #[must_use]
    pub fn floating(mut self) -> Self {
        self.world.base = Some(Base::Floating);
        self
    }

    /// Sets the pose of that root link in the world: x, y, z, roll, pitch, yaw [m, rad].
    #[must_use]
    pub fn base_pose(mut self, pose: [f64; 6]) -> Self {
        self.world.base_pose = Some(pose);
        self
    }

    /// Sets the acceleration of gravity in the world [m/s²].
    #[must_use]
    pub fn gravity(mut self, gravity: [f64; 3]) -> Self {
        self.world.gravity = Some(gravity);
        self
    }

    /// Leaves out a part of the file.
    #[must_use]
    pub fn without(mut self, left: Left) -> Self {
        self.world.without.push(left);
        self
    }

    /// Adds a floor at this height (m).
    #[must_use]
    pub fn floor(mut self, height: f64) -> Self {
        self.world.floor = Some(height);
        self
    }

    /// Sets which collision shapes may touch.
    #[must_use]
    pub fn contact(mut self, touching: Touching) -> Self {
        self.world.contact = Some(touching);
        self
    }

    /// Sets the folder of a ROS package.
    #[must_use]
    pub fn package(mut self, name: &str, folder: impl Into<PathBuf>) -> Self {
        self.world.packages.push((name.to_string(), folder.into()));
        self
    }

    /// Holds all joints without motors of their own where a run starts.
    #[must_use]
    pub fn hold(mut self, hold: Hold) -> Self {
        self.world.hold = Some(hold);
        self
    }

    /// Starts a model of MuJoCo with one of its keyframes.
    #[must_use]
    pub fn keyframe(mut self, name: &str) -> Self {
        self.world.keyframe = Some(name.to_string());
        self
    }

    /// Sets a number by its key path ([`Model::with_params`]).
    #[must_use]
    pub fn set(mut self, key: &str, number: f64) -> Self {
        self.world.set.push((key.to_string(), number.into()));
        self
    }

    /// Reads a `.urdf`, or a scene `.toml`.
    ///
    /// # Errors
    /// An invalid file; the error names file, line, and link, joint or key.
    pub fn load(self, path: impl AsRef<Path>) -> Result<Model, Error> {
        let path = path.as_ref();
        let loaded = self.world.load(path)?;
        Ok(Model::of_loaded(loaded, path.to_path_buf(), self.world))
    }

    /// The options.
    pub(crate) fn world(&self) -> &World {
        &self.world
    }
}

impl Borrow<Mechanism> for Shared {
    fn borrow(&self) -> &Mechanism {
        &self.loaded.model.mechanism
    }
}

impl Model {
    /// Reads a `.urdf`, or a scene `.toml`, without changes: with a fixed base, gravity and contact as in the file.
    ///
    /// # Errors
    /// An invalid file; the error names file, line, and link, joint or key.
    pub fn load(path: impl AsRef<Path>) -> Result<Self, Error> {
        Loader::default().load(path)
    }

    /// Options for reading a file.
    pub fn loader() -> Loader {
        Loader::default()
    }

    pub fn of_loaded(loaded: Loaded, path: PathBuf, world: World) -> Self {
        let coordinates = Coordinates::of(&loaded.model);
        Model { shared: Arc::new(Shared { loaded, coordinates, path, world, scene: OnceLock::new() }) }
    }

    /// The same model without the rules that have simplified it already, as far as they are among these.
    pub(crate) fn keeping(&self, rules: &[Rule]) -> Self {
        let mut shared = Shared::clone(&self.shared);
        shared.loaded.model.keep(rules);
        Model { shared: Arc::new(shared) }
    }

    /// The same model, whose numbers are found in this scene and in no file.
    #[doc(hidden)]
    #[must_use]
    pub fn of_scene(mut self, scene: Scene) -> Self {
        if let Some(shared) = Arc::get_mut(&mut self.shared) {
            shared.scene = Arc::new(scene).into();
        }
        self
    }

    /// The same model with other numbers, by their key paths: `link7.mass`, `spring.band.stiffness`, `gravity.z` (`catena model INPUT --parameters`
    /// lists them). The file is read again, once for all models made from this one.
    ///
    /// # Errors
    /// Keys that do not exist or mean several numbers, and numbers that a file could not contain.
    pub fn with_params<K: Into<String>>(&self, numbers: impl IntoIterator<Item = (K, f64)>) -> Result<Self, Error> {
        let mut world = self.world().clone();
        world.set.extend(numbers.into_iter().map(|(key, number)| (key.into(), number.into())));
        let scene = self.scene()?;
        let loaded = world.place_read(Scene::clone(&scene))?;
        let mut model = Model::of_loaded(loaded, self.path().to_path_buf(), world);
        if let Some(shared) = Arc::get_mut(&mut model.shared) {
            shared.scene = scene.into();
        }
        Ok(model)
    }

    /// Checks that there are numbers with these key paths.
    pub(crate) fn know_numbers<'k>(&self, keys: impl IntoIterator<Item = &'k str>) -> Result<(), Error> {
        let mut keys = keys.into_iter().peekable();
        if keys.peek().is_none() {
            return Ok(());
        }
        let scene = self.scene()?;
        let all = scene.parameters();
        keys.try_for_each(|key| Ok(scene.parameter_among(&all, key).map(drop)?))
    }

    /// The scene of the file with the numbers that were set.
    pub(crate) fn scene_with_numbers(&self) -> Result<Scene, Error> {
        let mut scene = Scene::clone(&*self.scene()?);
        self.world().set_numbers(&mut scene)?;
        Ok(scene)
    }

    /// The model of [`Model::scene_with_numbers`] with another number, which is known. Its own parameters have the numbers of the file.
    ///
    /// # Errors
    /// As of [`Model::with_params`].
    pub(crate) fn of_numbers(&self, scene: &Scene, number: &Parameter, value: f64) -> Result<Self, Error> {
        let mut scene = scene.clone();
        scene.set(&[(number.clone(), value)])?;
        let world = World { set: Vec::new(), ..self.world().clone() };
        let loaded = world.place_read(scene)?;
        Ok(Model::of_loaded(loaded, self.path().to_path_buf(), world))
    }

    /// The scene of the file.
    fn scene(&self) -> Result<Arc<Scene>, Error> {
        if let Some(scene) = self.shared.scene.get() {
            return Ok(scene.clone());
        }
        let scene = Arc::new(self.world().scene(self.path())?);
        // If another thread has read it meanwhile, the first result is used.
        Ok(self.shared.scene.get_or_init(|| scene).clone())
    }

    /// All numbers that have a key path, and their values: those that were set, or else those of the files (`None` where no file has one).
    ///
    /// # Errors
    /// As of [`Model::load`].
    pub fn params(&self) -> Result<Vec<(String, Option<f64>)>, Error> {
        Ok(self.scene_with_numbers()?.parameters().into_iter().map(|one| (one.key().to_string(), one.said())).collect())
    }

    /// Names of the movable joints, in the order of q and v.
    pub fn joint_names(&self) -> Vec<&str> {
        self.coordinates().joints().iter().map(|joint| joint.name.as_str()).collect()
    }

    /// Names of the joints with motors, in the order of targets.
    pub fn motor_names(&self) -> Vec<&str> {
        let mechanism = &self.description().mechanism;
        let joints = self.coordinates().joints();
        let of = |freedom: usize| joints.iter().find(|joint| joint.v.contains(&freedom));
        let motors = mechanism.nonsmooth.motors.iter();
        motors.map(|motor| of(motor.coordinate.freedom).map_or("", |joint| joint.name.as_str())).collect()
    }

    /// Names of all links, in the order of the file.
    pub fn link_names(&self) -> Vec<&str> {
        self.description().links.iter().map(|link| link.name.as_str()).collect()
    }

    /// Names `a|b` of the pairs of shapes that may touch, by [`ContactPoint::pair`](crate::mechanism::motion::contact_point::ContactPoint::pair).
    pub fn contact_pairs(&self) -> Vec<String> {
        let model = self.description();
        (0..pair_count(model)).map(|number| pair_name(model, number)).collect()
    }

    /// Warnings: parts left out and their reasons, and oddities of the file.
    pub fn warnings(&self) -> Vec<String> {
        self.description().warning_lines().collect()
    }

    /// The entries of each joint in q and v.
    pub fn coordinates(&self) -> &Coordinates {
        &self.shared.coordinates
    }

    /// q and v of the file's start, on all loops.
    ///
    /// # Errors
    /// Loops that cannot be closed.
    pub fn start(&self) -> Result<(Vec<f64>, Vec<f64>), Error> {
        let started = self.loaded().assembled(&[], &[], None)?;
        Ok(self.flat(&started.state))
    }

    /// Puts the joints that are moved in time where they are at a time (s), in q and v of another start.
    ///
    /// # Errors
    /// Wrong lengths of q and v.
    pub fn put_on_motions(&self, time: f64, q: &mut [f64], v: &mut [f64]) -> Result<(), Error> {
        let places = self.coordinates();
        places.check_lengths(q, v)?;
        places.put_on_motions(self.description(), time, q, v);
        Ok(())
    }

    /// q and v of a state.
    #[doc(hidden)]
    pub fn flat(&self, state: &State) -> (Vec<f64>, Vec<f64>) {
        let (mut q, mut v) = (vec![0.0; self.coordinates().q_count()], vec![0.0; self.coordinates().v_count()]);
        self.coordinates().write(self.description(), &state.position, &state.velocity, &mut q, &mut v);
        (q, v)
    }

    /// Pose of a link frame in the world for q.
    ///
    /// # Errors
    /// An unknown link, a wrong length of q, and numbers that are not finite.
    pub fn pose(&self, link: &str, q: &[f64]) -> Result<Pose, Error> {
        self.link_index(link)?;
        let rest = vec![0.0; self.coordinates().v_count()];
        Ok(pose_of(&self.link_at(link, &self.coordinates().state(self.description(), q, &rest)?)?))
    }

    /// Pose and motion of a link in a state.
    pub(crate) fn link_at(&self, link: &str, state: &State) -> Result<LinkState, Error> {
        let index = self.link_index(link)?;
        let bodies = body_states(&self.description().mechanism, state);
        Ok(self.description().link_state(&bodies, index))
    }

    pub(crate) fn link_index(&self, link: &str) -> Result<usize, Error> {
        self.description().link(link).ok_or_else(|| {
            let known: Vec<String> = self.description().links.iter().map(|link| link.name.clone()).collect();
            Error::UnknownLink { link: link.to_string(), known: crate::scene::listed(&known) }
        })
    }

    /// The parts of the model.
    #[doc(hidden)]
    pub fn description(&self) -> &crate::model::Model {
        &self.shared.loaded.model
    }

    #[doc(hidden)]
    pub fn loaded(&self) -> &Loaded {
        &self.shared.loaded
    }

    /// The same model with other motors.
    pub(crate) fn driven_by(&self, motors: Vec<Motor>) -> Self {
        let mut shared = Shared::clone(&self.shared);
        shared.loaded.model.mechanism.nonsmooth.motors = motors;
        Model { shared: Arc::new(shared) }
    }

    /// The same model with motors that hold these efforts from the start of a run on (s), if it is between their ticks.
    pub(crate) fn holding(&self, efforts: &[Option<f64>], since: f64) -> Self {
        if efforts.is_empty() {
            return self.clone();
        }
        let mut motors = self.description().mechanism.nonsmooth.motors.clone();
        if hold(&mut motors, efforts, since) { self.driven_by(motors) } else { self.clone() }
    }

    /// The same model with more warnings, if there are any.
    pub(crate) fn warned(&self, warnings: Vec<Warning>) -> Self {
        if warnings.is_empty() {
            return self.clone();
        }
        let mut shared = Shared::clone(&self.shared);
        shared.loaded.model.warnings.extend(warnings);
        Model { shared: Arc::new(shared) }
    }

    /// The path of the file, as given.
    pub fn path(&self) -> &Path {
        &self.shared.path
    }

    pub(crate) fn unknown_joint(&self, joint: &str) -> Error {
        let known = self.joint_names().into_iter().map(str::to_string).collect();
        crate::model::ModelError::UnknownJoint { joint: joint.to_string(), known }.into()
    }

    pub(crate) fn shared(&self) -> &Arc<Shared> {
        &self.shared
    }

    pub(crate) fn world(&self) -> &World {
        &self.shared.world
    }
}

pub(crate) fn pose_of(link: &LinkState) -> Pose {
    Pose::from_parts(Translation3::from(link.position), Rotation3::from_matrix_unchecked(link.rotation))
}

/// The number with this key path among all numbers of a scene, from which derivatives are taken, and its finite value.
///
/// # Errors
/// Numbers that are not there, that are several, or that have no value. Starts and efforts have key paths of their own.
pub(crate) fn number_of<'n>(scene: &Scene, all: &'n [Parameter], key: &str) -> Result<(&'n Parameter, f64), Error> {
    let own = || key.to_string();
    let number = scene.parameter_among(all, key).map_err(|error| match *error.problem {
        Problem::UnknownParameter { .. } => Error::from(SensitivityError::Unknown { key: own() }),
        _ => Error::from(error),
    })?;
    let said = number.said().filter(|value| value.is_finite());
    Ok((number, said.ok_or_else(|| SensitivityError::NoValue { key: own() })?))
}
