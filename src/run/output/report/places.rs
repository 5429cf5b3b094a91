//! Positions, velocities and reactions of links, joints and loops in a state.

use crate::instant::exerting::reactions::{LoopReaction, Reactions};
use crate::mechanism::description::body_state::BodyState;
use crate::mechanism::description::closure::LoopJoint;
use crate::mechanism::description::joint::wxyz_from_rotation;
use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::motion::event::JointStatus;
use crate::mechanism::motion::gaps::loop_gaps;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::model::{JointRecord, LinkFrame, Model};
use crate::output::report::events::JointStatusReport;
use crate::reduced::Reaction;
use serde::Serialize;

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

/// A joint: positions and velocities in its frame on the parent, and its reaction.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct JointReport {
    /// Position; turns are given as the quaternion w, x, y, z, after the translation.
    pub position: Numbers,
    /// Velocity; the velocity of the child frame's origin before the angular velocity.
    pub velocity: Numbers,
    /// Force of the parent on the child at the joint, in the world (N).
    pub reaction_force: [f64; 3],
    /// Torque of the parent on the child about the joint, in the world [N m].
    pub reaction_torque: [f64; 3],
    /// Limit, friction and motor; only of the end of a run, because a log's samples do not tell.
    #[serde(flatten, skip_serializing_if = "Option::is_none")]
    pub status: Option<JointStatusReport>,
}

/// The reaction of a loop joint at the end of a run.
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

/// Reports by name.
pub type Reports<T> = Vec<(String, T)>;

/// Every link of a model in a state, in the order of the URDF.
pub fn link_reports(model: &Model, state: &State) -> Reports<LinkReport> {
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

/// The efforts of the motors in a state [N m or N]: what the statuses of the bodies' joints say, if there are any, else what their laws give there.
fn motor_efforts(model: &Model, state: &State, statuses: &[JointStatus]) -> Vec<f64> {
    let motors = model.mechanism.nonsmooth.motors.iter();
    let effort = |motor: &Motor| {
        let at = motor.coordinate;
        let known = statuses.get(at.body).and_then(|status| status.effort);
        known.unwrap_or_else(|| motor.effort(state.time, state.position[at.position], state.velocity[at.freedom]))
    };
    motors.map(effort).collect()
}

/// Every joint of a model that moves, in the order of the URDF; a floating base comes first.
/// `statuses` has what the joint of each body is up to, where that is known: the effort of a sampled motor does not follow from the state.
pub fn joint_reports(model: &Model, state: &State, statuses: &[JointStatus]) -> Reports<JointReport> {
    carried_reports(model, state, statuses).0
}

/// The reports of joints and of loop joints, for whose reactions the closures are counted once.
pub fn carried_reports(
    model: &Model,
    state: &State,
    statuses: &[JointStatus],
) -> (Reports<JointReport>, Reports<LoopReport>) {
    let mechanism = &model.mechanism;
    // The joints of floating bases transmit nothing.
    if mechanism.loops.is_empty() && model.joints.iter().all(|record| record.is_base || record.body.is_none()) {
        let nothing = vec![Reaction::default(); mechanism.bodies.len()];
        return (reports_of_joints(model, state, &nothing, statuses), Vec::new());
    }
    let mut carried = Reactions::new(mechanism);
    carried.clock(state.time);
    carried.drive(&motor_efforts(model, state, statuses));
    let (reactions, _) = carried.at(&state.position, &state.velocity);
    let joints = reports_of_joints(model, state, reactions, statuses);
    if mechanism.loops.is_empty() {
        return (joints, Vec::new());
    }
    let bodies = body_states(mechanism, state);
    let (_, reactions) = carried.of_placed(&state.position, &state.velocity, &bodies);
    let loops = reports_of_loops(model, &bodies, reactions);
    (joints, loops)
}

fn reports_of_joints(
    model: &Model,
    state: &State,
    reactions: &[Reaction],
    statuses: &[JointStatus],
) -> Reports<JointReport> {
    let report = |(index, record): (usize, &JointRecord)| {
        let reaction = reactions[record.body?];
        let (position, velocity) = model.joint_user_coordinates(index, &state.position, &state.velocity);
        let report = JointReport {
            position: position.into(),
            velocity: velocity.into(),
            reaction_force: reaction.force.into(),
            reaction_torque: reaction.torque.into(),
            status: statuses.get(record.body?).map(JointStatusReport::from),
        };
        Some((record.name.clone(), report))
    };
    model.joints.iter().enumerate().filter_map(report).collect()
}

fn reports_of_loops(model: &Model, bodies: &[BodyState], reactions: &[LoopReaction]) -> Reports<LoopReport> {
    let report = |(joint, reaction): (&LoopJoint, &LoopReaction)| {
        let report = LoopReport {
            gap: loop_gaps(joint, bodies).largest().0,
            reaction_force: reaction.force.into(),
            reaction_torque: reaction.torque.into(),
        };
        (joint.name.clone(), report)
    };
    model.mechanism.loops.iter().zip(reactions).map(report).collect()
}
