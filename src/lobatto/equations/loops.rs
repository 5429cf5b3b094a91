//! The equations of loop joints at all stages, in space or in a plane: gaps, and the directions in which their multipliers push.
//!
//! The points are `P_a`, `P_b` (m), `d = P_b − P_a`, the direction u is fixed in a and w in b, and z is the part of `d` along the normal of a plane
//! (m, constant; zero in space). Every equation has one gradient, a force f and its torque t about the common origin that act on b, and their
//! opposites on a:
//!
//! ```text
//!     slide along u:         g = d · u                     f = u              t = P_b × u
//!     u square to w:         g = u · w                     f = 0              t = w × u
//!     distance L:            g = (d·d + z² − L²)/2L        f = d / L          t = P_b × d / L
//!     line of a spring:      no gap                        f = d / ℓ          t = P_b × d / ℓ,   ℓ² = d·d + z²
//! ```
//!
//! On a the arm is `P_b` too: the direction u turns with a, which makes up for the gap. Since the start of the step points and directions
//! have moved with their body, by its turn `1 + N` and the displacement of its anchor.

use crate::numbers::euclidean::Euclidean;
use crate::numbers::lanes::Lanes;
use catena_mechanism::forces::point_spring::NO_LENGTH;

/// One equation of a closure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Equation {
    /// The points coincide along a direction of a.
    Slide,
    /// A direction of a is square to one of b.
    Square,
    /// The points keep their distance: `L − z²/L` and L (m).
    Distance(f64, f64),
    /// No equation, but the line of a spring: the direction from a to b; z² (m²).
    Line(f64),
}

/// A closure at the start of a step, in the components `C` of the world or of the plane.
#[derive(Clone)]
pub(crate) struct LoopStart<C> {
    /// The bodies at its ends a and b; `None` is the world.
    pub bodies: [Option<usize>; 2],
    /// The places of its ends, from the common origin (m).
    pub points: [C; 2],
    /// Vectors from the bodies' anchors to the ends (m); not used for the world.
    pub arms: [C; 2],
    /// Every equation with its directions u and w.
    pub equations: Vec<(Equation, [C; 2])>,
}

impl<C: Copy + Default> LoopStart<C> {
    /// Room for a closure between two bodies.
    pub fn new(bodies: [Option<usize>; 2], equations: impl IntoIterator<Item = Equation>) -> Self {
        let nowhere = [C::default(); 2];
        let equations = equations.into_iter().map(|equation| (equation, nowhere)).collect();
        LoopStart { bodies, points: nowhere, arms: nowhere, equations }
    }
}

/// The displacement of a body since the start of the step, at all stages.
pub(crate) trait Displaced<V: Lanes> {
    /// In space or in a plane.
    type Vector: Euclidean<V>;
    /// `(1 + N) v`: a direction that turns with the body.
    fn turn(&self, v: &<Self::Vector as Euclidean<V>>::Components) -> Self::Vector;
    /// `Δa + N r`: displacement of the point at the arm r from the anchor a (m).
    fn displacement(&self, arm: &<Self::Vector as Euclidean<V>>::Components) -> Self::Vector;
}

/// The components of the vectors of displaced bodies.
type Components<V, D> = <<D as Displaced<V>>::Vector as Euclidean<V>>::Components;

/// A gap (m, or the sine of an angle), and its gradient: direction of the force on b, and its torque about the common origin.
#[derive(Clone)]
struct Value<V: Lanes, E: Euclidean<V>> {
    gap: V,
    force: E,
    torque: E::Axial,
}

/// Gaps and gradients of all closures, which have these rows, for the bodies at the columns' (0) and the rows' (1) stages. Gaps are the gaps at the
/// columns' stages.
#[inline(always)]
pub(crate) fn evaluate<'l, V: Lanes, D: Displaced<V> + 'l>(
    closures: impl Iterator<Item = &'l LoopStart<Components<V, D>>>,
    moved: &[[D; 2]],
    rows_of_loop: &[std::ops::Range<usize>],
    gaps: &mut [V],
    gradients: &mut [[[V; 6]; 2]],
) where
    Components<V, D>: 'l,
{
    for (closure, rows) in closures.zip(rows_of_loop) {
        for side in 0..2 {
            let bodies = closure.bodies.map(|body| body.map(|body| &moved[body][side]));
            let a = point(&closure.points[0], &closure.arms[0], bodies[0]);
            let b = point(&closure.points[1], &closure.arms[1], bodies[1]);
            for ((equation, directions), row) in closure.equations.iter().zip(rows.clone()) {
                let value = evaluate_one(*equation, directions, bodies, a, b);
                gradients[row][side] = value.force.joined(value.torque);
                if side == 0 {
                    gaps[row] = value.gap;
                }
            }
        }
    }
}

/// One equation between the points a and b of two bodies.
#[inline(always)]
fn evaluate_one<V: Lanes, D: Displaced<V>>(
    equation: Equation,
    directions: &[Components<V, D>; 2],
    bodies: [Option<&D>; 2],
    a: D::Vector,
    b: D::Vector,
) -> Value<V, D::Vector> {
    let apart = b.minus(a);
    match equation {
        Equation::Slide => {
            let along = direction(&directions[0], bodies[0]);
            Value { gap: apart.dot(along), force: along, torque: b.cross(along) }
        }
        Equation::Square => {
            let (first, second) = (direction(&directions[0], bodies[0]), direction(&directions[1], bodies[1]));
            Value { gap: first.dot(second), force: D::Vector::zero(), torque: second.cross(first) }
        }
        Equation::Distance(reduced, length) => {
            let along = apart.times(V::splat(1.0 / length));
            let gap = (apart.dot(along) - V::splat(reduced)) * V::splat(0.5);
            Value { gap, force: along, torque: b.cross(along) }
        }
        Equation::Line(square) => {
            let length = apart.dot_plus(apart, V::splat(square + NO_LENGTH)).square_root();
            let along = apart.times(length.reciprocal());
            Value { gap: V::zero(), force: along, torque: b.cross(along) }
        }
    }
}

/// The place of the end of a closure.
#[inline(always)]
fn point<V: Lanes, D: Displaced<V>>(start: &Components<V, D>, arm: &Components<V, D>, body: Option<&D>) -> D::Vector {
    let start = D::Vector::splat(start);
    match body {
        Some(body) => start.plus(body.displacement(arm)),
        None => start,
    }
}

/// A direction that is fixed in a body.
#[inline(always)]
fn direction<V: Lanes, D: Displaced<V>>(start: &Components<V, D>, body: Option<&D>) -> D::Vector {
    match body {
        Some(body) => body.turn(start),
        None => D::Vector::splat(start),
    }
}
