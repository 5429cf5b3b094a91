//! Steps on another spanning tree than the file's. The caller sees the coordinates of the file only.
//!
//! ```text
//!     file's tree ─ plan/spanning.rs ─▶ the joints to cut ─ structure/other_tree.rs ─▶ Mechanism, the same on the other tree
//!     State of the file ─ take ─▶ own State ── Lobatto::step ──▶ own State ─ give ─▶ State of the file
//! ```
//!
//! The integrator's own state is kept from step to step; it is computed again if the caller has changed the other one. The angle of a joint that is
//! cut follows from the places of its bodies up to whole turns, which are counted from its rates: over so short a time that no turn is missed, with
//! dense output inside the step where it is long.
//!
//! Efforts from outside act along coordinates of the file's tree. A joint that somebody drives is not cut: where one that is cut is driven for the
//! first time, another tree is chosen (`driven_elsewhere`).

use crate::integrator::{Lobatto, MethodError};
use crate::recipe::Recipe;
use crate::step_maker::{PieceSteps, StepFigures, StepMaker, StepPace};
use crate::trees::driven_elsewhere::Driven;
use crate::trees::turns::Turns;
use catena_lobatto::plan::spanning::spanning_tree;
use catena_mechanism::description::closure::Coordinate;
use catena_mechanism::description::forces::Forces;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::description::rules::Rule;
use catena_mechanism::motion::inputs::{ChangingEfforts, Feedback, Inputs};
use catena_mechanism::motion::integrator::{Cost, Integrator, MethodDescription, StepError, StepOutcome};
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::other_tree::{Found, OtherTree};
use catena_mechanism::structure::plane::Plane;
use catena_mechanism::structure::spanning_tree::{Graph, SpanningTree};
use nalgebra::Vector3;

/// The spanning tree on which steps of a mechanism are made, if it is not the file's. Efforts from outside act in the joints of the bodies `driven`,
/// and `kept` are disabled simplification rules.
pub fn other_tree(mechanism: &Mechanism, driven: &[usize], kept: &[Rule]) -> Option<(SpanningTree, Option<Plane>)> {
    if mechanism.loops.is_empty() || kept.contains(&Rule::Tree) {
        return None;
    }
    let plane = if kept.contains(&Rule::Planar) { None } else { Plane::of(mechanism) };
    let mut graph = Graph::new(mechanism, plane.as_ref());
    driven.iter().for_each(|&body| graph.keep(body));
    let tree = spanning_tree(&graph)?;
    (!graph.turns(mechanism, &tree)).then_some((tree, plane))
}

/// [`Lobatto`] on another spanning tree.
#[derive(Clone)]
pub struct OnOtherTree {
    recipe: Recipe,
    tree: SpanningTree,
    plane: Option<Plane>,
    inside: Inside,
    /// Start and end of the last step, in the coordinates of the file.
    origin: State,
    left: Option<State>,
    /// Gravity and forces at its creation.
    gravity: Vector3<f64>,
    forces: Forces,
    turns: Turns,
    /// The bodies in whose joints efforts act from outside, and their efforts here.
    in_joints: Vec<usize>,
    driven: Driven,
    /// The error of samples inside the steps that were made on other trees before this one (m).
    earlier: Option<f64>,
    /// Steps on the file's tree, once other forces act or no other tree is worthwhile.
    on_file: Option<Lobatto>,
}

/// The degrees of freedom along which something acts from outside.
fn acting(inputs: Inputs<'_>) -> impl Iterator<Item = usize> {
    let constant = inputs.efforts.iter().enumerate().filter(|(_, effort)| **effort != 0.0);
    let changing = inputs.changing.map_or(&[][..], ChangingEfforts::freedoms);
    let following = inputs.feedback.map_or(&[][..], Feedback::freedoms);
    constant.map(|(freedom, _)| freedom).chain(changing.iter().chain(following).copied())
}

