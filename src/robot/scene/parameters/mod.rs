//! Every number of a scene by its key path, to be read or set without a file: what sweeps vary, and programs.
//!
//! | key path                                                              | number                                                      |
//! |-----------------------------------------------------------------------|-------------------------------------------------------------|
//! | `scene.gravity.x` (`y`, `z`)                                          | acceleration of gravity [m/s²]                              |
//! | `robot.NAME.pose.position.x`, `robot.NAME.pose.rpy.roll` (`pitch`, `yaw`) | frame of the root link in the world [m, rad]            |
//! | `robot.NAME.velocity.linear.x`, `robot.NAME.velocity.angular.x`       | of a floating base [m/s, rad/s]                             |
//! | `robot.NAME.positions.JOINT`, `robot.NAME.velocities.JOINT`           | start of a joint of one freedom [rad, m, or a second of it] |
//! | `robot.NAME.positions.JOINT.x`                                        | one number of a joint of several                            |
//! | `body.NAME.density` or `.mass`, `.shape.radius`, `.shape.length`, `.shape.size.x`, `.shape.radii.x` | as `[[body]]`, in units of the file |
//! | `body.NAME.pose.position.x`, `.pose.rpy.roll`, `.velocity.linear.x`, `.velocity.angular.x` | start of a body [m, rad, m/s, rad/s] |
//! | `link.NAME.mass`                                                      | kg                                                          |
//! | `link.NAME.friction`, `link.NAME.restitution`, `body.NAME.friction`   | of all collision shapes of a link, with what says nothing else |
//! | `link.NAME.rolling_friction`, `.spinning_friction`, `body.…`, `obstacle.…`, `contact.…`, `contact.pair.1.…` | lengths (m)        |
//! | `link.NAME.surface_velocity.x`, `body.…`, `obstacle.…`                | of the surface over its link or obstacle, as of a belt [m/s] |
//! | `link.NAME.center_of_mass.x`                                          | in the link frame (m)                                       |
//! | `link.NAME.inertia.ixx` (`ixy`, `ixz`, `iyy`, `iyz`, `izz`)           | about the centre of mass, in the inertial frame [kg m²]     |
//! | `link.NAME.inertia.roll` (`pitch`, `yaw`)                             | turn of the inertial frame in the link frame (rad)          |
//! | `link.NAME.collision.1.radius`, `.length`, `.size.x`, `.radii.x`, `.scale.x` | size of a collision shape (m), scale of its mesh; from 1 |
//! | `link.NAME.collision.1.friction`, `.restitution`, `.rolling_friction`, `.surface_velocity.x` | of one collision shape, where a `[[link]]` says it |
//! | `link.NAME.collision.1.origin.x`, `.origin.roll`                      | its frame in the link frame [m, rad]                        |
//! | `joint.NAME.origin.x`, `joint.NAME.origin.roll`                       | of the joint frame in its parent link [m, rad]              |
//! | `joint.NAME.axis.x`                                                   | axis in the joint frame; its length does not count          |
//! | `joint.NAME.limit.effort`, `.limit.velocity`                          | bound of a motor's effort, speed that is watched            |
//! | `joint.NAME.mimic.multiplier`, `.mimic.offset`                        | of a joint that follows another                             |
//! | `joint.NAME.limit.lower` (`upper`), `.restitution`, `.friction`, `.damping` | as `[[joint]]` of a scene file                        |
//! | `motor.JOINT.kp`, `.kd`, `.target`, `.max_effort`, `.period`          | as `[[motor]]`; a target that is one number                 |
//! | `motor.JOINT.target.NAME`, `load.NAME.factor.NAME`                    | a parameter of a formula                                    |
//! | `motion.JOINT.position.1.time`, `.1.value`, `motion.JOINT.position.NAME` | an entry of a table, a parameter of a formula             |
//! | `motor.JOINT.gravity_compensation`                                    | part of the weight that is held besides the law             |
//! | `motor.JOINT.target.1.time`, `motor.JOINT.target.1.value`             | an entry of the table of a target, from 1 [s; rad, m, …]    |
//! | `spring.NAME.stiffness`, `.damping`, `.rest_length`, `.rest`, `.a.position.x` | as `[[spring]]`                                     |
//! | `rope.NAME.length`, `.restitution`, `.stop`, `.points.1.position.x`            | as `[[rope]]`; points from 1                                |
//! | `loop.NAME.length`, `.a.position.x`, `.a.axis.x`                      | as `[[loop]]`                                               |
//! | `loop.NAME.axis.x`, `.a.position.x`, `.a.rpy.roll`                    | of a `<loop_joint>`: its axis, and frames in its links      |
//! | `load.NAME.factor`, `.factor.1.time`, `.factor.1.value`, `.wave.amplitude`, `.from`, `.until` | as `[[load]]`                   |
//! | `coupling.NAME.joints.JOINT`, `coupling.NAME.offset`                  | as `[[coupling]]`                                           |
//! | `drag.LINK.linear`, `.quadratic`, `.angular`, `.angular_quadratic`, `.position.x` | as `[[drag]]`                                |
//! | `load.JOINT.effort`, `load.LINK.force.x`, `.torque.x`, `.position.x`  | as `[[load]]`; several on one are numbered: `load.2.effort` |
//! | `obstacle.NAME.friction`, `.restitution`, `.pose.position.x`, `.pose.rpy.roll` | as `[[obstacle]]` |
//! | `obstacle.NAME.shape.radius`, `.length`, `.size.x`, `.radii.x`, `.normal.x`, `.scale.x` | as the `shape` of `[[obstacle]]` |
//! | `contact.friction`, `contact.restitution`, `contact.pair.1.friction`  | as `[contact]` and its pairs, from 1                        |
//! | `contact.self_contact`                                                | 1: links of one robot touch each other, 0: they do not       |
//! | `simulation.duration`, `.tolerance`, `.stages`, `.step`, `.rate`      | as `[simulation]`                                           |
//!
//! The first word of a key path, or the first two for robots, may be left out if the rest names one number: `link7.mass`, `positions.joint1`,
//! `gravity.z`. If a scene has several robots, links and joints are called `robot/name`. Shapes and colours for viewers have no key path.

