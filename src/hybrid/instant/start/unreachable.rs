//! Limits that can never be reached and friction that never matters, where that can be proved at little cost.
//!
//! Each of three arguments is sound by itself. A limit or friction to which they do not apply is kept:
//!
//! 1. A mimic relation `q_f = k q_l + c` maps the range of one joint onto the other. A limit beyond the range that all other limits imply is never
//!    reached.
//! 2. An island of one freedom without motors and loads never has more energy than it starts with. A limit at which its potential energy would be
//!    larger is never reached.
//! 3. A joint whose range is one point never moves, so its friction never matters.

use crate::mechanism::description::closure::JointLimit;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::motion::energy::energy_with_forces;
use crate::mechanism::motion::kinematics::body_states;
use crate::mechanism::motion::state::State;
use crate::mechanism::structure::islands::islands;

/// Mimic relations of which ranges are still worked out.
const MOST_RELATIONS: usize = 300;
/// Part of a bound or an energy by which it must be missed.
const MARGIN: f64 = 1e-9;

/// Why the ends of a limit are never reached, where that is proved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NeverReached {
    /// The lower one.
    pub lower: Option<&'static str>,
    /// The upper one.
    pub upper: Option<&'static str>,
}

const RELATION: &str = "a mimic relation and the limits of other joints stop it before";
const ENERGY: &str = "the energy of the start does not suffice";

/// Which simulated limits a motion from a state never reaches, in their order.
pub fn never_reached(mechanism: &Mechanism, start: &State) -> Vec<NeverReached> {
    let limits = &mechanism.nonsmooth.limits;
    let mut never = vec![NeverReached::default(); limits.len()];
    for (number, limit) in limits.iter().enumerate() {
        let freedom = limit.coordinate.freedom;
        let in_relation = mechanism
            .mimics
            .iter()
            .any(|mimic| !mimic.is_moved() && [mimic.leader.freedom, mimic.follower.freedom].contains(&freedom));
        if in_relation && mechanism.mimics.len() <= MOST_RELATIONS {
            let (low, high) = ranges(mechanism, Some(number))[freedom];
            let margin = |bound: f64| MARGIN * (1.0 + bound.abs());
            never[number].lower = (low > limit.lower + margin(limit.lower)).then_some(RELATION);
            never[number].upper = (high < limit.upper - margin(limit.upper)).then_some(RELATION);
        }
    }
    for island in islands(mechanism) {
        let part = &island.mechanism;
        let driven = !part.nonsmooth.motors.is_empty()
            || !part.forces.joint_loads.is_empty()
            || !part.forces.wrenches.is_empty()
            || !part.forces.link_loads.is_empty()
            || !part.forces.joint_courses.is_empty()
            || !part.forces.gravity_compensations.is_empty()
            || part.has_closures();
        if part.velocity_count != 1 || driven {
            continue;
        }
        let body = island.body_of_whole(0);
        let energy = |state: &State| energy_with_forces(part, &state.position, &body_states(part, state));
        let own = island.state(start);
        let first = energy(&own);
        let too_high = |position: f64| {
            let mut there = own.clone();
            there.velocity.fill(0.0);
            there.position[0] = position;
            let then = energy(&there);
            let size = first.kinetic.abs() + first.spring.abs() + then.spring.abs();
            let size = size + first.potential.abs() + then.potential.abs();
            position.is_finite() && then.total() > first.total() + MARGIN * size
        };
        for (number, limit) in limits.iter().enumerate().filter(|(_, limit)| limit.coordinate.body == body) {
            let JointLimit { lower, upper, .. } = *limit;
            never[number].lower = never[number].lower.or(too_high(lower).then_some(ENERGY));
            never[number].upper = never[number].upper.or(too_high(upper).then_some(ENERGY));
        }
    }
    never
}

/// Which dry friction never matters because its joint cannot move, in their order.
pub fn never_slides(mechanism: &Mechanism) -> Vec<bool> {
    let ranges = if mechanism.mimics.len() <= MOST_RELATIONS { ranges(mechanism, None) } else { Vec::new() };
    let still = |freedom: usize| ranges.get(freedom).is_some_and(|(low, high)| low >= high);
    mechanism.nonsmooth.friction.iter().map(|friction| still(friction.coordinate.freedom)).collect()
}

/// The ranges [rad or m] of all freedoms that limits and mimic relations imply, without one of the limits.
fn ranges(mechanism: &Mechanism, without: Option<usize>) -> Vec<(f64, f64)> {
    let mut ranges = vec![(f64::NEG_INFINITY, f64::INFINITY); mechanism.velocity_count];
    let limits = mechanism.nonsmooth.limits.iter().enumerate().filter(|(number, _)| Some(*number) != without);
    for (_, limit) in limits {
        narrow(&mut ranges[limit.coordinate.freedom], (limit.lower, limit.upper));
    }
    // A range travels along one relation in each pass at least.
    for _ in 0..=mechanism.mimics.len() {
        let before = ranges.clone();
        for mimic in mechanism.mimics.iter().filter(|mimic| mimic.more.is_empty() && !mimic.is_moved()) {
            let (leader, follower) = (mimic.leader.freedom, mimic.follower.freedom);
            let (factor, offset) = (mimic.multiplier, mimic.offset);
            if factor == 0.0 {
                narrow(&mut ranges[follower], (offset, offset));
                continue;
            }
            let (low, high) = ranges[leader];
            let ends = (factor * low + offset, factor * high + offset);
            narrow(&mut ranges[follower], (ends.0.min(ends.1), ends.0.max(ends.1)));
            let (low, high) = ranges[follower];
            let ends = ((low - offset) / factor, (high - offset) / factor);
            narrow(&mut ranges[leader], (ends.0.min(ends.1), ends.0.max(ends.1)));
        }
        if ranges == before {
            break;
        }
    }
    ranges
}

fn narrow(range: &mut (f64, f64), by: (f64, f64)) {
    *range = (range.0.max(by.0), range.1.min(by.1));
}
