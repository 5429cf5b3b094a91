//! The constants of a mechanism in a plane, and the start of a step.
//!
//! Let `e₁, e₂` be the unit vectors of the plane and n its normal. Everything is projected at zero displacement: arms between anchors, arms to the
//! centres of mass, slides, gravity, and the moment of inertia about n. At the start of a step a body has turned by `(C, S) = (cos ψ, sin ψ)`, the
//! product of the turns of the joints on its path, each by `±q`, as its axis is n or −n:
//!
//! ```text
//!     arm = (C_p + S_p J) (arm⁰ + Σ q e⁰)          [m]       turns with the parent
//!     com = (C + S J) com⁰                         [m]       turns with the body
//!     v   = v_p + ω_p J arm + Σ q̇ e                [m/s]     of the anchor
//!     T   = ½ m |v + ω J com|² + ½ I ω²,           U = −m (g·x + g_n x_n)
//! ```
//!
//! where the height along n, `x_n`, never changes. [`crate::stages::start`] has the same of a mechanism in space, from rotation matrices.

use crate::plan::tree::Plan;
use crate::planar::body::{PlanarBody, turned};
use crate::planar::force_plan::{ForcesPlan, ForcesStart};
use crate::stages::start::{mimic_gaps, units_per_kilogram};
use catena_mechanism::description::joint::{FreeRotation, sine_cosine};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::energy::Energy;
use catena_mechanism::motion::kinematics::body_states;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::plane::Plane;
use nalgebra::Vector3;

/// The constant part of a body.
#[derive(Clone)]
pub(crate) struct BodyPlane {
    /// One if the joint turns about n, minus one if it turns about −n.
    pub sign: f64,
    /// Mass (kg).
    mass: f64,
    /// Moment of inertia about n through the centre of mass, and through the anchor [kg m²].
    central: f64,
    inertia: f64,
    /// At zero displacement: the vector from the parent's anchor to this one, to the centre of mass, and along the slides.
    arm: [f64; 2],
    com: [f64; 2],
    slides: [[f64; 2]; 2],
}

/// A mechanism in its plane.
#[derive(Clone)]
pub(crate) struct PlanarPlan {
    /// Which bodies hang where.
    pub tree: Plan,
    /// One entry a body.
    pub bodies: Vec<BodyPlane>,
    /// Gravity in the plane [m/s²]; zero along the normal.
    pub gravity: [f64; 3],
    /// Forces between points, and on bodies.
    pub forces: ForcesPlan,
    /// Largest component of the normal: the weight of the sine of a turn in the rotation matrix.
    pub share: f64,
    /// Potential energy of the heights along n (J).
    offset: f64,
}

/// The start of a step.
#[derive(Clone)]
pub(crate) struct PlanarStart {
    /// One entry a body.
    pub bodies: Vec<PlanarBody>,
    /// Direction of each slide; one entry a degree of freedom.
    pub axes: Vec<[f64; 2]>,
    /// Velocity of each degree of freedom.
    pub rates: Vec<f64>,
    /// `q_follower − multiplier · q_leader − offset` of every mimic.
    pub mimic_gaps: Vec<f64>,
    /// ṙ of every mimic whose joint is moved in time [rad/s or m/s]; else zero.
    pub mimic_rates: Vec<f64>,
    /// Quantities of the forces.
    pub applied: ForcesStart,
    /// Energy of the state.
    pub energy: Energy,
    /// Whether every step has its own unit of mass ([`crate::stages::start::Start::with_units`]).
    own_unit: bool,
}

impl PlanarPlan {
    /// Projects a mechanism to the plane it moves in.
    pub fn new(mechanism: &Mechanism, plane: &Plane) -> Self {
        let normal = plane.normal();
        let flat = |v: &Vector3<f64>| plane.flat(v);
        let zero = body_states(mechanism, &State::zero(mechanism));
        let mut offset = 0.0;
        let anchor = |index: usize| {
            let state = &zero[index];
            state.position + state.rotation * mechanism.bodies[index].joint.on_child.translation.vector
        };
        let bodies = mechanism.bodies.iter().enumerate().map(|(index, body)| {
            let joint = &body.joint;
            let frame = zero[index].rotation * joint.on_child.rotation.matrix();
            let from = body.parent.map_or_else(Vector3::zeros, anchor);
            let com = flat(&(zero[index].position - anchor(index)));
            let mut slides = [[0.0; 2]; 2];
            for (slide, &axis) in slides.iter_mut().zip(joint.kind.translation_axes()) {
                *slide = flat(&frame.column(axis).into_owned());
            }
            let along = zero[index].rotation.transpose() * normal;
            let central = body.inertia.dot(&along.component_mul(&along));
            offset -= body.mass * mechanism.gravity.dot(&normal) * zero[index].position.dot(&normal);
            BodyPlane {
                sign: if frame.column(2).dot(&normal) < 0.0 { -1.0 } else { 1.0 },
                mass: body.mass,
                central,
                inertia: central + body.mass * (com[0] * com[0] + com[1] * com[1]),
                arm: flat(&(anchor(index) - from)),
                com,
                slides,
            }
        });
        let bodies = bodies.collect();
        let [x, y] = flat(&mechanism.gravity);
        PlanarPlan {
            tree: Plan::new(mechanism),
            forces: ForcesPlan::new(mechanism, plane, &zero),
            bodies,
            gravity: [x, y, 0.0],
            share: normal.amax(),
            offset,
        }
    }
}

