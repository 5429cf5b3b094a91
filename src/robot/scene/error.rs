//! Errors about the input: each names the file, the line, and the link or joint.

use std::fmt;
use std::path::PathBuf;

/// The part of a robot or scene that a message is about.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Element {
    /// A link, by name.
    Link(String),
    /// A joint, by name.
    Joint(String),
    /// A robot of a scene, by name.
    Robot(String),
    /// A body of a scene, by name.
    Body(String),
    /// A joint that closes a loop, by name.
    Loop(String),
    /// A relation of joints, by name.
    Coupling(String),
    /// A spring, by name.
    Spring(String),
    /// A rope, by name.
    Rope(String),
    /// A load, by the name of the loaded part.
    Load(String),
    /// The drag of a link, by the name of that.
    Drag(String),
    /// A motor, by the joint that it drives.
    Motor(String),
    /// A motion in time, by the joint that it moves.
    Motion(String),
    /// An obstacle, by name.
    Obstacle(String),
    /// A pair that may touch, by both names, in quotes.
    Pair(String),
}

impl fmt::Display for Element {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Element::Link(name) => write!(out, "link {name:?}"),
            Element::Joint(name) => write!(out, "joint {name:?}"),
            Element::Robot(name) => write!(out, "robot {name:?}"),
            Element::Body(name) => write!(out, "body {name:?}"),
            Element::Loop(name) => write!(out, "loop {name:?}"),
            Element::Coupling(name) => write!(out, "coupling {name:?}"),
            Element::Spring(name) => write!(out, "spring {name:?}"),
            Element::Rope(name) => write!(out, "rope {name:?}"),
            Element::Load(on) => write!(out, "load on {on:?}"),
            Element::Drag(on) => write!(out, "drag of {on:?}"),
            Element::Motor(on) => write!(out, "motor on {on:?}"),
            Element::Motion(on) => write!(out, "motion of {on:?}"),
            Element::Obstacle(name) => write!(out, "obstacle {name:?}"),
            Element::Pair(names) => write!(out, "contact of {names}"),
        }
    }
}

/// `file:line: element: `, without unknown parts.
pub(crate) fn place(file: &std::path::Path, line: Option<usize>, element: &Option<Element>) -> String {
    let mut place = file.display().to_string();
    if let Some(line) = line {
        place += &format!(":{line}");
    }
    if let Some(element) = element {
        place += &format!(": {element}");
    }
    place
}

/// Why a file is not a robot or a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{}: {problem}", place(file, *line, element))]
pub struct SceneError {
    /// The file.
    pub file: PathBuf,
    /// The line, counted from 1.
    pub line: Option<usize>,
    /// The link or joint.
    pub element: Option<Element>,
    /// The defect.
    pub problem: Box<Problem>,
}

