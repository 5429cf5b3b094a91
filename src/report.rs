//! The report of a run: one structure, shown as JSON to scripts and as a few aligned lines to people.
//!
//! The JSON is a promise to other people's scripts; its keys and their order are tested (`tests/cli.rs`). Links and
//! joints are given in the world and in the joint's frame on the parent as [`LinkReport`] and [`JointReport`] say.

use crate::calibration::Calibration;
use crate::closures::loop_gaps;
use crate::islands::{IslandFigures, Plan};
use crate::kinematics::body_states;
use crate::lobatto::assembly::Redundancy;
use crate::model::joint::wxyz_from_rotation;
use crate::model::{JointRecord, LinkFrame, LoopJoint, Model};
use crate::reactions::{LoopReaction, Reactions};
use crate::simulation::{FrequencyStep, MethodDescription, SingularPosition, Summary};
use crate::state::State;
use serde::{Serialize, Serializer};
use std::fmt;
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
    /// Simulated time (s).
    pub duration: f64,
    /// The scheme and its step.
    pub method: MethodReport,
    /// Size of the model.
    pub model: ModelReport,
    /// Accepted steps.
    pub steps: usize,
    /// Iterations of all steps.
    pub iterations: usize,
    /// Steps that were thrown away.
    pub rejected_steps: usize,
    /// Time the run took (s).
    pub wall_seconds: f64,
    /// Processor time the run took (s).
    pub cpu_seconds: f64,
    /// Processor time in the integration loop without logging (s).
    pub solve_cpu_seconds: f64,
    /// The accuracy to expect, when one was asked for.
    pub accuracy: Option<AccuracyReport>,
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
    /// The islands of the mechanism, if there are several; small ones are run together.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub islands: Vec<IslandReport>,
    /// What the user should know about the model and the run.
    pub warnings: Vec<String>,
    /// Where the log is; part of the lines for people alone.
    #[serde(skip)]
    pub log: Option<PathBuf>,
}

/// The scheme of a run.
#[derive(Clone, Debug, Serialize)]
pub struct MethodReport {
    /// Name of the scheme; part of the lines for people alone.
    #[serde(skip)]
    pub name: String,
    /// Number of stages.
    pub stages: usize,
    /// Order of convergence.
    pub order: usize,
    /// The step, or the mean step of an adaptive run (s).
    pub step: f64,
    /// Whether the step is chosen from a tolerance.
    pub adaptive: bool,
    /// The tolerance it is chosen from.
    pub tolerance: Option<f64>,
    /// The nearest that any step came to the limit of linear stability; null where nobody looked, as in a run of a few steps.
    pub max_frequency_step: Option<FrequencyReport>,
    /// How often reversible steps had to be set anew, which turning time round would not repeat; null for other steps.
    pub reversible_resets: Option<usize>,
}

/// How near a step came to the limit of linear stability.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FrequencyReport {
    /// Step times frequency of the fastest mode (rad).
    pub value: f64,
    /// Where the scheme becomes unstable (rad).
    pub limit: f64,
    /// The step (s).
    pub step: f64,
    /// When (s).
    pub time: f64,
}

/// The accuracy to expect of a run, from pilot runs.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct AccuracyReport {
    /// The accuracy asked for (m).
    pub wanted: f64,
    /// The largest error to expect at any instant of the run (m).
    pub estimated: f64,
    /// The instant up to which the wanted accuracy is expected to hold (s).
    pub holds_until: f64,
    /// Whether that is the end of the run.
    pub reached: bool,
    /// Number of pilot runs.
    pub pilots: usize,
}

impl AccuracyReport {
    /// What a calibration found for a run that ends at `end`.
    pub fn new(wanted: f64, end: f64, found: &Calibration) -> Self {
        AccuracyReport {
            wanted,
            estimated: found.estimate,
            holds_until: found.holds_until,
            reached: found.holds_until >= end,
            pilots: found.pilots,
        }
    }

