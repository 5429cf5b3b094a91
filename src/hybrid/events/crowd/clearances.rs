//! How far pairs are apart at least, by earlier looks at them.
//!
//! ```text
//!     φ(t) ≥ φ(t₁) − Σ (|Δx_a| + |ΔR_a| R_a + |Δx_b| + |ΔR_b| R_b)        summed over the looks at the bodies since t₁
//!     φ(t) ≥ φ(t₁) − |Δ(R_bᵀ (x_a − x_b))| − |Δ(R_bᵀ R_a)| R_a           from t₁ to t alone
//! ```
//!
//! φ is the gap of a pair (m), x and R are the places and rotations of its bodies, R_a and R_b also their reaches (m). The first bound costs less; the
//! second one is that of bodies that fly and turn together, as the links of a robot do.

use crate::geometry::Before;
use crate::instant::holding::near::Near;
use crate::instant::holding::pairs::Pair;
use crate::instant::holding::per_pair::PerPair;
use crate::instant::holding::touching::{Contact, Touching};
use crate::instant::moved::Moved;
use crate::mechanism::description::body_state::BodyState;
use nalgebra::{Matrix3, Vector3};
use std::f64::consts::FRAC_1_SQRT_2;

/// Distances of pairs that were seen before.
#[derive(Clone, Default)]
pub(crate) struct Clearances {
    /// The pairs that may be within reach.
    pub near: Near,
    pairs: PerPair<Clearance>,
    bodies: Vec<BodyState>,
    /// How far each body has moved since all were seen last.
    moved: Vec<Moved>,
}

/// What is known of a pair.
#[derive(Clone, Copy, Default)]
struct Clearance {
    /// A lower bound of the gap (m).
    clear: f64,
    /// The last look at it, if it has told one.
    look: Option<Look>,
    before: Before,
}

/// A look at two bodies.
#[derive(Clone, Copy)]
struct Look {
    /// The gap was at least this (m).
    apart: f64,
    /// Where the first was, seen from the second (m).
    place: Place,
}

/// A place and a rotation.
type Place = (Vector3<f64>, Matrix3<f64>);

impl Clearances {
    /// Takes the places of the bodies now: how far they have moved since the last look.
    pub fn see(&mut self, bodies: &[BodyState]) {
        if self.bodies.len() != bodies.len() {
            self.bodies = bodies.to_vec();
        }
        self.moved.clear();
        self.moved.extend(bodies.iter().zip(&self.bodies).map(|(now, before)| Moved::between(before, now)));
        self.bodies.copy_from_slice(bodies);
    }

    /// Knows the near pairs, and no other; `parted` tells whether some are near no more.
    pub fn keep_near(&mut self, parted: bool) {
        let Clearances { near, pairs, .. } = self;
        if parted {
            pairs.retain(|pair| near.pairs().binary_search(&pair).is_ok());
        }
        pairs.extend(near.pairs(), |_| Clearance::default());
    }

    /// Whether a pair that had no contacts is still farther apart than `within` (m).
    pub fn is_beyond(&mut self, pair: usize, of: &Pair, within: f64) -> bool {
        let known = self.pairs.of(pair);
        for (body, reach) in of.bodies.into_iter().zip(of.reach) {
            if let Some(body) = body {
                known.clear -= self.moved[body].of_reach(reach);
            }
        }
        if known.before.touches {
            return false;
        }
        if known.clear <= within
            && let (Some(look), Some((place, reach))) = (known.look, seen(of.bodies, of.reach, &self.bodies))
        {
            known.clear = known.clear.max(look.apart - displacement(&look.place, &place, reach));
        }
        known.clear > within
    }

    /// Looks at a pair: its contacts with a gap of at most `within` (m).
    pub fn look(&mut self, pair: usize, touching: &Touching, bodies: &[BodyState], within: f64) -> Vec<Contact> {
        let known = self.pairs.of(pair);
        let (found, apart) = touching.soon(pair, bodies, within, &mut known.before);
        known.clear = apart.max(0.0);
        let place = if known.clear > 0.0 {
            seen(touching.pairs[pair].bodies, touching.pairs[pair].reach, bodies)
        } else {
            None
        };
        known.look = place.map(|(place, _)| Look { apart, place });
        found
    }
}

/// The place of the body with the smaller reach, seen from the other body of a pair, and that reach (m); `None` beside the world.
fn seen(of: [Option<usize>; 2], reach: [f64; 2], bodies: &[BodyState]) -> Option<(Place, f64)> {
    let [Some(a), Some(b)] = of else { return None };
    let (own, from, reach) = if reach[0] <= reach[1] { (a, b, reach[0]) } else { (b, a, reach[1]) };
    let (own, from) = (&bodies[own], &bodies[from]);
    let place = from.rotation.tr_mul(&(own.position - from.position));
    Some(((place, from.rotation.tr_mul(&own.rotation)), reach))
}

/// The most that a point within a reach (m) has moved between two places of its body (m).
fn displacement((place, rotation): &Place, (now, turned): &Place, reach: f64) -> f64 {
    (now - place).norm() + (turned - rotation).norm() * FRAC_1_SQRT_2 * reach
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::body_state::WORLD;
    use nalgebra::Rotation3;

    #[test]
    fn bodies_that_fly_and_turn_together_have_not_moved_and_one_that_turns_beside_has_by_its_turn() {
        let at = |turn: f64, own: f64| {
            let rotation = Rotation3::new(Vector3::new(0.3, -0.5, 0.7) * turn).into_inner();
            let first = BodyState { position: Vector3::new(4.0, 1.0, -2.0) * turn, rotation, ..WORLD };
            let position = first.position + rotation * Vector3::new(0.0, 0.3, 0.0);
            let second =
                BodyState { position, rotation: rotation * Rotation3::new(Vector3::x() * own).into_inner(), ..first };
            let (place, reach) = seen([Some(0), Some(1)], [0.5, 0.2], &[first, second]).expect("two bodies");
            assert_eq!(reach, 0.2);
            place
        };
        assert!(displacement(&at(0.0, 0.0), &at(1.5, 0.0), 0.2) < 1e-14);
        // A chord: 2 sin(φ/2) of the reach for a turn φ.
        let by = displacement(&at(0.0, 0.0), &at(1.5, 0.4), 0.2);
        assert!((by - 0.2 * 2.0 * 0.2_f64.sin()).abs() < 1e-14, "{by}");
        assert!(seen([Some(0), None], [0.5, f64::INFINITY], &[WORLD]).is_none());
    }
}
