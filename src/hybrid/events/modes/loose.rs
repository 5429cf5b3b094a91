//! The islands that no closure holds in a mode, and the bodies that fly by themselves.
//!
//! ```text
//!     H dq = Jᵀ μ,   J = 0 on an island without closures      ─▶ dq = 0: interpolated states are on all closures as they are
//! ```
//!
//! Bodies belong to one island if joints, loops, mimic relations, springs or ropes tie them ([`first_of_tied`]). A closed contact holds the islands
//! of both of its bodies. What happens to the bodies of other islands does not touch a body that flies by itself before and after: whatever was known
//! of its pairs is still known.

use crate::instant::holding::held::Closures;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::structure::islands::first_of_tied;

/// What no closure holds, in the present mode and in the one before.
#[derive(Clone, Debug)]
pub(crate) struct Loose {
    /// The first body of the island of each body.
    firsts: Vec<usize>,
    /// For the first body of each island: whether closures hold it in every mode, in this one, and in the one before.
    always: Vec<bool>,
    now: Vec<bool>,
    before: Vec<bool>,
    /// Whether each body is an island.
    alone: Vec<bool>,
}

impl Loose {
    /// For a mechanism, before its first mode.
    pub fn new(mechanism: &Mechanism) -> Self {
        let firsts = first_of_tied(mechanism);
        let mut counts = vec![0; firsts.len()];
        firsts.iter().for_each(|&first| counts[first] += 1);
        let mut always = vec![false; firsts.len()];
        let ends = mechanism.closing_ends().flatten().filter_map(|end| end.body);
        let ropes = mechanism.touches.iter().flat_map(|joint| &joint.reeved).filter_map(|point| point.body);
        let mimics = mechanism.mimics.iter().map(|mimic| mimic.follower.body);
        ends.chain(ropes).chain(mimics).for_each(|body| always[firsts[body]] = true);
        Loose {
            alone: firsts.iter().map(|&first| counts[first] == 1).collect(),
            now: vec![true; firsts.len()],
            before: vec![true; firsts.len()],
            firsts,
            always,
        }
    }

    /// Takes the closed contacts of the mode that follows.
    pub fn take(&mut self, closures: &Closures) {
        let Loose { firsts, always, now, before, .. } = self;
        std::mem::swap(now, before);
        now.copy_from_slice(always);
        let anchors = closures.anchors.iter().flat_map(|joint| [&joint.a, &joint.b]);
        let touches = closures.touches.iter().flat_map(|joint| [&joint.a, &joint.b].into_iter().chain(&joint.reeved));
        anchors.chain(touches).filter_map(|end| end.body).for_each(|body| now[firsts[body]] = true);
    }

    /// Whether no closure holds the islands of these bodies in the mode; the world is none.
    pub fn are_loose(&self, bodies: impl IntoIterator<Item = Option<usize>>) -> bool {
        bodies.into_iter().flatten().all(|body| !self.now[self.firsts[body]])
    }

    /// Whether these bodies fly by themselves, in the mode and in the one before.
    pub fn still_fly(&self, bodies: impl IntoIterator<Item = Option<usize>>) -> bool {
        bodies.into_iter().flatten().all(|body| self.alone[body] && !self.now[body] && !self.before[body])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanism::description::closure::{Attachment, LoopJoint, LoopKind};
    use crate::mechanism::description::joint::{Joint, JointKind, Pose};
    use crate::mechanism::description::mechanism::Body;
    use nalgebra::Vector3;

    /// Two bodies that fly, and a rod on another one.
    fn bodies() -> Mechanism {
        let bodies = [None, None, None, Some(2)].iter().enumerate().map(|(index, &parent)| {
            let kind = if parent.is_some() { JointKind::Revolute } else { JointKind::Floating };
            let joint = Joint::new(&format!("joint {index}"), kind, Pose::identity(), Pose::identity());
            let inertia = Vector3::new(0.05, 0.06, 0.07);
            Body { name: format!("body {index}"), parent, mass: 1.0, inertia, joint }
        });
        Mechanism::new("bodies", Vector3::new(0.0, 0.0, -9.81), bodies.collect()).expect("a mechanism")
    }

    fn anchored(body: usize) -> Closures {
        let on = |body| Attachment { body, frame: Pose::identity() };
        let joint = LoopJoint { name: "contact".into(), kind: LoopKind::Spherical, a: on(None), b: on(Some(body)) };
        Closures { touches: Vec::new(), anchors: vec![joint] }
    }

    #[test]
    fn a_closed_contact_holds_the_island_of_its_body_and_no_other() {
        let mut loose = Loose::new(&bodies());
        loose.take(&anchored(3));
        assert!(loose.are_loose([Some(0), Some(1)]) && loose.are_loose([Some(0), None]));
        assert!(!loose.are_loose([Some(2), None]) && !loose.are_loose([Some(0), Some(3)]));
    }

    #[test]
    fn a_body_still_flies_if_it_is_alone_and_no_contact_was_closed_before_or_is_now() {
        let mut loose = Loose::new(&bodies());
        // Nothing is known of a mode before the first.
        loose.take(&Closures::default());
        assert!(!loose.still_fly([Some(0), None]));
        loose.take(&anchored(1));
        assert!(loose.still_fly([Some(0), None]) && !loose.still_fly([Some(0), Some(1)]));
        loose.take(&Closures::default());
        assert!(loose.still_fly([Some(0), None]) && !loose.still_fly([Some(1), None]));
        loose.take(&Closures::default());
        assert!(loose.still_fly([Some(0), Some(1)]) && !loose.still_fly([Some(3), Some(2)]));
    }
}
