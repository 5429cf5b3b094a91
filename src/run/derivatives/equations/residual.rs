//! The efforts that a motion needs besides all forces: d'Alembert's principle along each degree of freedom.
//!
//! ```text
//!     ρ_k = Σ_bodies ∂x/∂q_k · F + (∂R/∂q_k) : F_R − τ_k        F = m (ẍ − g) + R̈ p − f        F_R = (ẍ − g) pᵀ + R̈ P
//! ```
//!
//! in coordinates (x, R) of R¹² a body (`tests/scheme/literal/scheme.rs`), with the inertial numbers m, p, P and armatures of
//! [`crate::derivatives::equations::figures`], wrenches f of springs and loads, and efforts τ in the joints. The torque of F_R about x is
//! `Σ_c R_c × F_R,c` over the columns; forces and torques are summed over the subtree of each joint, about its anchor.
//!
//! Source: R. Featherstone, Rigid Body Dynamics Algorithms, Springer 2008, chapter 5.

use crate::derivatives::equations::figures::{End, Figures, Frame};
use crate::derivatives::equations::placed::{Offsets, Placed, end_frame};
use crate::derivatives::numbers::jet::Jet;
use crate::derivatives::numbers::number::Number;
use crate::derivatives::numbers::vector::{Matrix, Vector};

/// A force on a body, and its torque about the origin of the body's frame.
#[derive(Clone, Copy)]
pub struct Load<T> {
    /// N.
    pub force: Vector<T>,
    /// N m.
    pub torque: Vector<T>,
}

/// ρ (n) of a motion whose offsets have their rates and accelerations; without the efforts of closures and of efforts from outside.
pub fn residual<T: Number>(figures: &Figures<Jet<T>>, placed: &[Placed<Jet<T>>], offsets: &Offsets<Jet<T>>) -> Vec<T> {
    let mut loads: Vec<Load<T>> = placed
        .iter()
        .zip(&figures.bodies)
        .map(|(at, body)| {
            let mass = body.mass.value;
            let moment = body.moment.map(|entry| entry.value);
            let second = body.second_moments.map(|column| column.map(|entry| entry.value));
            let fall = at.frame.origin.map(|entry| entry.acceleration) - figures.gravity.map(|entry| entry.value);
            let turn = at.frame.axes.map(|column| column.map(|entry| entry.acceleration));
            let force = fall.scaled(mass) + turn.apply(moment);
            let axes = values(&at.frame.axes);
            let mut torque = Vector::zero();
            for (column, axis) in axes.0.iter().enumerate() {
                let pull = fall.scaled(moment.0[column]) + turn.apply(second.0[column]);
                torque = torque + axis.cross(pull);
            }
            Load { force, torque }
        })
        .collect();
    add_point_springs(figures, placed, &mut loads);
    for wrench in &figures.wrenches {
        let force = wrench.force.map(|entry| entry.value);
        let arm = values(&placed[wrench.body].frame.axes).apply(wrench.point.map(|entry| entry.value));
        let load = &mut loads[wrench.body];
        load.force = load.force - force;
        load.torque = load.torque - arm.cross(force) - wrench.torque.map(|entry| entry.value);
    }
    let mut rows = along_freedoms(figures, &still(placed), loads);
    for &(freedom, armature) in &figures.rotors {
        rows[freedom] = rows[freedom] + armature.value * offsets.second[freedom].acceleration;
    }
    for &(freedom, coefficient) in &figures.dampers {
        rows[freedom] = rows[freedom] + coefficient.value * offsets.second[freedom].rate;
    }
    for spring in &figures.springs {
        let stretch = offsets.coordinate(spring.coordinate).value - spring.rest.value;
        let freedom = spring.coordinate.freedom;
        rows[freedom] = rows[freedom] + spring.stiffness.value * stretch;
    }
    for &(freedom, effort) in &figures.loads {
        rows[freedom] = rows[freedom] - effort.value;
    }
    rows
}

/// The tensions of springs between points, as loads that the motion needs.
fn add_point_springs<T: Number>(figures: &Figures<Jet<T>>, placed: &[Placed<Jet<T>>], loads: &mut [Load<T>]) {
    for spring in &figures.point_springs {
        let ends = [&spring.a, &spring.b];
        let [a, b] = ends.map(|end| end_frame(end, placed).origin);
        let gap = b - a;
        let length = gap.dot(gap).square_root();
        let tension =
            spring.stiffness.value * (length.value - spring.rest_length.value) + spring.damping.value * length.rate;
        let pull = gap.map(|entry| entry.value).scaled(tension / length.value);
        let mut add = |end: &End<Jet<T>>, place: Vector<Jet<T>>, need: Vector<T>| {
            let Some(body) = end.body else { return };
            let arm = (place - placed[body].frame.origin).map(|entry| entry.value);
            loads[body].force = loads[body].force + need;
            loads[body].torque = loads[body].torque + arm.cross(need);
        };
        add(ends[0], a, -pull);
        add(ends[1], b, pull);
    }
}

/// The loads of each subtree along the degrees of freedom of its joint.
pub fn along_freedoms<F, T: Number>(figures: &Figures<F>, placed: &[Placed<T>], mut loads: Vec<Load<T>>) -> Vec<T> {
    let mut rows = vec![T::zero(); figures.freedoms];
    for (index, body) in figures.bodies.iter().enumerate().rev() {
        let at = &placed[index];
        let origin = at.frame.origin;
        let Load { force, torque } = loads[index];
        let slides = body.kind.translation_axes();
        let about_anchor = torque + (origin - at.anchor).cross(force);
        for (offset, &axis) in slides.iter().enumerate() {
            rows[body.velocity_index + offset] = at.on_parent.0[axis].dot(force);
        }
        for (offset, &axis) in body.kind.rotation_axes().iter().enumerate() {
            rows[body.velocity_index + slides.len() + offset] = at.on_child.0[axis].dot(about_anchor);
        }
        if let Some(parent) = body.parent {
            let arm = origin - placed[parent].frame.origin;
            loads[parent].force = loads[parent].force + force;
            loads[parent].torque = loads[parent].torque + torque + arm.cross(force);
        }
    }
    rows
}

/// Placed bodies without their motion.
pub fn still<T: Number>(placed: &[Placed<Jet<T>>]) -> Vec<Placed<T>> {
    let of = |at: &Placed<Jet<T>>| Placed {
        frame: Frame { axes: values(&at.frame.axes), origin: at.frame.origin.map(|entry| entry.value) },
        anchor: at.anchor.map(|entry| entry.value),
        on_parent: values(&at.on_parent),
        on_child: values(&at.on_child),
    };
    placed.iter().map(of).collect()
}

fn values<T: Number>(matrix: &Matrix<Jet<T>>) -> Matrix<T> {
    matrix.map(|column| column.map(|entry| entry.value))
}
