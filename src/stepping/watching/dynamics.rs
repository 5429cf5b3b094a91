//! The motion at one instant, for the step control: accelerations, their rates, and how stiff the joints are.
//!
//! In world axes about the anchor of each body, as in [`catena_lobatto::stages::start`]: anchor acceleration `a`, angular acceleration `φ`,
//! arms `r` from the parent's anchor and `c` to the centre of mass, sliding velocity `u`, turning rate `w`,
//!
//! ```text
//!     φ = φ_p + ω_p × w + Σ q̈ z          a = a_p + φ_p × r + ω_p × (ω_p × r) + 2 ω_p × u + Σ q̈ t
//!     f = m (ẍ − g)  [N],   ẍ = a + φ × c + ω × (ω × c)          Z = (φ̂ + ω̂²) Σ  [N m],  e = vee(Z − Zᵀ)
//!     F = Σ f,   T = Σ e + (x − a) × f                           over the subtree, about its joint's anchor
//!     z·T = 0,   t·F = 0                                         for every free rotation z and translation t
//! ```
//!
//! The joint accelerations `q̈` follow from the last line by the articulated recursion; applied wrenches are taken off `f` and `T` of their bodies,
//! and efforts τ in the joints stand in place of the zeros. With the wrenches of all bodies held fast, a displacement with the twist `(α, ψ)` of each
//! body changes that line by `K δq`, the geometric stiffness:
//!
//! ```text
//!     δ(z·T) = (ψ_p × z)·T + z·δT,       δ(t·F) = (ψ_p × t)·F
//!     δT = −(tr Z − Zᵀ) ψ + (ψ × c) × f + Σ_children δT + (α_child − α) × F_child
//! ```
//!
//! and in time the same line, differentiated as it stands, gives the rates of the accelerations.

use catena_lobatto::numbers::algebra::{Matrix, Symmetric, Vector};
use catena_lobatto::numbers::lanes::Lanes;
use catena_lobatto::plan::tree::{BodyPlan, Plan};
use catena_lobatto::solve::sweeps::collect;
use catena_lobatto::stages::articulated::{Articulated, Eliminated, Push};
use catena_lobatto::stages::start::{BodyStart, Start};
use catena_lobatto::vectors::portable::Portable;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::total::BodyWrench;
use nalgebra::{Matrix3, Vector3};

/// One number where the step has a lane for each stage.
type Scalar = Portable<1>;

/// Data of a body.
#[derive(Clone, Copy, Default)]
pub struct Body {
    /// Acceleration of the anchor [m/s²].
    linear: Vector3<f64>,
    /// Angular acceleration [rad/s²].
    pub angular: Vector3<f64>,
    /// Force on the body itself (N).
    pub own: Vector3<f64>,
    /// Force on the subtree (N).
    pub force: Vector3<f64>,
    /// Torque on the subtree about the anchor [N m].
    torque: Vector3<f64>,
    /// Z.
    turn: Matrix3<f64>,
}

/// Factors of the elimination of a degree of freedom.
#[derive(Clone, Copy, Default)]
struct Row {
    force_ratio: Vector3<f64>,
    torque_ratio: Vector3<f64>,
    /// `1 / (sᵀ A s)`.
    inverse: f64,
}

/// Twist or wrench of a body: the part at its anchor, and the angular part.
type Pair = (Vector3<f64>, Vector3<f64>);

/// The motion at one instant.
#[derive(Clone)]
pub struct Dynamics {
    pub bodies: Vec<Body>,
    rows: Vec<Row>,
    /// Sums of the children's inertias, in the slots of [`Plan::below`].
    slots: Vec<Articulated<Scalar>>,
    /// Twists of the last forward sweep; wrenches on the way to it.
    pub pairs: Vec<Pair>,
    /// Changes of the wrenches, leaf to root.
    pub changes: Vec<Pair>,
    pub accelerations: Vec<f64>,
    /// Applied to each body: force (N), and torque about its anchor [N m].
    wrenches: Vec<Pair>,
    /// In the joints along each degree of freedom [N m or N].
    efforts: Vec<f64>,
    /// Inertia of the rotor of each degree of freedom [kg m² or kg].
    rotors: Vec<f64>,
}

