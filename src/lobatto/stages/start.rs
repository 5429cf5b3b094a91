//! The start of a step: everything the stages need of the known state, once a step.
//!
//! All vectors are in world axes. For body `b` with anchor `a` (the origin of its joint frame) and parent anchor `a_p`:
//!
//! ```text
//!     arm   = a − a_p                 [m]        turns with the parent
//!     com   = x − a                   [m]        turns with the body
//!     Σ     = R Σ_body Rᵀ             [kg m²]    second moments about the centre of mass
//!     axes  = the free axes of the joint: translations turn with the parent, rotations with the body
//! ```
//!
//! Under gravity alone the motion does not depend on the unit of mass, and a step may have one of its own: [`Start::with_units`]. An inertia about a
//! joint that is the same in every step would round to the same side in every step, while the momentum that it is to be divided by it does not: the
//! energy then drifts by some 2e-17 of itself a step. In a unit of mass that differs from step to step all roundings are as good as random.

use crate::numbers::algebra::{Symmetric, Vector};
use crate::numbers::arithmetic::Arithmetic;
use crate::numbers::lanes::Lanes;
use crate::plan::forces::AppliedStart;
use crate::vectors::portable::Portable;
use catena_mechanism::description::body_state::{BodyState, WORLD};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::stored;
use catena_mechanism::ground::matrices::{column, times};
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::gaps::mimic_gap;
use catena_mechanism::motion::kinematics::{Placed, place};
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::special_bodies::{pivoted_bodies, tumbles};
use nalgebra::{Matrix3, Vector3};

/// The start-of-step part of a body.
#[derive(Clone, Copy, Debug, Default)]
pub struct BodyStart<R = f64> {
    /// Mass (kg, or the unit of the step).
    pub mass: R,
    /// Vector from the parent's anchor to this body's (m).
    pub arm: [R; 3],
    /// Vector from the anchor to the centre of mass (m).
    pub com: [R; 3],
    /// Σ: xx, xy, xz, yy, yz, zz [kg m²].
    pub sigma: [R; 6],
    /// Velocity of the centre of mass [m/s].
    pub velocity: [R; 3],
    /// Angular velocity [rad/s].
    pub spin: [R; 3],
}

/// Quantities of the equation at the start of a step.
#[derive(Clone, Copy, Debug, Default)]
pub struct Pivot<R = f64> {
    /// `I` [kg m²].
    pub inertia: R,
    /// `m g·(a × c)` and `m g·(a × (a × c))`: the torque of gravity at the start, and a quarter of a turn later [N m].
    pub weights: [R; 2],
}

impl<R: Copy> Pivot<R> {
    /// The equation of a body on an axis (a unit vector).
    #[inline(always)]
    pub fn new<V: Arithmetic<Real = R>>(known: &BodyStart<R>, axis: &[R; 3], gravity: &[f64; 3]) -> Self {
        let (axis, mass) = (Vector::<V>::splat(axis), V::whole(known.mass));
        let across = axis.cross(Vector::splat(&known.com));
        let second = Symmetric(known.sigma.map(V::whole));
        let [xx, _, _, yy, _, zz] = second.0;
        let inertia = across.dot(across).mul_add(mass, xx + yy + zz - axis.dot(second.apply(axis)));
        let gravity = Vector(gravity.map(V::splat)).times(mass);
        let weights = [gravity.dot(across), gravity.dot(axis.cross(across))];
        Pivot { inertia: inertia.lane(0), weights: weights.map(|weight| weight.lane(0)) }
    }

    /// The same in other digits.
    #[inline(always)]
    pub fn map<T>(&self, digits: impl Fn(R) -> T + Copy) -> Pivot<T> {
        Pivot { inertia: digits(self.inertia), weights: self.weights.map(digits) }
    }
}

/// The start of a step.
#[derive(Clone)]
pub struct Start<R = f64> {
    /// One entry a body.
    pub bodies: Vec<BodyStart<R>>,
    /// One entry a body on a hinge that the world holds.
    pub pivots: Vec<Pivot<R>>,
    /// `J⁻¹` about the centre of mass of a body that floats freely: xx, xy, xz, yy, yz, zz [1/(kg m²)].
    pub inverse: Option<[R; 6]>,
    /// World direction of each degree of freedom.
    pub axes: Vec<[R; 3]>,
    /// Velocity of each degree of freedom.
    pub rates: Vec<R>,
    /// `q_follower − multiplier · q_leader − offset` of every mimic.
    pub mimic_gaps: Vec<f64>,
    /// ṙ of every mimic whose joint is moved in time [rad/s or m/s]; else zero.
    pub mimic_rates: Vec<f64>,
    /// Quantities of the forces.
    pub applied: AppliedStart,
    /// Energy of the state.
    pub energy: Energy,
    /// The unit of mass of the step (1/kg).
    pub units: f64,
    states: Vec<BodyState>,
    /// The bodies of `pivots`.
    pivoted: Vec<usize>,
    /// Whether every step has its own unit of mass.
    own_unit: bool,
}

