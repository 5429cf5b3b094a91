//! The options that say what is simulated: shared by every verb that reads a robot or a scene.
//!
//! What the command line says goes before what a scene file says, and that before the defaults; [`WorldArgs::load`] is
//! where they meet.

use crate::cli::contact_args::ContactArgs;
use crate::cli::numbers::{Assignment, numbers};
use anyhow::{Context, bail};
use catena::instant::assembly::assemble_counted;
use catena::lobatto::coupled::counted::Counted;
use catena::mechanism::description::joint::Pose;
use catena::mechanism::description::rules::Rule;
use catena::mechanism::ground::words::{decimals, short};
use catena::mechanism::motion::energy::violation;
use catena::mechanism::motion::kinematics::body_states;
use catena::mechanism::motion::state::State;
use catena::model::{Base, Left, Model, ModelError, ModelOptions, Start};
use catena::output::report::{Numbers, joint_reports};
use catena::scene::{ContactSettings, PackagePath, Robot, Scene, SimulationSettings, Warning, read_scene, read_urdf};
use nalgebra::{Rotation3, Translation3, Vector3};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The robot or scene, and where it stands.
#[derive(Clone, Debug, clap::Args)]
pub struct InputArgs {
    /// The robot or scene: a .urdf or .toml file
    pub input: PathBuf,

    #[command(flatten)]
    pub world: WorldArgs,

    /// Rules that are switched off.
    #[arg(long, value_name = "RULE", help = keep_help())]
    pub keep: Vec<Rule>,
}

/// Where a robot stands, and where its files are.
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

    /// What is left out of the simulation although the files say it.
    #[arg(long, value_name = "WHAT", help = without_help())]
    pub without: Vec<Left>,

    #[command(flatten)]
    pub contact: ContactArgs,

    /// Folder of a ROS package, for package://NAME/... (repeatable); then ROS_PACKAGE_PATH, AMENT_PREFIX_PATH and the
    /// folders above the URDF are searched
    #[arg(long, value_name = "NAME=DIR", value_parser = package)]
    pub package: Vec<(String, PathBuf)>,
}

/// What was read: the model, where it starts, and how its file wants it to be run.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// What is simulated.
    pub model: Model,
    /// Where the file starts it.
    pub start: Start,
    /// What the file says about the run.
    pub simulation: SimulationSettings,
    /// What was counted of the closures at the start, once there is one.
    pub counted: Option<Arc<Counted>>,
}

/// Changes of the start [m, rad, or a second of these] that nobody need be told.
const UNNOTICEABLE: f64 = 1e-9;

/// Most changes of the start that are told one by one.
const NAMED: usize = 3;

impl Loaded {
    /// The start, moved within limits and onto all loops and mimic relations; what was changed for that becomes a warning of the model.
    ///
    /// # Errors
    /// As [`Loaded::unassembled_state`], if a joint is given twice, if a loop cannot be closed or the velocities contradict one, and if
    /// forces or energies are undefined or infinite there.
    pub fn initial_state(
        &mut self,
        positions: &[Assignment],
        velocities: &[Assignment],
        base_velocity: Option<[f64; 6]>,
    ) -> anyhow::Result<State> {
        refuse_repeated("--position", positions)?;
        refuse_repeated("--velocity", velocities)?;
        let wanted = self.wanted(positions, velocities, base_velocity)?;
        let mut state = self.model.initial_state(&wanted.positions, &wanted.velocities, None)?;
        let file = self.model.path();
        let in_file = || file.display().to_string();
        self.model.check_representable(&state).with_context(in_file)?;
        let given = state.clone();
        let (correction, counted) = assemble_counted(&self.model.mechanism, &mut state).with_context(in_file)?;
        self.counted = counted;
        self.model.check_springs(&state).with_context(in_file)?;
        // What limits alone moved is said apart.
        let mechanism = &self.model.mechanism;
        let open = violation(mechanism, &given, &body_states(mechanism, &given)).position > UNNOTICEABLE;
        let apart = correction.overlap.and_then(|(number, depth)| {
            let pair = mechanism.nonsmooth.pairs.iter().find(|pair| pair.number == number)?;
            let [a, b] = [pair.a, pair.b].map(|of| mechanism.nonsmooth.colliders[of].name.as_str());
            Some(format!(
                "{a:?} and {b:?} start {depth:.1e} m inside each other: the start was moved apart, positions by up to {:.1e} rad or m",
                correction.position
            ))
        });
        if mechanism.has_closures()
            && ((open && correction.position > UNNOTICEABLE) || correction.velocity > UNNOTICEABLE)
        {
            let message = format!(
                "the start was moved onto the loops: positions by up to {:.1e} rad or m, velocities by up to {:.1e} rad/s or m/s{}",
                correction.position,
                correction.velocity,
                self.moved(&wanted, &state)
            );
            self.model.warnings.push(Warning { file: file.to_path_buf(), line: None, element: None, message });
        }
        if let Some(message) = apart {
            let file = self.model.path().to_path_buf();
            self.model.warnings.push(Warning { file, line: None, element: None, message });
        }
        self.model.warnings.extend(self.model.moved_in_warning(&given, &state));
        self.model.warnings.extend(self.model.limit_warning(&state));
        Ok(state)
    }

