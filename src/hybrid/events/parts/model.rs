//! The constant part of a motion with events: the mechanism, the elements that change a mode, the pairs that may touch, and how steps are made.
//!
//! Invariants: `elements` and `touching` belong to `whole`; only a run that hands over another mechanism changes them, between two steps.

use crate::events::finding::extremes::next_extreme;
use crate::events::modes::piece_recipe::PieceRecipe;
use crate::instant::holding::elements::Elements;
use crate::instant::holding::touching::Touching;
use crate::mechanism::description::mechanism::Mechanism;
use std::sync::Arc;

/// The height that accumulating impacts may leave without a tolerance (rad or m).
const HEIGHT: f64 = 1e-13;
/// The same over a tolerance.
const LEFT: f64 = 1e-4;

/// The model of a motion that is smooth in pieces.
#[derive(Clone)]
pub(crate) struct HybridModel {
    /// The mechanism with all its joints free.
    pub whole: Arc<Mechanism>,
    /// Joints with limits or friction, and motors.
    pub elements: Elements,
    /// The pairs of shapes that may touch.
    pub touching: Arc<Touching>,
    /// Stages and steps, or the comparator.
    pub recipe: PieceRecipe,
    /// The height that accumulating impacts may leave (rad or m).
    pub height: f64,
    /// Steps over events have this many times their length: more than one in a run with which another is compared.
    pub coarser: f64,
    /// Their length, if all steps are such (s).
    pub over_events: Option<f64>,
}

impl HybridModel {
    pub fn new(mechanism: &Mechanism, recipe: PieceRecipe) -> Self {
        let mut model = HybridModel {
            whole: Arc::new(mechanism.clone()),
            elements: Elements::new(mechanism),
            touching: Arc::new(Touching::new(mechanism)),
            recipe,
            height: HEIGHT,
            coarser: 1.0,
            over_events: None,
        };
        model.leave_of_impacts(1.0, 1.0);
        model
    }

    /// Lets accumulating impacts leave this part of the height that they may leave, and at least this multiple of the least height.
    pub fn leave_of_impacts(&mut self, part: f64, least: f64) {
        self.height = (least * HEIGHT).max(part * self.recipe.tolerance().map_or(HEIGHT, |tolerance| LEFT * tolerance));
    }

    /// Whether another mechanism than the one that is known acts.
    pub fn is_other(&self, mechanism: &Mechanism) -> bool {
        self.whole.gravity != mechanism.gravity || !self.whole.forces.are_those_of(&mechanism.forces)
    }

    /// Takes a mechanism with the same bodies and joints, but other forces.
    pub fn replace(&mut self, mechanism: &Mechanism) {
        self.whole = Arc::new(mechanism.clone());
        self.touching = Arc::new(Touching::new(mechanism));
    }

    /// The next instant (s) at which a load, or the law of a motor at rest, is largest or least, or the end.
    pub fn next_extreme(&self, since: f64, until: f64) -> f64 {
        let forces = &self.whole.forces;
        let courses = forces.joint_courses.iter().map(|load| &load.course);
        let courses = courses.chain(forces.link_loads.iter().map(|load| &load.course));
        let loads = courses.filter(|course| !course.is_constant());
        let first = loads.fold(until, |first, load| next_extreme(since, first, |time| load.value(since, time)));
        let motors = self.elements.motors.iter().filter(|motor| motor.period == 0.0 && !motor.target.is_constant());
        motors.fold(first, |first, motor| {
            let first = next_extreme(since, first, |time| motor.target.piece(since, time).0);
            next_extreme(since, first, |time| motor.target.piece(since, time).1)
        })
    }

    /// The longest step from a time on, of `step` seconds at most, over which stages resolve the targets of motors; the run goes on to `until` (s).
    pub fn resolved_step(&self, time: f64, step: f64, until: f64) -> f64 {
        // Between ticks an effort is held.
        let followed = self.elements.motors.iter().filter(|motor| motor.period == 0.0);
        followed.fold(step, |step, motor| motor.target.resolved_step(time, step, until))
    }

    /// The next instant at which an effort changes its law, or the end.
    pub fn next_instant(&self, time: f64, until: f64) -> f64 {
        let motors = self.elements.motors.iter().map(|motor| motor.next_instant(time));
        let next = motors.fold(until.min(self.whole.next_instant(time)), f64::min);
        if until - next < 1e-12 * until.abs().max(1.0) { until } else { next }
    }
}
