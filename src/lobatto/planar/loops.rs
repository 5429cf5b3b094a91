//! The equations of loop joints in a plane at all stages: those of [`crate::equations::loops`] that mean something there.
//!
//! With the points `P_a`, `P_b` (m), `d = P_b − P_a`, their difference in height z, and directions u fixed in a and w in b, every
//! equation has one gradient, a force f and its torque t about the common origin that act on b, and their opposites on a:
//!
//! ```text
//!     slide along u:         g = d · u                     f = u              t = P_b × u
//!     u square to w:         g = u · w                     f = 0              t = w × u
//!     distance L:            g = (d·d + z² − L²)/2L        f = d / L          t = P_b × d / L
//!     line of a spring:      no gap                        f = d / ℓ          t = P_b × d / ℓ,   ℓ² = d·d + z²
//! ```

use crate::planar::algebra::Vector2;
use crate::planar::body::{PlanarBody, turned};
use crate::planar::force_plan::{End, Ends};
use nalgebra::Vector3;

use crate::numbers::lanes::Lanes;
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::forces::point_spring::NO_LENGTH;
use catena_mechanism::motion::kinematics::body_states;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::planar_loops::PlanarEquation;
use catena_mechanism::structure::plane::Plane;

/// An equation; directions are those at zero displacement.
enum Equation {
    Slide([f64; 2]),
    Square([f64; 2], [f64; 2]),
    /// L (m) and z² (m²).
    Distance(f64, f64),
    /// z².
    Line(f64),
}

/// A closure: constant, but for where its ends are at the start of the step.
pub(crate) struct PlanarClosure {
    ends: [End; 2],
    equations: Vec<Equation>,
    known: [EndStart; 2],
    /// The directions of each equation on the two bodies.
    directions: Vec<[[f64; 2]; 2]>,
}

/// An end at the start of a step.
#[derive(Clone, Copy, Default)]
struct EndStart {
    /// From the common origin (m).
    point: [f64; 2],
    /// From the anchor of the body (m).
    arm: [f64; 2],
}

impl EndStart {
    /// Where it is when its body has moved.
    #[inline(always)]
    fn moved<V: Lanes>(&self, body: &Moved<V>) -> Vector2<V> {
        let arm = Vector2::splat(&self.arm).turned_plus(body.cosine, body.sine, body.anchor);
        Vector2::splat(&self.point).plus(arm)
    }
}

/// Where a body is since the start of the step: its turn as `κ = cos φ − 1` and `σ = sin φ`, and the displacement of its anchor (m).
#[derive(Clone, Copy)]
pub(crate) struct Moved<V> {
    pub cosine: V,
    pub sine: V,
    pub anchor: Vector2<V>,
}

impl<V: Lanes> Moved<V> {
    /// Not at all.
    pub fn not() -> Self {
        Moved { cosine: V::zero(), sine: V::zero(), anchor: Vector2::zero() }
    }

    /// `(1 + κ + σ J) v`.
    #[inline(always)]
    pub fn turn(&self, v: &[f64; 2]) -> Vector2<V> {
        let v = Vector2::splat(v);
        v.turned_plus(self.cosine, self.sine, v)
    }
}

/// A gap and its gradient.
#[derive(Clone, Copy)]
pub(crate) struct Value<V> {
    pub gap: V,
    pub force: Vector2<V>,
    pub torque: V,
}

