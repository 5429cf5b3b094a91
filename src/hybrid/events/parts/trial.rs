//! The step that is being made: where it begins, the functions that are watched in it, and room to look at them.
//!
//! Invariants: `origin` is the state at which the step begins; `bodies` are those of `placed` in the state that was looked at last; `covers` belong
//! to the last attempt; a function that is `fresh` is zero at the start of the step, and its zero there is no event.

use crate::events::finding::cover::Cover;
use crate::events::finding::detection::Looking;
use crate::events::finding::reserves::Reserves;
use crate::events::finding::speeds::Speeds;
use crate::events::finding::watched::Watched;
use crate::events::forces::holding::Holding;
use crate::events::modes::inside_bodies::InsideBodies;
use crate::events::modes::instants::Evaluated;
use crate::events::modes::loose::Loose;
use crate::events::modes::placed::PlacedBodies;
use crate::events::parts::model::HybridModel;
use crate::instant::holding::near::Near;
use crate::instant::holding::per_pair::PerPair;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::motion::state::State;
use nalgebra::Vector3;

/// The step at hand.
#[derive(Clone)]
pub(crate) struct StepTrial {
    /// The state at which it begins.
    pub origin: State,
    /// A state inside, and the evaluated functions there.
    pub sample: State,
    pub evaluated: Evaluated,
    /// The bodies at instants of the last step.
    pub inside: InsideBodies,
    /// The functions whose sign is watched.
    pub watched: Vec<Watched>,
    /// The contacts that part where the step begins, because their pressures end in less time than a step can be solved in.
    pub parts: Vec<Watched>,
    /// Functions whose zero at the start of the step is no event.
    pub fresh_joints: Vec<bool>,
    pub fresh_motors: Vec<bool>,
    pub fresh_pairs: PerPair<bool>,
    /// Room for looks at steps.
    pub looking: Looking,
    /// Bounds of the speeds of bodies over the step.
    pub speeds: Speeds,
    /// The pairs that are looked at: all others are proved apart.
    pub near: Near,
    /// What no closure holds in the mode.
    pub loose: Loose,
    /// How far pairs are from closing, by the looks at steps before.
    pub reserves: Reserves,
    /// The covered stretches of the last step for each pair that may close in it, by its number among the watched functions.
    pub covers: Vec<(usize, Cover)>,
    /// A bound of the overlap of all pairs in the last step (m).
    pub overlap: f64,
    /// Looks at the gaps of hulls with many vertices that the cost of steps does not have yet.
    pub looks: usize,
    /// The bodies in the state that was looked at last.
    pub bodies: Vec<BodyState>,
    /// The bodies in the latest states.
    pub placed: PlacedBodies,
    /// Efforts of the joints over the step, and those that hold the joints that are held.
    pub efforts: Vec<f64>,
    pub holding: Holding,
    /// The directions in which closed contacts slide where the step begins.
    pub slips: Vec<Vector3<f64>>,
    /// The directions in which they turn there: across the normal, and along it.
    pub turns: Vec<[Vector3<f64>; 2]>,
    /// Their slips there [m/s], and room for contacts whose slips may pass near their stops.
    pub begins: Vec<Vector3<f64>>,
    pub suspects: Vec<usize>,
}

impl StepTrial {
    /// Before the first step.
    pub fn new(model: &HybridModel, holding: Holding, state: State) -> Self {
        let HybridModel { whole, elements, .. } = model;
        StepTrial {
            origin: state.clone(),
            sample: state,
            evaluated: Evaluated::default(),
            inside: InsideBodies::default(),
            watched: Vec::new(),
            parts: Vec::new(),
            fresh_joints: vec![false; elements.joints.len()],
            fresh_motors: vec![false; elements.motors.len()],
            fresh_pairs: PerPair::default(),
            looking: Looking::default(),
            speeds: Speeds::default(),
            reserves: Reserves::new(whole),
            near: Near::default(),
            loose: Loose::new(whole),
            covers: Vec::new(),
            overlap: 0.0,
            looks: 0,
            bodies: vec![WORLD; whole.bodies.len()],
            placed: PlacedBodies::default(),
            efforts: vec![0.0; whole.velocity_count],
            holding,
            slips: Vec::new(),
            turns: Vec::new(),
            begins: Vec::new(),
            suspects: Vec::new(),
        }
    }

    /// Takes another mechanism with the same bodies and joints.
    pub fn replace(&mut self, model: &HybridModel) {
        self.loose = Loose::new(&model.whole);
        self.reserves = Reserves::new(&model.whole);
        self.reserves.take(self.near.pairs(), &model.touching.pairs);
        self.placed.forget();
    }

    /// From now on a zero at the start of a step is an event.
    pub fn wear_off(&mut self) {
        self.fresh_joints.fill(false);
        self.fresh_motors.fill(false);
        self.fresh_pairs.clear();
    }

    /// Forgets the looks at the last step: it is another, or bodies that are held in it have moved.
    pub fn forget_looks(&mut self) {
        self.evaluated = Evaluated::default();
        self.inside.forget();
    }
}
