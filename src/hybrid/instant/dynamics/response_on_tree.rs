//! How a mechanism answers to efforts and impulses at one instant, with its closures, computed on its own spanning tree.
//!
//! ```text
//!     a = a_free + Y τ          accelerations under efforts τ            a_free: without them
//!     v⁺ = v⁻ + Y P             velocities after impulses P
//!     Y = H⁻¹ − H⁻¹ Jᵀ (J H⁻¹ Jᵀ)⁺ J H⁻¹      (n × n)  symmetric, positive semidefinite
//! ```
//!
//! H (n × n) is the mass matrix, J the gradient of the closures. A column of Y is one solve of the articulated-body algorithm, made to fit the
//! closures by the least motion in the metric of H ([`Closing`]; where joints follow others or are moved and no loop closes
//! [`Following`]); H is never formed.

use crate::instant::dynamics::closing::Closing;
use crate::instant::dynamics::following::{Fitted, Following};
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::inputs::Inputs;
use crate::mechanism::motion::kinematics::{BodyAcceleration, place_bodies};
use crate::mechanism::motion::state::State;
use crate::reduced::ReducedOde;
use nalgebra::Vector3;
use std::sync::Arc;

/// The workspace of one mechanism.
#[derive(Clone)]
pub(crate) struct ResponseOnTree {
    mechanism: Arc<Mechanism>,
    /// The equations with all forces, and efforts from outside.
    ode: ReducedOde,
    /// The masses alone: without gravity and forces.
    bare: ReducedOde,
    bodies: Vec<BodyState>,
    accelerations: Vec<BodyAcceleration>,
    closing: Option<Closing>,
    /// In the state at which columns of Y are asked for, where joints follow others or are moved and no loop closes.
    following: Option<Following>,
    zero: Vec<f64>,
    free: Vec<f64>,
}

impl ResponseOnTree {
    /// For a mechanism with its forces.
    pub fn new(mechanism: &Mechanism) -> Self {
        let mut driven = mechanism.clone();
        driven.forces.driven = true;
        let mut bare = mechanism.clone();
        bare.gravity = Vector3::zeros();
        bare.forces = Default::default();
        ResponseOnTree {
            ode: ReducedOde::new(&driven),
            bare: ReducedOde::new(&bare),
            bodies: vec![WORLD; mechanism.bodies.len()],
            accelerations: vec![BodyAcceleration::default(); mechanism.bodies.len()],
            closing: Closing::new(mechanism),
            following: None,
            zero: vec![0.0; mechanism.velocity_count],
            free: vec![0.0; mechanism.velocity_count],
            mechanism: Arc::new(driven),
        }
    }

    /// The accelerations of a state under its forces and these efforts, one entry a degree of freedom.
    pub fn accelerations(&mut self, state: &State, efforts: &[f64], out: &mut [f64]) {
        let ResponseOnTree { mechanism, ode, bodies, accelerations, closing, .. } = self;
        place_bodies(mechanism, state, bodies);
        ode.drive_at(state.time, Inputs::constant(efforts));
        ode.accelerations_of_placed(&state.position, &state.velocity, bodies, out);
        if let Some(following) = Following::at(mechanism, state.time, |efforts, answer| ode.respond(efforts, answer)) {
            following.follow(Fitted::Accelerations, out);
        } else if let Some(closing) = closing {
            closing.place(mechanism, state);
            closing.accelerations(mechanism, &state.velocity, bodies, out, accelerations);
        }
    }

    /// Takes a state at which columns of Y are asked for.
    pub fn place(&mut self, state: &State) {
        let ResponseOnTree { mechanism, bare, closing, following, zero, free, .. } = self;
        bare.accelerations(&state.position, zero, free);
        *following = Following::at(mechanism, state.time, |efforts, answer| bare.respond(efforts, answer));
        if let Some(closing) = closing.as_mut().filter(|_| following.is_none()) {
            closing.place(mechanism, state);
        }
    }

    /// Y τ for efforts τ at the state that was taken last.
    pub fn answer(&mut self, efforts: &[f64], out: &mut [f64]) {
        let ResponseOnTree { mechanism, bare, closing, following, .. } = self;
        bare.respond(efforts, out);
        if let Some(following) = following {
            following.follow(Fitted::Answers, out);
        } else if let Some(closing) = closing {
            closing.changes(mechanism, out);
        }
    }

    /// Whether the trees of the mechanism answer each to its own efforts alone, in the state that was taken last; with the tree of each degree of
    /// freedom.
    pub fn trees_are_apart(&self, of_freedoms: &[usize]) -> bool {
        self.following.as_ref().map_or(self.closing.is_none(), |following| following.stays_in_trees(of_freedoms))
    }

    /// Brings velocities on the closures, with the least change in the metric of H.
    pub fn close_velocities(&mut self, state: &mut State) {
        if self.closing.is_none() {
            return;
        }
        self.place(state);
        let ResponseOnTree { mechanism, closing, following, .. } = self;
        if let Some(following) = following {
            following.follow(Fitted::Velocities, &mut state.velocity);
        } else if let Some(closing) = closing {
            closing.velocities(mechanism, &mut state.velocity);
        }
    }
}
