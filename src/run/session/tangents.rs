//! Derivatives of q and v, from derivatives of a state: the only place at which derivatives change their coordinates.
//!
//! A derivative of q is along the entries of v: a displacement of the child link's origin, and a rotation vector φ, `R_link ← exp(φ̂) R_link`, both
//! in the joint's frame on the parent. Derivatives of a state are along its velocities: a displacement δx of the body's frame, and a turn θ about the
//! axes of that frame. With the rotation R and angular velocity w of the body's frame, and the link's origin at d in it,
//!
//! ```text
//!     δx_link = δx + R (θ × d + δd)                                              φ  = R θ
//!     δv_link = δv + R (θ × (w × d) + δw × d + w × δd)                           δω = R (θ × w + δw)
//!     δa_link = δv̇ + R (θ × (w × (w × d) + ẇ × d) + δw × (w × d) + w × (δw × d) + δẇ × d)        δω̇ = R (θ × ẇ + δẇ)
//!     δτ = (0, −θ × RᵀM − d × (θ × RᵀF))     of the efforts of the state, at a constant force F at the link's origin and a constant moment M
//! ```
//!
//! The body's frame is at the centre of mass along principal axes. Its turn in the link is no part of a derivative: it is chosen freely, and has no
//! derivative where moments are equal. Ball joints have the parts of turns alone; all other joints have the coordinates of the state.

use crate::derivatives::linear::elsewhere::Elsewhere;
use crate::mechanism::description::joint::rotation_from_wxyz;
use crate::mechanism::motion::state::State;
use crate::model::Model;
use crate::scene::UrdfJointKind;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// A joint that turns freely, in a state.
struct Turning {
    /// Its first entry that turns, among the velocities.
    first: usize,
    /// d, of a floating joint: its entries that slide come before the others.
    arm: Option<Vector3<f64>>,
    /// R and w.
    turn: Matrix3<f64>,
    spin: Vector3<f64>,
}

/// The joints of a model that turn freely, in a state.
pub(crate) struct Tangents {
    joints: Vec<Turning>,
    freedoms: usize,
}

impl Tangents {
    /// Of a state of a model.
    pub fn at(model: &Model, state: &State) -> Self {
        let of = |record: &crate::model::JointRecord| {
            let joint = &model.mechanism.bodies[record.body?].joint;
            let arm = match record.kind {
                UrdfJointKind::Spherical => None,
                UrdfJointKind::Floating => Some(record.child_link_in_body.translation.vector),
                _ => return None,
            };
            let slides = if arm.is_some() { 3 } else { 0 };
            let (first, slot) = (joint.velocity_index + slides, joint.position_index + slides);
            let spin = Vector3::from_column_slice(&state.velocity[first..first + 3]);
            Some(Turning { first, arm, turn: rotation_from_wxyz(&state.position[slot..slot + 4]), spin })
        };
        Tangents { joints: model.joints.iter().filter_map(of).collect(), freedoms: state.velocity.len() }
    }

    /// Derivatives of a state (n × p) as derivatives of q and v; `arms` belong to d (n × p, in the rows of sliding).
    pub fn shown(&self, positions: &mut DMatrix<f64>, velocities: &mut DMatrix<f64>, arms: &DMatrix<f64>) {
        for (joint, column) in self.places(positions.ncols()) {
            let Turning { first, arm, turn, spin } = *joint;
            let (theta, by_spin) = (three(positions, first, column), three(velocities, first, column));
            if let Some(arm) = arm {
                let moved = three(arms, first - 3, column);
                add(positions, first - 3, column, &(turn * (theta.cross(&arm) + moved)));
                let speed = theta.cross(&spin.cross(&arm)) + by_spin.cross(&arm) + spin.cross(&moved);
                add(velocities, first - 3, column, &(turn * speed));
            }
            set(positions, first, column, &(turn * theta));
            set(velocities, first, column, &(turn * (theta.cross(&spin) + by_spin)));
        }
    }

    /// The inverse of [`Tangents::shown`], where d does not vary.
    pub fn of_state(&self, positions: &mut DMatrix<f64>, velocities: &mut DMatrix<f64>) {
        for (joint, column) in self.places(positions.ncols()) {
            let Turning { first, arm, turn, spin } = *joint;
            let theta = turn.tr_mul(&three(positions, first, column));
            let by_spin = turn.tr_mul(&three(velocities, first, column)) - theta.cross(&spin);
            set(positions, first, column, &theta);
            set(velocities, first, column, &by_spin);
            if let Some(arm) = arm {
                add(positions, first - 3, column, &(turn * -theta.cross(&arm)));
                let speed = theta.cross(&spin.cross(&arm)) + by_spin.cross(&arm);
                add(velocities, first - 3, column, &(turn * -speed));
            }
        }
    }

