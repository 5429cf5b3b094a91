//! The fastest mode of a mechanism with forces and closures, from differences of its accelerations.
//!
//! About an instant, `q̈ = a(q, q̇)` with all forces and on all closures is linear in a small deviation `d` along them,
//!
//! ```text
//!     K d = −∂a/∂q d ≈ −(a(q + εd) − a(q − εd)) / 2ε       [1/s²],    ε = 1e-6 where the largest entry of d is 1
//!     C d = −∂a/∂q̇ d = −(a(q̇ + d) − a(q̇ − d)) / 2          [1/s]
//! ```
//!
//! the second exactly, because accelerations are polynomials of second degree in velocities; the first without the dampers, whose forces change with
//! the directions in which they act, but do not pull back. K is symmetric in the scalar product of the inertia H, so that the power iteration
//! `w = K d` finds its largest eigenvalue from below,
//!
//! ```text
//!     ω⁴ ← T(w) / T(d),      2ζω ← dᵀH C d / dᵀH d,      d ← w        with T(x) = ½ xᵀH x, the kinetic energy of rates x (J)
//! ```
//!
//! A motion that dampers are about to stop shows in the acceleration itself: of a deviation w from where it settles `a = −C w`, so that
//!
//! ```text
//!     γ² = T(C a) / T(a),      w ≈ −a / γ        [1/s], [1/s of the coordinates]
//! ```
//!
//! while on the slow motion behind a hard damper a is as small as that is slow, and w with it.
//!
//! Deviations are projected on the closures; their second-order part does not count in central differences. The closures are factored for each
//! acceleration in a K d, whose differences show the change of the factors. Projections and C d use the factors of a state beside, which change them by ε. A tree under gravity needs K alone, which
//! [`crate::watching::dynamics`] has without differences.

use crate::watching::dynamics::Dynamics;
use crate::watching::fastest_mode::first_direction;
use crate::watching::watch::{Mode, Transient};
use catena_lobatto::coupled::known::Known;
use catena_lobatto::coupled::projection::Projection;
use catena_lobatto::plan::tree::Plan;
use catena_lobatto::stages::start::Start;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::{BodyWrench, body_wrenches, joint_efforts};
use catena_mechanism::motion::gaps::gap_accelerations;
use catena_mechanism::motion::kinematics::{BodyAcceleration, body_accelerations};
use catena_mechanism::motion::state::State;

/// ε: second order and rounding leave some nine digits of K.
const DEVIATION: f64 = 1e-6;

/// A decaying part of a motion counts if it has this part of the largest rate.
const SHARE: f64 = 1e-2;

/// Accelerations of a mechanism with forces and closures at one state after another.
#[derive(Clone)]
struct Motion {
    plan: Plan,
    start: Start,
    dynamics: Dynamics,
    wrenches: Vec<BodyWrench>,
    efforts: Vec<f64>,
    closing: Option<Closing>,
}

#[derive(Clone)]
struct Closing {
    projection: Projection,
    multipliers: Vec<f64>,
    bodies: Vec<BodyAcceleration>,
}

impl Motion {
    fn new(mechanism: &Mechanism) -> Self {
        let plan = Plan::new(mechanism);
        let closing = mechanism.has_closures().then(|| {
            let projection = Projection::new(mechanism);
            let multipliers = vec![0.0; projection.row_count()];
            Closing { projection, multipliers, bodies: vec![BodyAcceleration::default(); mechanism.bodies.len()] }
        });
        let mut dynamics = Dynamics::new(&plan, mechanism.velocity_count);
        dynamics.take_rotors(mechanism);
        Motion {
            start: Start::new(mechanism),
            dynamics,
            wrenches: vec![BodyWrench::default(); mechanism.bodies.len()],
            efforts: vec![0.0; mechanism.velocity_count],
            plan,
            closing,
        }
    }

    /// Forgets the factors of the closures: the looks that follow are at another state.
    fn go_elsewhere(&mut self) {
        if let Some(Closing { projection, .. }) = &mut self.closing {
            projection.go_elsewhere();
        }
    }