    /// The first joints of one number that do not start as they were wanted, as the end of a sentence.
    fn moved(&self, wanted: &Start, state: &State) -> String {
        let unit = |joint: &str| {
            let record = self.model.joints.iter().find(|record| record.name == joint);
            let body = record.and_then(|record| record.body);
            body.map_or("", |body| self.model.mechanism.bodies[body].joint.kind.unit(0))
        };
        let reports = joint_reports(&self.model, state, &[]);
        let mut all = Vec::new();
        for (joint, report) in &reports {
            for (given, starts, per_second) in
                [(&wanted.positions, &report.position, ""), (&wanted.velocities, &report.velocity, "/s")]
            {
                // What comes later counts.
                let given = given.iter().rev().find(|(name, _)| name == joint).map(|(_, numbers)| numbers.as_slice());
                if let (Some(&[given]), &Numbers::One(starts)) = (given, starts)
                    && decimals(given) != decimals(starts)
                {
                    let (starts, given, unit) = (decimals(starts), short(given), unit(joint));
                    all.push(format!("; {joint} starts at {starts} {unit}{per_second}, not at {given}"));
                }
            }
        }
        all.truncate(NAMED);
        all.concat()
    }

    /// The start of the file as it stands, whatever the loops say.
    ///
    /// # Errors
    /// [`ModelError`] for joints that do not exist or do not move, and for wrong counts of numbers.
    pub fn unassembled_state(&self) -> Result<State, ModelError> {
        self.model.initial_state(&self.start.positions, &self.start.velocities, None)
    }

    /// The start of the file, with what the command line says instead of it.
    fn wanted(
        &self,
        positions: &[Assignment],
        velocities: &[Assignment],
        base_velocity: Option<[f64; 6]>,
    ) -> anyhow::Result<Start> {
        let pairs = |given: &[Assignment]| -> Vec<(String, Vec<f64>)> {
            given.iter().map(|one| (one.name.clone(), one.values.clone())).collect()
        };
        let mut wanted = self.start.clone();
        // What comes later counts.
        wanted.positions.extend(pairs(positions));
        wanted.velocities.extend(pairs(velocities));
        if let Some(velocity) = base_velocity {
            let count = self.model.robots.len();
            if count > 1 {
                bail!("--base-velocity is for one robot; there are {count}: give --velocity ROBOT/base=... for each");
            }
            // The velocity of the base is that of its joint.
            let base = self.model.joints.iter().find(|joint| joint.is_base).ok_or(ModelError::BaseDoesNotFloat)?;
            if velocities.iter().any(|one| one.name == base.name) {
                bail!("the velocity of the base is given twice, by --base-velocity and by --velocity {}", base.name);
            }
            wanted.velocities.push((base.name.clone(), velocity.to_vec()));
        }
        Ok(wanted)
    }
}

/// Of two values for one joint, nobody can tell which was meant.
fn refuse_repeated(option: &str, given: &[Assignment]) -> anyhow::Result<()> {
    for (index, one) in given.iter().enumerate() {
        if given[..index].iter().any(|earlier| earlier.name == one.name) {
            bail!("{option} is given twice for joint {:?}", one.name);
        }
    }
    Ok(())
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
    /// What is wrong with the file, naming file, line, and link, joint or key.
    pub fn load(&self) -> anyhow::Result<Loaded> {
        self.world.load(&self.input)
    }
}