    /// The derivatives of a loss by q and v (n each), as those by the state: the transpose of [`Tangents::shown`]. Returns the derivatives by d.
    pub fn pulled_back(&self, by_q: &mut DVector<f64>, by_v: &mut DVector<f64>) -> DVector<f64> {
        let mut by_arms = DVector::zeros(self.freedoms);
        for Turning { first, arm, turn, spin } in &self.joints {
            let (first, slides) = (*first, first.saturating_sub(3));
            let along =
                |of: &DVector<f64>, row: usize| turn.tr_mul(&Vector3::from_column_slice(&of.as_slice()[row..row + 3]));
            let (of_turn, of_spin) = (along(by_q, first), along(by_v, first));
            // a · (θ × b) = θ · (b × a)
            let (mut theta, mut by_spin) = (of_turn + spin.cross(&of_spin), of_spin);
            if let Some(arm) = arm {
                let (place, speed) = (along(by_q, slides), along(by_v, slides));
                theta += arm.cross(&place) + spin.cross(arm).cross(&speed);
                by_spin += arm.cross(&speed);
                by_arms.rows_mut(slides, 3).copy_from(&(place + speed.cross(spin)));
            }
            by_q.rows_mut(first, 3).copy_from(&theta);
            by_v.rows_mut(first, 3).copy_from(&by_spin);
        }
        by_arms
    }

    /// The change from coordinates of the state to q, v and dv/dt, for linear equations of those freedoms (by their entries among all) with these
    /// accelerations u̇ of the state, under efforts along its velocities; `None` if no joint turns freely.
    pub fn elsewhere(&self, freedoms: &[usize], accelerations: &DVector<f64>, efforts: &[f64]) -> Option<Elsewhere> {
        if self.joints.is_empty() {
            return None;
        }
        let n = self.freedoms;
        let mut whole = Elsewhere::identity(n);
        let mut rates = DVector::zeros(n);
        freedoms.iter().zip(accelerations.iter()).for_each(|(&freedom, rate)| rates[freedom] = *rate);
        let none = DMatrix::zeros(n, n);
        self.shown(&mut whole.along, &mut whole.bent, &none);
        for Turning { first, arm, turn, spin } in &self.joints {
            let first = *first;
            let gain = Vector3::from_column_slice(&rates.as_slice()[first..first + 3]);
            // The matrix of θ ↦ R (θ × b), and of δ ↦ b × δ.
            let across = |of: &Vector3<f64>| -(turn * of.cross_matrix());
            let block = |into: &mut DMatrix<f64>, row: usize, column: usize, of: &Matrix3<f64>| {
                into.view_mut((row, column), (3, 3)).copy_from(of);
            };
            block(&mut whole.by_position, first, first, &across(&gain));
            block(&mut whole.turning, first, first, &(turn * spin).cross_matrix());
            let held = |row: usize| match efforts.get(row..row + 3) {
                Some(own) => Vector3::from_column_slice(own),
                None => Vector3::zeros(),
            };
            let mut moment = held(first);
            if let Some(arm) = arm {
                let slides = first - 3;
                let (speed, force) = (spin.cross(arm), turn.tr_mul(&held(slides)));
                block(&mut whole.by_position, slides, first, &across(&(spin.cross(&speed) + gain.cross(arm))));
                let of_spin = -speed.cross_matrix() - spin.cross_matrix() * arm.cross_matrix();
                block(&mut whole.by_velocity, slides, first, &(turn * of_spin));
                moment -= arm.cross(&force);
                let own = moment.cross_matrix() + arm.cross_matrix() * force.cross_matrix();
                block(&mut whole.of_efforts, first, first, &own);
            } else {
                block(&mut whole.of_efforts, first, first, &moment.cross_matrix());
            }
            rates.rows_mut(first, 3).copy_from(&(turn * gain));
            if let Some(arm) = arm {
                let bias = turn * (spin.cross(&spin.cross(arm)) + gain.cross(arm));
                let mut own = rates.rows_mut(first - 3, 3);
                own += bias;
            }
        }
        whole.accelerations = rates;
        Some(whole.of(freedoms))
    }

    fn places(&self, columns: usize) -> impl Iterator<Item = (&Turning, usize)> {
        self.joints.iter().flat_map(move |joint| (0..columns).map(move |column| (joint, column)))
    }
}

fn three(of: &DMatrix<f64>, row: usize, column: usize) -> Vector3<f64> {
    Vector3::new(of[(row, column)], of[(row + 1, column)], of[(row + 2, column)])
}

fn set(of: &mut DMatrix<f64>, row: usize, column: usize, value: &Vector3<f64>) {
    (0..3).for_each(|axis| of[(row + axis, column)] = value[axis]);
}

fn add(of: &mut DMatrix<f64>, row: usize, column: usize, value: &Vector3<f64>) {
    (0..3).for_each(|axis| of[(row + axis, column)] += value[axis]);
}