/// The steps on the other tree.
#[derive(Clone)]
struct Inside {
    other: OtherTree,
    lobatto: Lobatto,
    state: State,
    /// Room for the results of dense output.
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
    /// For a mechanism with efforts from outside in the joints of these bodies; `None` if the file's tree is as good.
    ///
    /// # Errors
    /// [`MethodError`] for stages and steps that cannot be.
    pub fn new(mechanism: &Mechanism, driven: &[usize], recipe: &Recipe) -> Result<Option<Self>, MethodError> {
        let Some((tree, plane)) = other_tree(mechanism, driven, &recipe.kept) else { return Ok(None) };
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
            in_joints: driven.to_vec(),
            driven: Driven::new(&other),
            inside: Inside::new(other, lobatto),
            earlier: Some(0.0),
            on_file: None,
        }))
    }

    /// Writes where a step from the origin has ended in the coordinates of the file.
    fn hand_out(&mut self, mechanism: &Mechanism, state: &mut State) {
        let OnOtherTree { inside, turns, left, .. } = self;
        inside.other.give(mechanism, &inside.state, state);
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
            self.hang(mechanism, other);
        }
        self.inside.other.take(mechanism, state, &mut self.inside.state);
        self.left = Some(state.clone());
    }

    /// Makes sure that all driven joints are on this tree; `false` if no tree has all of them.
    fn heed(&mut self, mechanism: &Mechanism, inputs: Inputs, state: &State) -> bool {
        let count = self.in_joints.len();
        for freedom in acting(inputs).filter(|&freedom| self.inside.other.freedom(freedom).is_none()) {
            let body = mechanism.body_of_freedom(freedom).filter(|body| !self.in_joints.contains(body));
            self.in_joints.extend(body);
        }
        if self.in_joints.len() == count {
            return true;
        }
        let found = other_tree(mechanism, &self.in_joints, &self.recipe.kept);
        let Some((tree, plane)) = found else { return false };
        let Ok(other) = OtherTree::new(mechanism, &tree, plane.as_ref(), state) else { return false };
        (self.tree, self.plane, self.left) = (tree, plane, None);
        self.hang(mechanism, other);
        true
    }

    /// Goes on with the same mechanism written in another way.
    fn hang(&mut self, mechanism: &Mechanism, other: OtherTree) {
        self.earlier = self.figures().between;
        let lobatto = self.make(&other.mechanism);
        self.turns = Turns::new(mechanism, other.computed());
        self.driven = Driven::new(&other);
        self.inside = Inside::new(other, lobatto);
    }
}

impl StepMaker for OnOtherTree {
    /// In a scene with closed loops a run beside this one has steps of its own, and rings, too.
    fn figures(&self) -> StepFigures {
        let on_file = self.on_file.as_ref().map_or(Some(0.0), |on_file| on_file.figures().between);
        let mut all = StepFigures { ringing: 0.0, ..self.active().figures() };
        all.between = self.inside.lobatto.figures().between;
        all.see_between(self.earlier);
        all.see_between(on_file);
        all
    }
}

impl PieceSteps for OnOtherTree {
    fn duplicate(&self) -> Box<dyn PieceSteps> {
        Box::new(self.clone())
    }

    fn again(
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
        self.left = None;
        self.turns.begin(&self.origin);
        let Inside { other, lobatto, state: own, .. } = &mut self.inside;
        let again = |inputs: Inputs| lobatto.again(&other.mechanism, inputs, own, length);
        let outcome = self.driven.within(mechanism, other, &self.turns, inputs, again)?;
        self.hand_out(mechanism, state);
        Ok(outcome)
    }

    /// Zero for a joint that is cut, because it has no forces.
    fn mean_square_rate(&self, coordinate: Coordinate, rates: &mut Vec<f64>) -> f64 {
        let freedom = match (&self.on_file, self.inside.other.joint(coordinate.body)) {
            (Some(_), _) => coordinate.freedom,
            (None, Found::Carries { body, .. }) => self.inside.other.mechanism.bodies[body].joint.velocity_index,
            (None, Found::Closes(_)) => return 0.0,
        };
        self.active().mean_square_rate(freedom, rates)
    }

    fn step_pace(&self, origin: f64) -> StepPace {
        self.active().step_pace(origin)
    }

    fn keep_pace(&mut self, pace: StepPace, time: f64) {
        self.on_file.as_mut().unwrap_or(&mut self.inside.lobatto).keep_pace(pace, time);
    }

    fn leaves_transient(&self) -> bool {
        self.active().leaves_transient()
    }

    fn give_up_below(&mut self, length: f64) {
        self.on_file.as_mut().unwrap_or(&mut self.inside.lobatto).give_up_below(length);
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
        if self.on_file.is_none() && !(known && self.heed(mechanism, inputs, state)) {
            self.on_file = Some(self.make(mechanism));
        }
        if let Some(on_file) = &mut self.on_file {
            return on_file.step(mechanism, inputs, state, until);
        }
        self.meet(mechanism, state);
        self.origin.copy_from(state);
        self.turns.begin(&self.origin);
        let Inside { other, lobatto, state: own, .. } = &mut self.inside;
        let step = |inputs: Inputs| lobatto.step(&other.mechanism, inputs, own, until);
        let outcome = self.driven.within(mechanism, other, &self.turns, inputs, step)?;
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

    fn take_abandoned(&mut self) -> Cost {
        let mut cost = self.inside.lobatto.take_abandoned();
        if let Some(on_file) = &mut self.on_file {
            cost.add(&on_file.take_abandoned());
        }
        cost
    }

    fn description(&self) -> MethodDescription {
        self.active().description()
    }
}
