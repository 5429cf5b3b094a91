//! Closed contacts at all stages of a step: their equations, and the directions in which their multipliers push.
//!
//! ```text
//!     gap         φ(Q_i) = 0                          i = 2..s          pushes along n_k − μ t_k,   k = 1..s
//!     rolling     h Σ_j a_ij e_j · u_j = 0            i = 2..s          pushes along both e_k
//!     rates       Q̇_j = q̇₀ + h⁻¹ Σ_i (Ā B)_ji w_i                        u of rolling contacts
//!     slips       ẋ_j of the centres of mass as above,  ω_j = ω₀ + h⁻¹ Σ_k ā_jk ½ vee(S_k R_kᵀ − R_k S_kᵀ),  S_k = Σ_i B_ki w_i
//! ```
//!
//! `w_i = Q_i − q₀ − h c_i q̇₀` in R¹² a body. The direction t is that of the slip, with the sign that it has along its direction at the start. A step
//! that begins without slip has the given direction at its first stage. A slip below a thousandth of the largest has the direction of the stage before,
//! and at the end that of the polynomial through the stages.
//!
//! Source: `tests/scheme/literal/touches.rs`, and `lobatto/equations/braking.rs` for slips that stop.

use crate::derivatives::equations::closed::{ClosedTouch, Friction, across, along, tangents_from};
use crate::derivatives::equations::contacts::Touching;
use crate::derivatives::equations::figures::BodyFigures;
use crate::derivatives::equations::placed::Placed;
use crate::derivatives::forward::twelve::Twelve;
use crate::derivatives::numbers::jet::Jet;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::{Matrix, Vector};
use crate::lobatto::tableau::butcher::Tableau;
use crate::mechanism::motion::touches::tangents;
use nalgebra::Vector3;

/// A slip at a stage that is this part of the largest of the step stops there.
const STOPS: f64 = 1e-3;

/// The bodies in a step.
pub(super) struct BodiesInStep<'s, T> {
    pub tableau: &'s Tableau,
    pub bodies: &'s [BodyFigures<T>],
    /// h (s).
    pub step: T,
    /// The start with its rates, and the places at all stages.
    pub started: &'s [Placed<Jet<T>>],
    pub placed: &'s [Vec<Placed<T>>],
    /// q̇₀, and w_i at the stages i = 2..s.
    pub rates: &'s [Twelve<T>],
    pub ahead: &'s [Vec<Twelve<T>>],
}

/// A closed contact at all stages.
pub(super) struct TouchInStep<T> {
    pub bodies: [Option<usize>; 2],
    /// p at the stages k = 1..s, and for each equation the direction of its push on the second body.
    pub points: Vec<Vector<T>>,
    pub pushes: Vec<Vec<Vector<T>>>,
    /// The equations at the stages i = 2..s (m).
    pub rows: Vec<Vec<T>>,
}

/// How a body moves at a stage: the velocity of a point of it, and the rest by its arm.
struct Rate<T> {
    origin: Vector<T>,
    velocity: Vector<T>,
    turning: Turning<T>,
}

enum Turning<T> {
    /// Ṙ Rᵀ as the scheme has it.
    Of(Matrix<T>, Matrix<T>),
    /// ω.
    About(Vector<T>),
}

impl<T: Number> Rate<T> {
    fn at(&self, point: Vector<T>) -> Vector<T> {
        let arm = point - self.origin;
        self.velocity
            + match &self.turning {
                Turning::Of(rate, axes) => rate.apply(axes.transpose().apply(arm)),
                Turning::About(spin) => spin.cross(arm),
            }
    }
}

