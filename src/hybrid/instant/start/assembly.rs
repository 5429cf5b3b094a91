//! The start of a run: positions and velocities that satisfy all loops, and how many of their equations are redundant.
//!
//! Initial conditions need only be near. They are projected on the closures with the least motion in the metric of the mass
//! matrix ([`crate::lobatto::coupled::projection`]) before t = 0: a defect left in them would stay in the multipliers for the whole run
//! as defect/h.

use crate::instant::holding::locked::Locked;
use crate::instant::start::apart::{Reach, without_overlap};
use crate::instant::start::assembly_elsewhere::close_elsewhere;
use crate::instant::start::limits::{close_within, excess, most_exceeded, move_within, within};
use crate::lobatto::coupled::counted::Counted;
use crate::lobatto::coupled::deciding::{Decided, known_of_steps};
use crate::lobatto::coupled::known::Known;
use crate::lobatto::coupled::projection::{Projected, Projection};
use crate::lobatto::stages::start::Start;
use crate::mechanism::description::closure::JointLimit;
use crate::mechanism::description::contact::Shape;
use crate::mechanism::description::contact_pairs::ContactPairs;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::gaps::loop_gaps;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use std::sync::Arc;

/// A gap that the projection leaves larger than this [m, rad] is a mechanism that does not close.
const OPEN: f64 = 1e-9;
/// Rates that the projection leaves larger than this, of the largest rate, contradict each other.
const CONTRADICTION: f64 = 1e-7;

/// A position this far beyond its limit [rad, m] is at it where limits only choose how loops are closed: they are written with few digits.
const AT_LIMIT: f64 = 1e-6;
/// The same where limits stop the motion: what closing loops leaves.
const ON_LIMIT: f64 = 1e-9;

/// Velocities below this [m/s, rad/s] decide no branch.
const AT_REST: f64 = 1e-9;

/// The changes that the projection of the start made.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Correction {
    /// Largest change of a number of the joint positions [m, rad, or of a quaternion].
    pub position: f64,
    /// Largest change of a joint velocity [m/s or rad/s].
    pub velocity: f64,
    /// The pair of shapes that overlapped most, by its number, and by how much (m), where any did.
    pub overlap: Option<(usize, f64)>,
}

/// The redundant equations of the closures at a configuration.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Redundancy {
    /// Number of equations of all closures.
    pub equations: usize,
    /// Closures with equations that the others imply, and how many.
    pub redundant: Vec<(String, usize)>,
}

impl Redundancy {
    /// Number of redundant equations.
    pub fn count(&self) -> usize {
        self.redundant.iter().map(|(_, count)| count).sum()
    }

    /// Degrees of freedom of the tree that the closures leave.
    pub fn degrees_of_freedom(&self, mechanism: &Mechanism) -> usize {
        (mechanism.velocity_count + self.count()).saturating_sub(self.equations)
    }
}

/// Why a mechanism cannot start.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AssemblyError {
    /// The loops do not close anywhere near.
    #[error(
        "loop {closure:?} cannot be closed: a gap of {gap:.3e} (m or rad) remains between its ends; move the initial joint positions \
         nearer to where it closes, or check its frames"
    )]
    Open { closure: String, gap: f64 },
    /// The loops close, but only beyond the limits of joints.
    #[error(
        "loop {closure:?} cannot be closed within the limits of the joints: a gap of {gap:.3e} (m or rad) remains between its \
         ends, or joint {joint:?} is {excess:.3e} {unit} outside its limits; move the initial joint positions, or widen the limits"
    )]
    Limited { closure: String, gap: f64, joint: String, excess: f64, unit: &'static str },
    /// A joint cannot be moved within its limits.
    #[error(
        "joint {joint:?} starts {excess:.3e} {unit} outside its limits, and moving it in fails; give it an initial position inside"
    )]
    Outside { joint: String, excess: f64, unit: &'static str },
    /// Shapes start inside each other, or a rope is too short, and they cannot be moved apart.
    #[error("{words}, and moving them apart fails; {advice}")]
    Overlap { words: String, advice: String },
    /// At rest in a singular position.
    #[error(
        "the mechanism starts at rest in a singular position, where its loops leave {extra} more degrees of freedom than near it: \
         its direction of motion is not determined; give an initial velocity, or start it elsewhere"
    )]
    Undecided { extra: usize },
    /// The closures allow no velocity at all like the initial one.
    #[error(
        "the initial velocities contradict loop {closure:?}: its ends would separate with {rate:.3e} (m/s or rad/s); give \
         velocities that the loops allow"
    )]
    Contradiction { closure: String, rate: f64 },
}