impl<R: Copy + Default> Start<R> {
    /// Room for the start of a step.
    pub fn new(mechanism: &Mechanism) -> Self {
        let pivoted = pivoted_bodies(mechanism).into_iter().enumerate().filter(|(_, pivoted)| *pivoted);
        let pivoted: Vec<usize> = pivoted.map(|(body, _)| body).collect();
        Start {
            bodies: vec![BodyStart::default(); mechanism.bodies.len()],
            pivots: vec![Pivot::default(); pivoted.len()],
            pivoted,
            inverse: tumbles(mechanism).then(|| [R::default(); 6]),
            axes: vec![[R::default(); 3]; mechanism.velocity_count],
            rates: vec![R::default(); mechanism.velocity_count],
            mimic_gaps: vec![0.0; mechanism.mimics.len()],
            mimic_rates: vec![0.0; mechanism.mimics.len()],
            applied: AppliedStart::new(mechanism),
            energy: Energy::default(),
            units: 1.0,
            states: vec![WORLD; mechanism.bodies.len()],
            own_unit: false,
        }
    }

    /// The same for a kernel: a unit of mass for every step, if gravity is the only force.
    pub fn with_units(mechanism: &Mechanism) -> Self {
        Start { own_unit: mechanism.is_plain_tree(), ..Start::new(mechanism) }
    }

    /// Takes bodies, axes and rates of a start in doubles, in these digits.
    #[inline(always)]
    pub fn take(&mut self, start: &Start, digits: impl Fn(f64) -> R + Copy) {
        for (own, &rate) in self.rates.iter_mut().zip(&start.rates) {
            *own = digits(rate);
        }
        for (own, axis) in self.axes.iter_mut().zip(&start.axes) {
            *own = axis.map(digits);
        }
        self.inverse = start.inverse.map(|inverse| inverse.map(digits));
        for (own, known) in self.pivots.iter_mut().zip(&start.pivots) {
            *own = known.map(digits);
        }
        for (own, known) in self.bodies.iter_mut().zip(&start.bodies) {
            *own = BodyStart {
                mass: digits(known.mass),
                arm: known.arm.map(digits),
                com: known.com.map(digits),
                sigma: known.sigma.map(digits),
                velocity: known.velocity.map(digits),
                spin: known.spin.map(digits),
            };
        }
    }
}

impl Start {
    /// Poses and velocities of all bodies.
    pub fn body_states(&self) -> &[BodyState] {
        &self.states
    }

    /// Pose and velocity of a body.
    pub fn body_state(&self, body: usize) -> &BodyState {
        &self.states[body]
    }

    /// The place of a body's anchor in the world (m).
    pub fn anchor(&self, body: usize) -> [f64; 3] {
        let (position, com) = (self.states[body].position, self.bodies[body].com);
        [position.x - com[0], position.y - com[1], position.z - com[2]]
    }

    /// The same, to be written.
    #[inline(always)]
    pub(crate) fn body_state_mut(&mut self, body: usize) -> &mut BodyState {
        &mut self.states[body]
    }

    /// Copies the bodies on hinges that the world holds from the start of all bodies.
    #[inline(always)]
    pub(crate) fn set_pivots(&mut self, mechanism: &Mechanism) {
        for (pivot, &body) in self.pivots.iter_mut().zip(&self.pivoted) {
            let axis = &self.axes[mechanism.bodies[body].joint.velocity_index];
            *pivot = Pivot::new::<Portable<1>>(&self.bodies[body], axis, &mechanism.gravity.into());
        }
    }

    /// Takes the state at the start of a step. Does not allocate.
    pub fn set(&mut self, mechanism: &Mechanism, state: &State) {
        self.take_state(mechanism, state);
    }

    /// The same with the instructions of a vector type, to the same bits.
    pub fn set_with<V: Lanes>(&mut self, mechanism: &Mechanism, state: &State) {
        V::apart(
            #[inline(always)]
            || self.take_state(mechanism, state),
        );
    }

