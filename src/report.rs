//! The report of a run: one structure, shown as JSON to scripts and as a few aligned lines to people.
//!
//! The JSON is a promise to other people's scripts; its keys and their order are tested (`tests/cli.rs`). Links and
//! joints are given in the world and in the joint's frame on the parent as [`LinkReport`] and [`JointReport`] say.

use crate::kinematics::joint_rates;
use crate::log::LinkFrame;
use crate::model::joint::wxyz_from_rotation;
use crate::model::{FreeRotation, Joint, Mechanism};
use crate::reduced::{Reaction, ReducedOde, joint_reactions};
use crate::simulation::{MethodDescription, Summary};
use crate::state::{BodyState, State};
use nalgebra::Vector3;
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
    /// Simulated time [s].
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
    /// Time the run took [s].
    pub wall_seconds: f64,
    /// Processor time the run took [s].
    pub cpu_seconds: f64,
    /// Processor time in the integration loop without logging [s].
    pub solve_cpu_seconds: f64,
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
    /// The step, or the mean step of an adaptive run [s].
    pub step: f64,
    /// Whether the step is chosen from a tolerance.
    pub adaptive: bool,
    /// The tolerance it is chosen from.
    pub tolerance: Option<f64>,
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
}

/// Energy [J] at both ends and its error in between.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct EnergyReport {
    /// Total energy at the start.
    pub initial: f64,
    /// Total energy at the end.
    pub r#final: f64,
    /// Largest deviation from the start, relative to the largest kinetic energy seen.
    pub max_relative_error: f64,
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
    /// Origin of the link's frame [m].
    pub position: [f64; 3],
    /// Orientation of the link's frame, as w, x, y, z.
    pub orientation: [f64; 4],
    /// Centre of mass of the link itself [m].
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
    /// Force of the parent on the child at the joint, in the world [N].
    pub reaction_force: [f64; 3],
    /// Torque of the parent on the child about the joint, in the world [N m].
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
        }
    }
}

impl EnergyReport {
    /// The energies of a run.
    pub fn new(summary: &Summary) -> Self {
        EnergyReport {
            initial: summary.initial_energy.total(),
            r#final: summary.final_energy.total(),
            max_relative_error: summary.max_relative_energy_error,
        }
    }
}

impl ConstraintReport {
    /// The constraint violations of a run.
    pub fn new(summary: &Summary) -> Self {
        ConstraintReport { max_position: summary.max_violation.position, max_velocity: summary.max_violation.velocity }
    }
}

impl LinkReport {
    /// A link whose frame is at `frame` in its body, with the centre of mass at `center_of_mass` in the link's frame.
    pub fn new(frame: &LinkFrame, center_of_mass: &Vector3<f64>, bodies: &[BodyState]) -> Self {
        let body = frame.body.map_or(crate::kinematics::WORLD, |body| bodies[body]);
        let rotation = body.rotation * frame.pose.rotation.matrix();
        let position = body.position + body.rotation * frame.pose.translation.vector;
        let center_of_mass = position + rotation * center_of_mass;
        let arm = center_of_mass - body.position;
        LinkReport {
            position: position.into(),
            orientation: wxyz_from_rotation(&rotation),
            center_of_mass: center_of_mass.into(),
            linear_velocity: (body.velocity + body.angular_velocity.cross(&arm)).into(),
            angular_velocity: body.angular_velocity.into(),
        }
    }
}

impl JointReport {
    /// One joint of a state.
    pub fn new(joint: &Joint, state: &State, reaction: &Reaction) -> Self {
        let position = &state.position[joint.position_range()];
        let velocity = &state.velocity[joint.velocity_range()];
        let mut reported_velocity = velocity.to_vec();
        if joint.kind.rotation() == FreeRotation::Ball {
            // The state has the angular velocity in the joint frame on the child.
            let (_, turned) = joint.displacement(position);
            let (_, angular) = joint_rates(joint, velocity);
            let first = joint.kind.translation_axes().len();
            reported_velocity[first..].copy_from_slice((turned * angular).as_slice());
        }
        JointReport {
            position: position.to_vec().into(),
            velocity: reported_velocity.into(),
            reaction_force: reaction.force.into(),
            reaction_torque: reaction.torque.into(),
        }
    }
}

/// Every joint of a mechanism, in the order of its bodies.
pub fn joint_reports(mechanism: &Mechanism, state: &State) -> Vec<(String, JointReport)> {
    let mut accelerations = vec![0.0; mechanism.velocity_count];
    ReducedOde::new(mechanism).accelerations(&state.position, &state.velocity, &mut accelerations);
    let reactions = joint_reactions(mechanism, &state.position, &state.velocity, &accelerations);
    let joints = mechanism.bodies.iter().map(|body| &body.joint);
    let report = |(joint, reaction): (&Joint, _)| (joint.name.clone(), JointReport::new(joint, state, &reaction));
    joints.zip(reactions).map(report).collect()
}

/// Serializes pairs as the entries of an object, in their order.
fn as_object<T: Serialize, S: Serializer>(pairs: &[(String, T)], serializer: S) -> Result<S::Ok, S::Error> {
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
            self.duration,
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
        let method = &self.method;
        write!(out, "  method      {}, {}, order {}, ", method.name, counted(method.stages, "stage"), method.order)?;
        match method.tolerance {
            Some(tolerance) => writeln!(out, "tolerance {tolerance:e}, mean step {} ms", rounded(1e3 * method.step))?,
            None => writeln!(out, "step {} ms", rounded(1e3 * method.step))?,
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
    use super::{counted, joint_reports, rounded};
    use crate::model::{Body, Joint, JointKind, Mechanism, Pose};
    use crate::state::{State, quaternion_exponential};
    use nalgebra::{Translation3, Vector3};

    /// The state has ω in the child's frame, the report promises the joint's frame on the parent.
    #[test]
    fn angular_velocity_of_floating_joints_is_in_the_frame_on_the_parent() {
        let joint = Joint::new("base", JointKind::Floating, Translation3::new(1.0, 2.0, 3.0).into(), Pose::identity());
        let body = Body { name: "b".into(), parent: None, mass: 1.0, inertia: Vector3::repeat(1.0), joint };
        let mechanism = Mechanism::new("m", Vector3::zeros(), vec![body]).expect("one body is a tree");
        let mut state = State::zero(&mechanism);
        let quarter = std::f64::consts::FRAC_PI_2;
        state.position[3..7].copy_from_slice(&quaternion_exponential(&[0.0, 0.0, quarter]));
        state.velocity.copy_from_slice(&[4.0, 5.0, 6.0, 1.0, 0.0, 0.5]);
        let reports = joint_reports(&mechanism, &state);
        let super::Numbers::Many(velocity) = &reports[0].1.velocity else { panic!("six numbers") };
        for (got, expected) in velocity.iter().zip([4.0, 5.0, 6.0, 0.0, 1.0, 0.5]) {
            assert!((got - expected).abs() < 1e-15, "{velocity:?}");
        }
    }

    #[test]
    fn numbers_for_people_have_three_digits_and_nouns_agree() {
        assert_eq!([833.33, 0.012345, 1e9].map(rounded), ["833", "0.0123", "1.00e9"]);
        assert_eq!(counted(1, "stage"), "1 stage");
        assert_eq!(counted(2, "moving body"), "2 moving bodies");
    }
}
