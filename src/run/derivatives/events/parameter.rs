//! A parameter of a run: the derivatives of constant numbers and of the start by it, and of efforts that change in time.
//!
//! ```text
//!     ∂τ(t)/∂θ = Σ_k w_k τ(t; θ + k δ)        k = −4 … 4, without 0        over models with other numbers
//! ```
//!
//! Source: B. Fornberg, Generation of finite difference formulas on arbitrarily spaced grids, Math. Comp. 51 (1988), table 1.

use crate::mechanism::description::forces::{Forces, JointCourse};
use crate::mechanism::description::nonsmooth::Motor;
use nalgebra::DVector;

/// Weights of differences over k widths, k = 1..4: the derivative is their sum over both signs, over the width.
pub const WEIGHTS: [f64; 4] = [4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0];
/// Numbers vary by this part of themselves, and up to four times of it; numbers that are zero by this much.
pub const WIDTH: f64 = 4e-3;

/// Efforts that follow time.
#[derive(Clone, Debug, PartialEq)]
pub struct TimeLaws {
    pub motors: Vec<Motor>,
    pub courses: Vec<JointCourse>,
}

/// A parameter.
#[derive(Clone, Debug)]
pub struct Parameter {
    /// Of all figures, in their order.
    pub figures: Vec<f64>,
    /// Of the start (n each).
    pub position: DVector<f64>,
    pub velocity: DVector<f64>,
    /// Of a constant effort (n).
    pub constant_effort: DVector<f64>,
    /// Of the origins of the child links of floating joints, in the frames of their bodies (n, in the rows of sliding).
    pub arms: DVector<f64>,
    /// Models with other numbers, with their weights; none if efforts do not change.
    pub others: Vec<(f64, TimeLaws)>,
}

impl Parameter {
    /// One that changes none of the n freedoms.
    pub fn none(freedoms: usize) -> Self {
        let zero = DVector::zeros(freedoms);
        Parameter {
            figures: Vec::new(),
            position: zero.clone(),
            velocity: zero.clone(),
            constant_effort: zero.clone(),
            arms: zero,
            others: Vec::new(),
        }
    }

    /// ∂/∂θ of a number of the laws of time.
    pub fn slope(&self, of: impl Fn(&TimeLaws) -> f64) -> f64 {
        self.others.iter().map(|(weight, laws)| weight * of(laws)).sum()
    }
}

impl TimeLaws {
    /// Of motors and forces.
    pub fn new(motors: &[Motor], forces: &Forces) -> Self {
        TimeLaws { motors: motors.to_vec(), courses: forces.joint_courses.clone() }
    }

    /// The given instants of the target of a motor, in their order (s).
    fn knots(&self, motor: usize) -> impl Iterator<Item = f64> + '_ {
        let target = &self.motors[motor].target;
        let next = |time: f64| Some(target.next_knot(time)).filter(|knot| knot.is_finite());
        std::iter::successors(next(f64::MIN), move |&knot| next(knot))
    }

    /// The number of given instants of the target of a motor that are reached at a time (s).
    pub fn piece(&self, motor: usize, time: f64) -> usize {
        let target = &self.motors[motor].target;
        let ahead = target.next_knot(time);
        self.knots(motor).take_while(|knot| *knot < ahead).count()
    }

    /// When a piece of the target of a motor begins (s).
    pub fn beginning(&self, motor: usize, piece: usize) -> f64 {
        piece.checked_sub(1).and_then(|before| self.knots(motor).nth(before)).unwrap_or(f64::MIN)
    }
}