    /// What the calibrations of islands say of the whole, in a run that ends at `end`: nothing if one of them says nothing.
    /// What sleeps is where it should be.
    pub fn together(wanted: f64, end: f64, islands: &[Option<AccuracyReport>]) -> Option<Self> {
        let all: Vec<AccuracyReport> = islands.iter().copied().collect::<Option<_>>()?;
        Some(AccuracyReport {
            wanted,
            estimated: all.iter().map(|one| one.estimated).fold(0.0, f64::max),
            holds_until: all.iter().map(|one| one.holds_until).fold(end, f64::min),
            reached: all.iter().all(|one| one.reached),
            pilots: all.iter().map(|one| one.pilots).sum(),
        })
    }

    /// What the user should know, if the accuracy does not hold to the end.
    pub fn warning(&self) -> Option<String> {
        (!self.reached).then(|| {
            format!(
                "the motion amplifies every error: the accuracy of {:e} m is expected to hold until t = {} s only; after \
                 that the run is one of many possible motions, with the right energy and constraints",
                self.wanted,
                rounded(self.holds_until)
            )
        })
    }
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
    /// Constraints that say what others say already.
    pub redundant_constraints: usize,
    /// Parts that nothing connects and that are simulated apart.
    pub islands: usize,
    /// Those of them that start at rest in equilibrium and are not simulated.
    pub sleeping_islands: usize,
}

/// What became of a part of the mechanism that nothing connects with the rest, or of several small ones together.
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
    /// Largest deviation from the start, but for what was dissipated and put in, relative to the largest kinetic energy
    /// seen.
    pub max_relative_error: f64,
    /// What makes up the energy at the end.
    pub parts: EnergyParts,
    /// Turned into heat by dampers over the run.
    pub dissipated: f64,
    /// Put in by torques without a potential over the run.
    pub work: f64,
}

/// The parts of an energy (J).
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EnergyParts {
    /// Of motion.
    pub kinetic: f64,
    /// Of weights.
    pub gravity: f64,
    /// In springs.
    pub spring: f64,
    /// Of constant forces and efforts.
    pub load: f64,
}

/// Largest constraint violations of the run.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct ConstraintReport {
    /// Of positions [m, rad].
    pub max_position: f64,
    /// Of velocities [m/s, rad/s].
    pub max_velocity: f64,
}

/// A link in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LinkReport {
    /// Origin of the link's frame (m).
    pub position: [f64; 3],
    /// Orientation of the link's frame, as w, x, y, z.
    pub orientation: [f64; 4],
    /// Centre of mass of the link itself (m).
    pub center_of_mass: [f64; 3],
    /// Velocity of the centre of mass [m/s].
    pub linear_velocity: [f64; 3],
    /// Angular velocity [rad/s].
    pub angular_velocity: [f64; 3],
}

/// A joint: positions and velocities in its frame on the parent, and what it transmits.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointReport {
    /// Position; turns are given as the quaternion w, x, y, z, after the translation.
    pub position: Numbers,
    /// Velocity; that of the child frame's origin before the angular velocity.
    pub velocity: Numbers,
    /// Force of the parent on the child at the joint, in the world (N).
    pub reaction_force: [f64; 3],
    /// Torque of the parent on the child about the joint, in the world [N m].
    pub reaction_torque: [f64; 3],
}

/// What a loop joint carries at the end of a run.
#[derive(Clone, Debug, Serialize)]
pub struct LoopReport {
    /// Largest gap between its ends (m, or sine of an angle).
    pub gap: f64,
    /// Force of the first end on the second, in the world (N).
    pub reaction_force: [f64; 3],
    /// Torque of the first end on the second about the point of the second, in the world [N m].
    pub reaction_torque: [f64; 3],
}

/// One number for joints of one degree of freedom, an array for all others.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Numbers {
    /// The only number.
    One(f64),
    /// All numbers.
    Many(Vec<f64>),
}

