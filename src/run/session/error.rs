//! The errors of a session: in its input, the start, the run, or the log.

use crate::derivatives::forward::failure::SensitivityError;
use crate::derivatives::linear::about::LinearizeError;
use crate::instant::start::assembly::AssemblyError;
use crate::model::ModelError;
use crate::output::log::LogError;
use crate::scene::SceneError;
use crate::simulation::{InputError, RunError, SimulationError};
use std::path::PathBuf;

/// Any error of a controller.
pub type ControllerFailure = Box<dyn std::error::Error + Send + Sync>;

/// Why a model cannot be loaded, started, run or logged. The command line has the same messages.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The robot or scene is invalid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The model cannot be simulated, or a joint does not exist.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The loops cannot be assembled.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// The start of the model in a file is invalid.
    #[error("{}: {problem}", file.display())]
    InFile {
        /// The scene file or URDF.
        file: PathBuf,
        /// The error.
        problem: Box<Error>,
    },
    /// The folder of a ROS package does not exist.
    #[error("--package {name}: there is no folder {folder:?}")]
    Package {
        /// The package.
        name: String,
        /// The given folder.
        folder: PathBuf,
    },
    /// A floor is given, but the scene has one.
    #[error("--floor: the scene has an obstacle {0:?} already; leave one of them out")]
    FloorTwice(&'static str),
    /// A floor is given, but nothing may touch it.
    #[error("--floor: nothing may touch it, because pairs are \"none\"; give --contact environment, or no --floor")]
    FloorUntouched,
    /// Options for one robot are given, but the scene has several.
    #[error("--base and --base-pose are for one robot; {} has {count}: write them there", file.display())]
    SeveralRobots {
        /// The scene.
        file: PathBuf,
        /// How many robots it has.
        count: usize,
    },
    /// A joint is given two starts.
    #[error("--{option} is given twice for joint {joint:?}")]
    GivenTwice {
        /// `position` or `velocity`.
        option: &'static str,
        /// The joint.
        joint: String,
    },
    /// A velocity of the base is given, but there are several bases.
    #[error("--base-velocity is for one robot; there are {0}: give --velocity ROBOT/base=... for each")]
    SeveralBases(usize),
    /// Two velocities of the base are given.
    #[error("the velocity of the base is given twice, by --base-velocity and by --velocity {0}")]
    BaseVelocityTwice(String),
    /// A number is invalid.
    #[error("{option} is {value}: {wanted}")]
    Option {
        /// Its option.
        option: &'static str,
        /// The given number.
        value: f64,
        /// The condition that it must satisfy.
        wanted: &'static str,
    },
    /// The count of numbers is wrong.
    #[error("{what}: {given} numbers where {wanted} are wanted")]
    Count {
        /// The name of the list.
        what: &'static str,
        /// The given count.
        given: usize,
        /// The right count.
        wanted: usize,
    },
    /// A number is not finite.
    #[error("{what}: the number for {of:?} is {value}: give a finite number")]
    NotFinite {
        /// The kind of number.
        what: &'static str,
        /// Its joint.
        of: String,
        /// The given number.
        value: f64,
    },
    /// The link does not exist.
    #[error("there is no link {link:?}; the links are {known}")]
    UnknownLink {
        /// The requested link.
        link: String,
        /// The links that exist (the first ones, if there are many).
        known: String,
    },
    /// The joint has no motor.
    #[error("joint {joint:?} has no motor; the joints with motors are {known}")]
    NoMotor {
        /// The joint.
        joint: String,
        /// The joints that have motors (the first ones, if there are many).
        known: String,
    },
    /// A sensor of one freedom is on a joint of several.
    #[error("joint {0:?} has not one freedom: ask for its wrench")]
    NotOneFreedom(String),
    /// Efforts cannot give these accelerations.
    #[error(
        "these accelerations are {left:e} (rad/s², m/s²) away from any that the loops, mimic relations and joints allow: give accelerations that fit them"
    )]
    ImpossibleAcceleration {
        /// How far they are from the nearest [rad/s², m/s²].
        left: f64,
    },
    /// Some motions of the tree move no mass.
    #[error("the mass matrix is singular here: some motion of the joints moves no mass")]
    SingularMass,
    /// A state has no linear equations of motion.
    #[error(transparent)]
    Linear(#[from] LinearizeError),
    /// A run has no derivatives.
    #[error(transparent)]
    Sensitivity(#[from] SensitivityError),
    /// A setting must be made before the first step.
    #[error("{0}: the run has begun; set it before the first step")]
    Begun(&'static str),
    /// A run with a log cannot go back.
    #[error("a run with a log goes on in time alone: leave the log out to take states back or to start elsewhere")]
    Logged,
    /// A result of Python that was pickled has no log.
    #[error("a result that was pickled has samples and a report, and no log any more: write logs and pages before")]
    Pickled,
    /// A state is of another model.
    #[error("the state is of {state:?}, and the run of {run:?}: take states of the same model")]
    OtherModel {
        /// The model of the state.
        state: String,
        /// That of the run.
        run: String,
    },
    /// A state is of a run with other settings.
    #[error(
        "the state is of a run with other steps or other parts that rest: take states of runs with the same settings"
    )]
    OtherSettings,
    /// The run has ended.
    #[error("the run ended at t = {0} s; start a new one")]
    Over(f64),
    /// The requested time has passed already or is after the end.
    #[error(
        "cannot step to t = {wanted} s: the run is at {time} s and ends at {end} s; give it a longer duration before its first step"
    )]
    OutOfRun {
        /// The requested time (s).
        wanted: f64,
        /// The present time (s).
        time: f64,
        /// The end of the run (s).
        end: f64,
    },
    /// A log cannot be written to this path.
    #[error("cannot write {}: {reason}", path.display())]
    Output {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// The run is too long for a log.
    #[error(
        "a log counts nanoseconds, up to {longest:e} s after 1970; give a shorter --duration than {duration:e}, an earlier \
         --start-time or --no-log"
    )]
    TooLong {
        /// The longest duration (s).
        longest: f64,
        /// The requested duration (s).
        duration: f64,
    },
    /// The stages or the steps cannot be.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The efforts are invalid.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A controller failed.
    #[error("the controller failed at t = {time} s: {failure}")]
    Controller {
        /// The time (s).
        time: f64,
        /// The error of the controller.
        failure: ControllerFailure,
    },
    /// The run failed.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The log failed.
    #[error("{0}")]
    Log(LogError),
    /// The run was interrupted before its log, a pipe, had a reader.
    #[error("interrupted while waiting for a reader of {}", path.display())]
    Unread {
        /// The pipe.
        path: PathBuf,
    },
    /// The run failed, so its log was not put in place of an earlier one.
    #[error("{problem}; {} is as it was, the log of this run is {}", output.display(), beside.display())]
    Beside {
        /// The failure.
        problem: Box<Error>,
        /// The path of the earlier log.
        output: PathBuf,
        /// The path of the log of this run.
        beside: PathBuf,
    },
}

