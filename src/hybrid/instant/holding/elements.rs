//! The nonsmooth elements of a mechanism (limits, dry friction, motors), joint by joint. They do not change during a run.
//!
//! Joints that mimic others have no freedom of their own: with `q_f = m q_l + b` a limit or friction of the follower is one of the leader,
//!
//! ```text
//!     lower ≤ q_f ≤ upper   ⇔   (lower − b)/m ≤ q_l ≤ (upper − b)/m   (m > 0; exchanged for m < 0),       τ_l = |m| τ_f
//! ```
//!
//! so that a gripper whose fingers all reach their ends is held once, and not twice.

use crate::mechanism::description::closure::Coordinate;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::motion::event::{FrictionState, JointStatus, Side};
use crate::mechanism::motion::state::State;

/// A joint of one freedom with limits or dry friction, its own or of joints that follow it.
#[derive(Clone, Debug)]
pub struct ElementJoint {
    /// Its coordinate.
    pub coordinate: Coordinate,
    /// Smallest and largest position (rad or m); infinite without a limit.
    pub lower: f64,
    pub upper: f64,
    /// e: the part of the rate that an impact gives back.
    pub restitution: f64,
    /// Dry friction [N m or N]; zero without friction.
    pub friction: f64,
    /// The bodies whose joints have these limits: it, or one that follows it.
    owners: [usize; 2],
    /// All joints that move with it, itself first.
    pub members: Vec<Member>,
}

/// A joint that moves with another.
#[derive(Clone, Copy, Debug)]
pub struct Member {
    pub coordinate: Coordinate,
    /// m and b.
    pub factor: f64,
    pub offset: f64,
    /// Whether it has friction itself.
    pub rubs: bool,
}

/// All elements of a mechanism.
#[derive(Clone, Debug, Default)]
pub struct Elements {
    pub joints: Vec<ElementJoint>,
    pub motors: Vec<Motor>,
}

/// A position this close to its limit is on it (rad or m, times the size of the limit where that is larger than one).
pub(crate) const AT_LIMIT: f64 = 1e-14;

impl Elements {
    /// The elements of a mechanism, in the order of its bodies. Several limits of one joint are their intersection, several frictions their sum.
    pub fn new(mechanism: &Mechanism) -> Self {
        let nonsmooth = &mechanism.nonsmooth;
        let coordinates = nonsmooth.limits.iter().map(|limit| limit.coordinate);
        let coordinates = coordinates.chain(nonsmooth.friction.iter().map(|friction| friction.coordinate));
        let mut leaders: Vec<Coordinate> = coordinates.map(|own| leader(mechanism, own).0).collect();
        leaders.sort_by_key(|coordinate| coordinate.freedom);
        leaders.dedup();
        let mut joints: Vec<ElementJoint> = leaders.into_iter().map(|own| ElementJoint::new(mechanism, own)).collect();
        for limit in &nonsmooth.limits {
            let (own, factor, offset) = leader(mechanism, limit.coordinate);
            let Some(joint) = joints.iter_mut().find(|joint| joint.coordinate == own) else { continue };
            let ends = [limit.lower, limit.upper].map(|end| (end - offset) / factor);
            joint.narrow(
                if factor > 0.0 { ends } else { [ends[1], ends[0]] },
                limit.coordinate.body,
                limit.restitution,
            );
        }
        for friction in &nonsmooth.friction {
            let (own, factor, _) = leader(mechanism, friction.coordinate);
            let Some(joint) = joints.iter_mut().find(|joint| joint.coordinate == own) else { continue };
            joint.friction += factor.abs() * friction.effort;
            for member in joint.members.iter_mut().filter(|member| member.coordinate == friction.coordinate) {
                member.rubs = true;
            }
        }
        Elements { joints, motors: nonsmooth.motors.clone() }
    }
}

/// The coordinate that leads another in the end, and how: `q = m q_l + b`. A chain that leads round in a circle leads nowhere.
fn leader(mechanism: &Mechanism, of: Coordinate) -> (Coordinate, f64, f64) {
    let (mut own, mut factor, mut offset) = (of, 1.0, 0.0);
    for _ in 0..mechanism.mimics.len() {
        let Some(mimic) = mechanism.mimics.iter().find(|mimic| mimic.follower == own && mimic.more.is_empty()) else {
            break;
        };
        offset += factor * mimic.offset;
        factor *= mimic.multiplier;
        own = mimic.leader;
    }
    if factor == 0.0 || !factor.is_finite() { (of, 1.0, 0.0) } else { (own, factor, offset) }
}

