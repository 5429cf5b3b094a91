//! Links of one robot that overlap by design, and so never touch each other.
//!
//! Collision shapes are often larger than their links: shapes of links two joints apart may overlap in every position. Two links whose shapes overlap
//! where all joints are at zero (within their limits), and at the start, are left out, with a warning. A `[[contact.pair]]` with `ignore = false`
//! keeps them. Links that overlap at the start alone are moved apart, as all shapes are.

use crate::geometry::PairGeometry;
use crate::mechanism::description::body_state::{BodyState, WORLD};
use crate::mechanism::description::contact::ContactPair;
use crate::mechanism::description::joint::Pose;
use crate::mechanism::ground::words::counted;
use crate::mechanism::motion::energy::violation;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::model::description::chain_reach::{Ball, ball_about};
use crate::model::description::contact_pairs::{LeftOutPair, are_wanted};
use crate::model::description::never_touch::NeverTouch;
use crate::model::description::robot_model::Model;
use crate::scene::{Warning, WarningGroup};
use nalgebra::{Rotation3, Translation3};

/// Shapes that overlap by less than this part of the smaller one touch: roundings of files are smaller.
const TOUCHES: f64 = 1e-6;
/// Position zero counts if it violates loops and mimic relations by less than this [rad, m].
const CLOSED: f64 = 1e-6;
/// Pairs that the warning names, at most.
const NAMED: usize = 8;

/// Numbers pairs in their order.
pub(crate) fn number(pairs: &mut [ContactPair]) {
    pairs.iter_mut().enumerate().for_each(|(number, pair)| pair.number = number);
}

impl Model {
    /// Leaves out links of one robot that overlap where all joints are at zero, or at the limit that is nearest to it, and also at the start.
    pub fn leave_out_overlaps(&mut self, start: &State) {
        let links = self.overlapping(start);
        if links.is_empty() {
            return;
        }
        let all = std::mem::take(&mut self.mechanism.nonsmooth.pairs);
        let (left, mut kept): (Vec<_>, Vec<_>) =
            all.iter().partition(|pair| links.iter().any(|known| *known == self.names(pair)));
        number(&mut kept);
        self.mechanism.nonsmooth.pairs = kept.into();
        let because = NeverTouch::Overlap;
        self.contact.left_out.extend(left.into_iter().map(|pair| LeftOutPair { pair, because }));
        let mut named: Vec<String> = links.iter().map(|[a, b]| format!("{a:?} and {b:?}")).collect();
        let more = named.len().saturating_sub(NAMED);
        named.truncate(NAMED);
        if more > 0 {
            named.push(counted(more, "more pair", "more pairs"));
        }
        let message = format!(
            "links of one robot overlap at position zero and at the start, and do not touch each other: {}; a [[contact.pair]] with ignore = false lets them touch",
            named.join(", ")
        );
        self.warnings.push(Warning::odd(self.path(), None, None, message).in_group(WarningGroup::NotSimulated));
    }

    /// Links of one robot that overlap at the start and at position zero.
    fn overlapping(&self, start: &State) -> Vec<[String; 2]> {
        let bodies = body_states(&self.mechanism, start);
        // Each is worked out once: a mesh has many points, and a pair with each other link.
        let mut balls = vec![None; self.mechanism.nonsmooth.colliders.len()];
        let mut zero = None;
        let mut links: Vec<[String; 2]> = Vec::new();
        // The links of a robot follow each other.
        let is_own = |pair: &ContactPair| self.contact.owners[pair.a] == self.contact.owners[pair.b];
        for pair in self.mechanism.nonsmooth.pairs.runs().iter().flat_map(|run| run.pairs().take_while(is_own)) {
            let names = self.names(&pair);
            if !links.iter().any(|known| *known == names)
                && !are_wanted(&self.contact.settings, names)
                && self.overlaps(&pair, &mut balls, &bodies)
                && self.overlaps(
                    &pair,
                    &mut balls,
                    zero.get_or_insert_with(|| self.bodies_at_zero()).as_deref().unwrap_or(&bodies),
                )
            {
                links.push(names.map(str::to_string));
            }
        }
        links
    }

    /// The bodies where all joints are at zero, or at the limit that is nearest to it; `None` where loops or mimic relations are not satisfied there.
    fn bodies_at_zero(&self) -> Option<Vec<BodyState>> {
        let mut zero = self.initial_state(&[], &[], None).ok()?;
        for limit in &self.mechanism.nonsmooth.limits {
            let position = &mut zero.position[limit.coordinate.position];
            *position = position.max(limit.lower).min(limit.upper);
        }
        let bodies = body_states(&self.mechanism, &zero);
        (violation(&self.mechanism, &zero, &bodies).position < CLOSED).then_some(bodies)
    }

    /// The links of a pair.
    fn names(&self, pair: &ContactPair) -> [&str; 2] {
        [pair.a, pair.b].map(|of| self.mechanism.nonsmooth.colliders[of].name.as_str())
    }

    /// Whether the shapes of a pair overlap where the bodies are; the balls about colliders are kept.
    fn overlaps(&self, pair: &ContactPair, known: &mut [Option<Ball>], bodies: &[BodyState]) -> bool {
        let colliders = [pair.a, pair.b].map(|of| &self.mechanism.nonsmooth.colliders[of]);
        let balls = [pair.a, pair.b].map(|of| {
            let collider = &self.mechanism.nonsmooth.colliders[of];
            let ball = *known[of].get_or_insert_with(|| ball_about(collider));
            let body = collider.body.map_or(&WORLD, |body| &bodies[body]);
            (body.position + body.rotation * ball.center, ball.radius)
        });
        if (balls[0].0 - balls[1].0).norm() > balls[0].1 + balls[1].1 {
            return false;
        }
        let Ok(geometry) = PairGeometry::new(colliders[0], colliders[1]) else { return false };
        let [a, b] = colliders.map(|collider| pose(collider.body.map_or(&WORLD, |body| &bodies[body])));
        geometry.distance(&a, &b).distance < -TOUCHES * balls[0].1.min(balls[1].1)
    }
}

/// The pose of a body.
fn pose(body: &BodyState) -> Pose {
    Pose::from_parts(Translation3::from(body.position), Rotation3::from_matrix_unchecked(body.rotation))
}
