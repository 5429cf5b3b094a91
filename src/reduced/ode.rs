//! The mechanism as a first-order system in joint coordinates.
//!
//! ```text
//!     y = (q, v)          q the joint positions [m, rad, -], v the joint velocities [m/s, rad/s]
//!     q̇ = v               for lengths and angles
//!     q̇ = ½ q ∘ (0, ω)    for quaternions, ω the child's angular velocity in its joint frame
//!     v̇ = q̈(q, v)         by the articulated-body algorithm
//! ```
//!
//! Forces besides gravity add two entries, the energy dissipated and the work put in (J) since the start. Their rates are the powers: the method
//! integrates them like everything else.
//!
//! The quaternion equation keeps |q|, and the accelerations do not depend on it, so rounding and truncation errors in
//! |q| do no harm between the renormalisations at the ends of the steps.

use crate::articulated_body::ArticulatedBody;
use crate::regularised::Regularised;
use catena_mechanism::description::body_state::{BodyState, WORLD};
use catena_mechanism::description::joint::FreeRotation;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::{BodyWrench, Exchange, body_wrenches, joint_efforts, powers};
use catena_mechanism::motion::inputs::Inputs;
use catena_mechanism::motion::kinematics::forward_kinematics;
use catena_mechanism::motion::state::{State, quaternion_product};
use std::ops::Range;
use std::sync::Arc;

/// The right-hand side of the first-order system of one mechanism.
#[derive(Clone, Debug)]
pub struct ReducedOde {
    articulated: ArticulatedBody,
    position_count: usize,
    velocity_count: usize,
    /// Runs of positions whose rates are velocities: first position, first velocity, length.
    plain: Vec<(usize, usize, usize)>,
    /// First entries of each quaternion and of its angular velocity.
    quaternions: Vec<(usize, usize)>,
    forced: Option<Forced>,
}

/// The workspace of forces besides gravity.
#[derive(Clone, Debug)]
struct Forced {
    mechanism: Arc<Mechanism>,
    bodies: Vec<BodyState>,
    /// About the centres of mass, then about the anchors.
    wrenches: Vec<BodyWrench>,
    efforts: Vec<f64>,
    /// The part of them that comes from outside.
    driven: Vec<f64>,
    /// Now (s).
    time: f64,
    /// Limits, friction and motors, and their efforts.
    regularised: Regularised,
    soft: Vec<f64>,
    /// Up to the last state that was stored.
    total: Exchange,
}

impl Forced {
    fn new(mechanism: &Mechanism) -> Option<Self> {
        let count = mechanism.bodies.len();
        (!mechanism.forces.is_empty()).then(|| Forced {
            mechanism: Arc::new(mechanism.clone()),
            bodies: vec![WORLD; count],
            wrenches: vec![BodyWrench::default(); count],
            efforts: vec![0.0; mechanism.velocity_count],
            driven: vec![0.0; mechanism.velocity_count],
            time: 0.0,
            regularised: Regularised::default(),
            soft: vec![0.0; mechanism.velocity_count],
            total: Exchange::default(),
        })
    }

    /// The efforts and wrenches of all forces, where the bodies have been placed.
    fn evaluate(&mut self, position: &[f64], velocity: &[f64]) {
        joint_efforts(&self.mechanism, self.time, (position, velocity), &self.bodies, &mut self.efforts);
        self.soft.fill(0.0);
        self.regularised.add_efforts(self.time, position, velocity, &mut self.soft);
        for ((effort, driven), soft) in self.efforts.iter_mut().zip(&self.driven).zip(&self.soft) {
            *effort += driven + soft;
        }
        body_wrenches(&self.mechanism, self.time, &self.bodies, &mut self.wrenches);
        for ((wrench, body), state) in self.wrenches.iter_mut().zip(&self.mechanism.bodies).zip(&self.bodies) {
            let to_anchor = state.rotation * body.joint.on_child.translation.vector;
            wrench.1 -= to_anchor.cross(&wrench.0);
        }
    }

    /// The powers (W) of forces without potential and of the efforts from outside.
    fn powers(&self, velocity: &[f64]) -> Exchange {
        let mut powers = powers(&self.mechanism, self.time, velocity, &self.bodies);
        let outside = self.driven.iter().zip(&self.soft).zip(velocity);
        powers.work += outside.map(|((driven, soft), rate)| (driven + soft) * rate).sum::<f64>();
        powers
    }
}