impl ElementJoint {
    fn new(mechanism: &Mechanism, coordinate: Coordinate) -> Self {
        let itself = Member { coordinate, factor: 1.0, offset: 0.0, rubs: false };
        let pairs = mechanism.mimics.iter().filter(|mimic| mimic.more.is_empty());
        let followers = pairs.filter_map(|mimic| {
            let (own, factor, offset) = leader(mechanism, mimic.follower);
            (own == coordinate).then_some(Member { coordinate: mimic.follower, factor, offset, rubs: false })
        });
        ElementJoint {
            coordinate,
            lower: f64::NEG_INFINITY,
            upper: f64::INFINITY,
            restitution: 0.0,
            friction: 0.0,
            owners: [coordinate.body; 2],
            members: std::iter::once(itself).chain(followers).collect(),
        }
    }

    /// Takes over one more limit, of the joint of a body.
    fn narrow(&mut self, [lower, upper]: [f64; 2], body: usize, restitution: f64) {
        if lower > self.lower {
            (self.lower, self.owners[0], self.restitution) = (lower, body, restitution);
        }
        if upper < self.upper {
            (self.upper, self.owners[1], self.restitution) = (upper, body, restitution);
        }
    }

    /// The body whose joint has a bound.
    pub fn owner(&self, side: Side) -> usize {
        self.owners[usize::from(side == Side::Upper)]
    }

    /// Puts it on a bound, and what follows it.
    pub fn put_on(&self, side: Side, state: &mut State) {
        let position = self.bound(side);
        for member in &self.members {
            let slot = member.coordinate.position;
            state.position[slot] = member.factor * position + member.offset;
            state.compensation[slot] = 0.0;
        }
    }

    /// Its position, with what rounding left out.
    pub fn position(&self, state: &State) -> f64 {
        state.position[self.coordinate.position] + state.compensation[self.coordinate.position]
    }

    /// Its rate.
    pub fn rate(&self, state: &State) -> f64 {
        state.velocity[self.coordinate.freedom]
    }

    /// The position of a bound.
    pub fn bound(&self, side: Side) -> f64 {
        match side {
            Side::Lower => self.lower,
            Side::Upper => self.upper,
        }
    }

    /// Distance to a bound, positive inside (rad or m).
    pub fn gap(&self, side: Side, position: f64) -> f64 {
        match side {
            Side::Lower => position - self.lower,
            Side::Upper => self.upper - position,
        }
    }

    /// The distance that counts as being on a bound (rad or m).
    pub fn at_limit(&self, side: Side) -> f64 {
        AT_LIMIT * self.bound(side).abs().max(1.0)
    }

    /// The bound that a position is on, if it is.
    pub fn side(&self, position: f64) -> Option<Side> {
        self.sides().find(|&side| self.gap(side, position) <= self.at_limit(side))
    }

    /// The bounds that it has.
    pub fn sides(&self) -> impl Iterator<Item = Side> + use<> {
        let finite = [(Side::Lower, self.lower.is_finite()), (Side::Upper, self.upper.is_finite())];
        finite.into_iter().filter(|(_, finite)| *finite).map(|(side, _)| side)
    }

    /// The efforts that can hold it at rest, on this limit or without a limit: λ from … to [N m or N].
    pub fn holding(&self, on: Option<Side>) -> (f64, f64) {
        match on {
            _ if self.is_locked() => (f64::NEG_INFINITY, f64::INFINITY),
            Some(Side::Lower) => (-self.friction, f64::INFINITY),
            Some(Side::Upper) => (f64::NEG_INFINITY, self.friction),
            None => (-self.friction, self.friction),
        }
    }

    /// The status of the joint of a body that moves with this one, which is held (on a limit or not) or not.
    pub fn status(&self, body: usize, held: Option<Option<Side>>) -> Option<JointStatus> {
        let member = self.members.iter().find(|member| member.coordinate.body == body)?;
        let own = |side: Side| if (member.factor > 0.0) == (side == Side::Lower) { Side::Lower } else { Side::Upper };
        let friction = if held.is_some() { FrictionState::Stuck } else { FrictionState::Sliding };
        Some(JointStatus {
            limit: held.flatten().filter(|&side| self.owner(side) == body).map(own),
            friction: member.rubs.then_some(friction),
            effort: None,
        })
    }

    /// Whether its bounds leave no room.
    pub fn is_locked(&self) -> bool {
        self.lower >= self.upper || self.leaves_one_position()
    }

    /// Whether its bounds are one position, but for rounding.
    pub fn leaves_one_position(&self) -> bool {
        self.lower.is_finite() && (self.upper - self.lower).abs() <= self.at_limit(Side::Lower)
    }
}

/// The direction into the allowed range: 1 from the lower bound, −1 from the upper.
pub fn inward(side: Side) -> f64 {
    match side {
        Side::Lower => 1.0,
        Side::Upper => -1.0,
    }
}