    #[inline(always)]
    fn take_state(&mut self, mechanism: &Mechanism, state: &State) {
        self.rates.copy_from_slice(&state.velocity);
        let mut energy = Energy::default();
        self.units = if self.own_unit { units_per_kilogram(&state.velocity) } else { 1.0 };
        let per_unit = self.units;
        for (index, body) in mechanism.bodies.iter().enumerate() {
            let joint = &body.joint;
            let parent = body.parent.map_or(WORLD, |parent| self.states[parent]);
            let slots = joint.position_range();
            let (position, rest) = (&state.position[slots.clone()], &state.compensation[slots]);
            let velocity = &state.velocity[joint.velocity_range()];
            let Placed { body: own, frame, translation } = place(joint, &parent, position, rest, velocity);
            self.states[index] = own;
            let com = -times(&own.rotation, &joint.on_child.translation.vector);
            // The anchor on the parent, from the parent's own anchor, without a difference of world positions.
            let mut arm = times(&parent.rotation, &joint.on_parent.translation.vector) + times(&frame, &translation);
            if let Some(parent) = body.parent {
                for axis in 0..3 {
                    arm[axis] += self.bodies[parent].com[axis];
                }
            }
            let moments = body.inertia;
            let second = Vector3::repeat(0.5 * moments.sum()) - moments;
            let sigma = turned_diagonal(&own.rotation, &second);
            // ωᵀ J ω with J = ½ tr J − Σ.
            let spin = own.angular_velocity;
            let spread = (sigma[0] * spin.x + 2.0 * (sigma[1] * spin.y + sigma[2] * spin.z)) * spin.x
                + (sigma[3] * spin.y + 2.0 * sigma[4] * spin.z) * spin.y
                + sigma[5] * spin.z * spin.z;
            energy.kinetic += 0.5 * (body.mass * own.velocity.norm_squared())
                + 0.5 * (0.5 * moments.sum() * spin.norm_squared() - spread);
            if joint.armature != 0.0 {
                energy.kinetic += 0.5 * joint.armature * velocity[0] * velocity[0];
            }
            energy.potential -= body.mass * mechanism.gravity.dot(&own.position);
            self.bodies[index] = BodyStart {
                mass: body.mass * per_unit,
                arm: arm.into(),
                com: com.into(),
                sigma: sigma.map(|moment| moment * per_unit),
                velocity: own.velocity.into(),
                spin: own.angular_velocity.into(),
            };
            let mut slot = joint.velocity_index;
            for &axis in joint.kind.translation_axes() {
                self.axes[slot] = column(&frame, axis).into();
                slot += 1;
            }
            for &axis in joint.kind.rotation_axes() {
                self.axes[slot] = times(&own.rotation, &column(joint.on_child.rotation.matrix(), axis)).into();
                slot += 1;
            }
        }
        if let Some(inverse) = &mut self.inverse {
            let moments = mechanism.bodies[0].inertia * per_unit;
            *inverse = turned_diagonal(&self.states[0].rotation, &moments.map(|moment| 1.0 / moment));
        }
        self.set_pivots(mechanism);
        mimic_gaps(mechanism, state, [&mut self.mimic_gaps, &mut self.mimic_rates]);
        if !mechanism.forces.is_empty() {
            self.applied.set(mechanism, state, &self.states);
            let stored = stored(mechanism, &state.position, &self.states);
            (energy.spring, energy.load) = (stored.spring, stored.load);
        }
        self.energy = energy;
    }
}

/// `R diag(d) Rᵀ`: xx, xy, xz, yy, yz, zz.
#[inline(always)]
fn turned_diagonal(rotation: &Matrix3<f64>, diagonal: &Vector3<f64>) -> [f64; 6] {
    let entry = |row: usize, column: usize| {
        rotation[(row, 0)] * diagonal.x * rotation[(column, 0)]
            + rotation[(row, 1)] * diagonal.y * rotation[(column, 1)]
            + rotation[(row, 2)] * diagonal.z * rotation[(column, 2)]
    };
    [entry(0, 0), entry(0, 1), entry(0, 2), entry(1, 1), entry(1, 2), entry(2, 2)]
}

/// A number from 1 to 2 that is as good as random, but the same for the same rates.
pub(crate) fn units_per_kilogram(rates: &[f64]) -> f64 {
    /// An odd number without a pattern: 2⁶⁴ over the golden ratio.
    const SPREAD: u64 = 0x9e37_79b9_7f4a_7c15;
    let mix = |mixed: u64, rate: &f64| (mixed.rotate_left(23) ^ rate.to_bits()).wrapping_mul(SPREAD);
    let mantissa = rates.iter().fold(0, mix) >> 12;
    f64::from_bits(1.0_f64.to_bits() | mantissa)
}

/// Writes `q_follower − multiplier · q_leader − offset` of every mimic in a state, and the rates of joints that are moved in time.
pub(crate) fn mimic_gaps(mechanism: &Mechanism, state: &State, [gaps, rates]: [&mut [f64]; 2]) {
    for ((gap, rate), mimic) in gaps.iter_mut().zip(rates).zip(&mechanism.mimics) {
        *gap = mimic_gap(mimic, state).0;
        *rate = mimic.motion(state.time, state.time)[1];
    }
}
