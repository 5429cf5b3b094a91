//! The arguments of `catena linearize`.

use crate::cli::arguments::input::InputArgs;
use crate::cli::arguments::numbers::{Assignment, positive};

/// Linear equations of motion and their modes
#[derive(Clone, Debug, clap::Args)]
pub struct LinearizeArgs {
    /// The robot or scene, or the log of a run, which carries it; the other options of the input are for robots and scenes alone.
    #[command(flatten)]
    pub input: InputArgs,

    /// About which state: `rest`, the equilibrium near the start; `start`; or a time T [s] of the run [default: rest, of a log its end]
    #[arg(long, value_name = "rest|start|T")]
    pub(crate) at: Option<At>,

    /// Position of a joint at the start [rad, m] (repeatable)
    #[arg(long, value_name = "JOINT=VALUE")]
    pub(crate) position: Vec<Assignment>,

    /// Velocity of a joint at the start [rad/s, m/s] (repeatable)
    #[arg(long, value_name = "JOINT=VALUE")]
    pub(crate) velocity: Vec<Assignment>,

    /// Add the matrices of a discrete system with this step [s], inputs being held over a step
    #[arg(long, value_name = "S", allow_hyphen_values = true, value_parser = positive, requires = "json")]
    pub(crate) discrete: Option<f64>,

    /// Add the derivatives of all frequencies and eigenvalues by a number of the scene, with its key path (repeatable); about the equilibrium, the start or an instant of a log
    #[arg(long, value_name = "KEY")]
    pub(crate) by: Vec<String>,

    /// The multipliers of the motion from the start on, or from --at T on, over this period [s], instead of modes
    #[arg(long, value_name = "T", value_parser = positive, allow_hyphen_values = true, conflicts_with_all = ["by", "discrete"])]
    pub(crate) orbit: Option<f64>,

    /// Print one JSON object, with all matrices, instead of a table
    #[arg(long)]
    pub(crate) json: bool,
}

/// `--at`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum At {
    Rest,
    Start,
    Time(f64),
}

impl std::str::FromStr for At {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "rest" => Ok(At::Rest),
            "start" => Ok(At::Start),
            "end" => Ok(At::Time(f64::INFINITY)),
            number => match number.parse::<f64>() {
                Ok(time) if time.is_finite() && time >= 0.0 => Ok(At::Time(time)),
                _ => Err(format!("{number:?} is no instant; give rest, start, or a time in s that is not negative")),
            },
        }
    }
}
