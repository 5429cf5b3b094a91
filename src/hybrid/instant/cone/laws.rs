//! Each law as equations `F(u, r) = 0` with their derivatives, in units in which the block has mobility 1.
//!
//! ```text
//!     interval      F = r − clamp(r − u)
//!     sliding       F_N = r_N − (r_N − u_N)₊           F_T = r_T + μ r_N t
//!     contact       F_N = r_N − z₊                     F_T = r_T − P_disc(μ z₊)(r_T − u_T)       z = r_N − u_N   (Alart and Curnier)
//!                   F = r − P_K(r − û),                û = u + μ |u_T| e_N                       (natural map)
//! ```
//!
//! Both forms of the contact have the same solutions. A = ∂F/∂u and B = ∂F/∂r are 3 × 3; at a kink of F one of its derivatives is taken.
//!
//! Source: P. Alart, A. Curnier, A mixed formulation for frictional contact problems, Computer Methods in Applied Mechanics and Engineering 92
//! (1991).

use crate::instant::cone::problem::Law;
use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

/// Which equations stand for the law of a contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// The equations of Alart and Curnier.
    AlartCurnier,
    /// The natural map of De Saxcé's complementarity.
    Natural,
}

/// F of a block with its derivatives.
#[derive(Clone, Copy, Debug)]
pub(super) struct Equations {
    /// F; rows that the block does not have are 0.
    pub value: Vector3<f64>,
    /// A = ∂F/∂u.
    pub by_rate: Matrix3<f64>,
    /// B = ∂F/∂r.
    pub by_force: Matrix3<f64>,
}

impl Equations {
    /// F = r: the force is known to be zero.
    fn without_force(force: Vector3<f64>) -> Self {
        Equations { value: force, by_rate: Matrix3::zeros(), by_force: Matrix3::identity() }
    }

    /// F = u: the rate is known to be zero.
    fn without_rate(rate: Vector3<f64>) -> Self {
        Equations { value: rate, by_rate: Matrix3::identity(), by_force: Matrix3::zeros() }
    }
}

/// The equations of a law at rates and forces; their first rows are the rows of the block.
pub(super) fn equations(law: &Law, form: Form, rates: &[f64], forces: &[f64]) -> Equations {
    match *law {
        Law::Interval { lower, upper } => {
            let (rate, force) = (Vector3::new(rates[0], 0.0, 0.0), Vector3::new(forces[0], 0.0, 0.0));
            let moved = force.x - rate.x;
            if lower < moved && moved < upper {
                return Equations::without_rate(rate);
            }
            let bound = if moved <= lower { lower } else { upper };
            Equations::without_force(force - Vector3::new(bound, 0.0, 0.0))
        }
        Law::Sliding { friction, direction } => {
            let mut found = Equations::without_force(Vector3::new(forces[0], forces[1], forces[2]));
            for (row, along) in [(1, direction[0]), (2, direction[1])] {
                found.value[row] += friction * forces[0] * along;
                found.by_force[(row, 0)] = friction * along;
            }
            if forces[0] - rates[0] > 0.0 {
                found.value.x = rates[0];
                (found.by_rate[(0, 0)], found.by_force[(0, 0)]) = (1.0, 0.0);
            }
            found
        }
        Law::Contact { friction } => {
            let rate = Vector3::new(rates[0], rates[1], rates[2]);
            let force = Vector3::new(forces[0], forces[1], forces[2]);
            match form {
                Form::AlartCurnier => alart_curnier(friction, &rate, &force),
                Form::Natural => natural(friction, &rate, &force),
            }
        }
    }
}

/// `r − P_K(r − û)` of any law: what the law is off by.
pub(super) fn natural_map(law: &Law, rates: &[f64], forces: &[f64]) -> Vector3<f64> {
    match *law {
        Law::Interval { lower, upper } => {
            Vector3::new(forces[0] - (forces[0] - rates[0]).max(lower).min(upper), 0.0, 0.0)
        }
        Law::Sliding { friction, direction: [x, y] } => Vector3::new(
            forces[0] - (forces[0] - rates[0]).max(0.0),
            forces[1] + friction * forces[0] * x,
            forces[2] + friction * forces[0] * y,
        ),
        Law::Contact { friction } => {
            let force = Vector3::new(forces[0], forces[1], forces[2]);
            let shift = friction * rates[1].hypot(rates[2]);
            let moved = force - Vector3::new(rates[0] + shift, rates[1], rates[2]);
            force - on_cone(friction, &moved)
        }
    }
}

/// The point of the cone |r_T| ≤ μ r_N nearest to a point.
fn on_cone(friction: f64, point: &Vector3<f64>) -> Vector3<f64> {
    let tangential = point.y.hypot(point.z);
    if tangential <= friction * point.x {
        return *point;
    }
    let normal = (point.x + friction * tangential) / (1.0 + friction * friction);
    if normal <= 0.0 {
        return Vector3::zeros();
    }
    let factor = friction * normal / tangential;
    Vector3::new(normal, factor * point.y, factor * point.z)
}