impl Dynamics {
    /// Room for a mechanism under gravity alone.
    pub fn new(plan: &Plan, freedoms: usize) -> Self {
        let count = plan.bodies.len();
        Dynamics {
            bodies: vec![Body::default(); count],
            rows: vec![Row::default(); freedoms],
            slots: vec![Articulated::zero(); plan.slots + 2],
            pairs: vec![Pair::default(); count],
            changes: vec![Pair::default(); count],
            accelerations: vec![0.0; freedoms],
            wrenches: vec![Pair::default(); count],
            efforts: vec![0.0; freedoms],
            rotors: vec![0.0; freedoms],
        }
    }

    /// Takes the rotors of a mechanism.
    pub fn take_rotors(&mut self, mechanism: &Mechanism) {
        mechanism.rotors().for_each(|(freedom, armature)| self.rotors[freedom] = armature);
    }

    /// Applies wrenches about the centres of mass of the bodies at `start`, and efforts in the joints, from now on.
    pub fn apply(&mut self, start: &Start, wrenches: &[BodyWrench], efforts: &[f64]) {
        for ((own, known), (force, torque)) in self.wrenches.iter_mut().zip(&start.bodies).zip(wrenches) {
            *own = (*force, torque + Vector3::from(known.com).cross(force));
        }
        self.efforts.copy_from_slice(efforts);
    }

    /// Second derivative of every degree of freedom at the instant of the last [`Dynamics::set`].
    pub fn accelerations(&self) -> &[f64] {
        &self.accelerations
    }

    /// The same, to be corrected for closures.
    pub fn accelerations_mut(&mut self) -> &mut [f64] {
        &mut self.accelerations
    }

    /// Takes an instant: factors the joint-space inertia `H` and finds accelerations and wrenches.
    pub fn set(&mut self, plan: &Plan, start: &Start, gravity: &[f64; 3]) {
        let gravity = Vector3::from(*gravity);
        for (index, (own, known)) in plan.bodies.iter().zip(&start.bodies).enumerate() {
            let (parent, spin) = self.parent(own, start);
            let (slide, turn) = joint_motion(own, start, &start.rates);
            let arm = Vector3::from(known.arm);
            let body = &mut self.bodies[index];
            body.angular = parent.angular + spin.cross(&turn);
            body.linear = parent.linear + parent.angular.cross(&arm) + spin.cross(&(spin.cross(&arm) + 2.0 * slide));
        }
        for (index, (own, known)) in plan.bodies.iter().zip(&start.bodies).enumerate().rev() {
            let (force, torque, _) = body_wrench(known, &self.bodies[index], &gravity);
            let alone = body_inertia(known, force - self.wrenches[index].0, torque - self.wrenches[index].1);
            let mut total = alone.plus(&self.slots[plan.below(index)]);
            for freedom in own.freedoms().rev() {
                let axis = Vector::splat(&start.axes[freedom]);
                let push = Some(Push { effort: lane(self.efforts[freedom]), inertia: lane(self.rotors[freedom]) });
                let Eliminated { force_ratio, torque_ratio, bias, inverse, .. } =
                    if freedom < own.first_axis + own.translations {
                        total.eliminate_translation(axis, push)
                    } else {
                        total.eliminate_rotation(axis, push)
                    };
                self.accelerations[freedom] = scalar(bias);
                self.rows[freedom] = Row {
                    force_ratio: vector(force_ratio),
                    torque_ratio: vector(torque_ratio),
                    inverse: scalar(inverse),
                };
            }
            if own.parent.is_some() {
                collect(plan, own, &mut self.slots, &total.shifted(Vector::splat(&known.arm)));
            }
        }
        let mut accelerations = std::mem::take(&mut self.accelerations);
        self.forward(plan, start, &mut accelerations);
        self.accelerations = accelerations;
        for (index, known) in start.bodies.iter().enumerate() {
            let (linear, angular) = self.pairs[index];
            let body = &mut self.bodies[index];
            body.linear += linear;
            body.angular += angular;
            (body.own, body.torque, body.turn) = body_wrench(known, body, &gravity);
            body.own -= self.wrenches[index].0;
            body.torque -= self.wrenches[index].1;
            body.force = body.own;
        }
        for (index, own) in plan.bodies.iter().enumerate().rev() {
            if let Some(parent) = own.parent {
                let Body { force, torque, .. } = self.bodies[index];
                let arm = Vector3::from(start.bodies[index].arm);
                self.bodies[parent].force += force;
                self.bodies[parent].torque += torque + arm.cross(&force);
            }
        }
    }

