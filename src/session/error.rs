//! Why a session cannot go on: what was given, the start, the run, or the log.

use crate::instant::assembly::AssemblyError;
use crate::model::ModelError;
use crate::output::log::LogError;
use crate::scene::SceneError;
use crate::simulation::{InputError, RunError, SimulationError};
use std::path::PathBuf;

/// Anything a controller may fail with.
pub type ControllerFailure = Box<dyn std::error::Error + Send + Sync>;

/// Why a model cannot be loaded, started, run or logged. The messages are those of the command line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The robot or scene.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// What cannot be simulated, and joints that are not there.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The loops.
    #[error(transparent)]
    Assembly(#[from] AssemblyError),
    /// Something is wrong with the start of the model in a file.
    #[error("{}: {problem}", file.display())]
    InFile {
        /// The scene file or URDF.
        file: PathBuf,
        /// What is wrong.
        problem: Box<Error>,
    },
    /// There is no folder for a ROS package.
    #[error("--package {name}: there is no folder {folder:?}")]
    Package {
        /// The package.
        name: String,
        /// Where it was said to be.
        folder: PathBuf,
    },
    /// A floor where the scene has one.
    #[error("--floor: the scene has an obstacle {0:?} already; leave one of them out")]
    FloorTwice(&'static str),
    /// A floor that nothing may touch.
    #[error("--floor: nothing may touch it, because pairs are \"none\"; give --contact environment, or no --floor")]
    FloorUntouched,
    /// Options for one robot where there are several.
    #[error("--base and --base-pose are for one robot; {} has {count}: write them there", file.display())]
    SeveralRobots {
        /// The scene.
        file: PathBuf,
        /// How many robots it has.
        count: usize,
    },
    /// A joint that is given two starts.
    #[error("--{option} is given twice for joint {joint:?}")]
    GivenTwice {
        /// `position` or `velocity`.
        option: &'static str,
        /// The joint.
        joint: String,
    },
    /// A velocity of the base where there are several.
    #[error("--base-velocity is for one robot; there are {0}: give --velocity ROBOT/base=... for each")]
    SeveralBases(usize),
    /// Two velocities of the base.
    #[error("the velocity of the base is given twice, by --base-velocity and by --velocity {0}")]
    BaseVelocityTwice(String),
    /// A number that cannot be.
    #[error("{option} is {value}: {wanted}")]
    Option {
        /// What it is for.
        option: &'static str,
        /// What was given.
        value: f64,
        /// What is wanted.
        wanted: &'static str,
    },
    /// As many numbers as nobody asked for.
    #[error("{what}: {given} numbers where {wanted} are wanted")]
    Count {
        /// What they are.
        what: &'static str,
        /// How many were given.
        given: usize,
        /// How many are wanted.
        wanted: usize,
    },
    /// A number that is not finite.
    #[error("{what}: the number for {of:?} is {value}: give a finite number")]
    NotFinite {
        /// What it is.
        what: &'static str,
        /// Its joint.
        of: String,
        /// What was given.
        value: f64,
    },
    /// No such link.
    #[error("there is no link {link:?}; the links are {known}")]
    UnknownLink {
        /// What was asked for.
        link: String,
        /// All links, or the first.
        known: String,
    },
    /// A tree some of whose motions move no mass.
    #[error("the mass matrix is singular here: some motion of the joints moves no mass")]
    SingularMass,
    /// What can only be said before the first step.
    #[error("{0}: the run has begun; set it before the first step")]
    Begun(&'static str),
    /// A run that is over.
    #[error("the run ended at t = {0} s; start a new one")]
    Over(f64),
    /// A time that is not ahead.
    #[error(
        "cannot step to t = {wanted} s: the run is at {time} s and ends at {end} s; give it a longer duration before its first step"
    )]
    OutOfRun {
        /// Where it should go (s).
        wanted: f64,
        /// Where it is (s).
        time: f64,
        /// Where it ends (s).
        end: f64,
    },
    /// A log where there can be none.
    #[error("cannot write {}: {reason}", path.display())]
    Output {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// A run too long for a log.
    #[error(
        "a log counts nanoseconds, up to {longest:e} s after 1970; give a shorter --duration than {duration:e}, an earlier \
         --start-time or --no-log"
    )]
    TooLong {
        /// The longest (s).
        longest: f64,
        /// What was asked for (s).
        duration: f64,
    },
    /// Stages, steps, and trial runs.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// Efforts.
    #[error(transparent)]
    Input(#[from] InputError),
    /// A controller gave up.
    #[error("the controller failed at t = {time} s: {failure}")]
    Controller {
        /// When (s).
        time: f64,
        /// Why.
        failure: ControllerFailure,
    },
    /// The run.
    #[error(transparent)]
    Run(#[from] RunError),
    /// The log.
    #[error("{0}")]
    Log(LogError),
    /// A log that is as it was, because the run failed.
    #[error("{problem}; {} is as it was, the log of this run is {}", output.display(), beside.display())]
    Beside {
        /// What failed.
        problem: Box<Error>,
        /// Where the log should have gone.
        output: PathBuf,
        /// Where it is.
        beside: PathBuf,
    },
}

impl Error {
    /// The same, in a file.
    pub(crate) fn in_file(self, file: &std::path::Path) -> Self {
        Error::InFile { file: file.to_path_buf(), problem: Box::new(self) }
    }

    /// What is wrong, without the file.
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
            Error::Run(RunError::Interrupted { .. }) | Error::Log(LogError::Blocked { .. }) => true,
            Error::Simulation(SimulationError::Interrupted(_)) => true,
            Error::Run(RunError::Observer(source)) => matches!(source.downcast_ref(), Some(LogError::Blocked { .. })),
            _ => false,
        }
    }

    /// Whether what was given is wrong, so that nothing was run or written.
    pub fn is_input(&self) -> bool {
        match self {
            Error::Beside { .. } | Error::Run(_) | Error::Controller { .. } => false,
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
