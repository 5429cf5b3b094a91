//! The description of a run in its log: its origin at the beginning, its figures at the end.

use crate::mechanism::description::joint::Pose;
use crate::mechanism::motion::integrator::MethodDescription;
use crate::model::{Model, PlacedRobot};
use crate::output::report::{ERROR_AT_START, FromLog};
use crate::session::held_start::held_targets;
use crate::simulation::{StepChoice, Summary};
use std::collections::BTreeMap;

/// The log entry that names who controlled the run, if its files alone do not say.
pub const DRIVEN: &str = "driven";

/// The same of a run that nobody controlled, and that began where another run had ended.
pub(crate) const WENT_ON: &str = "it went on where another run had ended";

/// The same of a run that a program made step by step.
pub(crate) const STEPPED: &str = "a program has stepped it";

/// The log entry about motors that hold their joints where the run starts ([`HeldTargets`](crate::session::HeldTargets), as JSON).
pub const HELD: &str = "held";

/// Who made a run, and how.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Origin {
    /// The command line, for people.
    pub command_line: String,
    /// The arguments of a `catena simulate` that makes the same run, without the program's name.
    pub arguments: Vec<String>,
    /// Inputs that are not in the log: steps chosen or efforts given by a program. Such a run cannot be replayed from its log.
    pub driven: Option<String>,
    /// The start of a run that goes on from a log.
    pub from_log: Option<FromLog>,
}

/// The log entries about the origin of the run.
pub fn description(
    model: &Model,
    duration: f64,
    rate: f64,
    choice: StepChoice,
    method: MethodDescription,
    origin: &Origin,
) -> BTreeMap<String, String> {
    let said = |number: Option<f64>| number.map_or(String::new(), |number| number.to_string());
    // Word by word, because the command line for people does not show word borders.
    let arguments = serde_json::Value::from(origin.arguments.clone());
    // Lists an entry of several robots one after the other.
    let of_robots = |what: &dyn Fn(&PlacedRobot) -> String| model.robots.iter().map(what).collect::<Vec<_>>().join(";");
    let base = |robot: &PlacedRobot| {
        let floats = model.joints[robot.joints.clone()].iter().any(|joint| joint.is_base);
        if floats { "floating" } else { "fixed" }.to_string()
    };
    let entries = [
        ("scene", model.mechanism.name.clone()),
        ("robot", of_robots(&|robot| robot.name.clone())),
        ("base", of_robots(&base)),
        ("base_pose", of_robots(&|robot| listed(&pose_numbers(&robot.base_pose)))),
        ("gravity", listed(model.mechanism.gravity.as_slice())),
        ("version", env!("CARGO_PKG_VERSION").to_string()),
        ("method", method.name),
        ("stages", method.stages.to_string()),
        ("order", method.order.to_string()),
        ("step", said(choice.step())),
        ("tolerance", said(choice.tolerance())),
        ("duration", duration.to_string()),
        ("rate", rate.to_string()),
        ("command_line", origin.command_line.clone()),
        ("arguments", arguments.to_string()),
    ];
    let driven = origin.driven.iter().map(|by| (DRIVEN, by.clone()));
    let held = held_targets(model);
    let held = (!held.is_empty()).then(|| (HELD, serde_json::json!(held).to_string()));
    entries.into_iter().chain(driven).chain(held).map(|(name, value)| (name.to_string(), value)).collect()
}

/// A pose as `--base-pose` takes it.
fn pose_numbers(pose: &Pose) -> [f64; 6] {
    let (roll, pitch, yaw) = pose.rotation.euler_angles();
    let [x, y, z] = pose.translation.vector.into();
    [x, y, z, roll, pitch, yaw]
}

/// Numbers with commas between, in full precision.
fn listed(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(",")
}

/// The figures of the whole run for its log, with the estimated error of positions (m) if it is known, and that of its start in another log.
pub(crate) fn figures(
    summary: &Summary,
    method: &MethodDescription,
    estimated_error: Option<f64>,
    from_log: Option<&FromLog>,
) -> BTreeMap<String, String> {
    let figures = [
        ("steps", summary.steps.to_string()),
        ("iterations", summary.cost.iterations.to_string()),
        ("rejected_steps", summary.cost.rejected.total().to_string()),
        ("located_attempts", summary.cost.located.to_string()),
        ("energy_initial", summary.initial_energy.total().to_string()),
        ("energy_final", summary.final_energy.total().to_string()),
        ("energy_max_relative_error", summary.max_relative_energy_error.to_string()),
        ("constraint_max_position", summary.max_violation.position.to_string()),
        ("constraint_max_velocity", summary.max_violation.velocity.to_string()),
        ("contact_max_penetration", summary.contact.penetration.to_string()),
        ("contact_max_cone_violation", summary.contact.cone_violation.to_string()),
    ];
    let estimated = estimated_error.map(|error| ("estimated_error", error.to_string()));
    let at_start = from_log.map(|from| (ERROR_AT_START, from.entry()));
    let reasons = summary.cost.rejected.reasons();
    let reasons = reasons.map(|(why, count)| (format!("rejected_{}", why.key()), count.to_string()));
    let figures = figures.into_iter().chain(estimated).chain(at_start).map(|(name, value)| (name.to_string(), value));
    let solvers = method.contact_solvers.used();
    let solvers = solvers.map(|(by, count)| (format!("solved_{}", by.key()), count.to_string()));
    figures.chain(reasons).chain(solvers).collect()
}