/// A defect of a URDF or a scene file.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// The file system refused.
    #[error("cannot be read: {0}")]
    Unreadable(String),
    /// A file of another kind.
    #[error("is neither a robot nor a scene; give a URDF, xacro or MJCF file, or a scene file that ends in .toml")]
    OtherFile,
    /// A scene file in a build without the feature `scene`.
    #[error("this build reads no scene files: build catena with its feature `scene`")]
    NotBuilt,
    /// An empty file.
    #[error("the file is empty")]
    Empty,
    /// Not text.
    #[error("is not a text file (byte {0} is not UTF-8)")]
    NotText(usize),
    /// Not XML.
    #[error("is not well-formed XML: {0}")]
    Xml(String),
    /// XML, but not a URDF.
    #[error("the outermost element is <{0}>; a URDF has <robot>, a model of MuJoCo <mujoco>")]
    NotRobot(String),
    /// A model of MuJoCo as the robot of a scene.
    #[error(
        "it is a model of MuJoCo, which is a whole scene and no robot of another one: run it by itself, `catena simulate FILE.xml`, and set its numbers \
         with --set, of which `catena model FILE.xml --parameters` lists the keys; or name a URDF of the robot here"
    )]
    ModelOfMujoco,
    /// SDF instead of URDF or MJCF.
    #[error(
        "it is SDF, which is not read: give the URDF that it was made of, or convert it to MJCF with Gazebo's converter \
         (`pip install sdformat-mjcf`, which needs Gazebo's packages for Python, then `sdf2mjcf FILE.sdf FILE.xml`)"
    )]
    Sdf,
    /// A xacro source instead of its result.
    #[error("{0} is xacro, which must be expanded first: `xacro FILE.xacro > FILE.urdf`")]
    Xacro(String),
    /// A xacro source, and no program to expand it.
    #[error(
        "it is xacro, and the program `xacro`, which expands it, was not found: install it (`pip install xacro`), or expand the file where it is \
         installed (`xacro FILE.xacro > FILE.urdf`)"
    )]
    NoXacro,
    /// A xacro source that its program does not expand.
    #[error("the program `xacro` cannot expand it: {0}")]
    XacroFailed(String),
    /// No links.
    #[error("the robot has no links")]
    NoLinks,
    /// An attribute is missing or empty.
    #[error("<{element}> has no {attribute}=\"...\"")]
    MissingAttribute { element: String, attribute: String },
    /// A child element is missing.
    #[error("<{parent}> has no <{element}>")]
    MissingElement { parent: String, element: String },
    /// A child element appears more than once, and not twice the same.
    #[error("<{parent}> has <{element}> more than once, with different contents (the first on line {first_line})")]
    RepeatedElement { parent: String, element: String, first_line: usize },
    /// Two links or two joints with one name.
    #[error("the name is already taken on line {first_line}")]
    DuplicateName { first_line: usize },
    /// Text that is no number, a number that is not finite, or too many or too few numbers.
    #[error("<{element} {attribute}=\"{text}\">: {reason}")]
    Number { element: String, attribute: String, text: String, reason: String },
    /// Not a joint type of URDF.
    #[error(
        "type {0:?} is not one of revolute, continuous, prismatic, fixed, floating, planar, spherical, screw (URDF knows no other)"
    )]
    JointType(String),
    /// A screw without its thread.
    #[error("a screw needs its thread: give <thread_pitch value=\"0.01\"/> in m a turn, not zero")]
    ScrewPitch,
    /// The axis has no direction.
    #[error("the axis is zero, so the joint has no direction to move in")]
    ZeroAxis,
    /// A negative mass.
    #[error("the mass {0} kg is negative")]
    NegativeMass(f64),
    /// A joint refers to a link that does not exist.
    #[error("its {role} link {name:?} does not exist")]
    UnknownLink { role: &'static str, name: String },
    /// A link is the child of two joints.
    #[error("is the child of two joints, {first:?} and {second:?}: the links of a URDF must form a tree")]
    TwoParents { first: String, second: String },
    /// The joints go round in a circle.
    #[error("is its own ancestor ({}): the links of a URDF must form a tree", path.join(" → "))]
    Cycle { path: Vec<String> },
    /// More than one link without a parent.
    #[error("the links form several trees, with the roots {}: join them, or fix them to a link \"world\"", quoted(.0))]
    SeveralRoots(Vec<String>),
    /// Not a type of joint that closes loops.
    #[error(
        "type {0:?} is not one of revolute, continuous, prismatic, cylindrical, universal, spherical, ball, planar, fixed"
    )]
    LoopType(String),
    /// Not TOML, or not the tables and keys of a scene.
    #[error("{}{message}", key.as_ref().map_or(String::new(), |key| format!("{key}: ")))]
    Toml { key: Option<String>, message: String },
    /// A model of MuJoCo without joints.
    #[error("no body of the model has a joint, so that nothing moves")]
    NothingMoves,
    /// A scene without robots and bodies.
    #[error("the scene has no [[robot]] and no [[body]]")]
    NoRobots,
    /// A name that cannot be told from another.
    #[error("the name of a robot must not be empty, {WORLD_LINK:?} or contain \"/\"", WORLD_LINK = crate::scene::world::WORLD_LINK)]
    RobotName,
    /// A body whose name says something else, too.
    #[error("the name of a body must not be empty, {WORLD_LINK:?}, \"floor\" or contain \"/\", \"|\" or \"*\"", WORLD_LINK = crate::scene::world::WORLD_LINK)]
    BodyName,
    /// A body with the name of a link or joint.
    #[error("the robot {robot:?} has a {what} of this name; choose another name for the body")]
    BodyNamedAs { what: &'static str, robot: String },
    /// An obstacle whose name says something else, too.
    #[error("the name of an obstacle must not be empty, {WORLD_LINK:?} or contain \"|\" or \"*\"", WORLD_LINK = crate::scene::world::WORLD_LINK)]
    ObstacleName,
    /// A link or joint that no robot has.
    #[error("there is no {what} {name:?}{}; there are {}", hint(*robots), listed(known))]
    UnknownName { what: &'static str, name: String, robots: usize, known: Vec<String> },
    /// A number of a joint with a unit that its motion has not.
    #[error("joint {joint:?}: {reason}")]
    JointNumber { joint: String, reason: String },
    /// Limits between which there is nothing.
    #[error("its lower limit {lower} is above its upper limit {upper}; swap them")]
    ReversedLimits { lower: f64, upper: f64 },
    /// Friction that would drive.
    #[error("its friction {0} is negative; give one that is not")]
    NegativeFriction(f64),
    /// A rotor that would push.
    #[error("its armature {0} is negative; give one that is not")]
    NegativeArmature(f64),
    /// A motor or setting of a joint that is not in the tree.
    #[error("{0:?} closes a loop; only joints of a URDF's tree can have motors, limits and friction")]
    NotOfTree(String),
    /// Two motors on one joint.
    #[error("the joint already has the motor of line {first_line}; give one motor for each joint")]
    SecondMotor { first_line: usize },
    /// Two motions of one joint.
    #[error("the joint already has the [[motion]] of line {first_line}; give it one")]
    SecondMotion { first_line: usize },
    /// Two tables for one joint.
    #[error("the joint already has the [[joint]] of line {first_line}; write all keys into that")]
    SecondJoint { first_line: usize },
    /// Two tables for one link.
    #[error(
        "the link already has the [[link]] of line {first_line}; give one for each link, or for each `shape` of it"
    )]
    SecondLink { first_line: usize },
    /// A collision shape that a link has not.
    #[error("it has no collision shape {number}: they are counted from 1, and it has {count}")]
    NoCollisionShape { number: usize, count: usize },
    /// An entry of a table of times and values.
    #[error("{0}")]
    Table(String),
    /// Keys that exclude each other, or of which one is missing.
    #[error("{0}")]
    Keys(&'static str),
    /// A key path that belongs to no number of the scene.
    #[error("no number of the scene is called {key:?}{}", proposal(near))]
    UnknownParameter { key: String, near: Vec<String> },
    /// A short key path that means several numbers.
    #[error("{key:?} may mean {}; write it whole", quoted(keys))]
    AmbiguousParameter { key: String, keys: Vec<String> },
    /// A number that its place cannot have.
    #[error("{key} = {number}: {reason}")]
    ParameterValue { key: String, number: f64, reason: String },
}

/// How links and joints are called where there are several robots.
fn hint(robots: usize) -> &'static str {
    if robots > 1 { "; with several robots it must be written robot/name" } else { "" }
}

/// A proposal of similar names.
fn proposal(near: &[String]) -> String {
    match near {
        [] => "; `catena model INPUT --parameters` lists all".to_string(),
        near => format!("; the nearest are {} (`catena model INPUT --parameters` lists all)", quoted(near)),
    }
}

/// `"a", "b", "c"`.
pub fn quoted<S: AsRef<str>>(names: &[S]) -> String {
    names.iter().map(|name| format!("{:?}", name.as_ref())).collect::<Vec<_>>().join(", ")
}

/// Names in quotes; of a robot with hundreds of joints no more than fit into a line or two.
pub fn listed(known: &[String]) -> String {
    const MOST: usize = 12;
    match known {
        [] => "none".to_string(),
        few if few.len() <= MOST => quoted(few),
        many => {
            let (shown, rest) = many.split_at(MOST - 2);
            format!("{} and {} more, which `catena model` lists", quoted(shown), rest.len())
        }
    }
}
