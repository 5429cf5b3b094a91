//! The constraints of the literal scheme as polynomials of degree two in the coordinates, with exact derivatives.
//!
//! A vector that is fixed in a body is an affine function of its coordinates `(x, R)`, and so is the place of a point. Every row of g is a scalar
//! product of two of them; rows of loop joints, too.

use crate::literal::coordinates::BODY_COORDINATES;
use catena::mechanism::description::closure::{LoopJoint, LoopKind};
use catena::mechanism::description::joint::{FreeRotation, Pose};
use catena::mechanism::description::mechanism::Mechanism;
use nalgebra::{DVector, Vector3};

/// An affine function of the coordinates.
#[derive(Clone, Debug)]
struct Affine {
    constant: f64,
    /// (coordinate, coefficient)
    terms: Vec<(usize, f64)>,
}

/// A vector of the world whose components are affine functions of the coordinates.
type AffineVector = [Affine; 3];

/// A polynomial of degree two in the coordinates without its constant, of which no step asks: one row of g.
#[derive(Clone, Debug)]
pub(crate) struct Quadratic {
    /// (coordinate, coefficient)
    linear: Vec<(usize, f64)>,
    /// (coordinate, coordinate, coefficient)
    products: Vec<(usize, usize, f64)>,
}

impl Quadratic {
    /// Value at `q + increment` less the value at `q`.
    pub(crate) fn change(&self, q: &DVector<f64>, increment: &DVector<f64>) -> f64 {
        let linear = self.linear.iter().map(|&(i, coefficient)| coefficient * increment[i]);
        let products = self.products.iter().map(|&(i, j, coefficient)| {
            coefficient * (q[i] * increment[j] + increment[i] * q[j] + increment[i] * increment[j])
        });
        linear.sum::<f64>() + products.sum::<f64>()
    }

    /// Hands every contribution to the gradient at q to `add(coordinate, value)`.
    pub(crate) fn add_gradient(&self, q: &DVector<f64>, mut add: impl FnMut(usize, f64)) {
        for &(i, coefficient) in &self.linear {
            add(i, coefficient);
        }
        for &(i, j, coefficient) in &self.products {
            add(i, coefficient * q[j]);
            add(j, coefficient * q[i]);
        }
    }

    /// Hands every contribution to the second derivative to `add(coordinate, coordinate, value)`.
    pub(crate) fn add_second_derivative(&self, mut add: impl FnMut(usize, usize, f64)) {
        for &(i, j, coefficient) in &self.products {
            add(i, j, coefficient);
            add(j, i, coefficient);
        }
    }
}

/// The vector fixed in a body (or in the world) with the components `local` in its frame.
fn direction(body: Option<usize>, local: &Vector3<f64>) -> AffineVector {
    [0, 1, 2].map(|row| match body {
        None => Affine { constant: local[row], terms: Vec::new() },
        Some(index) => Affine {
            constant: 0.0,
            terms: (0..3).map(|column| (BODY_COORDINATES * index + 3 + 3 * column + row, local[column])).collect(),
        },
    })
}

/// The place in the world of the point `local` of a body.
fn point(body: Option<usize>, local: &Vector3<f64>) -> AffineVector {
    let mut place = direction(body, local);
    if let Some(index) = body {
        for (row, component) in place.iter_mut().enumerate() {
            component.terms.push((BODY_COORDINATES * index + row, 1.0));
        }
    }
    place
}

/// `a − b`.
fn difference(a: AffineVector, b: &AffineVector) -> AffineVector {
    let mut result = a;
    for (left, right) in result.iter_mut().zip(b) {
        left.constant -= right.constant;
        left.terms.extend(right.terms.iter().map(|&(i, coefficient)| (i, -coefficient)));
    }
    result
}

