//! Closed contacts in the literal scheme: their equations at all stages, and how their multipliers push.
//!
//! Let `K_e(q) q̇ = e · (vel_b(p) − vel_a(p))` be the velocity of the bodies' material at the point of contact p, along a direction e, with
//! `vel(p) = ẋ + Ṙ Rᵀ (p − x)`:
//!
//! ```text
//!     gap                φ(Q_i) = 0                             i = 2..s         pushes with  Λ_k K_{n − μ t}(Q_k)ᵀ       k = 1..s−1
//!     rolling            h Σ_j a_ij K_e(Q_j) Q̇_j = 0            i = 2..s         pushes with  Λ_k K_e(Q_k)ᵀ               e = e_1, e_2
//!     end of the step    K_n(q̄) M⁻¹ p̄ = 0,  K_e(q̄) M⁻¹ p̄ = 0                  pushes as above with the stage s
//!     slip               u = ẋ + ω × (p − x) of b less that of a,   u_T = u − (n·u) n,   t = ± u_T/|u_T|
//!     belts              u_T + w_T,  K_e(q) q̇ + e · w_T         w_T = w − (n·w) n,  w = R_b w_b − R_a w_a
//! ```
//!
//! The sign of t is the sign of u_T along its direction at the start of the step. If a step starts without slip, that direction is the one given to
//! the contact, and it is t of the first stage. The tangents e are the two at the start, `e_1` kept square to n by taking away its part along n, and
//! `e_2 = n × e_1`. The rates of the stages follow from their positions by (2.5.11a, b, d, e) without the momenta:
//!
//! ```text
//!     Q_i − q − h c_i q̇ = h² Σ_j a_ij Σ_k ā_jk r_k,       Q̇_j = q̇ + h Σ_k ā_jk r_k        i = 2..s,  j = 1..s,  k = 1..s−1
//! ```
//!
//! The angular velocity of a slip is `ω_j = ω + h Σ_k ā_jk ½ vee(R̈_k R_kᵀ − R_k R̈_kᵀ)`, with R̈ the part of r for the rotation matrix.
//!
//! This file shares no code with [`catena::lobatto::equations::touches`], for which it is the oracle.

use crate::literal::coordinates::BODY_COORDINATES;
use crate::literal::pairs::{Meeting, Placed, meet};
use catena::lobatto::tableau::butcher::Tableau;
use catena::mechanism::description::closure::Attachment;
use catena::mechanism::description::contact::{Grip, Moments, TouchJoint};
use catena::mechanism::description::mechanism::Mechanism;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// A slip below this counts as zero [m/s]; at a stage this happens in the first iteration at most.
const NO_SLIP: f64 = 1e-9;

/// The contacts of a mechanism in a step of this length from `(q, q̇)`.
pub(crate) struct TouchStep<'a> {
    pub(crate) mechanism: &'a Mechanism,
    pub(crate) tableau: &'a Tableau,
    pub(crate) q: &'a DVector<f64>,
    pub(crate) velocity: &'a DVector<f64>,
    pub(crate) step: f64,
}

/// All contacts at all stages; m equations at each.
#[derive(Clone, Debug)]
pub(crate) struct TouchStages {
    /// Gaps and creeps (m) of every stage.
    pub(crate) rows: Vec<DVector<f64>>,
    /// For every stage the opposites of the directions in which multipliers push, as a Jacobian of constraints has them (m × 12 n).
    pub(crate) pulls: Vec<DMatrix<f64>>,
    /// The opposites of K at the end of the step (m × 12 n), and the rates that belts add to them there (m).
    pub(crate) ends: DMatrix<f64>,
    pub(crate) carried: DVector<f64>,
}

/// One contact at all stages: the equations it has, and the directions e of K for each of them.
struct OneTouch {
    rows: Vec<Vec<f64>>,
    pushes: Vec<Vec<DVector<f64>>>,
    ends: Vec<DVector<f64>>,
    carried: Vec<f64>,
}