impl ReducedOde {
    /// Sets up the system.
    pub fn new(mechanism: &Mechanism) -> Self {
        let mut plain: Vec<(usize, usize, usize)> = Vec::new();
        let mut quaternions = Vec::new();
        for body in &mechanism.bodies {
            let joint = &body.joint;
            let (position, velocity) = (joint.position_index, joint.velocity_index);
            let ball = joint.kind.rotation() == FreeRotation::Ball;
            let scalars = joint.kind.velocity_count() - if ball { 3 } else { 0 };
            match plain.last_mut() {
                Some((p, v, length)) if *p + *length == position && *v + *length == velocity => *length += scalars,
                _ => plain.push((position, velocity, scalars)),
            }
            if ball {
                quaternions.push((position + scalars, velocity + scalars));
            }
        }
        ReducedOde {
            articulated: ArticulatedBody::new(mechanism),
            position_count: mechanism.position_count,
            velocity_count: mechanism.velocity_count,
            plain,
            quaternions,
            forced: Forced::new(mechanism),
        }
    }

    /// The system with limits, friction and motors as ordinary forces. All that they do counts as work put in.
    pub fn with_regularised(mechanism: &Mechanism, regularised: Regularised) -> Self {
        let mut driven = mechanism.clone();
        driven.forces.driven = true;
        let mut system = ReducedOde::new(&driven);
        if let Some(forced) = &mut system.forced {
            forced.regularised = regularised;
        }
        system
    }

    /// The mechanism that the system has to be set up for anew, because other forces act now or efforts that it does not know; gravity and masses,
    /// too, may have changed.
    pub fn changed(&self, mechanism: &Mechanism, inputs: Inputs) -> Option<Mechanism> {
        let known = match &self.forced {
            Some(forced) => {
                let own = &forced.mechanism;
                let driven = own.forces.driven || (inputs.is_none() && !mechanism.forces.driven);
                driven && own.forces.are_those_of(&mechanism.forces) && own.gravity == mechanism.gravity
            }
            None => mechanism.forces.is_empty() && inputs.is_none() && self.articulated.gravity() == mechanism.gravity,
        };
        (!known).then(|| {
            let mut now = mechanism.clone();
            now.forces.driven |=
                !inputs.is_none() || self.forced.as_ref().is_some_and(|forced| forced.mechanism.forces.driven);
            now
        })
    }

    /// Takes the efforts that drive the joints from now on.
    pub fn drive(&mut self, inputs: Inputs) {
        self.drive_at(0.0, inputs);
    }

    /// Takes the efforts that drive the joints at a time (s).
    pub fn drive_at(&mut self, time: f64, inputs: Inputs) {
        if let Some(forced) = &mut self.forced {
            forced.time = time;
            inputs.write_constant(&mut forced.driven);
            if let Some(changing) = inputs.changing {
                for (entry, &freedom) in changing.freedoms().iter().enumerate() {
                    forced.driven[freedom] += changing.effort(entry, time);
                }
            }
        }
    }

    /// Whether an effort is a function of time: [`ReducedOde::drive_at`] has to be told every instant at which slopes are asked for.
    pub fn depends_on_time(&self, inputs: Inputs) -> bool {
        let change = self.forced.as_ref().is_some_and(|forced| forced.mechanism.forces.change());
        change
            || inputs.changing.is_some()
            || self.forced.as_ref().is_some_and(|forced| forced.regularised.depends_on_time())
    }

    /// Length of y.
    pub fn dimension(&self) -> usize {
        self.position_count + self.velocity_count + if self.forced.is_some() { 2 } else { 0 }
    }

    /// The entries of y that are velocities.
    pub fn velocity_range(&self) -> Range<usize> {
        self.position_count..self.position_count + self.velocity_count
    }

    /// Writes ẏ into `slope`. Does not allocate.
    pub fn derivative(&mut self, y: &[f64], slope: &mut [f64]) {
        let (position, rest) = y.split_at(self.position_count);
        let velocity = &rest[..self.velocity_count];
        let (position_rate, rest) = slope.split_at_mut(self.position_count);
        let (acceleration, exchange) = rest.split_at_mut(self.velocity_count);
        for &(p, v, length) in &self.plain {
            position_rate[p..p + length].copy_from_slice(&velocity[v..v + length]);
        }
        for &(p, v) in &self.quaternions {
            let half = [0.0, 0.5 * velocity[v], 0.5 * velocity[v + 1], 0.5 * velocity[v + 2]];
            position_rate[p..p + 4].copy_from_slice(&quaternion_product(&position[p..p + 4], &half));
        }
        self.accelerations(position, velocity, acceleration);
        if let (Some(forced), [dissipated, work]) = (&self.forced, exchange) {
            let powers = forced.powers(velocity);
            (*dissipated, *work) = (powers.dissipated, powers.work);
        }
    }