/// Whether an input of this name is a scene file; all others are URDFs.
pub fn is_scene(input: &Path) -> bool {
    input.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

impl WorldArgs {
    /// Reads and reduces a robot or scene. Every error here is bad input (exit code 2).
    ///
    /// # Errors
    /// What is wrong with the file, naming file, line, and link, joint or key.
    pub fn load(&self, input: &Path) -> anyhow::Result<Loaded> {
        if let Some((name, folder)) = self.package.iter().find(|(_, folder)| !folder.is_dir()) {
            bail!("--package {name}: there is no folder {folder:?}");
        }
        let packages = PackagePath::from_environment(self.package.clone());
        if is_scene(input) {
            self.place_scene(read_scene(input, &packages)?)
        } else {
            self.place_robot(read_urdf(input, &packages)?)
        }
    }

    /// Reads a scene, or a robot as the only one of a scene, whose numbers have key paths.
    ///
    /// # Errors
    /// As [`WorldArgs::load`].
    pub fn scene(&self, input: &Path) -> anyhow::Result<Scene> {
        let packages = PackagePath::from_environment(self.package.clone());
        Ok(if is_scene(input) { read_scene(input, &packages)? } else { Scene::of_robot(read_urdf(input, &packages)?) })
    }

    /// Reduces a robot that was read.
    ///
    /// # Errors
    /// What cannot be simulated.
    pub fn place_robot(&self, robot: Robot) -> anyhow::Result<Loaded> {
        let defaults = ModelOptions::default();
        let options = ModelOptions {
            base: self.base.map_or(defaults.base, BaseChoice::base),
            base_pose: self.base_pose.map_or(defaults.base_pose, pose),
            gravity: self.gravity.map_or(defaults.gravity, Vector3::from),
        };
        let mut model = Model::new(robot, &options)?;
        model.set_contact(&self.contact.settings(ContactSettings::default(), &self.without)?)?;
        model.without(&self.without);
        model.warnings.extend(nothing_moves(&model, "--base floating"));
        Ok(Loaded { model, start: Start::default(), simulation: SimulationSettings::default(), counted: None })
    }

    /// Reduces a scene that was read.
    ///
    /// # Errors
    /// What cannot be simulated, and options that are for one robot where there are several.
    pub fn place_scene(&self, mut scene: Scene) -> anyhow::Result<Loaded> {
        if let Some(gravity) = self.gravity {
            scene.gravity = Some(Vector3::from(gravity));
        }
        match scene.robots.as_mut_slice() {
            [only] => {
                if let Some(base) = self.base {
                    only.floating = base == BaseChoice::Floating;
                    // A velocity of the base is lost with its freedom.
                    only.velocity = only.velocity.filter(|_| only.floating);
                }
                only.pose = self.base_pose.map_or(only.pose, pose);
            }
            several => {
                if self.base.is_some() || self.base_pose.is_some() {
                    let count = several.len();
                    bail!(
                        "--base and --base-pose are for one robot; {} has {count}: write them there",
                        scene.path.display()
                    );
                }
            }
        }
        scene.contact = self.contact.settings(scene.contact, &self.without)?;
        let (mut model, start) = Model::from_scene(&scene)?;
        model.without(&self.without);
        model.warnings.extend(nothing_moves(&model, "base = \"floating\" in its [[robot]]"));
        Ok(Loaded { model, start, simulation: scene.simulation, counted: None })
    }
}

/// A warning of a robot without bodies, all of whose mass is fixed in the world, which `remedy` would let move.
fn nothing_moves(model: &Model, remedy: &str) -> Option<Warning> {
    let robot = model.robots.iter().find(|placed| !placed.robot.root_is_world())?;
    let has_mass = model.links[robot.links.clone()].iter().any(|link| link.mass > 0.0);
    (model.mechanism.bodies.is_empty() && has_mass).then(|| Warning {
        file: model.path().to_path_buf(),
        line: None,
        element: None,
        message: format!("nothing moves, because the root link is fixed in the world; {remedy} lets it move"),
    })
}

impl BaseChoice {
    fn base(self) -> Base {
        match self {
            BaseChoice::Fixed => Base::Fixed,
            BaseChoice::Floating => Base::Floating,
        }
    }
}

fn pose([x, y, z, roll, pitch, yaw]: [f64; 6]) -> Pose {
    Pose::from_parts(Translation3::new(x, y, z), Rotation3::from_euler_angles(roll, pitch, yaw))
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
    format!("Leave something out of the simulation although the files say it (repeatable): {names}")
}

/// The help of `--keep`, with the names of all rules.
fn keep_help() -> String {
    let names = Rule::ALL.map(Rule::name).join(", ");
    format!("Switch off a rule that leaves something out (repeatable): {names}; `catena model` shows what each does")
}