impl TouchStep<'_> {
    /// All contacts for the increments `Q_i − q` of the stages; `None` if one of them is of a pair of features that is not in the table, or has
    /// rolling or spinning friction.
    pub(crate) fn at(&self, increments: &[DVector<f64>]) -> Option<TouchStages> {
        let positions: Vec<DVector<f64>> = increments.iter().map(|increment| self.q + increment).collect();
        let [rates, slips] = self.rates(increments, &positions);
        let touching = self.mechanism.touches.iter().filter(|joint| joint.touch.rows() > 0);
        let all =
            touching.map(|joint| self.one(joint, &positions, &rates, &slips)).collect::<Option<Vec<OneTouch>>>()?;
        let count = all.iter().map(|touch| touch.ends.len()).sum();
        let matrix = |rows: &mut dyn Iterator<Item = &DVector<f64>>| {
            let mut matrix = DMatrix::zeros(count, self.q.len());
            rows.enumerate().for_each(|(row, along)| matrix.row_mut(row).tr_copy_from(&-along));
            matrix
        };
        let stages = 0..self.tableau.stages;
        Some(TouchStages {
            rows: stages
                .clone()
                .map(|k| DVector::from_iterator(count, all.iter().flat_map(|touch| touch.rows[k].iter().copied())))
                .collect(),
            pulls: stages.map(|k| matrix(&mut all.iter().flat_map(|touch| &touch.pushes[k]))).collect(),
            ends: matrix(&mut all.iter().flat_map(|touch| &touch.ends)),
            carried: DVector::from_iterator(count, all.iter().flat_map(|touch| touch.carried.iter().copied())),
        })
    }

    /// `Q̇_1 … Q̇_s`, and the rates for slips, with `ω̂ R` in the place of Ṙ.
    fn rates(&self, increments: &[DVector<f64>], positions: &[DVector<f64>]) -> [Vec<DVector<f64>>; 2] {
        let (s, h) = (self.tableau.stages, self.step);
        let Tableau { a, a_bar, nodes, .. } = self.tableau;
        let twice = DMatrix::from_fn(s - 1, s - 1, |i, k| {
            (0..s).map(|j| a[(i + 1) * s + j] * a_bar[j * s + k]).sum::<f64>() * h * h
        });
        let ahead = DMatrix::from_fn(s - 1, self.q.len(), |i, coordinate| {
            increments[i + 1][coordinate] - h * nodes[i + 1] * self.velocity[coordinate]
        });
        let impulses = twice.lu().solve(&ahead).unwrap_or_else(|| ahead.map(|_| f64::NAN));
        let rate = |j: usize| {
            (0..s - 1).fold(self.velocity.clone(), |sum, k| sum + impulses.row(k).transpose() * (h * a_bar[j * s + k]))
        };
        let rates: Vec<DVector<f64>> = (0..s).map(rate).collect();
        let mut slips = rates.clone();
        for rotation in (0..self.q.len() / BODY_COORDINATES).map(|body| BODY_COORDINATES * body + 3) {
            let matrix = |of: &DVector<f64>| Matrix3::from_column_slice(&of.as_slice()[rotation..rotation + 9]);
            let vee = |of: Matrix3<f64>| {
                Vector3::new(of[(2, 1)] - of[(1, 2)], of[(0, 2)] - of[(2, 0)], of[(1, 0)] - of[(0, 1)]) / 2.0
            };
            let spin = vee(matrix(self.velocity) * matrix(self.q).transpose());
            let acceleration = |k: usize| vee(matrix(&impulses.row(k).transpose()) * matrix(&positions[k]).transpose());
            for (j, slip) in slips.iter_mut().enumerate() {
                let turns = (0..s - 1).fold(spin, |sum, k| sum + acceleration(k) * (h * a_bar[j * s + k]));
                let turning = turns.cross_matrix() * matrix(&positions[j]);
                slip.rows_mut(rotation, 9).copy_from_slice(turning.as_slice());
            }
        }
        [rates, slips]
    }

    /// One contact, for the positions of all stages, their rates and the rates of slips.
    fn one(
        &self,
        joint: &TouchJoint,
        positions: &[DVector<f64>],
        rates: &[DVector<f64>],
        slips: &[DVector<f64>],
    ) -> Option<OneTouch> {
        let s = self.tableau.stages;
        if joint.moments != Moments::default() {
            return None;
        }
        let start = meeting(joint, self.q)?;
        let begins = slip(joint, &start, self.q, self.velocity);
        let (friction, given) = match joint.touch.grip {
            Grip::Slides { friction, direction } => (friction, direction),
            Grip::Rolls => (0.0, Vector3::zeros()),
        };
        let rests = begins.norm() < NO_SLIP;
        let reference = if rests { given } else { begins.normalize() };
        let first = across(&start.normal, if start.normal.x.abs() <= 0.6 { Vector3::x() } else { Vector3::y() });
        let meetings = positions.iter().map(|q| meeting(joint, q)).collect::<Option<Vec<Meeting>>>()?;
        let (mut rows, mut pushes, mut creeping) = (Vec::new(), Vec::new(), Vec::new());
        for (k, here) in meetings.iter().enumerate() {
            rows.push(vec![here.gap]);
            let Meeting { normal, .. } = here;
            if joint.touch.grip == Grip::Rolls {
                let along = tangents(normal, &first);
                let belts = along.map(|along| along.dot(&belt(joint, here, &positions[k])));
                let along = along.map(|along| row(joint, here, &positions[k], &along));
                creeping.push([0, 1].map(|axis: usize| along[axis].dot(&rates[k]) + belts[axis]));
                let [one, two] = along;
                pushes.push(vec![row(joint, here, &positions[k], normal), one, two]);
            } else {
                let braking = if friction == 0.0 {
                    Vector3::zeros()
                } else if rests && k == 0 {
                    reference * friction
                } else {
                    let slip = slip(joint, here, &positions[k], &slips[k]);
                    let along = slip.try_normalize(NO_SLIP).unwrap_or(reference);
                    along * (friction * along.dot(&reference).signum())
                };
                pushes.push(vec![row(joint, here, &positions[k], &(normal - braking))]);
            }
        }
        let (last, q) = (&meetings[s - 1], &positions[s - 1]);
        let mut ends = vec![row(joint, last, q, &last.normal)];
        let mut carried = vec![0.0];
        if joint.touch.grip == Grip::Rolls {
            for (i, rows) in rows.iter_mut().enumerate() {
                let creep =
                    |e: usize| (0..s).map(|j| self.step * self.tableau.a[i * s + j] * creeping[j][e]).sum::<f64>();
                rows.extend([0, 1].map(creep));
            }
            let along = tangents(&last.normal, &first);
            ends.extend(along.map(|along| row(joint, last, q, &along)));
            carried.extend(along.map(|along| along.dot(&belt(joint, last, q))));
        }
        Some(OneTouch { rows, pushes, ends, carried })
    }
}

