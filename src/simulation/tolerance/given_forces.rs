//! The error that steps make in the impulses of forces given in time, which a run and its companion have in common: their values at the stages do not
//! depend on the motion.
//!
//! ```text
//!     one step, n nodes c and weights b:      P = h Σ b_i f(t + c_i h)
//!     its halves, with the same nodes:        P' = h/2 Σ b_i (f(t + c_i h/2) + f(t + h/2 + c_i h/2))
//!     δP = |P − P'|  [s]                      the error of P, as that of P' is less by 2^(2n − 2)
//!     δv = δP (|F|/m + |M|/√(I m))  [m/s]     of the body with mass m and least moment of inertia I, at its radius of gyration
//!     error(t) = Σ_k δv_k (t − t_k)  (m)
//! ```
//!
//! The factor f(t) is that of a load on a link or joint, or the target of a motor that is an effort; F and M are the force (N) and torque [N m] that
//! it multiplies. Efforts of other motors depend on the motion. The motion may amplify the error further.
//!
//! Source: J. Stoer, R. Bulirsch, Introduction to Numerical Analysis, Springer 2002, section 3.5, for the error of a quadrature by halving.

use crate::lobatto::tableau::butcher::Tableau;
use crate::mechanism::description::joint::JointKind;
use crate::mechanism::description::mechanism::{Body, Mechanism};
use crate::mechanism::description::nonsmooth::MotorLaw;

/// Differences of impulses below this part of them are rounding.
const ROUNDING: f64 = 1e-14;

/// `Σ δv` [m/s] and `Σ δv t` (m) so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct GivenForces {
    speed: f64,
    moment: f64,
}

impl GivenForces {
    /// Takes note of a step of this number of stages between two times (s). Does not allocate.
    pub fn see(&mut self, mechanism: &Mechanism, stages: usize, [from, to]: [f64; 2]) {
        let motors = &mechanism.nonsmooth.motors;
        if to <= from || !mechanism.forces.change() && motors.is_empty() {
            return;
        }
        let Ok(tableau) = Tableau::of(stages) else { return };
        let doubt = |factor: &dyn Fn(f64) -> f64| doubt(tableau, from, to - from, factor);
        let masses: f64 = mechanism.bodies.iter().map(|body| body.mass).sum();
        let mut speed = 0.0;
        for load in mechanism.forces.link_loads.iter().filter(|load| !load.course.is_constant()) {
            let moment = load.torque.norm() + load.point.cross(&load.force).norm();
            let most = speed_of(&mechanism.bodies[load.body], masses, load.force.norm(), moment);
            speed += most * doubt(&|time| load.course.value(from, time));
        }
        for load in mechanism.forces.joint_courses.iter().filter(|load| !load.course.is_constant()) {
            let driven = mechanism.bodies.iter().find(|body| {
                let first = body.joint.velocity_index;
                (first..first + body.joint.kind.velocity_count()).contains(&load.freedom)
            });
            let Some(body) = driven else { continue };
            speed += along_joint(body, masses, load.effort.abs()) * doubt(&|time| load.course.value(from, time));
        }
        for motor in motors.iter().filter(|motor| motor.law == MotorLaw::Effort && motor.period == 0.0) {
            let most = along_joint(&mechanism.bodies[motor.coordinate.body], masses, 1.0);
            speed += most * doubt(&|time| motor.drive(from, time));
        }
        self.speed += speed;
        self.moment += speed * to;
    }

    /// The error of positions at a time (s) (m).
    pub fn error(&self, time: f64) -> f64 {
        (self.speed * time - self.moment).max(0.0)
    }
}

/// `|P − P'|` (s) of a step from a time on, zero if it is rounding.
fn doubt(tableau: &Tableau, from: f64, step: f64, factor: &dyn Fn(f64) -> f64) -> f64 {
    let over = |begin: f64, length: f64| {
        let terms = tableau.nodes.iter().zip(&tableau.weights);
        terms.fold([0.0, 0.0], |[sum, size], (node, weight)| {
            let term = length * weight * factor(begin + node * length);
            [sum + term, size + term.abs()]
        })
    };
    let half = 0.5 * step;
    let ([whole, size], [first, _], [second, _]) = (over(from, step), over(from, half), over(from + half, half));
    let apart = (whole - first - second).abs();
    if apart > ROUNDING * size { apart } else { 0.0 }
}

/// The speed that unit impulses of a force (N) and a torque [N m] give to a body; a body without mass moves others.
fn speed_of(body: &Body, masses: f64, force: f64, torque: f64) -> f64 {
    let mass = if body.mass > 0.0 { body.mass } else { masses };
    let least = body.inertia.iter().copied().filter(|moment| *moment > 0.0).fold(f64::INFINITY, f64::min);
    let about = if least.is_finite() { torque / (least * mass).sqrt() } else { 0.0 };
    let sum = force / mass + about;
    if sum.is_finite() { sum } else { 0.0 }
}

/// The same of an effort along the joint of a body.
fn along_joint(body: &Body, masses: f64, effort: f64) -> f64 {
    match body.joint.kind {
        JointKind::Prismatic => speed_of(body, masses, effort, 0.0),
        _ => speed_of(body, masses, 0.0, effort),
    }
}