/// The name of a closure: the loops first, then the mimics.
pub fn closure_name(mechanism: &Mechanism, closure: usize) -> &str {
    match mechanism.loops.get(closure) {
        Some(joint) => &joint.name,
        None => mechanism.mimics.get(closure - mechanism.loops.len()).map_or("", |mimic| &mimic.name),
    }
}

/// Moves a state within the limits that are simulated, onto all closures and out of all overlaps, positions first, by the least motion in the metric
/// of the mass matrix. Velocities are changed only as far as the closures require: a joint that starts on a limit and moves out of it has an impact
/// at once.
///
/// # Errors
/// [`AssemblyError`] with the closure that stays open or the joint that stays outside; the state is then where the projection gave up.
pub fn assemble(mechanism: &Mechanism, state: &mut State) -> Result<Correction, AssemblyError> {
    assemble_counted(mechanism, state).map(|(correction, _)| correction)
}

/// The same, with the count of the closures in the assembled state, if there are any.
///
/// # Errors
/// As of [`assemble`].
pub fn assemble_counted(
    mechanism: &Mechanism,
    state: &mut State,
) -> Result<(Correction, Option<Arc<Counted>>), AssemblyError> {
    assemble_within(mechanism, state, Reach::Beside)
}

/// Moves the end of a step onto all closures and within limits, and out of overlaps as far as small motions do that.
///
/// # Errors
/// As of [`assemble`].
pub(crate) fn assemble_nearby(mechanism: &Mechanism, state: &mut State) -> Result<(), AssemblyError> {
    assemble_within(mechanism, state, Reach::Nearby).map(|_| ())
}

fn assemble_within(
    mechanism: &Mechanism,
    state: &mut State,
    reach: Reach,
) -> Result<(Correction, Option<Arc<Counted>>), AssemblyError> {
    match Locked::of(mechanism) {
        Some(locked) => assemble_in_place(&locked, locked.mechanism(), mechanism, state, reach),
        None => assemble_moving(mechanism, state, reach),
    }
}

/// Moves a state onto all closures, as [`assemble`] does, past limits and through other shapes: how an assembled start within them follows its
/// numbers.
///
/// # Errors
/// As of [`assemble`].
pub fn assemble_on_closures(mechanism: &Mechanism, state: &mut State) -> Result<(), AssemblyError> {
    let unbounded = |mechanism: &Mechanism| {
        let mut own = mechanism.clone();
        own.limits.clear();
        own.nonsmooth.limits.clear();
        own.nonsmooth.pairs = ContactPairs::default();
        own
    };
    match Locked::of(mechanism) {
        Some(locked) => assemble_in_place(&locked, &unbounded(locked.mechanism()), mechanism, state, Reach::Beside),
        None => assemble_moving(&unbounded(mechanism), state, Reach::Beside),
    }
    .map(|_| ())
}

/// Assembles a mechanism without its locked joints, which are put in their places, at rest; `moving` is what moves.
fn assemble_in_place(
    locked: &Locked,
    moving: &Mechanism,
    mechanism: &Mechanism,
    state: &mut State,
    reach: Reach,
) -> Result<(Correction, Option<Arc<Counted>>), AssemblyError> {
    let wanted = state.clone();
    let mut own = State::zero(moving);
    locked.gather(mechanism, state, &mut own);
    let assembled = assemble_moving(moving, &mut own, reach);
    locked.spread(mechanism, &own, state);
    let (mut correction, _) = assembled?;
    // Closures between locked joints are not among those that were closed.
    let bodies = body_states(mechanism, state);
    for joint in &mechanism.loops {
        let (gap, _) = loop_gaps(joint, &bodies).largest();
        if gap.is_nan() || gap > OPEN {
            return Err(AssemblyError::Open { closure: joint.name.clone(), gap });
        }
    }
    correction.position = largest_change(&wanted, state);
    if !mechanism.has_closures() {
        return Ok((correction, None));
    }
    let changes = state.velocity.iter().zip(&wanted.velocity).map(|(after, before)| (after - before).abs());
    correction.velocity = changes.fold(0.0, f64::max);
    Ok((correction, Some(Arc::new(Counted::at(mechanism, state)))))
}