mod keys;
pub(crate) mod load_keys;
mod place;
mod reach;
mod settle;
mod slot;
mod stand;
mod surface_keys;
mod units;

use crate::scene::description::Scene;
use crate::scene::error::{Problem, SceneError};
use crate::scene::scene_reading::scene_numbers::{Bound, Finite, Fraction, Friction, NotNegative, Positive, STAGES};
use place::Place;

/// A number of a scene: its place, its range, and its value in the files.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    key: String,
    short: String,
    place: Place,
    range: Range,
    said: Option<f64>,
}

/// The numbers of the inertia of a link.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InertialNumber {
    Mass,
    /// Along an axis of the link frame.
    CenterOfMass(usize),
    /// Row and column in the axes of the inertial frame.
    Inertia(usize, usize),
}

/// The range of a number, as its table in the scene file has it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Range {
    Finite,
    NotNegative,
    Positive,
    /// Not negative, perhaps infinite.
    Bound,
    /// Between 0 and 1.
    Fraction,
    /// A friction coefficient.
    Friction,
    /// A limit of a joint, perhaps infinite; both are checked together when all numbers are set.
    Limit,
    /// A number of stages.
    Stages,
    /// 1 for yes, 0 for no.
    Flag,
}

impl Range {
    /// The reason why the number is not in the range, by the rules of the file.
    fn refuse(self, number: f64) -> Option<String> {
        match self {
            Range::Finite => Finite::try_from(number).err(),
            Range::NotNegative => NotNegative::try_from(number).err(),
            Range::Positive => Positive::try_from(number).err(),
            Range::Bound => Bound::try_from(number).err(),
            Range::Friction => Friction::try_from(number).err(),
            Range::Fraction => Fraction::try_from(number).err(),
            Range::Limit => number.is_nan().then(|| "a limit must not be NaN".to_string()),
            Range::Flag => (number != 0.0 && number != 1.0).then(|| format!("{number} must be 1 (yes) or 0 (no)")),
            Range::Stages => (number.fract() != 0.0 || !STAGES.contains(&(number as usize)))
                .then(|| format!("{number} must be a whole number from {} to {}", STAGES.start(), STAGES.end())),
        }
    }
}

impl Parameter {
    /// The whole key path.
    pub fn key(&self) -> &str {
        &self.key
    }

    /// The number in the scene that was asked, in SI units; `None` where neither the scene file nor the URDF says one.
    pub fn said(&self) -> Option<f64> {
        self.said
    }

    /// Whether it may be this number, whatever the others are.
    ///
    /// # Errors
    /// Why it may not.
    pub fn check(&self, number: f64) -> Result<(), String> {
        self.range.refuse(number).map_or(Ok(()), Err)
    }

    /// Whether it only says how a run starts: the model is the same whatever it is.
    pub fn is_start(&self) -> bool {
        matches!(self.place, Place::Position { .. } | Place::Velocity { .. })
    }

