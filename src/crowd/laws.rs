//! The laws of one row or one contact, as equations of Alart and Curnier and as projections.
//!
//! ```text
//!     cone of friction μ:  F = r − Π_{C(y_N)}(y),   y = r − ρ u,    C: r_N ≥ 0, |r_T| ≤ μ max(0, y_N)
//!     interval:            F = r − clamp(y, lower, upper)
//!     F + A du + B dr = 0                          one step of Newton's method
//! ```
//!
//! `u` are rates with their bias [m/s], `r` impulses (N s), both along normal and two tangents; `ρ` is the mass at the row (kg). An interval
//! has the first component alone. The exact law has De Saxcé's shift: `K ∋ r ⊥ u + μ|u_T| n ∈ K*`; its natural map is what a residual is made of.
//!
//! Source: P. Alart, A. Curnier, A mixed formulation for frictional contact problems prone to Newton like solution methods, Computer Methods in
//! Applied Mechanics and Engineering 92 (1991); G. De Saxcé, Z.-Q. Feng, The bipotential method (1998).

use nalgebra::{Matrix3, Vector3};

/// The law of a block.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Law {
    /// Coulomb's cone with this friction, which is positive.
    Cone(f64),
    /// Impulses from … to …; a contact without friction, a limit, a joint with friction, a motor.
    Interval(f64, f64),
}

/// F, A and B.
pub struct Linear {
    pub value: Vector3<f64>,
    pub by_rate: Matrix3<f64>,
    pub by_impulse: Matrix3<f64>,
}

impl Law {
    /// Number of rows.
    pub fn rows(self) -> usize {
        match self {
            Law::Cone(_) => 3,
            Law::Interval(..) => 1,
        }
    }

    /// De Saxcé's shift of the normal rate.
    pub fn shift(self, rate: &Vector3<f64>) -> f64 {
        match self {
            Law::Cone(friction) => friction * norm(rate.y, rate.z),
            Law::Interval(..) => 0.0,
        }
    }

    /// The nearest impulse that the law allows.
    pub fn project(self, y: &Vector3<f64>) -> Vector3<f64> {
        match self {
            Law::Interval(lower, upper) => Vector3::new(y.x.max(lower).min(upper), 0.0, 0.0),
            Law::Cone(friction) => {
                let across = norm(y.y, y.z);
                if y.x >= 0.0 && across <= friction * y.x {
                    *y
                } else if friction * across <= -y.x {
                    Vector3::zeros()
                } else {
                    let normal = (y.x + friction * across) / (1.0 + friction * friction);
                    let part = friction * normal / across;
                    Vector3::new(normal, part * y.y, part * y.z)
                }
            }
        }
    }

    /// The derivative of the projection; `None` where it is zero.
    pub fn projection_slope(self, y: &Vector3<f64>) -> Option<Matrix3<f64>> {
        match self {
            Law::Interval(lower, upper) => {
                (lower < y.x && y.x < upper).then(|| Matrix3::from_diagonal(&Vector3::new(1.0, 0.0, 0.0)))
            }
            Law::Cone(friction) => {
                let across = norm(y.y, y.z);
                if y.x >= 0.0 && across <= friction * y.x {
                    return Some(Matrix3::identity());
                }
                if friction * across <= -y.x {
                    return None;
                }
                let part = 1.0 / (1.0 + friction * friction);
                let along = Vector3::new(0.0, y.y / across, y.z / across);
                let normal = (y.x + friction * across) * part;
                let outward = Vector3::new(1.0, friction * along.y, friction * along.z);
                let mut slope = part * outward * outward.transpose();
                let turning = friction * normal / across;
                for row in 1..3 {
                    for column in 1..3 {
                        let same = if row == column { 1.0 } else { 0.0 };
                        slope[(row, column)] += turning * (same - along[row] * along[column]);
                    }
                }
                Some(slope)
            }
        }
    }

    /// How far an impulse is from the one that the law makes of it with this rate: the natural map.
    pub fn defect(self, impulse: &Vector3<f64>, rate: &Vector3<f64>, rho: f64) -> Vector3<f64> {
        let mut rate = *rate;
        rate.x += self.shift(&rate);
        impulse - self.project(&(impulse - rate * rho))
    }

    /// The equation and its derivatives.
    pub fn linearise(self, r: &Vector3<f64>, u: &Vector3<f64>, rho: f64) -> Linear {
        let one = Matrix3::identity();
        let y = r - u * rho;
        match self {
            Law::Interval(lower, upper) => {
                if lower < y.x && y.x < upper {
                    let mut by_impulse = one;
                    by_impulse[(0, 0)] = 0.0;
                    let by_rate = Matrix3::from_diagonal(&Vector3::new(rho, 0.0, 0.0));
                    Linear { value: Vector3::new(rho * u.x, 0.0, 0.0), by_rate, by_impulse }
                } else {
                    let bound = y.x.max(lower).min(upper);
                    let value = Vector3::new(r.x - bound, 0.0, 0.0);
                    Linear { value, by_rate: Matrix3::zeros(), by_impulse: one }
                }
            }
            Law::Cone(friction) => {
                let across = norm(y.y, y.z);
                if y.x <= 0.0 {
                    return Linear { value: *r, by_rate: Matrix3::zeros(), by_impulse: one };
                }
                if across <= friction * y.x {
                    return Linear { value: u * rho, by_rate: one * rho, by_impulse: Matrix3::zeros() };
                }
                let along = [y.y / across, y.z / across];
                let most = friction * y.x;
                let value = Vector3::new(rho * u.x, r.y - most * along[0], r.z - most * along[1]);
                let (mut by_rate, mut by_impulse) = (Matrix3::zeros(), Matrix3::zeros());
                by_rate[(0, 0)] = rho;
                for row in 0..2 {
                    let slope = friction * along[row];
                    by_rate[(1 + row, 0)] = rho * slope;
                    by_impulse[(1 + row, 0)] = -slope;
                    for column in 0..2 {
                        let same = if row == column { 1.0 } else { 0.0 };
                        let turn = most / across * (same - along[row] * along[column]);
                        by_rate[(1 + row, 1 + column)] = rho * turn;
                        by_impulse[(1 + row, 1 + column)] = same - turn;
                    }
                }
                Linear { value, by_rate, by_impulse }
            }
        }
    }
}

fn norm(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}
