//! The islands of a mechanism: which of them rest in equilibrium, and which small ones are integrated together.
//!
//! Each step has a fixed cost, which small islands share if they are integrated together. Islands in parallel planes are grouped among themselves,
//! because planar steps are cheaper than spatial ones.

use crate::instant::exerting::rest::is_at_rest_counted;
use crate::lobatto::coupled::counted::Counted;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::rules::Rule;
use crate::mechanism::motion::state::State;
use crate::mechanism::structure::islands::{Island, islands};
use crate::mechanism::structure::plane::Plane;
use std::sync::Arc;

/// The islands of a mechanism after grouping.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The islands, and whether each sleeps.
    pub islands: Vec<(Island, bool)>,
    /// The disabled rules.
    pub kept: Vec<Rule>,
}

impl Plan {
    /// Applies the rules that are not disabled.
    pub fn new(mechanism: &Mechanism, state: &State, switched_off: &[Rule]) -> Self {
        Self::from_counted(mechanism, state, switched_off, None)
    }

    /// The same with ranks of the closures that were computed before.
    pub fn from_counted(
        mechanism: &Mechanism,
        state: &State,
        switched_off: &[Rule],
        counted: Option<&Arc<Counted>>,
    ) -> Self {
        let all =
            if switched_off.contains(&Rule::Islands) { vec![Island::whole(mechanism)] } else { islands(mechanism) };
        Self::of(all, state, switched_off, counted)
    }

    /// These islands of a mechanism.
    pub(crate) fn of(all: Vec<Island>, state: &State, switched_off: &[Rule], counted: Option<&Arc<Counted>>) -> Self {
        let of_all = counted.filter(|_| all.len() == 1);
        let with_sleep = |island: Island| {
            let asleep = rests(&island.mechanism, &island.state(state), switched_off, of_all);
            (island, asleep)
        };
        Plan { islands: all.into_iter().map(with_sleep).collect(), kept: switched_off.to_vec() }
    }

    /// Groups awake islands with fewer than `smallest` bodies until each group has as many, so that they share the fixed cost of a step. The rest
    /// joins the last group. Islands in parallel planes are grouped among themselves, and so are trees and closed loops, if they have enough
    /// bodies.
    pub fn grouped(self, mechanism: &Mechanism, smallest: usize) -> Self {
        let is_small = |mechanism: &Mechanism| mechanism.bodies.len() < smallest && mechanism.nonsmooth.is_empty();
        let (small, mut parts): (Vec<_>, Vec<_>) =
            self.islands.into_iter().partition(|(island, asleep)| !asleep && is_small(&island.mechanism));
        let small = small.into_iter().map(|(island, _)| island).collect();
        for class in alike(small, smallest, &self.kept) {
            parts.extend(groups(class, smallest).into_iter().map(|group| match <[Island; 1]>::try_from(group) {
                Ok([alone]) => (alone, false),
                Err(group) => (Island::together(mechanism, &group), false),
            }));
        }
        parts.sort_by_key(|(island, _)| island.pieces.first().map(|piece| piece.bodies.start));
        Plan { islands: parts, kept: self.kept }
    }

    /// The islands that move, each in a plane of its own.
    pub fn planar(&self) -> impl Iterator<Item = &Island> {
        self.awake().filter(|island| Plane::of(&island.mechanism).is_some())
    }

    /// The awake islands in space, and the planar ones if the rule of planes is switched off by `kept`.
    pub fn spatial(&self, kept: &[Rule]) -> impl Iterator<Item = &Island> {
        let planes = !kept.contains(&Rule::Planar);
        self.awake().filter(move |island| !planes || Plane::of(&island.mechanism).is_none())
    }

    fn awake(&self) -> impl Iterator<Item = &Island> {
        self.islands.iter().filter(|(_, asleep)| !asleep).map(|(island, _)| island)
    }

    /// Whether no rule applies: there is one island, and it is awake.
    pub fn is_whole(&self) -> bool {
        self.islands.len() < 2 && self.sleeping() == 0
    }

    /// How many islands sleep.
    pub fn sleeping(&self) -> usize {
        self.islands.iter().filter(|(_, asleep)| *asleep).count()
    }
}

/// Whether an island is at rest in equilibrium, and need not be simulated.
pub(super) fn rests(
    mechanism: &Mechanism,
    state: &State,
    switched_off: &[Rule],
    counted: Option<&Arc<Counted>>,
) -> bool {
    // The efforts of motors can change, and are not among the forces that decide on equilibrium.
    let driven = !mechanism.nonsmooth.motors.is_empty();
    !switched_off.contains(&Rule::Sleep) && !driven && is_at_rest_counted(mechanism, state, counted.cloned())
}

/// Islands that are grouped only with each other: islands in parallel planes, and trees apart from closed loops (whose steps cost more), if they have
/// `smallest` bodies; and all others.
fn alike(islands: Vec<Island>, smallest: usize, kept: &[Rule]) -> Vec<Vec<Island>> {
    if kept.contains(&Rule::Planar) {
        return vec![islands];
    }
    let mut planes: Vec<(Plane, bool, usize)> = Vec::new();
    let plane_of: Vec<Option<usize>> = islands
        .iter()
        .map(|Island { mechanism, .. }| {
            let (plane, closed) = (Plane::of(mechanism)?, mechanism.has_closures());
            let same = |(other, loops, _): &(Plane, bool, usize)| other.is_parallel(&plane) && *loops == closed;
            let number = planes.iter().position(same).unwrap_or_else(|| {
                planes.push((plane, closed, 0));
                planes.len() - 1
            });
            planes[number].2 += mechanism.bodies.len();
            Some(number)
        })
        .collect();
    let mut classes: Vec<Vec<Island>> = vec![Vec::new(); planes.len() + 1];
    for (island, plane) in islands.into_iter().zip(plane_of) {
        let enough = plane.filter(|&number| planes[number].2 >= smallest);
        classes[enough.map_or(0, |number| number + 1)].push(island);
    }
    classes
}

/// Groups of islands with no fewer bodies than `smallest` each, if there are as many.
fn groups(islands: Vec<Island>, smallest: usize) -> Vec<Vec<Island>> {
    let mut groups: Vec<Vec<Island>> = Vec::new();
    let mut bodies = smallest;
    for island in islands {
        if bodies >= smallest {
            groups.push(Vec::new());
            bodies = 0;
        }
        bodies += island.mechanism.bodies.len();
        if let Some(group) = groups.last_mut() {
            group.push(island);
        }
    }
    if bodies < smallest
        && groups.len() > 1
        && let (Some(rest), Some(last)) = (groups.pop(), groups.last_mut())
    {
        last.extend(rest);
    }
    groups
}