    /// Solves `H x = b` in place.
    pub fn solve(&mut self, plan: &Plan, start: &Start, values: &mut [f64]) {
        self.pairs.fill(Pair::default());
        for (index, own) in plan.bodies.iter().enumerate().rev() {
            let (mut force, mut torque) = self.pairs[index];
            for freedom in own.freedoms().rev() {
                let row = &self.rows[freedom];
                let axis = Vector3::from(start.axes[freedom]);
                let along = if freedom < own.first_axis + own.translations { force } else { torque };
                let left = values[freedom] - axis.dot(&along);
                force += row.force_ratio * left;
                torque += row.torque_ratio * left;
                values[freedom] = left * row.inverse;
            }
            if let Some(parent) = own.parent {
                let arm = Vector3::from(start.bodies[index].arm);
                self.pairs[parent].0 += force;
                self.pairs[parent].1 += torque + arm.cross(&force);
            }
        }
        self.forward(plan, start, values);
    }

    /// Writes `K v`; returns `vᵀ H v`.
    pub fn stiffness(&mut self, plan: &Plan, start: &Start, direction: &[f64], out: &mut [f64]) -> f64 {
        let mut size = 0.0;
        for (index, (own, known)) in plan.bodies.iter().zip(&start.bodies).enumerate() {
            let parent = self.parent_twist(own);
            let (slide, turn) = joint_motion(own, start, direction);
            let com = Vector3::from(known.com);
            let angular = parent.1 + turn;
            let linear = parent.0 + parent.1.cross(&Vector3::from(known.arm)) + slide;
            let swing = angular.cross(&com);
            size += known.mass * (linear + swing).norm_squared() + angular.dot(&spin_inertia(known, &angular));
            let body = &self.bodies[index];
            let spread = body.turn.tr_mul(&angular) - body.turn.trace() * angular;
            self.pairs[index] = (linear, angular);
            // The forces are held, so that only torques change.
            self.changes[index] = (Vector3::zeros(), spread + swing.cross(&body.own));
        }
        for (index, own) in plan.bodies.iter().enumerate().rev() {
            let parent = self.parent_twist(own);
            self.rows_of(own, start, index, &parent.1, out);
            if let Some(above) = own.parent {
                let moved = self.pairs[index].0 - parent.0;
                let change = self.changes[index].1 + moved.cross(&self.bodies[index].force);
                self.changes[above].1 += change;
            }
        }
        size
    }

    /// Changes of the rows of a joint, if its axes turn with the parent by `turn` and the wrench changes.
    pub fn rows_of(&self, own: &BodyPlan, start: &Start, index: usize, turn: &Vector3<f64>, out: &mut [f64]) {
        let (force, torque) = self.changes[index];
        let body = &self.bodies[index];
        for freedom in own.freedoms() {
            let axis = Vector3::from(start.axes[freedom]);
            let (change, carried) =
                if freedom < own.first_axis + own.translations { (force, body.force) } else { (torque, body.torque) };
            out[freedom] = axis.dot(&change) + turn.cross(&axis).dot(&carried);
        }
    }