    /// Adds `sign · a` in a state to `sum`; of the closures with the factors at hand where these are `beside` the state.
    fn add(&mut self, mechanism: &Mechanism, state: &State, sign: f64, beside: bool, sum: &mut [f64]) {
        self.start.set(mechanism, state);
        let states = self.start.body_states();
        body_wrenches(mechanism, state.time, states, &mut self.wrenches);
        joint_efforts(mechanism, state.time, (&state.position, &state.velocity), states, &mut self.efforts);
        self.dynamics.apply(&self.start, &self.wrenches, &self.efforts);
        self.dynamics.set(&self.plan, &self.start, &mechanism.gravity.into());
        let accelerations = self.dynamics.accelerations_mut();
        if let Some(Closing { projection, multipliers, bodies }) = &mut self.closing {
            if !beside {
                projection.go_elsewhere();
            }
            projection.accelerations_beside(&self.start, accelerations, multipliers, |joints, out| {
                body_accelerations(mechanism, states, &state.velocity, joints, bodies);
                gap_accelerations(mechanism, state.time, states, joints, bodies, out);
            });
        }
        for (sum, acceleration) in sum.iter_mut().zip(accelerations) {
            *sum += sign * *acceleration;
        }
    }

    /// Adds `C d` at a state to `sum`; leaves that state in `moved`.
    fn brake(&mut self, mechanism: &Mechanism, state: &State, direction: &[f64], moved: &mut State, sum: &mut [f64]) {
        for sign in [1.0, -1.0] {
            moved.copy_from(state);
            for (velocity, value) in moved.velocity.iter_mut().zip(direction) {
                *velocity += sign * value;
            }
            self.add(mechanism, moved, -0.5 * sign, true, sum);
        }
        moved.copy_from(state);
    }

    /// T of rates at the positions of a state.
    fn kinetic(&mut self, mechanism: &Mechanism, state: &mut State, rates: impl Iterator<Item = f64>) -> f64 {
        for (velocity, rate) in state.velocity.iter_mut().zip(rates) {
            *velocity = rate;
        }
        self.start.set(mechanism, state);
        self.start.energy.kinetic
    }

    /// Projects rates on the closures at the positions of a state.
    fn project(&mut self, mechanism: &Mechanism, state: &State, rates: &mut [f64]) {
        if let Some(Closing { projection, .. }) = &mut self.closing {
            self.start.set(mechanism, state);
            projection.velocities_beside(mechanism, &self.start, rates);
        }
    }
}

/// Follows the fastest mode of a mechanism with forces and closures.
#[derive(Clone)]
pub struct Linearised {
    motion: Motion,
    /// `d`.
    direction: Vec<f64>,
    image: Vec<f64>,
    acceleration: Vec<f64>,
    state: State,
    /// The mechanism without its dampers, if it has any.
    undamped: Option<Mechanism>,
}

impl Linearised {
    /// An estimate without a known direction.
    pub fn new(mechanism: &Mechanism) -> Self {
        let forces = &mechanism.forces;
        let between_points = forces.point_springs.iter().any(|spring| spring.damping > 0.0);
        let damped = between_points || !forces.joint_dampers.is_empty() || !forces.drags.is_empty();
        let undamped = damped.then(|| {
            let mut undamped = mechanism.clone();
            undamped.forces.joint_dampers.clear();
            undamped.forces.drags.clear();
            undamped.forces.point_springs.iter_mut().for_each(|spring| spring.damping = 0.0);
            undamped
        });
        let mut mode = Linearised {
            motion: Motion::new(mechanism),
            direction: vec![0.0; mechanism.velocity_count],
            image: vec![0.0; mechanism.velocity_count],
            acceleration: vec![0.0; mechanism.velocity_count],
            state: State::zero(mechanism),
            undamped,
        };
        mode.forget();
        mode
    }

    /// Forgets the mode.
    pub fn forget(&mut self) {
        first_direction(&mut self.direction);
    }

    /// Takes over the ranks and flags of the closures.
    pub fn heed(&mut self, known: &Known) {
        if let Some(closing) = &mut self.motion.closing {
            closing.projection.heed(known.of_freedoms());
        }
    }