impl PlanarClosure {
    /// The loops of a mechanism in its plane, and with `springs` the lines of its springs.
    pub fn all(mechanism: &Mechanism, plane: &Plane, springs: bool) -> Vec<Self> {
        let zero = body_states(mechanism, &State::zero(mechanism));
        let ends = Ends { mechanism, plane, zero: &zero };
        let flat = |v: &Vector3<f64>| plane.flat(v);
        let closure = |ends: [End; 2], equations: Vec<Equation>| PlanarClosure {
            ends,
            directions: vec![[[0.0; 2]; 2]; equations.len()],
            equations,
            known: [EndStart::default(); 2],
        };
        let loops = mechanism.loops.iter().map(|joint| {
            let equations =
                plane.equations(joint, &zero).unwrap_or_default().into_iter().map(|equation| match equation {
                    PlanarEquation::Slide(along) => Equation::Slide(flat(&along)),
                    PlanarEquation::Square(on_a, on_b) => Equation::Square(flat(&on_a), flat(&on_b)),
                    PlanarEquation::Distance { length, height } => Equation::Distance(length, height * height),
                });
            closure([ends.end(&joint.a), ends.end(&joint.b)], equations.collect())
        });
        let lines = mechanism.forces.point_springs.iter().filter(|_| springs).map(|spring| {
            let height = ends.height(&spring.b) - ends.height(&spring.a);
            closure([ends.end(&spring.a), ends.end(&spring.b)], vec![Equation::Line(height * height)])
        });
        loops.chain(lines).collect()
    }

    /// Number of equations.
    pub fn rows(&self) -> usize {
        self.equations.len()
    }

    /// Takes the start of a step.
    pub fn begin(&mut self, bodies: &[PlanarBody], origin: &[f64; 2]) {
        let still = [1.0, 0.0];
        let turn = [0, 1].map(|side: usize| self.ends[side].body.map_or(&still, |body| &bodies[body].turn));
        for side in 0..2 {
            let End { body, arm } = &self.ends[side];
            let arm = turned(turn[side], arm);
            let anchor = body.map_or([0.0; 2], |body| bodies[body].position);
            let point = [anchor[0] + arm[0] - origin[0], anchor[1] + arm[1] - origin[1]];
            self.known[side] = EndStart { point, arm };
        }
        for (equation, directions) in self.equations.iter().zip(&mut self.directions) {
            match equation {
                Equation::Slide(along) => directions[0] = turned(turn[0], along),
                Equation::Square(on_a, on_b) => *directions = [turned(turn[0], on_a), turned(turn[1], on_b)],
                Equation::Distance(..) | Equation::Line(_) => {}
            }
        }
    }

    /// Gaps and gradients for bodies that have moved so, in the order of the equations.
    #[inline(always)]
    pub fn evaluate<V: Lanes>(&self, moved: &[[Moved<V>; 2]], side: usize, mut put: impl FnMut(usize, Value<V>)) {
        let still = Moved::not();
        let (a, b) = (self.ends[0].body, self.ends[1].body);
        let bodies = [a.map_or(&still, |body| &moved[body][side]), b.map_or(&still, |body| &moved[body][side])];
        let points = [self.known[0].moved(bodies[0]), self.known[1].moved(bodies[1])];
        let apart = points[1].minus(points[0]);
        let zero = V::zero();
        for (number, (equation, directions)) in self.equations.iter().zip(&self.directions).enumerate() {
            let value = match *equation {
                Equation::Slide(_) => {
                    let along = bodies[0].turn(&directions[0]);
                    Value { gap: apart.dot(along), force: along, torque: points[1].cross_plus(along, zero) }
                }
                Equation::Square(..) => {
                    let (first, second) = (bodies[0].turn(&directions[0]), bodies[1].turn(&directions[1]));
                    Value { gap: first.dot(second), force: Vector2::zero(), torque: second.cross_plus(first, zero) }
                }
                Equation::Distance(length, square) => {
                    let along = apart.times(V::splat(1.0 / length));
                    let over = apart.dot_plus(along, V::splat((square - length * length) / length));
                    let gap = over * V::splat(0.5);
                    Value { gap, force: along, torque: points[1].cross_plus(along, zero) }
                }
                Equation::Line(square) => {
                    let length = apart.dot_plus(apart, V::splat(square + NO_LENGTH)).square_root();
                    let along = apart.times(length.reciprocal());
                    Value { gap: zero, force: along, torque: points[1].cross_plus(along, zero) }
                }
            };
            put(number, value);
        }
    }
}