    /// The joint accelerations of a state, without the rest of ẏ. Does not allocate.
    pub fn accelerations(&mut self, position: &[f64], velocity: &[f64], acceleration: &mut [f64]) {
        if let Some(Forced { mechanism, bodies, .. }) = &mut self.forced {
            forward_kinematics(mechanism, position, velocity, bodies);
        }
        self.accelerations_under_forces(position, velocity, acceleration);
    }

    /// The same, where positions and velocities have placed the bodies already.
    pub fn accelerations_of_placed(
        &mut self,
        position: &[f64],
        velocity: &[f64],
        bodies: &[BodyState],
        acceleration: &mut [f64],
    ) {
        if let Some(forced) = &mut self.forced {
            forced.bodies.copy_from_slice(bodies);
        }
        self.accelerations_under_forces(position, velocity, acceleration);
    }

    /// H⁻¹ τ for joint forces τ at the configuration whose accelerations were asked for last. Does not allocate.
    pub fn respond(&mut self, joint_force: &[f64], acceleration: &mut [f64]) {
        self.articulated.respond(joint_force, acceleration);
    }

    fn accelerations_under_forces(&mut self, position: &[f64], velocity: &[f64], acceleration: &mut [f64]) {
        match &mut self.forced {
            None => self.articulated.accelerations(position, velocity, None, acceleration),
            Some(forced) => {
                forced.evaluate(position, velocity);
                let (efforts, wrenches) = (&forced.efforts, &forced.wrenches);
                self.articulated.accelerations_with_forces(position, velocity, efforts, wrenches, acceleration);
            }
        }
    }

    /// The powers (W) of forces without potential, of the state whose accelerations were asked for last.
    pub fn powers(&self, velocity: &[f64]) -> Exchange {
        self.forced.as_ref().map_or(Exchange::default(), |forced| forced.powers(velocity))
    }

    /// The energy dissipated and the work put in from `start` to `end`.
    pub fn exchange(&self, start: &[f64], end: &[f64]) -> Exchange {
        let first = self.position_count + self.velocity_count;
        match (&start[first..], &end[first..]) {
            ([dissipated, work], [later, more]) => {
                Exchange { dissipated: later - dissipated, work: more - work, ..Exchange::default() }
            }
            _ => Exchange::default(),
        }
    }

    /// Scales every quaternion in y (or in its positions alone) to unit length.
    pub fn normalise(&self, y: &mut [f64]) {
        for &(p, _) in &self.quaternions {
            let quaternion = &mut y[p..p + 4];
            let norm = quaternion.iter().map(|c| c * c).sum::<f64>().sqrt();
            quaternion.iter_mut().for_each(|c| *c /= norm);
        }
    }

    /// Copies a state into y. The digits that rounding cut off the positions are added back as far as a number can hold them.
    pub fn load(&self, state: &State, y: &mut [f64]) {
        let (position, rest) = y.split_at_mut(self.position_count);
        let (velocity, exchange) = rest.split_at_mut(self.velocity_count);
        for ((entry, &value), &rest) in position.iter_mut().zip(&state.position).zip(&state.compensation) {
            *entry = value + rest;
        }
        velocity.copy_from_slice(&state.velocity);
        if let (Some(forced), [dissipated, work]) = (&self.forced, exchange) {
            (*dissipated, *work) = (forced.total.dissipated, forced.total.work);
        }
    }

    /// Copies y into a state; the time is left alone.
    pub fn store(&mut self, y: &[f64], state: &mut State) {
        let (position, rest) = y.split_at(self.position_count);
        let (velocity, exchange) = rest.split_at(self.velocity_count);
        if let (Some(forced), &[dissipated, work]) = (&mut self.forced, exchange) {
            forced.total = Exchange { dissipated, work, ..Exchange::default() };
        }
        state.position.copy_from_slice(position);
        state.compensation.fill(0.0);
        state.velocity.copy_from_slice(velocity);
    }
}

/// The name of the joint that owns entry `index` of y; the last joint for the energies behind all joints.
pub fn joint_of_entry(mechanism: &Mechanism, index: usize) -> String {
    let index = index.min((mechanism.position_count + mechanism.velocity_count).saturating_sub(1));
    let owns = |joint: &catena_mechanism::description::joint::Joint| match index.checked_sub(mechanism.position_count) {
        Some(velocity) => joint.velocity_range().contains(&velocity),
        None => joint.position_range().contains(&index),
    };
    mechanism.bodies.iter().find(|body| owns(&body.joint)).map_or_else(String::new, |body| body.joint.name.clone())
}

/// The end of a step of at most `step` towards `until`, and the length of the step.
///
/// A rest that is longer than the step only by rounding is taken whole, so that no sliver of a step remains.
pub fn next_time(time: f64, step: f64, until: f64) -> (f64, f64) {
    let remaining = until - time;
    if remaining <= step * 1.000_000_1 { (until, remaining) } else { (time + step, step) }
}
