//! Steps on another spanning tree than the file's. The caller sees the coordinates of the file only.
//!
//! ```text
//!     file's tree ─ plan/spanning.rs ─▶ the joints to cut ─ structure/other_tree.rs ─▶ Mechanism, the same on the other tree
//!     State of the file ─ take ─▶ own State ── Lobatto::step ──▶ own State ─ give ─▶ State of the file
//! ```
//!
//! The integrator's own state is kept from step to step; it is computed again if the caller has changed the other one. The angle of a joint that is cut follows from
//! the places of its bodies up to whole turns, which are counted from its rates: over so short a time that no turn is missed, with dense
//! output inside the step where it is long.
//!
//! Efforts from outside act along coordinates of the file's tree: whoever drives a joint gets that tree from then on. So does a mechanism with joints that
//! its loops lock: the solve holds them by what is implied on the file's tree, which was found to lose digits on another.

use crate::integrator::{Lobatto, MethodError, StepPace};
use crate::recipe::Recipe;
use catena_lobatto::plan::spanning::spanning_tree;
use catena_mechanism::description::closure::Coordinate;
use catena_mechanism::description::forces::Forces;
use catena_mechanism::description::joint::{FreeRotation, Joint};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::description::rules::Rule;
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::integrator::{Integrator, MethodDescription, StepError, StepOutcome};
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::other_tree::{Found, OtherTree};
use catena_mechanism::structure::plane::Plane;
use catena_mechanism::structure::ranks::counting::Ranks;
use catena_mechanism::structure::spanning_tree::{Graph, SpanningTree};
use nalgebra::Vector3;
use std::f64::consts::{FRAC_PI_4, TAU};

/// The spanning tree on which steps of a mechanism are made, if it is not the file's; `kept` are rules that leave nothing out.
pub fn other_tree(mechanism: &Mechanism, kept: &[Rule]) -> Option<(SpanningTree, Option<Plane>)> {
    if mechanism.loops.is_empty() || !mechanism.touches.is_empty() || kept.contains(&Rule::Tree) {
        return None;
    }
    let plane = if kept.contains(&Rule::Planar) { None } else { Plane::of(mechanism) };
    let tree = spanning_tree(&Graph::new(mechanism, plane.as_ref()))?;
    Some((tree, plane))
}

/// The same for steps that begin in a state: none, too, where loops lock joints.
pub fn other_tree_at(mechanism: &Mechanism, state: &State, kept: &[Rule]) -> Option<SpanningTree> {
    let (tree, plane) = other_tree(mechanism, kept)?;
    let mut other = OtherTree::new(mechanism, &tree, plane.as_ref(), state).ok()?;
    let mut own = State::zero(&other.mechanism);
    other.take(mechanism, state, &mut own);
    (!is_locked(&other.mechanism, &own)).then_some(tree)
}

/// Whether closures forbid a joint to move.
fn is_locked(mechanism: &Mechanism, state: &State) -> bool {
    let ranks = Ranks::at(mechanism, state);
    ranks.locked.contains(&true) || ranks.still.contains(&true)
}

/// [`Lobatto`] on another spanning tree.
pub struct OnOtherTree {
    recipe: Recipe,
    tree: SpanningTree,
    plane: Option<Plane>,
    inside: Inside,
    /// Where the last step began and ended, in the coordinates of the file.
    origin: State,
    left: Option<State>,
    /// What acted when it was made.
    gravity: Vector3<f64>,
    forces: Forces,
    turns: Turns,
    /// Steps on the file's tree, where joints are locked, or once somebody drives them or other forces act.
    on_file: Option<Lobatto>,
}

/// The steps on the other tree.
struct Inside {
    other: OtherTree,
    lobatto: Lobatto,
    state: State,
    /// Room for what dense output says.
    position: Vec<f64>,
    velocity: Vec<f64>,
}

impl Inside {
    fn new(other: OtherTree, lobatto: Lobatto) -> Self {
        let state = State::zero(&other.mechanism);
        Inside { position: state.position.clone(), velocity: state.velocity.clone(), state, other, lobatto }
    }

    /// Positions and velocities in the coordinates of the file at a time inside the last step (s), but for whole turns.
    fn dense(&mut self, file: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        let Inside { other, lobatto, position: own_position, velocity: own_velocity, .. } = self;
        lobatto.dense(&other.mechanism, time, own_position, own_velocity);
        other.give_coordinates(file, (own_position, own_velocity), position, velocity);
    }
}