impl From<Vec<f64>> for Numbers {
    fn from(numbers: Vec<f64>) -> Self {
        match numbers[..] {
            [number] => Numbers::One(number),
            _ => Numbers::Many(numbers),
        }
    }
}

impl MethodReport {
    /// The method as an integrator describes itself.
    pub fn new(description: &MethodDescription) -> Self {
        MethodReport {
            name: description.name.clone(),
            stages: description.stages,
            order: description.order,
            step: description.step,
            adaptive: description.adaptive,
            tolerance: description.tolerance,
            max_frequency_step: description.frequency_step.map(|seen| FrequencyReport {
                value: seen.product,
                limit: seen.limit,
                step: seen.step,
                time: seen.time,
            }),
            reversible_resets: description.reversible_resets,
        }
    }

    /// What the user should know, if a step was beyond the limit of stability.
    pub fn warning(description: &MethodDescription) -> Option<String> {
        let seen = description.frequency_step.filter(FrequencyStep::is_unstable)?;
        Some(format!(
            "a step of {} s is beyond the stability limit of {} at t = {} s, where the fastest motion turns by {} rad in it \
             and {} rad is the limit: fast motions grow without bound; use --step below {} s, more --stages, or --tolerance",
            rounded(seen.step),
            counted(description.stages, "stage"),
            rounded(seen.time),
            rounded(seen.product),
            rounded(seen.limit),
            rounded(seen.longest())
        ))
    }
}

/// What the user should know, if closures said less somewhere in the run than elsewhere.
pub fn singular_warning(description: &MethodDescription) -> Option<String> {
    let SingularPosition { time, extra } = description.singular?;
    let (equations, are) = if extra == 1 { ("constraint", "is") } else { ("constraints", "are") };
    Some(format!(
        "near t = {} s the mechanism passes a singular position, where {extra} more {equations} {are} redundant and inertia alone \
         decides the branch",
        rounded(time)
    ))
}

/// Energy errors beyond this part of the kinetic energy are said to the user: a digit or two are right at best.
pub const COARSE: f64 = 1e-2;

/// What the user should know, if the energy does not balance.
pub fn energy_warning(description: &MethodDescription, relative_error: f64) -> Option<String> {
    // What is not a number does not balance either.
    if relative_error <= COARSE {
        return None;
    }
    let remedy =
        if description.adaptive { "a smaller --tolerance" } else { "a smaller --step, more --stages, or --tolerance" };
    Some(format!(
        "the energy balance is off by {} % of the largest kinetic energy: the steps are too long for this motion; use {remedy}",
        rounded(100.0 * relative_error)
    ))
}

impl EnergyReport {
    /// The energies of a run.
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
            work: summary.exchange.work,
        }
    }
}

impl ConstraintReport {
    /// The constraint violations of a run.
    pub fn new(summary: &Summary) -> Self {
        ConstraintReport { max_position: summary.max_violation.position, max_velocity: summary.max_violation.velocity }
    }
}

impl ModelReport {
    /// The size of a model whose closures have these redundant equations, and that is simulated after this plan.
    pub fn new(model: &Model, redundancy: &Redundancy, plan: &Plan) -> Self {
        ModelReport {
            links: model.links.len(),
            bodies: model.mechanism.bodies.len(),
            joints: model.mechanism.bodies.len(),
            degrees_of_freedom: redundancy.degrees_of_freedom(&model.mechanism),
            loops: model.mechanism.loops.len(),
            redundant_constraints: redundancy.count(),
            islands: plan.islands.len(),
            sleeping_islands: plan.sleeping(),
        }
    }
}

impl IslandReport {
    /// What an island did in a run.
    pub fn new(figures: &IslandFigures) -> Self {
        IslandReport {
            roots: figures.island.roots().map(str::to_string).collect(),
            bodies: figures.island.mechanism.bodies.len(),
            asleep: figures.method.is_none(),
            stages: figures.method.as_ref().map(|method| method.stages),
            step: figures.method.as_ref().map(|method| method.step),
            steps: figures.steps,
            iterations: figures.iterations,
        }
    }
}

