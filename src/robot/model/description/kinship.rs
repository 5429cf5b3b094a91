//! Links that never touch because of the joints between them: of one robot, and of two that a loop joint joins.
//!
//! Bodies that locked joints hold together are one group. Two links are neighbours if one joint joins their groups, perhaps with links without mass
//! in between: a joint of the tree, or a loop joint other than a rod of given length. Shapes of neighbours overlap at their joint by design.

use crate::mechanism::description::closure::LoopKind;
use crate::mechanism::description::mechanism::Mechanism;
use crate::model::description::never_touch::NeverTouch;

/// The joints of a mechanism, as far as contact of one robot with itself depends on them.
pub(crate) struct Kinship<'m> {
    mechanism: &'m Mechanism,
    /// For each body the first body that it does not move against: by locked joints.
    head: Vec<Option<usize>>,
}

impl<'m> Kinship<'m> {
    /// Of a mechanism, with its limits.
    pub fn new(mechanism: &'m Mechanism) -> Self {
        let limits = &mechanism.nonsmooth.limits;
        let locked =
            |body: usize| limits.iter().any(|limit| limit.coordinate.body == body && limit.lower == limit.upper);
        let mut head: Vec<Option<usize>> = Vec::with_capacity(mechanism.bodies.len());
        for (index, body) in mechanism.bodies.iter().enumerate() {
            let above = body.parent.and_then(|parent| head[parent]);
            head.push(if locked(index) { above } else { Some(index) });
        }
        Kinship { mechanism, head }
    }

    /// Why links on these bodies never touch, if joints are the reason.
    pub fn reason(&self, ends: [Option<usize>; 2]) -> Option<NeverTouch> {
        let itself = |body: usize| Some(body);
        if ends[0] == ends[1] {
            return Some(NeverTouch::OneBody);
        }
        if self.are_neighbours(ends, &itself) {
            return Some(NeverTouch::Neighbours);
        }
        let of_group = |body: usize| self.head[body];
        let heads = ends.map(|body| body.and_then(of_group));
        (heads[0] == heads[1] || self.are_neighbours(heads, &of_group)).then_some(NeverTouch::Locked)
    }

    /// The groups of bodies, by their first ones, that loop joints join to the group of a body; rods of given length join none, and neither does the
    /// world.
    pub fn joined_by_loops(&self, body: usize) -> Vec<usize> {
        let Some(own) = self.head[body] else { return Vec::new() };
        let of_groups = self.joining().filter_map(|[a, b]| Some([self.head[a?]?, self.head[b?]?]));
        let others = of_groups.filter_map(|[a, b]| (a == own).then_some(b).or((b == own).then_some(a)));
        others.collect()
    }

    /// Whether a body belongs to one of these groups.
    pub fn is_of(&self, groups: &[usize], body: usize) -> bool {
        self.head[body].is_some_and(|head| groups.contains(&head))
    }

    /// The bodies of the loop joints other than rods of given length.
    fn joining(&self) -> impl Iterator<Item = [Option<usize>; 2]> {
        let joints = self.mechanism.loops.iter().filter(|joint| !matches!(joint.kind, LoopKind::Distance(_)));
        joints.map(|joint| [joint.a.body, joint.b.body])
    }

    /// Whether one joint joins two groups; `group` is the first body of a group, `None` the world.
    fn are_neighbours(&self, [a, b]: [Option<usize>; 2], group: &dyn Fn(usize) -> Option<usize>) -> bool {
        let above = |body: usize| self.mechanism.bodies[body].parent.and_then(group);
        let is_below = |below: Option<usize>, other: Option<usize>| {
            let Some(mut here) = below else { return false };
            loop {
                match above(here) {
                    parent if parent == other => return true,
                    Some(parent) if self.mechanism.bodies[parent].mass == 0.0 => here = parent,
                    _ => return false,
                }
            }
        };
        let of_loop = || {
            self.joining().any(|ends| {
                let ends = ends.map(|body| body.and_then(group));
                ends == [a, b] || ends == [b, a]
            })
        };
        is_below(a, b) || is_below(b, a) || of_loop()
    }
}