impl<T: Number> BodiesInStep<'_, T> {
    fn mixed(&self, body: usize, weight: impl Fn(usize) -> f64) -> Twelve<T> {
        let sum =
            |sum: Twelve<T>, (i, ahead): (usize, &Vec<Twelve<T>>)| sum.plus(&ahead[body].scaled(T::of(weight(i))));
        self.ahead.iter().enumerate().fold(Twelve::zero(), sum)
    }

    /// Q̇_j.
    fn rate(&self, body: usize, stage: usize) -> Twelve<T> {
        let gained = self.mixed(body, |i| self.tableau.velocity[stage * (self.tableau.stages - 1) + i]);
        self.rates[body].plus(&gained.scaled(T::of(1.0) / self.step))
    }

    fn rolling(&self, body: usize, stage: usize) -> Rate<T> {
        let (rate, frame) = (self.rate(body, stage), &self.placed[stage][body].frame);
        Rate { origin: frame.origin, velocity: rate.origin, turning: Turning::Of(rate.axes, frame.axes) }
    }

    fn sliding(&self, body: usize, stage: usize) -> Rate<T> {
        let (s, frame) = (self.tableau.stages, &self.placed[stage][body].frame);
        let figures = &self.bodies[body];
        let center = match figures.mass.value() {
            0.0 => Vector::zero(),
            _ => figures.moment.scaled(T::of(1.0) / figures.mass),
        };
        let rate = self.rate(body, stage);
        let mut gained = Vector::zero();
        for k in 0..s - 1 {
            let second = self.mixed(body, |i| self.tableau.b_matrix[k * (s - 1) + i]);
            let turning = skew_part(&self.placed[k][body].frame.axes, &second.axes);
            gained = gained + turning.scaled(T::of(self.tableau.a_bar[stage * s + k]));
        }
        let start = skew_part(&self.placed[0][body].frame.axes, &self.rates[body].axes);
        Rate {
            origin: frame.origin + frame.axes.apply(center),
            velocity: rate.origin + rate.axes.apply(center),
            turning: Turning::About(start + gained.scaled(T::of(1.0) / self.step)),
        }
    }

    /// A closed contact at all stages.
    pub fn touch(&self, closed: &ClosedTouch<T>) -> TouchInStep<T> {
        let ends = [closed.touch.a.body, closed.touch.b.body];
        let found: Vec<Touching<T>> = self.placed.iter().map(|placed| closed.touch.at(placed)).collect();
        let slip = |of: &dyn Fn(usize) -> Rate<T>, at: &Touching<T>| {
            let [a, b] = ends.map(|body| body.map_or_else(Vector::zero, |body| of(body).at(at.point)));
            b - a
        };
        let mut rows: Vec<Vec<T>> = found[1..].iter().map(|at| vec![at.gap]).collect();
        let pushes = match closed.friction {
            Friction::Slides { coefficient, direction } => {
                let slips = found.iter().enumerate();
                let slips = slips.map(|(k, at)| across(at.normal, slip(&|body| self.sliding(body, k), at))).collect();
                let directions = self.directions(closed, &found[0], direction, slips);
                let push = |(at, along): (&Touching<T>, Vector<T>)| vec![at.normal - along.scaled(coefficient)];
                found.iter().zip(directions).map(push).collect()
            }
            Friction::Rolls => {
                let first = tangents(&Vector3::from(found[0].normal.0.map(Number::value)))[0];
                let axes: Vec<[Vector<T>; 2]> = found.iter().map(|at| tangents_from(at.normal, &first)).collect();
                let creeps: Vec<[T; 2]> = (0..found.len())
                    .map(|k| axes[k].map(|axis| axis.dot(slip(&|body| self.rolling(body, k), &found[k]))))
                    .collect();
                let s = self.tableau.stages;
                for (i, rows) in rows.iter_mut().enumerate() {
                    let weight = |j: usize| self.tableau.a[(i + 1) * s + j];
                    let sum = |axis: usize| (0..s).fold(T::zero(), |sum, j| sum + creeps[j][axis].times(weight(j)));
                    rows.extend([0, 1].map(|axis| sum(axis) * self.step));
                }
                found.iter().zip(axes).map(|(at, [one, two])| vec![at.normal, one, two]).collect()
            }
        };
        TouchInStep { bodies: ends, points: found.into_iter().map(|at| at.point).collect(), pushes, rows }
    }

    /// t at all stages, from the slips there.
    fn directions(
        &self,
        closed: &ClosedTouch<T>,
        start: &Touching<T>,
        given: Vector<T>,
        slips: Vec<Vector<T>>,
    ) -> Vec<Vector<T>> {
        let unit = |of: Vector<T>| of.scaled(T::of(1.0) / of.dot(of).square_root());
        let begins = across(start.normal, closed.touch.slip(self.started, start.point));
        let rests = closed.rests(self.started, start, begins);
        let reference = if rests { along(across(start.normal, given)) } else { unit(begins) };
        let size = |of: &Vector<T>| of.dot(*of).value().max(0.0).sqrt();
        let last = self.tableau.stages - 1;
        let largest = slips[..last].iter().map(size).fold(0.0, f64::max);
        let of = |slip: &Vector<T>| {
            let direction = unit(*slip);
            if direction.dot(reference).value() < 0.0 { -direction } else { direction }
        };
        let stops = |slip: &Vector<T>| size(slip) <= STOPS * largest;
        let mut all = vec![if rests || stops(&slips[0]) { reference } else { of(&slips[0]) }];
        let mut before = reference;
        for slip in &slips[1..last] {
            before = if stops(slip) { before } else { of(slip) };
            all.push(before);
        }
        let nodes = &self.tableau.nodes;
        let ahead = |k: usize| -> f64 {
            (0..last).filter(|&m| m != k).map(|m| (1.0 - nodes[m]) / (nodes[k] - nodes[m])).product()
        };
        let extrapolated = || {
            let sum = (0..last).fold(Vector::zero(), |sum, k| sum + all[k].scaled(T::of(ahead(k))));
            let sum = along(sum);
            if sum.dot(sum).value() > 0.0 { sum } else { reference }
        };
        all.push(if stops(&slips[last]) { extrapolated() } else { of(&slips[last]) });
        all
    }
}

/// `½ vee(S Rᵀ − R Sᵀ)`.
fn skew_part<T: Number>(axes: &Matrix<T>, of: &Matrix<T>) -> Vector<T> {
    let columns = axes.0.iter().zip(&of.0);
    columns.fold(Vector::zero(), |sum, (&axis, &own)| sum + axis.cross(own).scaled(T::of(0.5)))
}
