//! The report of a run: one structure, shown as JSON to scripts and as a few aligned lines to people (`text`).
//!
//! The JSON is a promise to other people's scripts; its keys and their order are tested (`tests/program/cli/report.rs`). Links and
//! joints are given in the world and in the joint's frame on the parent as [`LinkReport`] and [`JointReport`] say.

mod accuracy;
mod contact;
mod events;
mod from_log;
mod method;
mod places;
mod rejected;
mod rounding;
mod solvers;
mod speeds;
mod step_error;
mod text;

pub use accuracy::{AccuracyReport, Horizon, NoAccuracyReport};
pub use contact::{ContactReport, ContactsReport};
#[cfg(feature = "log")]
pub(crate) use contact::{contact_words, state_name};
pub(crate) use contact::{pair_count, pair_name, pair_names};
#[cfg(feature = "log")]
pub(crate) use events::joint_name;
pub use events::{EventEntry, EventReport, JointStatusReport, KindCounts};
pub use from_log::{ERROR_AT_START, FromLog, UNKNOWN};
pub use method::{CrowdReport, FrequencyReport, MethodReport, OverSlipsReport};
pub(crate) use method::{ringing_warning, singular_warning, unsolved_warning};
pub use places::joint_reports;
pub use places::{JointReport, LinkReport, LoopReport, Numbers};
pub use places::{carried_reports, link_reports};
pub use rejected::RejectedReport;
pub use rounding::energy_warning;
pub(crate) use rounding::{FarSpring, balance_warning};
pub use solvers::SolversReport;
pub use speeds::SpeedWatch;
pub use step_error::StepErrorReport;

use crate::instant::start::assembly::Redundancy;
use crate::model::Model;
use crate::simulation::Summary;
use crate::simulation::parallel::islands::IslandFigures;
use serde::{Serialize, Serializer};
use std::path::PathBuf;

/// Everything `catena simulate` has to say about a run.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// Version of catena.
    pub catena: &'static str,
    /// The input as it was given.
    pub input: String,
    /// Name of the robot or scene.
    pub scene: String,
    /// The time at the start (s): zero, but for runs that go on from a log.
    pub start: f64,
    /// The time at the end (s), from a start at zero the simulated time.
    pub duration: f64,
    /// The scheme and its step.
    pub method: MethodReport,
    /// Size of the model.
    pub model: ModelReport,
    /// Accepted steps.
    pub steps: usize,
    /// Iterations of all steps.
    pub iterations: usize,
    /// The number of them that kept the factors of the articulated inertias of an earlier one ([`crate::lobatto::solve::kept_factors`]).
    pub kept_factor_iterations: usize,
    /// Attempts at steps that were thrown away.
    pub rejected_steps: usize,
    /// The same by reason.
    pub rejected: RejectedReport,
    /// Attempts at steps with another length, which ends them at an event.
    pub located_attempts: usize,
    /// Accepted steps whose equations needed the exact Newton method: all with closed loops, few without.
    pub exact_newton_steps: usize,
    /// Time the run took (s).
    pub wall_seconds: f64,
    /// Processor time the run took (s).
    pub cpu_seconds: f64,
    /// Processor time in the integration loop without logging (s).
    pub solve_cpu_seconds: f64,
    /// The start in a log, if the run goes on from one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from_log: Option<FromLog>,
    /// The accuracy to expect,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracyReport>,
    /// or why it is not known, under the same key in JSON.
    #[serde(rename = "accuracy", skip_serializing_if = "Option::is_none")]
    pub no_accuracy: Option<NoAccuracyReport>,
    /// The estimated error of fixed steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub step_error: Option<StepErrorReport>,
    /// The events of the motion.
    pub events: EventReport,
    /// The contacts.
    pub contact: ContactsReport,
    /// Energy over the run.
    pub energy: EnergyReport,
    /// Constraint violation over the run.
    pub constraint: ConstraintReport,
    /// Every link at the end of the run.
    #[serde(serialize_with = "as_object")]
    pub links: Vec<(String, LinkReport)>,
    /// Every moving joint at the end of the run.
    #[serde(serialize_with = "as_object")]
    pub joints: Vec<(String, JointReport)>,
    /// Every loop joint at the end of the run.
    #[serde(serialize_with = "as_object", skip_serializing_if = "Vec::is_empty")]
    pub loops: Vec<(String, LoopReport)>,
    /// The islands of the mechanism, if there are several; small ones are run together. Of groups that form and fall apart, those at the end.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub islands: Vec<IslandReport>,
    /// Warnings about the model and the run.
    pub warnings: Vec<String>,
    /// The path of the log; part of the lines for people alone.
    #[serde(skip)]
    pub log: Option<PathBuf>,
}

/// The size of a model.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct ModelReport {
    /// Links of the input.
    pub links: usize,
    /// Moving bodies they form.
    pub bodies: usize,
    /// Joints that move.
    pub joints: usize,
    /// Degrees of freedom.
    pub degrees_of_freedom: usize,
    /// Joints that close loops.
    pub loops: usize,
    /// Constraints that repeat others.
    pub redundant_constraints: usize,
    /// Unconnected parts that are simulated apart.
    pub islands: usize,
    /// The number of them that start at rest in equilibrium and are not simulated.
    pub sleeping_islands: usize,
    /// The shapes that were turned onto the axes of their joints.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub wheels: Option<WheelsReport>,
}

