//! The log of a run: what it says about how the run was made, and how it is completed, whatever ended the run.

use crate::cli::Failure;
use anyhow::anyhow;
use catena::mechanism::description::joint::Pose;
use catena::mechanism::motion::integrator::MethodDescription;
use catena::model::{Model, PlacedRobot};
use catena::output::log::{Ending, LogError, Outcome, Recorder, Severity};
use catena::simulation::{RunError, StepChoice, Summary};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What the log says about how the run was made.
pub fn description(
    model: &Model,
    duration: f64,
    rate: f64,
    choice: StepChoice,
    method: MethodDescription,
) -> BTreeMap<String, String> {
    let said = |number: Option<f64>| number.map_or(String::new(), |number| number.to_string());
    let command_line: Vec<String> =
        std::env::args_os().map(|argument| argument.to_string_lossy().into_owned()).collect();
    // Word by word, which the command line as people read it does not tell.
    let arguments = serde_json::Value::from(command_line.get(1..).unwrap_or_default().to_vec());
    // Of several robots, one after the other.
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
        ("command_line", command_line.join(" ")),
        ("arguments", arguments.to_string()),
    ];
    entries.into_iter().map(|(name, value)| (name.to_string(), value)).collect()
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

/// Completes the log, whatever ended the run, and says how the run ended and where the log is.
pub fn finish(
    recorder: Option<Recorder>,
    ended: Result<(), RunError>,
    summary: &Summary,
    estimated_error: Option<f64>,
    output: Option<&Path>,
) -> (Result<(), Failure>, Option<PathBuf>) {
    let outcome = match &ended {
        Ok(()) => Outcome::Finished,
        Err(RunError::Interrupted { .. }) => Outcome::Interrupted,
        Err(_) => Outcome::Failed,
    };
    let ended = ended.map_err(|error| match error {
        RunError::Interrupted { .. } => Failure::interrupted(error),
        RunError::Step(_) => Failure::run(error),
        RunError::Observer(source) if matches!(source.downcast_ref(), Some(LogError::Blocked { .. })) => {
            Failure::interrupted(anyhow!(source))
        }
        RunError::Observer(source) => Failure::run(anyhow!(source)),
    });
    let (Some(mut recorder), Some(output)) = (recorder, output) else { return (ended, None) };
    match &ended {
        Err(failure) => recorder.say(Severity::Error, &format!("{:#}", failure.error)),
        Ok(()) => recorder.say(Severity::Info, "the run has reached its end"),
    }
    let beside = recorder.beside().map(Path::to_path_buf);
    let written = recorder.finish(Ending { outcome, figures: figures(summary, estimated_error) }).map_err(log_failure);
    match ended.and(written) {
        Ok(_) => (Ok(()), Some(output.to_path_buf())),
        // Of two errors the first is the cause.
        Err(mut failure) => {
            if let Some(beside) = &beside {
                let (output, beside) = (output.display(), beside.display());
                failure.error = anyhow!("{:#}; {output} is as it was, the log of this run is {beside}", failure.error);
            }
            (Err(failure), Some(beside.unwrap_or_else(|| output.to_path_buf())))
        }
    }
}

/// The figures of the whole run, as the log keeps them; with the error that is expected of positions (m), where that is known.
fn figures(summary: &Summary, estimated_error: Option<f64>) -> BTreeMap<String, String> {
    let figures = [
        ("steps", summary.steps.to_string()),
        ("iterations", summary.iterations.to_string()),
        ("rejected_steps", summary.rejected_steps.to_string()),
        ("energy_initial", summary.initial_energy.total().to_string()),
        ("energy_final", summary.final_energy.total().to_string()),
        ("energy_max_relative_error", summary.max_relative_energy_error.to_string()),
        ("constraint_max_position", summary.max_violation.position.to_string()),
        ("constraint_max_velocity", summary.max_violation.velocity.to_string()),
    ];
    let estimated = estimated_error.map(|error| ("estimated_error", error.to_string()));
    figures.into_iter().chain(estimated).map(|(name, value)| (name.to_string(), value)).collect()
}

/// Who is to blame for a log that cannot be written: the command line, or the disk.
pub fn log_failure(error: LogError) -> Failure {
    match error {
        LogError::Create { .. } | LogError::Busy { .. } => Failure::input(error),
        LogError::Blocked { .. } => Failure::interrupted(error),
        LogError::Write { .. } => Failure::run(error),
    }
}