fn alart_curnier(friction: f64, rate: &Vector3<f64>, force: &Vector3<f64>) -> Equations {
    let moved = force - rate;
    if moved.x <= 0.0 {
        return Equations::without_force(*force);
    }
    let tangential = moved.y.hypot(moved.z);
    if tangential <= friction * moved.x {
        return Equations::without_rate(*rate);
    }
    let along = Vector2::new(moved.y, moved.z) / tangential;
    let radius = friction * moved.x;
    // Derivative of the point of the disc by the projected vector and, along the radius, by the normal force.
    let turned = (Matrix2::identity() - along * along.transpose()) * (radius / tangential);
    let mut found = Equations::without_rate(*rate);
    found.by_rate.fixed_view_mut::<2, 2>(1, 1).copy_from(&turned);
    found.by_rate.fixed_view_mut::<2, 1>(1, 0).copy_from(&(along * friction));
    found.by_force.fixed_view_mut::<2, 2>(1, 1).copy_from(&(Matrix2::identity() - turned));
    found.by_force.fixed_view_mut::<2, 1>(1, 0).copy_from(&(along * -friction));
    (found.value.y, found.value.z) = (force.y - radius * along.x, force.z - radius * along.y);
    found
}

fn natural(friction: f64, rate: &Vector3<f64>, force: &Vector3<f64>) -> Equations {
    let slip = rate.y.hypot(rate.z);
    let moved = force - rate - Vector3::new(friction * slip, 0.0, 0.0);
    let mut shift = Matrix3::identity();
    if slip > 0.0 {
        (shift[(0, 1)], shift[(0, 2)]) = (friction * rate.y / slip, friction * rate.z / slip);
    }
    let nearest = on_cone(friction, &moved);
    let tangential = moved.y.hypot(moved.z);
    let projection = if tangential <= friction * moved.x {
        Matrix3::identity()
    } else if nearest.x <= 0.0 {
        Matrix3::zeros()
    } else {
        let along = Vector2::new(moved.y, moved.z) / tangential;
        let edge = Vector3::new(1.0, friction * along.x, friction * along.y);
        let mut projection = edge * edge.transpose() / (1.0 + friction * friction);
        let turned = (Matrix2::identity() - along * along.transpose()) * (friction * nearest.x / tangential);
        let mut corner = projection.fixed_view_mut::<2, 2>(1, 1);
        corner += turned;
        projection
    };
    Equations { value: force - nearest, by_rate: projection * shift, by_force: Matrix3::identity() - projection }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_agree_with_differences() {
        // Away from kinks central differences of step 1e-6 are off by 1e-12 for the curvature and 1e-10 for rounding.
        let points = [
            ([0.3, 0.1, -0.2], [1.1, 0.2, 0.1]),
            ([-0.3, 0.9, -0.7], [0.8, -0.5, 0.3]),
            ([1.5, 0.1, 0.4], [0.2, 0.1, 0.3]),
            ([0.1, -1.1, 0.6], [0.7, 0.3, -0.2]),
        ];
        let laws = [
            Law::Contact { friction: 0.6 },
            Law::Sliding { friction: 0.6, direction: [0.6, 0.8] },
            Law::Interval { lower: -0.5, upper: 0.7 },
        ];
        for (law, form) in laws.iter().flat_map(|law| [(law, Form::AlartCurnier), (law, Form::Natural)]) {
            for (rates, forces) in points {
                let found = equations(law, form, &rates, &forces);
                for column in 0..law.rows() {
                    let moved = |values: [f64; 3], by: f64| {
                        let mut values = values;
                        values[column] += by;
                        values
                    };
                    let step = 1e-6;
                    let by_rate = equations(law, form, &moved(rates, step), &forces).value
                        - equations(law, form, &moved(rates, -step), &forces).value;
                    let by_force = equations(law, form, &rates, &moved(forces, step)).value
                        - equations(law, form, &rates, &moved(forces, -step)).value;
                    let rate_error = (by_rate / (2.0 * step) - found.by_rate.column(column)).amax();
                    let force_error = (by_force / (2.0 * step) - found.by_force.column(column)).amax();
                    assert!(
                        rate_error < 1e-9 && force_error < 1e-9,
                        "{law:?} {form:?}: {rate_error:e} {force_error:e}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_natural_map_is_zero_where_coulombs_law_holds() {
        let contact = Law::Contact { friction: 0.5 };
        let slides = natural_map(&contact, &[0.0, 0.3, 0.4], &[2.0, -0.6, -0.8]);
        let sticks = natural_map(&contact, &[0.0, 0.0, 0.0], &[2.0, -0.6, 0.3]);
        let leaves = natural_map(&contact, &[0.1, 3.0, 4.0], &[0.0, 0.0, 0.0]);
        assert!(slides.amax() < 1e-15 && sticks.amax() == 0.0 && leaves.amax() == 0.0);
        assert!(
            natural_map(&contact, &[0.0, 0.3, 0.4], &[2.0, 0.6, 0.8]).amax() > 0.1,
            "friction that pushes along the slip"
        );
    }
}