/// Assembles a mechanism without locked joints.
fn assemble_moving(
    mechanism: &Mechanism,
    state: &mut State,
    reach: Reach,
) -> Result<(Correction, Option<Arc<Counted>>), AssemblyError> {
    let wanted = state.clone();
    let mut done = close(mechanism, state)?;
    let again = |state: &mut State| close(mechanism, state).map(|again| done = again).is_ok();
    let (overlap, left) = without_overlap(mechanism, state, reach, again);
    done.0.overlap = overlap;
    if let Some((number, depth)) = left {
        let [words, advice] = overlap_in_words(mechanism, number, depth).unwrap_or_default();
        return Err(AssemblyError::Overlap { words, advice });
    }
    done.0.position = largest_change(&wanted, state);
    Ok(done)
}

/// Moves a state within limits and onto all closures.
fn close(mechanism: &Mechanism, state: &mut State) -> Result<(Correction, Option<Arc<Counted>>), AssemblyError> {
    let mut correction = Correction::default();
    let simulated = &mechanism.nonsmooth.limits;
    let wanted = state.clone();
    if !mechanism.has_closures() {
        if !within(simulated, state, 0.0) && !move_within(mechanism, simulated, state) {
            let (joint, excess, unit) = worst_joint(mechanism, simulated, &wanted);
            return Err(AssemblyError::Outside { joint, excess, unit });
        }
        correction.position = largest_change(&wanted, state);
        return Ok((correction, None));
    }
    if within(simulated, state, ON_LIMIT) && close_elsewhere(mechanism, state, |other, own| close(other, own).is_ok()) {
        let counted = Counted::at(mechanism, state);
        let still = Decided::from(&counted, mechanism).still;
        let rates = state.velocity.iter_mut().zip(still);
        rates.filter(|(_, still)| *still).for_each(|(rate, _)| *rate = 0.0);
        correction.position = largest_change(&wanted, state);
        let changes = state.velocity.iter().zip(&wanted.velocity).map(|(after, before)| (after - before).abs());
        correction.velocity = changes.fold(0.0, f64::max);
        return Ok((correction, Some(Arc::new(counted))));
    }
    let mut projection = Projection::new(mechanism);
    let mut start = Start::new(mechanism);
    // If the start is not closed yet, the directions nearby are taken.
    projection.heed(Counted::at(mechanism, state).known_nearby());
    let Projected { mut gap, mut worst, .. } = projection.positions(mechanism, &mut start, state);
    let limits = if simulated.is_empty() { &mechanism.limits } else { simulated };
    let leaves = within(limits, &wanted, AT_LIMIT) && !within(limits, state, AT_LIMIT);
    if leaves || !within(simulated, state, ON_LIMIT) {
        let unlimited = state.clone();
        state.copy_from(&wanted);
        let limited = close_within(mechanism, limits, &mut projection, &mut start, state);
        if limited.gap.is_nan() || limited.gap > OPEN || !within(limits, state, ON_LIMIT) {
            if gap.is_nan() || gap > OPEN {
                return Err(AssemblyError::Open { closure: closure_name(mechanism, worst).to_string(), gap });
            }
            let (joint, excess, unit) = worst_joint(mechanism, limits, &unlimited);
            let (closure, gap) = (closure_name(mechanism, limited.worst).to_string(), limited.gap);
            return Err(AssemblyError::Limited { closure, gap, joint, excess, unit });
        }
        Projected { gap, worst, .. } = limited;
    }
    if gap.is_nan() || gap > OPEN {
        return Err(AssemblyError::Open { closure: closure_name(mechanism, worst).to_string(), gap });
    }
    // Once it is closed, the implied equations are known, which closes it to rounding.
    let closed = Counted::at(mechanism, state);
    let known = known_of_steps(&closed, mechanism, &mut projection, &mut start);
    projection.heed(Known { still: Vec::new(), locked: Vec::new(), ..known });
    projection.positions(mechanism, &mut start, state);
    correction.position = largest_change(&wanted, state);
    start.set(mechanism, state);
    let counted = if closed.is_at(state) { closed } else { Counted::at(mechanism, state) };
    let decided = Decided::from(&counted, mechanism);
    let known = known_of_steps(&counted, mechanism, &mut projection, &mut start);
    projection.heed(known);
    start.set(mechanism, state);
    // Gradients of gaps are those of equations that stand still; the velocities are those of joints that are moved.
    projection.take_motions(true);
    let fastest = state.velocity.iter().fold(1.0_f64, |most, rate| most.max(rate.abs()));
    let Projected { gap: rate, worst, correction: changed } =
        projection.velocities(mechanism, &start, &mut state.velocity);
    if rate.is_nan() || rate > CONTRADICTION * fastest {
        return Err(AssemblyError::Contradiction { closure: closure_name(mechanism, worst).to_string(), rate });
    }
    correction.velocity = changed;
    // A mechanism that cannot move has no branch to decide.
    if decided.singular > 0 && state.velocity.iter().all(|rate| rate.abs() < AT_REST) {
        return Err(AssemblyError::Undecided { extra: decided.singular });
    }
    Ok((correction, Some(Arc::new(counted))))
}

