//! The options of the simulated robot or scene, shared by every verb that reads one.
//!
//! [`catena::session::World`] works out their meaning.

use crate::cli::arguments::contact_args::ContactArgs;
use crate::cli::arguments::numbers::numbers;
use anyhow::anyhow;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::ground::words::counted;
use catena::model::{Base, Left, Model};
use catena::scene::{Quantity, Scene, WarningGroup, warning_lines};
use catena::session::{Hold, Loaded, World};
use std::path::{Path, PathBuf};

/// The robot or scene, and where it stands.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "What is simulated")]
pub struct InputArgs {
    /// The robot or scene: a .urdf, .toml or MJCF (.xml) file; a .xacro file if xacro is installed; - for standard input
    #[arg(help_heading = None)]
    pub input: PathBuf,

    #[command(flatten)]
    pub world: WorldArgs,

    /// Take warnings for errors: what the files say and is not simulated, is odd or is ignored, and what a run warns of
    #[arg(long)]
    pub strict: bool,

    /// Rules that are switched off.
    #[arg(long, value_name = "RULE", help = keep_help())]
    pub keep: Vec<Rule>,
}

/// The place of a robot, and of its files.
#[derive(Clone, Debug, clap::Args)]
pub struct WorldArgs {
    /// Whether the root link is fixed in the world or floats freely [default: fixed]
    #[arg(long, value_enum)]
    pub base: Option<BaseChoice>,

    /// Pose of the root link in the world [m, rad]; where it starts if the base floats [default: the world frame]
    #[arg(long, value_name = "X,Y,Z,ROLL,PITCH,YAW", value_parser = numbers::<6>, allow_hyphen_values = true)]
    pub base_pose: Option<[f64; 6]>,

    /// Acceleration of gravity in the world [m/s²] [default: 0,0,-9.81]
    #[arg(long, value_name = "X,Y,Z", value_parser = numbers::<3>, allow_hyphen_values = true)]
    pub gravity: Option<[f64; 3]>,

    /// Parts of the files that are left out of the simulation.
    #[arg(long, value_name = "WHAT", help = without_help())]
    pub without: Vec<Left>,

    #[command(flatten)]
    pub contact: ContactArgs,

    /// Hold all joints without motors of their own where they start, by motors with these gains [N m/rad and N m s/rad, or N/m and N s/m];
    /// without gains by critically damped ones of 10 Hz; `gravity=1` holds the weights besides
    #[arg(long, value_name = "kp=KP,kd=KD,gravity=PART", num_args = 0..=1, require_equals = true, default_missing_value = "", value_parser = gains)]
    pub hold: Option<Hold>,

    /// Start a model of MuJoCo with this keyframe of it
    #[arg(long, value_name = "NAME")]
    pub keyframe: Option<String>,

    /// Set a number of the scene or robot by its key path, as `link7.mass=2.5` or, of angles, `hinge.limit.upper="30 deg"` (repeatable);
    /// `catena model INPUT --parameters` lists them
    #[arg(long, value_name = "KEY=VALUE", value_parser = one_number)]
    pub set: Vec<(String, Quantity)>,

    /// Folder of a ROS package, for package://NAME/... (repeatable); then ROS_PACKAGE_PATH, AMENT_PREFIX_PATH and the
    /// folders above the URDF are searched
    #[arg(long, value_name = "NAME=DIR", value_parser = package)]
    pub package: Vec<(String, PathBuf)>,

    /// Give an argument to xacro sources, as the program `xacro` takes it (repeatable)
    #[arg(long, value_name = "NAME:=VALUE", value_parser = argument)]
    pub xacro: Vec<(String, String)>,
}

/// `--base`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum BaseChoice {
    /// The root link is fixed in the world
    Fixed,
    /// The root link moves freely
    Floating,
}

impl InputArgs {
    /// Reads and reduces the robot or scene. Every error here is bad input (exit code 2).
    ///
    /// # Errors
    /// The defect of the file, with file, line, and link, joint or key.
    pub fn load(&self) -> anyhow::Result<Loaded> {
        let mut loaded = self.world.load(&self.input)?;
        loaded.model.keep(&self.keep);
        Ok(loaded)
    }

    /// Refuses warnings, if they are to be errors.
    ///
    /// # Errors
    /// With `--strict` the first warning, and how many more there are.
    pub fn refuse_warnings(&self, model: &Model) -> anyhow::Result<()> {
        let lines = warning_lines(&model.warnings).into_iter();
        self.refuse(lines.filter(|(group, _)| *group != WarningGroup::Taken).map(|(_, line)| line))
    }

