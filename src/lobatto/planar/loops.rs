//! Loop joints in a plane: the equations that mean something there, and where its ends and directions are at the start of a step.
//!
//! A body has the turn `(C, S)` since zero displacement and its anchor a; arm and direction u⁰ are at zero displacement:
//!
//! ```text
//!     arm = (C + S J) arm⁰,   P = a + arm          (m), from the common origin
//!     u = (C + S J) u⁰
//! ```
//!
//! The equations are the same as in space: [`crate::equations::loops`].

use crate::equations::loops::{Displaced, Equation, LoopStart};
use crate::equations::origins::common_origin;
use crate::numbers::lanes::Lanes;
use crate::planar::algebra::Vector2;
use crate::planar::body::{PlanarBody, turned};
use crate::planar::force_plan::{End, Ends};
use catena_mechanism::description::mechanism::Mechanism;
use catena_mechanism::motion::kinematics::body_states;
use catena_mechanism::motion::state::State;
use catena_mechanism::structure::planar_loops::PlanarEquation;
use catena_mechanism::structure::plane::Plane;

/// A closure in a plane.
#[derive(Clone)]
pub(crate) struct PlanarLoop {
    ends: [End; 2],
    /// The directions of each equation on the two bodies at zero displacement.
    directions: Vec<[[f64; 2]; 2]>,
    /// At the start of the step.
    pub start: LoopStart<[f64; 2]>,
}

impl PlanarLoop {
    /// The loops of a mechanism in its plane, and with `springs` the lines of its springs.
    pub fn all(mechanism: &Mechanism, plane: &Plane, springs: bool) -> Vec<Self> {
        let zero = body_states(mechanism, &State::zero(mechanism));
        let ends = Ends { mechanism, plane, zero: &zero };
        let none = [[0.0; 2]; 2];
        let loops = mechanism.loops.iter().map(|joint| {
            let equations = plane.equations(joint, &zero).unwrap_or_default();
            let equations = equations.into_iter().map(|equation| match equation {
                PlanarEquation::Slide(along) => (Equation::Slide, [plane.flat(&along), [0.0; 2]]),
                PlanarEquation::Square(on_a, on_b) => (Equation::Square, [plane.flat(&on_a), plane.flat(&on_b)]),
                PlanarEquation::Distance { length, height } => {
                    (Equation::Distance(length - height * height / length, length), none)
                }
            });
            Self::new([ends.end(&joint.a), ends.end(&joint.b)], equations.collect())
        });
        let lines = mechanism.forces.point_springs.iter().filter(|_| springs).map(|spring| {
            let height = ends.height(&spring.b) - ends.height(&spring.a);
            Self::new([ends.end(&spring.a), ends.end(&spring.b)], vec![(Equation::Line(height * height), none)])
        });
        loops.chain(lines).collect()
    }

    fn new(ends: [End; 2], equations: Vec<(Equation, [[f64; 2]; 2])>) -> Self {
        let (equations, directions): (Vec<_>, Vec<_>) = equations.into_iter().unzip();
        PlanarLoop { start: LoopStart::new([ends[0].body, ends[1].body], equations), ends, directions }
    }

    /// Takes the start of a step; `origins` are the common origins of the parts of all bodies (m).
    pub fn begin(&mut self, bodies: &[PlanarBody], origins: &[[f64; 2]]) {
        let origin = common_origin(self.ends.iter().map(|end| end.body), origins);
        let still = [1.0, 0.0];
        let turn = [0, 1].map(|side: usize| self.ends[side].body.map_or(&still, |body| &bodies[body].turn));
        for (side, End { body, arm }) in self.ends.iter().enumerate() {
            let arm = turned(turn[side], arm);
            let anchor = body.map_or([0.0; 2], |body| bodies[body].position);
            self.start.points[side] = [anchor[0] + arm[0] - origin[0], anchor[1] + arm[1] - origin[1]];
            self.start.arms[side] = arm;
        }
        for ((_, now), at_zero) in self.start.equations.iter_mut().zip(&self.directions) {
            *now = [turned(turn[0], &at_zero[0]), turned(turn[1], &at_zero[1])];
        }
    }
}

/// The displacement of a body since the start of the step: its turn as `κ = cos φ − 1` and `σ = sin φ`, and the displacement of its anchor (m).
#[derive(Clone, Copy)]
pub(crate) struct Moved<V> {
    pub cosine: V,
    pub sine: V,
    pub anchor: Vector2<V>,
}

impl<V: Lanes> Displaced<V> for Moved<V> {
    type Vector = Vector2<V>;

    #[inline(always)]
    fn turn(&self, v: &[f64; 2]) -> Vector2<V> {
        let v = Vector2::splat(v);
        v.turned_plus(self.cosine, self.sine, v)
    }

    #[inline(always)]
    fn displacement(&self, arm: &[f64; 2]) -> Vector2<V> {
        Vector2::splat(arm).turned_plus(self.cosine, self.sine, self.anchor)
    }
}