impl Error {
    /// The same error, with the file that contains its cause.
    pub(crate) fn in_file(self, file: &std::path::Path) -> Self {
        Error::InFile { file: file.to_path_buf(), problem: Box::new(self) }
    }

    /// The error without the file.
    pub fn problem(&self) -> &Error {
        match self {
            Error::InFile { problem, .. } => problem.problem(),
            other => other,
        }
    }

    /// Whether the run was interrupted from outside.
    pub fn is_interruption(&self) -> bool {
        match self {
            Error::Beside { problem, .. } | Error::InFile { problem, .. } => problem.is_interruption(),
            Error::Run(RunError::Interrupted { .. }) | Error::Unread { .. } | Error::Log(LogError::Blocked { .. }) => {
                true
            }
            Error::Run(RunError::Observer(source)) => matches!(source.downcast_ref(), Some(LogError::Blocked { .. })),
            _ => false,
        }
    }

    /// Whether the input is wrong, so that the run did not start and no file was written.
    pub fn is_input(&self) -> bool {
        match self {
            Error::Beside { .. } | Error::Run(_) | Error::Unread { .. } | Error::Controller { .. } => false,
            Error::Log(log) => matches!(log, LogError::Create { .. } | LogError::Busy { .. }),
            Error::Simulation(error) => matches!(error, SimulationError::Method(_)),
            _ => true,
        }
    }
}

impl From<LogError> for Error {
    fn from(error: LogError) -> Self {
        Error::Log(error)
    }
}