    /// Root to leaf: the solution in place of each row's value without its parent, and the twists of all bodies.
    fn forward(&mut self, plan: &Plan, start: &Start, values: &mut [f64]) {
        for (index, (own, known)) in plan.bodies.iter().zip(&start.bodies).enumerate() {
            let (mut linear, mut angular) = self.parent_twist(own);
            linear += angular.cross(&Vector3::from(known.arm));
            for freedom in own.freedoms() {
                let row = &self.rows[freedom];
                let value = values[freedom] - row.force_ratio.dot(&linear) - row.torque_ratio.dot(&angular);
                let axis = Vector3::from(start.axes[freedom]);
                if freedom < own.first_axis + own.translations {
                    linear += axis * value;
                } else {
                    angular += axis * value;
                }
                values[freedom] = value;
            }
            self.pairs[index] = (linear, angular);
        }
    }

    pub fn parent_twist(&self, own: &BodyPlan) -> Pair {
        own.parent.map_or(Pair::default(), |parent| self.pairs[parent])
    }

    /// The parent with its spin; the world is at rest.
    pub fn parent(&self, own: &BodyPlan, start: &Start) -> (Body, Vector3<f64>) {
        own.parent.map_or_else(Default::default, |parent| (self.bodies[parent], start.bodies[parent].spin.into()))
    }
}

/// Sliding and turning of a joint for values of its degrees of freedom.
pub fn joint_motion(own: &BodyPlan, start: &Start, values: &[f64]) -> Pair {
    let mut motion = Pair::default();
    for freedom in own.freedoms() {
        let part = if freedom < own.first_axis + own.translations { &mut motion.0 } else { &mut motion.1 };
        *part += Vector3::from(start.axes[freedom]) * values[freedom];
    }
    motion
}

/// `J v` with `J = tr Σ − Σ` in world axes.
pub fn spin_inertia(known: &BodyStart, v: &Vector3<f64>) -> Vector3<f64> {
    (known.sigma[0] + known.sigma[3] + known.sigma[5]) * v - second_moments(known) * v
}

/// Σ in world axes.
fn second_moments(known: &BodyStart) -> Matrix3<f64> {
    let [xx, xy, xz, yy, yz, zz] = known.sigma;
    Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
}

/// Force on a body, torque about its anchor, and Z, for its accelerations.
fn body_wrench(known: &BodyStart, body: &Body, gravity: &Vector3<f64>) -> (Vector3<f64>, Vector3<f64>, Matrix3<f64>) {
    let (com, spin) = (Vector3::from(known.com), Vector3::from(known.spin));
    let acceleration = body.linear + body.angular.cross(&com) + spin.cross(&spin.cross(&com));
    let force = known.mass * (acceleration - gravity);
    let hat = spin.cross_matrix();
    let turn = (body.angular.cross_matrix() + hat * hat) * second_moments(known);
    let torque = Vector3::new(turn.m32 - turn.m23, turn.m13 - turn.m31, turn.m21 - turn.m12);
    (force, torque + com.cross(&force), turn)
}

/// The inertia of a body about its anchor, with a wrench as bias.
fn body_inertia(known: &BodyStart, force: Vector3<f64>, torque: Vector3<f64>) -> Articulated<Scalar> {
    let [xx, xy, xz, yy, yz, zz] = known.sigma;
    let [x, y, z] = known.com;
    let m = known.mass;
    let symmetric = |entries: [f64; 6]| Symmetric(entries.map(lane));
    Articulated {
        mass: symmetric([m, 0.0, 0.0, m, 0.0, m]),
        coupling: Matrix([[0.0, m * z, -m * y], [-m * z, 0.0, m * x], [m * y, -m * x, 0.0]].map(|row| row.map(lane))),
        inertia: symmetric([
            yy + zz + m * (y * y + z * z),
            -xy - m * x * y,
            -xz - m * x * z,
            xx + zz + m * (x * x + z * z),
            -yz - m * y * z,
            xx + yy + m * (x * x + y * y),
        ]),
        force: Vector([force.x, force.y, force.z].map(lane)),
        torque: Vector([torque.x, torque.y, torque.z].map(lane)),
    }
}

fn lane(value: f64) -> Scalar {
    Scalar::splat(value)
}

fn scalar(value: Scalar) -> f64 {
    let [value] = value.to_array();
    value
}

fn vector(value: Vector<Scalar>) -> Vector3<f64> {
    value.0.map(scalar).into()
}