/// Shapes that turn about the axes of their joints exactly, and not about those that the files give them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct WheelsReport {
    /// How many there are.
    pub shapes: usize,
    /// The largest angle by which one was turned (rad).
    pub angle: f64,
    /// The most that a point of a surface was moved (m).
    pub moved: f64,
}

impl WheelsReport {
    /// Those of a model, if it has any.
    fn of(model: &Model) -> Option<Self> {
        let wheels = &model.contact.wheels;
        let most = wheels.iter().fold(WheelsReport::default(), |most, wheel| WheelsReport {
            shapes: most.shapes + 1,
            angle: most.angle.max(wheel.angle),
            moved: most.moved.max(wheel.moved),
        });
        (most.shapes > 0).then_some(most)
    }
}

/// The result of a part of the mechanism that is not connected with the rest, or of several small ones together.
#[derive(Clone, Debug, Serialize)]
pub struct IslandReport {
    /// The bodies of it that hang on the world.
    pub roots: Vec<String>,
    /// Its bodies.
    pub bodies: usize,
    /// Whether it started at rest in equilibrium and was not simulated.
    pub asleep: bool,
    /// Number of stages; null if it slept.
    pub stages: Option<usize>,
    /// Its step, or mean step (s); null if it slept.
    pub step: Option<f64>,
    /// Accepted steps.
    pub steps: usize,
    /// Iterations of all steps.
    pub iterations: usize,
}

/// Energy (J) at both ends and its error in between.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EnergyReport {
    /// Total energy at the start.
    pub initial: f64,
    /// Total energy at the end.
    pub r#final: f64,
    /// Largest deviation from the start, but for energy that was dissipated, lost to friction and impacts, and put in, relative to the largest
    /// kinetic energy seen.
    pub max_relative_error: f64,
    /// The parts of the energy at the end.
    pub parts: EnergyParts,
    /// Turned into heat by dampers over the run.
    pub dissipated: f64,
    /// Turned into heat by dry friction over the run.
    pub friction: f64,
    /// Lost in impacts over the run.
    pub impacts: f64,
    /// Put in by motors and by loads without a potential over the run.
    pub work: f64,
}

/// The parts of an energy (J).
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EnergyParts {
    /// Energy of motion.
    pub kinetic: f64,
    /// Energy of weights.
    pub gravity: f64,
    /// In springs.
    pub spring: f64,
    /// Energy of constant forces and efforts.
    pub load: f64,
}

/// Largest constraint violations of the run.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ConstraintReport {
    /// Largest error of positions [m, rad].
    pub max_position: f64,
    /// Largest error of velocities [m/s, rad/s].
    pub max_velocity: f64,
}

impl EnergyReport {
    /// The energies of a run.
    #[doc(hidden)]
    pub fn new(summary: &Summary) -> Self {
        EnergyReport {
            initial: summary.initial_energy.total(),
            r#final: summary.final_energy.total(),
            max_relative_error: summary.max_relative_energy_error,
            parts: EnergyParts {
                kinetic: summary.final_energy.kinetic,
                gravity: summary.final_energy.potential,
                spring: summary.final_energy.spring,
                load: summary.final_energy.load,
            },
            dissipated: summary.exchange.dissipated,
            friction: summary.exchange.friction,
            impacts: summary.exchange.impacts,
            work: summary.exchange.work,
        }
    }
}

impl ConstraintReport {
    /// The constraint violations of a run.
    #[doc(hidden)]
    pub fn new(summary: &Summary) -> Self {
        ConstraintReport { max_position: summary.max_violation.position, max_velocity: summary.max_violation.velocity }
    }
}

impl ModelReport {
    /// The size of a model with the redundant equations of its closures, its number of islands, and the number of sleeping islands.
    #[doc(hidden)]
    pub fn new(model: &Model, redundancy: &Redundancy, (islands, sleeping_islands): (usize, usize)) -> Self {
        ModelReport {
            links: model.links.len(),
            bodies: model.mechanism.bodies.len(),
            joints: model.mechanism.bodies.len(),
            degrees_of_freedom: redundancy.degrees_of_freedom(&model.mechanism),
            loops: model.mechanism.loops.len(),
            redundant_constraints: redundancy.count(),
            islands,
            sleeping_islands,
            wheels: WheelsReport::of(model),
        }
    }
}

impl IslandReport {
    /// The report of an island.
    pub(crate) fn new(figures: &IslandFigures) -> Self {
        IslandReport {
            roots: figures.roots.clone(),
            bodies: figures.bodies,
            asleep: figures.method.is_none(),
            stages: figures.method.as_ref().map(|method| method.stages),
            step: figures.method.as_ref().map(|method| method.step),
            steps: figures.steps,
            iterations: figures.iterations,
        }
    }
}

/// Serializes pairs as the entries of an object, in their order.
///
/// # Errors
/// The errors of the serializer.
pub fn as_object<T: Serialize, S: Serializer>(pairs: &[(String, T)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(pairs.iter().map(|(name, value)| (name, value)))
}