/// Position and rotation matrix of an end in the coordinates of all bodies; `None` for the world.
fn pose(end: &Attachment, q: &DVector<f64>) -> Option<(usize, Vector3<f64>, Matrix3<f64>)> {
    let first = BODY_COORDINATES * end.body?;
    let rotation = Matrix3::from_column_slice(&q.as_slice()[first + 3..first + BODY_COORDINATES]);
    Some((first, q.fixed_rows::<3>(first).into_owned(), rotation))
}

/// The two features of a contact, placed; `None` for features that make no pair, and for ropes through several points.
fn meeting(joint: &TouchJoint, q: &DVector<f64>) -> Option<Meeting> {
    if joint.is_reeved() {
        return None;
    }
    let place = |end: &Attachment| {
        let (origin, axis) = (end.frame.translation.vector, end.frame.rotation * Vector3::z());
        let axes = *end.frame.rotation.matrix();
        match pose(end, q) {
            None => Placed { origin, axis, axes },
            Some((_, position, rotation)) => {
                Placed { origin: position + rotation * origin, axis: rotation * axis, axes: rotation * axes }
            }
        }
    };
    meet(&joint.touch, place(&joint.a), place(&joint.b))
}

/// `K_e(q)` (12 n).
fn row(joint: &TouchJoint, here: &Meeting, q: &DVector<f64>, along: &Vector3<f64>) -> DVector<f64> {
    let mut row = DVector::zeros(q.len());
    for (end, sign) in [(&joint.a, -1.0), (&joint.b, 1.0)] {
        let Some((first, position, rotation)) = pose(end, q) else { continue };
        let arm = rotation.transpose() * (here.point - position);
        for axis in 0..3 {
            row[first + axis] += sign * along[axis];
            for column in 0..3 {
                row[first + 3 + 3 * column + axis] += sign * along[axis] * arm[column];
            }
        }
    }
    row
}

/// `u_T` [m/s].
fn slip(joint: &TouchJoint, here: &Meeting, q: &DVector<f64>, rates: &DVector<f64>) -> Vector3<f64> {
    let along = |axis: usize| row(joint, here, q, &Vector3::ith(axis, 1.0)).dot(rates);
    across(&here.normal, Vector3::from_fn(|axis, _| along(axis))) + belt(joint, here, q)
}

/// `w_T` [m/s].
fn belt(joint: &TouchJoint, here: &Meeting, q: &DVector<f64>) -> Vector3<f64> {
    let [surface_a, surface_b] =
        [(&joint.a, joint.surfaces[0]), (&joint.b, joint.surfaces[1])].map(|(end, surface)| {
            let surface = end.frame.rotation * surface;
            pose(end, q).map_or(surface, |(_, _, rotation)| rotation * surface)
        });
    across(&here.normal, surface_b - surface_a)
}

/// The part of a vector that is orthogonal to a unit vector.
fn across(normal: &Vector3<f64>, vector: Vector3<f64>) -> Vector3<f64> {
    vector - normal * normal.dot(&vector)
}

/// The tangents at a normal that belong to the first of them at the start of the step.
fn tangents(normal: &Vector3<f64>, first: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let one = across(normal, *first).normalize();
    [one, normal.cross(&one)]
}