    /// The mode at a state, from below, after some power iterations; zero without stiffness, or if the state is not finite.
    pub fn estimate(&mut self, mechanism: &Mechanism, state: &State, iterations: usize) -> Mode {
        self.motion.go_elsewhere();
        self.motion.project(mechanism, state, &mut self.direction);
        scale(&mut self.direction);
        let mut frequency = 0.0;
        for _ in 0..iterations {
            self.image.fill(0.0);
            for sign in [1.0, -1.0] {
                self.state.copy_from(state);
                self.direction.iter_mut().for_each(|value| *value *= sign * DEVIATION);
                self.state.displace(mechanism, &self.direction);
                self.direction.iter_mut().for_each(|value| *value /= sign * DEVIATION);
                let resisting = self.undamped.as_ref().unwrap_or(mechanism);
                self.motion.add(resisting, &self.state, sign * -0.5 / DEVIATION, false, &mut self.image);
            }
            // The rest of the differences across the closures does not belong to the mode.
            self.motion.project(mechanism, state, &mut self.image);
            self.state.copy_from(state);
            let before = self.motion.kinetic(mechanism, &mut self.state, self.direction.iter().copied());
            let after = self.motion.kinetic(mechanism, &mut self.state, self.image.iter().copied());
            let power = after / before;
            if !power.is_normal() {
                self.forget();
                return Mode::default();
            }
            frequency = power.sqrt().sqrt();
            std::mem::swap(&mut self.direction, &mut self.image);
            scale(&mut self.direction);
        }
        let damping = if self.undamped.is_some() { self.damping(mechanism, state) / frequency } else { 0.0 };
        Mode { frequency, damping }
    }

    /// ζω of the mode [1/s].
    fn damping(&mut self, mechanism: &Mechanism, state: &State) -> f64 {
        self.image.fill(0.0);
        self.motion.brake(mechanism, state, &self.direction, &mut self.state, &mut self.image);
        // dᵀH w = ½ (T(d + w) − T(d − w)).
        let pairs = || self.direction.iter().zip(&self.image);
        let with = self.motion.kinetic(mechanism, &mut self.state, pairs().map(|(d, w)| d + w));
        let without = self.motion.kinetic(mechanism, &mut self.state, pairs().map(|(d, w)| d - w));
        let size = self.motion.kinetic(mechanism, &mut self.state, self.direction.iter().copied());
        (0.125 * (with - without) / size).max(0.0)
    }

    /// The largest eigenvalue of C [1/s], from below, by the power iteration `d ← C d`; zero without dampers, or where the state is not finite.
    pub fn hardest_damper(&mut self, mechanism: &Mechanism, state: &State, iterations: usize) -> f64 {
        if self.undamped.is_none() {
            return 0.0;
        }
        let Linearised { motion, acceleration, image, state: moved, .. } = self;
        motion.go_elsewhere();
        first_direction(acceleration);
        let mut decay = 0.0;
        for _ in 0..iterations {
            image.fill(0.0);
            motion.brake(mechanism, state, acceleration, moved, image);
            let before = motion.kinetic(mechanism, moved, acceleration.iter().copied());
            let after = motion.kinetic(mechanism, moved, image.iter().copied());
            let power = after / before;
            if !power.is_normal() {
                return decay;
            }
            decay = power.sqrt();
            acceleration.copy_from_slice(image);
            scale(acceleration);
        }
        decay
    }

    /// A motion that dampers are about to stop, if there is one to speak of.
    pub fn transient(&mut self, mechanism: &Mechanism, state: &State) -> Option<Transient> {
        self.undamped.as_ref()?;
        let Linearised { motion, acceleration, image, state: moved, .. } = self;
        motion.go_elsewhere();
        acceleration.fill(0.0);
        motion.add(mechanism, state, 1.0, true, acceleration);
        // The scale has the size of rates, so that the sums of the differences keep their digits.
        let scale = largest(&state.velocity).max(1.0) / largest(acceleration);
        acceleration.iter_mut().for_each(|value| *value *= scale);
        image.fill(0.0);
        motion.brake(mechanism, state, acceleration, moved, image);
        let before = motion.kinetic(mechanism, moved, acceleration.iter().copied());
        let after = motion.kinetic(mechanism, moved, image.iter().copied());
        let decay = (after / before).sqrt();
        let rate = largest(acceleration) / scale / decay;
        // Not where anything is no number.
        (rate > SHARE * largest(&state.velocity)).then_some(Transient { decay, rate })
    }
}

/// The largest entry, without its sign.
fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}

/// Makes the largest entry one.
fn scale(direction: &mut [f64]) {
    let largest = largest(direction);
    if largest > 0.0 {
        direction.iter_mut().for_each(|value| *value /= largest);
    }
}