impl OnOtherTree {
    /// For a mechanism; `None` if the file's tree is as good.
    ///
    /// # Errors
    /// [`MethodError`] for stages and steps that cannot be.
    pub fn new(mechanism: &Mechanism, recipe: &Recipe) -> Result<Option<Self>, MethodError> {
        let Some((tree, plane)) = other_tree(mechanism, &recipe.kept) else { return Ok(None) };
        let Ok(other) = OtherTree::new(mechanism, &tree, plane.as_ref(), &State::zero(mechanism)) else {
            return Ok(None);
        };
        let lobatto = recipe.lobatto(&other.mechanism)?;
        Ok(Some(OnOtherTree {
            recipe: recipe.clone(),
            tree,
            plane,
            origin: State::zero(mechanism),
            left: None,
            gravity: mechanism.gravity,
            forces: mechanism.forces.clone(),
            turns: Turns::new(mechanism, other.computed()),
            inside: Inside::new(other, lobatto),
            on_file: None,
        }))
    }

    /// Whether a step that was to be chosen for its accuracy was shortened for the stability of the scheme.
    pub fn was_held_by_stability(&self) -> bool {
        self.active().was_held_by_stability()
    }

    /// The error of samples inside the steps so far, as [`Lobatto::between`] says.
    pub fn between(&self) -> Option<f64> {
        let on_file = self.on_file.as_ref().map_or(Some(0.0), Lobatto::between)?;
        self.inside.lobatto.between().map(|other| other.max(on_file))
    }

    /// Makes the last step again from its start with another length (s), as [`Lobatto::again`] does.
    ///
    /// # Errors
    /// [`StepError`] where the equations cannot be solved; the state is then the start of the step.
    pub fn again(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        length: f64,
    ) -> Result<StepOutcome, StepError> {
        if let Some(on_file) = &mut self.on_file {
            return on_file.again(mechanism, inputs, state, length);
        }
        state.copy_from(&self.origin);
        let Inside { other, lobatto, state: own, .. } = &mut self.inside;
        self.left = None;
        let outcome = lobatto.again(&other.mechanism, Inputs::NONE, own, length)?;
        self.hand_out(mechanism, state);
        Ok(outcome)
    }

    /// The weighted mean of the squares of a scalar joint coordinate's rate over the last step [(m/s)² or (rad/s)²]; `rates` is room. Zero of a joint
    /// that is cut, along which nothing acts.
    pub fn mean_square_rate(&self, coordinate: Coordinate, rates: &mut Vec<f64>) -> f64 {
        let freedom = match (&self.on_file, self.inside.other.joint(coordinate.body)) {
            (Some(_), _) => coordinate.freedom,
            (None, Found::Carries { body, .. }) => self.inside.other.mechanism.bodies[body].joint.velocity_index,
            (None, Found::Closes(_)) => return 0.0,
        };
        self.active().mean_square_rate(freedom, rates)
    }

    /// The pace of the steps, for one who goes on; `origin` is where a grid began (s).
    pub fn step_pace(&self, origin: f64) -> StepPace {
        self.active().step_pace(origin)
    }

    /// Goes on at the pace of another, which made steps of the same motion up to `time` (s).
    pub fn keep_pace(&mut self, pace: StepPace, time: f64) {
        self.on_file.as_mut().unwrap_or(&mut self.inside.lobatto).keep_pace(pace, time);
    }

    /// Writes where a step from the origin has ended in the coordinates of the file.
    fn hand_out(&mut self, mechanism: &Mechanism, state: &mut State) {
        let OnOtherTree { inside, origin, turns, left, .. } = self;
        inside.other.give(mechanism, &inside.state, state);
        turns.begin(origin);
        turns.follow(state, |time, position, velocity| inside.dense(mechanism, time, position, velocity));
        match left {
            Some(left) => left.copy_from(state),
            None => *left = Some(state.clone()),
        }
    }

    fn active(&self) -> &Lobatto {
        self.on_file.as_ref().unwrap_or(&self.inside.lobatto)
    }

    fn make(&self, mechanism: &Mechanism) -> Lobatto {
        self.recipe.lobatto(mechanism).expect("stages and steps that were taken before")
    }

    /// Takes a state that no step has left.
    fn meet(&mut self, mechanism: &Mechanism, state: &State) {
        if self.left.as_ref() == Some(state) {
            return;
        }
        self.left = None;
        if !self.inside.other.fits(mechanism, &self.tree, self.plane.as_ref(), state)
            && let Ok(other) = OtherTree::new(mechanism, &self.tree, self.plane.as_ref(), state)
        {
            let lobatto = self.make(&other.mechanism);
            self.inside = Inside::new(other, lobatto);
        }
        self.inside.other.take(mechanism, state, &mut self.inside.state);
        if is_locked(&self.inside.other.mechanism, &self.inside.state) {
            self.on_file = Some(self.make(mechanism));
        }
        self.left = Some(state.clone());
    }
}