    /// The same of warnings of a run.
    ///
    /// # Errors
    /// As [`InputArgs::refuse_warnings`].
    pub fn refuse(&self, mut warnings: impl Iterator<Item = String>) -> anyhow::Result<()> {
        let Some(first) = warnings.next().filter(|_| self.strict) else { return Ok(()) };
        let more = match warnings.count() {
            0 => String::new(),
            more => format!("; and {}", counted(more, "more warning", "more warnings")),
        };
        Err(anyhow!("--strict: {first}{more}"))
    }
}

impl WorldArgs {
    /// Reads and reduces a robot or scene. Every error here is bad input (exit code 2).
    ///
    /// # Errors
    /// The defect of the file, with file, line, and link, joint or key.
    pub fn load(&self, input: &Path) -> anyhow::Result<Loaded> {
        Ok(self.world().load(input)?)
    }

    /// Reads a scene, or a robot as the only one of a scene, whose numbers have key paths.
    ///
    /// # Errors
    /// As [`WorldArgs::load`].
    pub fn scene(&self, input: &Path) -> anyhow::Result<Scene> {
        Ok(self.world().scene(input)?)
    }

    /// The world that they describe.
    pub fn world(&self) -> World {
        World {
            base: self.base.map(BaseChoice::base),
            base_pose: self.base_pose,
            gravity: self.gravity,
            without: self.without.clone(),
            floor: self.contact.floor,
            contact: self.contact.contact,
            packages: self.package.clone(),
            xacro: self.xacro.clone(),
            set: self.set.clone(),
            hold: self.hold,
            keyframe: self.keyframe.clone(),
        }
    }
}

impl BaseChoice {
    fn base(self) -> Base {
        match self {
            BaseChoice::Fixed => Base::Fixed,
            BaseChoice::Floating => Base::Floating,
        }
    }
}

/// `kp=KP,kd=KD,gravity=PART`, some of them, or none.
fn gains(text: &str) -> Result<Hold, String> {
    let mut hold = Hold::default();
    for gain in text.split(',').filter(|gain| !gain.is_empty()) {
        let refuse = || format!("{gain:?} is none of kp=NUMBER, kd=NUMBER and gravity=NUMBER");
        let (name, number) = gain.split_once('=').ok_or_else(refuse)?;
        let number: f64 = number.trim().parse().map_err(|_| refuse())?;
        if !number.is_finite() || number < 0.0 {
            return Err(format!("{name} is {number}; give a number that is finite and not negative"));
        }
        match name.trim() {
            "kp" => hold.kp = Some(number),
            "kd" => hold.kd = Some(number),
            "gravity" => hold.gravity = Some(number),
            _ => return Err(refuse()),
        }
    }
    Ok(hold)
}

/// `KEY=VALUE`. Which values a key takes is asked where it is known.
fn one_number(text: &str) -> Result<(String, Quantity), String> {
    let (key, value) = text.rsplit_once('=').filter(|(key, _)| !key.is_empty()).ok_or("give KEY=VALUE")?;
    let plain = value.trim().parse::<f64>().map(Quantity::from);
    let value = match plain {
        Err(_) if value.contains(|c: char| c.is_ascii_digit()) => Quantity::parse(value)?,
        other => other.map_err(|_| format!("{value:?} is not a number"))?,
    };
    Ok((key.to_string(), value))
}

/// `NAME:=VALUE`.
fn argument(text: &str) -> Result<(String, String), String> {
    let both = text.split_once(":=").filter(|(name, _)| !name.is_empty()).ok_or("give NAME:=VALUE")?;
    Ok((both.0.to_string(), both.1.to_string()))
}

/// `NAME=DIR`. Whether there is such a folder is asked where it is needed: a log can be read without.
pub fn package(text: &str) -> Result<(String, PathBuf), String> {
    match text.split_once('=') {
        Some((name, folder)) if !name.is_empty() && !folder.is_empty() => Ok((name.to_string(), folder.into())),
        _ => Err("give NAME=DIR, the name of the package and its folder".to_string()),
    }
}

/// The help of `--without`, with everything that can be left out.
fn without_help() -> String {
    let names = Left::ALL.map(Left::name).join(", ");
    format!("Leave out something that the files contain (repeatable): {names}")
}

/// The help of `--keep`, with the names of all rules.
fn keep_help() -> String {
    let names = Rule::ALL.map(Rule::name).join(", ");
    format!("Disable one model simplification (repeatable): {names}; `catena model` shows what each does")
}