impl PlanarStart {
    /// Room for the start of a step.
    pub fn new(mechanism: &Mechanism) -> Self {
        PlanarStart {
            bodies: vec![PlanarBody::default(); mechanism.bodies.len()],
            axes: vec![[0.0; 2]; mechanism.velocity_count],
            rates: vec![0.0; mechanism.velocity_count],
            mimic_gaps: vec![0.0; mechanism.mimics.len()],
            mimic_rates: vec![0.0; mechanism.mimics.len()],
            applied: ForcesStart::new(mechanism),
            energy: Energy::default(),
            own_unit: mechanism.is_plain_tree(),
        }
    }

    /// Takes the state at the start of a step. Does not allocate.
    pub fn set(&mut self, plan: &PlanarPlan, mechanism: &Mechanism, state: &State) {
        self.rates.copy_from_slice(&state.velocity);
        let mut energy = Energy { potential: plan.offset, ..Energy::default() };
        let per_unit = if self.own_unit { units_per_kilogram(&state.velocity) } else { 1.0 };
        for (index, (tree, flat)) in plan.tree.bodies.iter().zip(&plan.bodies).enumerate() {
            let parent = match tree.parent {
                Some(parent) => self.bodies[parent],
                None => PlanarBody { turn: [1.0, 0.0], ..PlanarBody::default() },
            };
            let slots = mechanism.bodies[index].joint.position_range();
            let (positions, rests) = (&state.position[slots.clone()], &state.compensation[slots]);
            let (mut arm, mut sliding) = (flat.arm, [0.0; 2]);
            for slide in 0..tree.translations {
                let freedom = tree.first_axis + slide;
                let axis = turned(&parent.turn, &flat.slides[slide]);
                for side in 0..2 {
                    arm[side] += positions[slide] * flat.slides[slide][side];
                    sliding[side] += self.rates[freedom] * axis[side];
                }
                self.axes[freedom] = axis;
            }
            let arm = turned(&parent.turn, &arm);
            let (mut turn, mut spin) = (parent.turn, parent.spin);
            if tree.rotation != FreeRotation::None {
                let (sine, cosine) = sine_cosine(positions[tree.translations], rests[tree.translations]);
                turn = turned(&turn, &[cosine, flat.sign * sine]);
                spin += flat.sign * self.rates[tree.first_axis + tree.translations];
            }
            let com = turned(&turn, &flat.com);
            let velocity = [
                parent.velocity[0] - parent.spin * arm[1] + sliding[0],
                parent.velocity[1] + parent.spin * arm[0] + sliding[1],
            ];
            let position = [parent.position[0] + arm[0], parent.position[1] + arm[1]];
            let moving = [velocity[0] - spin * com[1], velocity[1] + spin * com[0]];
            energy.kinetic +=
                0.5 * flat.mass * (moving[0] * moving[0] + moving[1] * moving[1]) + 0.5 * flat.central * spin * spin;
            let joint = &mechanism.bodies[index].joint;
            if joint.armature != 0.0 {
                energy.kinetic += 0.5 * joint.armature * self.rates[joint.velocity_index].powi(2);
            }
            energy.potential -=
                flat.mass * (plan.gravity[0] * (position[0] + com[0]) + plan.gravity[1] * (position[1] + com[1]));
            let (mass, inertia) = (flat.mass * per_unit, flat.inertia * per_unit);
            let heavy = [mass * com[0], mass * com[1]];
            self.bodies[index] = PlanarBody { arm, mass, inertia, heavy, spin, sliding, turn, position, velocity };
        }
        mimic_gaps(mechanism, state, [&mut self.mimic_gaps, &mut self.mimic_rates]);
        if !mechanism.forces.is_empty() {
            let stored = self.applied.set(&plan.forces, mechanism, state, &self.bodies);
            (energy.spring, energy.load) = (stored.spring, stored.load);
        }
        self.energy = energy;
    }
}