impl Integrator for OnOtherTree {
    fn step(
        &mut self,
        mechanism: &Mechanism,
        inputs: Inputs,
        state: &mut State,
        until: f64,
    ) -> Result<StepOutcome, StepError> {
        let known = self.gravity == mechanism.gravity && self.forces.are_those_of(&mechanism.forces);
        if self.on_file.is_none() && !(known && inputs.is_none()) {
            self.on_file = Some(self.make(mechanism));
        }
        if self.on_file.is_none() {
            self.meet(mechanism, state);
        }
        if let Some(on_file) = &mut self.on_file {
            return on_file.step(mechanism, inputs, state, until);
        }
        self.origin.copy_from(state);
        let Inside { other, lobatto, state: own, .. } = &mut self.inside;
        let outcome = lobatto.step(&other.mechanism, Inputs::NONE, own, until)?;
        self.hand_out(mechanism, state);
        Ok(outcome)
    }

    fn dense(&mut self, mechanism: &Mechanism, time: f64, position: &mut [f64], velocity: &mut [f64]) {
        if let Some(on_file) = &mut self.on_file {
            return on_file.dense(mechanism, time, position, velocity);
        }
        self.inside.dense(mechanism, time, position, velocity);
        self.turns.unwrap(time, position, velocity);
    }

    fn description(&self) -> MethodDescription {
        self.active().description()
    }
}

/// The angles of joints that are computed from places, at instants of the last step between which they turn little.
struct Turns {
    /// Their entries of the file's position and velocity vectors.
    joints: Vec<(usize, usize)>,
    /// One an instant: the time (s), the angles (rad) and rates [rad/s] of all joints.
    times: Vec<f64>,
    angles: Vec<f64>,
    rates: Vec<f64>,
    position: Vec<f64>,
    velocity: Vec<f64>,
}

/// Between two instants no joint turns by more than this (rad).
const LITTLE: f64 = FRAC_PI_4;
/// A step is looked at in no more parts than this: eight turns of a joint, which no step makes.
const PARTS: usize = 64;

impl Turns {
    fn new(mechanism: &Mechanism, bodies: &[usize]) -> Self {
        let joints = bodies.iter().map(|&body| &mechanism.bodies[body].joint);
        let turning = joints.filter(|joint| joint.kind.rotation() == FreeRotation::AboutZ);
        let slides = |joint: &Joint| joint.kind.translation_axes().len();
        let entries = |joint: &Joint| (joint.position_index + slides(joint), joint.velocity_index + slides(joint));
        let joints: Vec<_> = turning.map(entries).collect();
        Turns {
            times: Vec::with_capacity(PARTS),
            angles: Vec::with_capacity(PARTS * joints.len()),
            rates: Vec::with_capacity(PARTS * joints.len()),
            joints,
            position: vec![0.0; mechanism.position_count],
            velocity: vec![0.0; mechanism.velocity_count],
        }
    }

    /// A step begins at a state.
    fn begin(&mut self, state: &State) {
        self.times.clear();
        self.angles.clear();
        self.rates.clear();
        self.keep(state.time, &state.position, &state.velocity);
    }

    fn keep(&mut self, time: f64, position: &[f64], velocity: &[f64]) {
        self.times.push(time);
        self.angles.extend(self.joints.iter().map(|&(slot, _)| position[slot]));
        self.rates.extend(self.joints.iter().map(|&(_, freedom)| velocity[freedom]));
    }

    /// Adds whole turns to the angles at the end of a step, of whose inside `dense` writes positions and velocities.
    fn follow(&mut self, end: &mut State, mut dense: impl FnMut(f64, &mut [f64], &mut [f64])) {
        let begin = self.times[0];
        let rates = self.joints.iter().map(|&(_, freedom)| end.velocity[freedom]).chain(self.rates.iter().copied());
        let fastest = rates.fold(0.0, |most: f64, rate| most.max(rate.abs()));
        let parts = (fastest * (end.time - begin) / LITTLE).ceil().clamp(1.0, PARTS as f64);
        let (mut position, mut velocity) = (std::mem::take(&mut self.position), std::mem::take(&mut self.velocity));
        for part in 1..parts as usize {
            let time = begin + (end.time - begin) * (part as f64 / parts);
            dense(time, &mut position, &mut velocity);
            self.unwrap(time, &mut position, &velocity);
            self.keep(time, &position, &velocity);
        }
        (self.position, self.velocity) = (position, velocity);
        self.unwrap(end.time, &mut end.position, &end.velocity);
    }

    /// Adds whole turns to the angles at a time of the step (s), by the rates since the last instant before it.
    fn unwrap(&self, time: f64, position: &mut [f64], velocity: &[f64]) {
        let last = self.times.partition_point(|&before| before < time).saturating_sub(1);
        for (joint, &(slot, freedom)) in self.joints.iter().enumerate() {
            let entry = last * self.joints.len() + joint;
            let turned = 0.5 * (time - self.times[last]) * (self.rates[entry] + velocity[freedom]);
            position[slot] += TAU * ((self.angles[entry] + turned - position[slot]) / TAU).round();
        }
    }
}