/// Every link of a model in a state, in the order of the URDF.
pub fn link_reports(model: &Model, state: &State) -> Vec<(String, LinkReport)> {
    let bodies = body_states(&model.mechanism, state);
    let report = |(index, link): (usize, &LinkFrame)| {
        let link_state = model.link_state(&bodies, index);
        let report = LinkReport {
            position: link_state.position.into(),
            orientation: wxyz_from_rotation(&link_state.rotation),
            center_of_mass: link_state.center_of_mass.into(),
            linear_velocity: link_state.linear_velocity.into(),
            angular_velocity: link_state.angular_velocity.into(),
        };
        (link.name.clone(), report)
    };
    model.links.iter().enumerate().map(report).collect()
}

/// Every joint of a model that moves, in the order of the URDF; a floating base comes first.
pub fn joint_reports(model: &Model, state: &State) -> Vec<(String, JointReport)> {
    let mechanism = &model.mechanism;
    let mut carried = Reactions::new(mechanism);
    let (reactions, _) = carried.at(&state.position, &state.velocity);
    let report = |(index, record): (usize, &JointRecord)| {
        let reaction = reactions[record.body?];
        let (position, velocity) = model.joint_user_coordinates(index, &state.position, &state.velocity);
        let report = JointReport {
            position: position.into(),
            velocity: velocity.into(),
            reaction_force: reaction.force.into(),
            reaction_torque: reaction.torque.into(),
        };
        Some((record.name.clone(), report))
    };
    model.joints.iter().enumerate().filter_map(report).collect()
}

/// Every loop joint of a model.
pub fn loop_reports(model: &Model, state: &State) -> Vec<(String, LoopReport)> {
    let mechanism = &model.mechanism;
    if mechanism.loops.is_empty() {
        return Vec::new();
    }
    let bodies = body_states(mechanism, state);
    let mut carried = Reactions::new(mechanism);
    let (_, reactions) = carried.of_placed(&state.position, &state.velocity, &bodies);
    let report = |(joint, reaction): (&LoopJoint, &LoopReaction)| {
        let report = LoopReport {
            gap: loop_gaps(joint, &bodies).largest().0,
            reaction_force: reaction.force.into(),
            reaction_torque: reaction.torque.into(),
        };
        (joint.name.clone(), report)
    };
    mechanism.loops.iter().zip(reactions).map(report).collect()
}