    /// The robot and its link, both from 0, whose inertia has this number, and which number it is. Angles of inertial frames are not among them.
    pub fn as_inertial(&self) -> Option<([usize; 2], InertialNumber)> {
        match self.place {
            Place::Mass { robot, link } => Some(([robot, link], InertialNumber::Mass)),
            Place::CenterOfMass { robot, link, axis } => Some(([robot, link], InertialNumber::CenterOfMass(axis))),
            Place::Inertia { robot, link, row, column } => Some(([robot, link], InertialNumber::Inertia(row, column))),
            _ => None,
        }
    }

    /// Whether a key path means this number.
    fn is_called(&self, key: &str) -> bool {
        self.key == key || self.short == key
    }

    /// How much a key path looks like this one, from 0 to 1.
    fn likeness(&self, key: &str) -> f64 {
        let like = |own: &str| strsim::normalized_damerau_levenshtein(own, key);
        like(&self.key).max(like(&self.short))
    }
}

/// Key paths as unlike as this are not proposed for one that does not exist.
const UNLIKE: f64 = 0.5;

/// Most key paths that are proposed for one that does not exist.
const PROPOSED: usize = 3;

impl Scene {
    /// All numbers that have a key path, in the order of the table above.
    pub fn parameters(&self) -> Vec<Parameter> {
        let mut scratch = self.clone();
        let mut all = keys::all(self);
        for parameter in &mut all {
            parameter.said = parameter.place.slot(&mut scratch).and_then(|slot| slot.read());
        }
        all
    }

    /// The number of a key path. To look up many, ask for [`Scene::parameters`] once and use [`Scene::parameter_among`].
    ///
    /// # Errors
    /// [`Problem::UnknownParameter`] with the nearest key paths, [`Problem::AmbiguousParameter`] for a short one that means several numbers.
    pub fn parameter(&self, key: &str) -> Result<Parameter, SceneError> {
        self.parameter_among(&self.parameters(), key).cloned()
    }

    /// The same among all of them.
    ///
    /// # Errors
    /// As [`Scene::parameter`].
    pub fn parameter_among<'p>(&self, all: &'p [Parameter], key: &str) -> Result<&'p Parameter, SceneError> {
        let exact: Vec<&Parameter> = all.iter().filter(|parameter| parameter.key == key).collect();
        let called = || all.iter().filter(|parameter| parameter.is_called(key)).collect();
        let problem = match if exact.is_empty() { called() } else { exact }[..] {
            [one] => return Ok(one),
            [] => Problem::UnknownParameter { key: key.to_string(), near: near(all, key) },
            ref several => {
                let keys = several.iter().map(|parameter| parameter.key.clone()).collect();
                Problem::AmbiguousParameter { key: key.to_string(), keys }
            }
        };
        Err(SceneError { file: self.path.clone(), line: None, element: None, problem: Box::new(problem) })
    }

    /// Sets numbers, each checked as if its file said it; those that belong together (both limits of a joint, the numbers of an axis) are looked at
    /// when all are set. The texts of the files stay as they are. After an error the scene is of no use.
    ///
    /// # Errors
    /// [`Problem::ParameterValue`] with the key path, and the file and line of the table that the number belongs to where there is one.
    pub fn set(&mut self, numbers: &[(Parameter, f64)]) -> Result<(), SceneError> {
        for (parameter, number) in numbers {
            self.set_one(parameter, *number)?;
        }
        for (parameter, number) in numbers {
            parameter.place.settle(self).map_err(|reason| self.refusal(parameter, *number, reason))?;
        }
        Ok(())
    }

    fn set_one(&mut self, parameter: &Parameter, number: f64) -> Result<(), SceneError> {
        if let Some(reason) = parameter.range.refuse(number) {
            return Err(self.refusal(parameter, number, reason));
        }
        match parameter.place.slot(self) {
            Some(mut slot) => slot.write(number),
            None => return Err(self.refusal(parameter, number, "this scene has no such number".to_string())),
        }
        Ok(())
    }

    fn refusal(&self, parameter: &Parameter, number: f64, reason: String) -> SceneError {
        let (file, line, element) = parameter.place.stand(self);
        let problem = Problem::ParameterValue { key: parameter.key.clone(), number, reason };
        SceneError { file, line, element, problem: Box::new(problem) }
    }
}

/// The key paths that look most like one that does not exist.
fn near(all: &[Parameter], key: &str) -> Vec<String> {
    let mut like: Vec<(f64, &Parameter)> = all.iter().map(|parameter| (parameter.likeness(key), parameter)).collect();
    like.retain(|(likeness, _)| *likeness > UNLIKE);
    // Equal ones in the order of the scene.
    like.sort_by(|(one, _), (other, _)| other.total_cmp(one));
    like.truncate(PROPOSED);
    like.into_iter().map(|(_, parameter)| parameter.key.clone()).collect()
}