/// `a · b`.
fn dot(a: &AffineVector, b: &AffineVector) -> Quadratic {
    let mut row = Quadratic { linear: Vec::new(), products: Vec::new() };
    for (left, right) in a.iter().zip(b) {
        row.linear.extend(left.terms.iter().map(|&(i, coefficient)| (i, coefficient * right.constant)));
        row.linear.extend(right.terms.iter().map(|&(i, coefficient)| (i, coefficient * left.constant)));
        for &(i, of_left) in &left.terms {
            row.products.extend(right.terms.iter().map(|&(j, of_right)| (i, j, of_left * of_right)));
        }
    }
    row
}

/// Every row of g: `RᵀR = 1` and the joint of each body in turn, then the loop joints ([`loop_rows`]).
///
/// The joint frame F on parent and child gives `gap = F_c origin − F_p origin` and axes `e_i`; a joint requires
///
/// - `e_i(parent) · gap = 0` for each axis i along which it may not translate (for three such axes the gap itself);
/// - `e_i(parent) · e_j(child) = 0` for (i, j) = (x, z), (y, z) if it may turn about z only, and for (x, y), (y, z),
///   (z, x) if it may not turn at all. These hold also when F is turned by half a turn about an axis; a step that starts
///   from the right branch cannot get there.
pub(crate) fn constraints(mechanism: &Mechanism) -> Vec<Quadratic> {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let mut rows = Vec::new();
    for (index, body) in mechanism.bodies.iter().enumerate() {
        let own_axes = axes.map(|axis| direction(Some(index), &axis));
        for (first, second) in [(0, 0), (1, 1), (2, 2), (1, 2), (2, 0), (0, 1)] {
            rows.push(dot(&own_axes[first], &own_axes[second]));
        }

        let joint = &body.joint;
        let axes_of = |owner: Option<usize>, frame: &Pose| axes.map(|axis| direction(owner, &(frame.rotation * axis)));
        let on_parent = axes_of(body.parent, &joint.on_parent);
        let on_child = axes_of(Some(index), &joint.on_child);
        let gap = difference(
            point(Some(index), &joint.on_child.translation.vector),
            &point(body.parent, &joint.on_parent.translation.vector),
        );
        let free = joint.kind.translation_axes();
        for axis in (0..3).filter(|axis| !free.contains(axis)) {
            if free.is_empty() {
                rows.push(dot(&gap, &direction(None, &axes[axis])));
            } else {
                rows.push(dot(&on_parent[axis], &gap));
            }
        }
        let perpendicular: &[(usize, usize)] = match joint.kind.rotation() {
            FreeRotation::None => &[(0, 1), (1, 2), (2, 0)],
            FreeRotation::AboutZ => &[(0, 2), (1, 2)],
            FreeRotation::Ball => &[],
        };
        for &(first, second) in perpendicular {
            rows.push(dot(&on_parent[first], &on_child[second]));
        }
    }
    rows.extend(mechanism.loops.iter().flat_map(loop_rows));
    rows
}

/// The rows of a loop joint as in the table of [`catena::mechanism::description::closure`], the row of a distance times 2 L.
fn loop_rows(joint: &LoopJoint) -> Vec<Quadratic> {
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()];
    let [of_a, of_b] =
        [&joint.a, &joint.b].map(|end| axes.map(|axis| direction(end.body, &(end.frame.rotation * axis))));
    let [a, b] = [&joint.a, &joint.b].map(|end| point(end.body, &end.frame.translation.vector));
    let gap = difference(b, &a);
    let slides = joint.kind.slides();
    let along = |axis: usize| if slides.len() == 3 { direction(None, &axes[axis]) } else { of_a[axis].clone() };
    let mut rows: Vec<Quadratic> = slides.iter().map(|&axis| dot(&along(axis), &gap)).collect();
    rows.extend(joint.kind.squares().iter().map(|&(first, second)| dot(&of_a[first], &of_b[second])));
    if let LoopKind::Distance(_) = joint.kind {
        rows.push(dot(&gap, &gap));
    }
    rows
}