/// Largest change of a number of the positions.
fn largest_change(before: &State, after: &State) -> f64 {
    let changes = after.position.iter().zip(&before.position).map(|(after, before)| (after - before).abs());
    changes.fold(0.0, f64::max)
}

/// The joint that is furthest beyond its limits, by how much, and the unit of that.
fn worst_joint(mechanism: &Mechanism, limits: &[JointLimit], state: &State) -> (String, f64, &'static str) {
    most_exceeded(limits, state).map_or((String::new(), 0.0, ""), |limit| {
        let joint = &mechanism.bodies[limit.coordinate.body].joint;
        let unit = joint.kind.unit(limit.coordinate.freedom - joint.velocity_index);
        (joint.name.clone(), excess(limit, state), unit)
    })
}

/// Which equations are redundant in a run from a state: those that are so there and, where that is a singular position, beside it.
pub fn redundancy(mechanism: &Mechanism, state: &State) -> Redundancy {
    let counted = mechanism.has_closures().then(|| Counted::at(mechanism, state));
    counted.map_or_else(Redundancy::default, |counted| redundancy_counted(mechanism, &counted))
}

/// The same where the closures were counted already.
pub fn redundancy_counted(mechanism: &Mechanism, counted: &Counted) -> Redundancy {
    let closures = Decided::from(counted, mechanism).ranks.implied;
    let mut redundant: Vec<(String, usize)> = Vec::new();
    for closure in closures.iter().filter(|(_, implied)| *implied).map(|(closure, _)| *closure) {
        let name = closure_name(mechanism, closure);
        match redundant.last_mut() {
            Some((last, count)) if last == name => *count += 1,
            _ => redundant.push((name.to_string(), 1)),
        }
    }
    Redundancy { equations: closures.len(), redundant }
}

/// The defect of a start at which the colliders of a pair, by its number, overlap by `depth` (m), and the remedy.
pub fn overlap_in_words(mechanism: &Mechanism, number: usize, depth: f64) -> Option<[String; 2]> {
    let nonsmooth = &mechanism.nonsmooth;
    let pair = nonsmooth.pairs.with_number(number)?;
    let [a, b] = [pair.a, pair.b].map(|of| &nonsmooth.colliders[of]);
    Some(match a.shape {
        Shape::Hollow { .. } => [
            format!("rope {:?} is {depth:.1e} m too short for where {:?} starts", a.name, b.name),
            "give it more length, or move the start".to_string(),
        ],
        _ => [
            format!("{:?} and {:?} start {depth:.1e} m inside each other", a.name, b.name),
            "move the start, or let them pass with [[contact.pair]] ignore = true".to_string(),
        ],
    })
}