/// Serializes pairs as the entries of an object, in their order.
///
/// # Errors
/// Those of the serializer.
pub fn as_object<T: Serialize, S: Serializer>(pairs: &[(String, T)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(pairs.iter().map(|(name, value)| (name, value)))
}

/// More warnings than this are only counted in the lines for people.
const SHOWN_WARNINGS: usize = 10;

impl fmt::Display for Report {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let speed = if self.wall_seconds > 0.0 { self.duration / self.wall_seconds } else { f64::INFINITY };
        writeln!(
            out,
            "{}: {} s simulated in {:.3} s, {} times real time",
            self.scene,
            // Sums of steps carry roundings that nobody wants to read.
            (self.duration * 1e6).round() / 1e6,
            self.wall_seconds,
            rounded(speed)
        )?;
        let model = &self.model;
        write!(
            out,
            "  model       {}, {}, {}",
            counted(model.links, "link"),
            counted(model.bodies, "moving body"),
            counted(model.degrees_of_freedom, "degree of freedom")
        )?;
        match (model.loops, model.redundant_constraints) {
            (0, _) => writeln!(out)?,
            (loops, redundant) => {
                writeln!(out, ", {}, {}", counted(loops, "loop"), counted(redundant, "redundant constraint"))?;
            }
        }
        match (model.islands, model.sleeping_islands) {
            (0 | 1, 0) => {}
            (1, _) => writeln!(out, "  islands     at rest in equilibrium: not simulated")?,
            (islands, 0) => writeln!(out, "  islands     {islands}")?,
            (islands, all) if islands == all => {
                writeln!(out, "  islands     {islands}, all at rest in equilibrium: not simulated")?
            }
            (islands, asleep) => {
                writeln!(out, "  islands     {islands}, of which {asleep} at rest in equilibrium: not simulated")?;
            }
        }
        let method = &self.method;
        write!(out, "  method      {}, {}, order {}, ", method.name, counted(method.stages, "stage"), method.order)?;
        let step = rounded(1e3 * method.step);
        match (method.tolerance, method.reversible_resets) {
            (Some(tolerance), _) => writeln!(out, "tolerance {tolerance:e}, mean step {step} ms")?,
            (None, Some(resets)) => {
                writeln!(out, "reversible steps, mean {step} ms, {}", counted(resets, "reset"))?;
            }
            (None, None) => writeln!(out, "step {step} ms")?,
        }
        if let Some(accuracy) = &self.accuracy {
            writeln!(
                out,
                "  accuracy    {:.1e} m expected at worst, from {} pilot runs",
                accuracy.estimated, accuracy.pilots
            )?;
        }
        write!(out, "  steps       {}, {}", self.steps, counted(self.iterations, "iteration"))?;
        if self.steps > 0 {
            write!(out, " ({:.1} a step)", self.iterations as f64 / self.steps as f64)?;
        }
        writeln!(out, ", {} rejected", self.rejected_steps)?;
        writeln!(
            out,
            "  energy      {:.6} J at the start, largest relative error {:.1e}",
            self.energy.initial, self.energy.max_relative_error
        )?;
        let energy = &self.energy;
        if energy.dissipated != 0.0 || energy.work != 0.0 {
            writeln!(
                out,
                "              {} J dissipated, {} J put in, {} J left in springs",
                rounded(energy.dissipated),
                rounded(energy.work),
                rounded(energy.parts.spring)
            )?;
        }
        writeln!(
            out,
            "  constraint  largest violation {:.1e} m, {:.1e} m/s",
            self.constraint.max_position, self.constraint.max_velocity
        )?;
        if let Some(log) = &self.log {
            writeln!(out, "  log         {}", log.display())?;
        }
        for warning in self.warnings.iter().take(SHOWN_WARNINGS) {
            writeln!(out, "  warning     {warning}")?;
        }
        if self.warnings.len() > SHOWN_WARNINGS {
            writeln!(out, "  warning     and {} more", self.warnings.len() - SHOWN_WARNINGS)?;
        }
        Ok(())
    }
}

/// Three significant digits.
fn rounded(value: f64) -> String {
    if !value.is_finite() || value == 0.0 {
        return value.to_string();
    }
    let digits_before_point = value.abs().log10().floor() as i32;
    match digits_before_point {
        -4..=5 => format!("{value:.*}", (2 - digits_before_point).max(0) as usize),
        _ => format!("{value:.2e}"),
    }
}

/// A number and its noun, in the plural where that is due.
fn counted(count: usize, noun: &str) -> String {
    match (count, noun) {
        (1, _) => format!("1 {noun}"),
        (_, "moving body") => format!("{count} moving bodies"),
        (_, "degree of freedom") => format!("{count} degrees of freedom"),
        _ => format!("{count} {noun}s"),
    }
}

#[cfg(test)]
mod tests {
    use super::{counted, rounded};

    #[test]
    fn numbers_for_people_have_three_digits_and_nouns_agree() {
        assert_eq!([833.33, 0.012345, 1e9].map(rounded), ["833", "0.0123", "1.00e9"]);
        assert_eq!(counted(1, "stage"), "1 stage");
        assert_eq!(counted(2, "moving body"), "2 moving bodies");
    }
}
