//! The nonsmooth elements of a mechanism, joint by joint: all of it constant.

use crate::mechanism::description::closure::Coordinate;
use crate::mechanism::description::mechanism::Mechanism;
use crate::mechanism::description::nonsmooth::Motor;
use crate::mechanism::motion::event::Side;
use crate::mechanism::motion::state::State;

/// A joint of one freedom with limits or dry friction.
#[derive(Clone, Debug)]
pub(crate) struct ElementJoint {
    /// Its coordinate.
    pub coordinate: Coordinate,
    /// Smallest and largest position (rad or m); infinite where there is none.
    pub lower: f64,
    pub upper: f64,
    /// e: the part of the rate that an impact gives back.
    pub restitution: f64,
    /// Dry friction [N m or N]; zero for none.
    pub friction: f64,
}

/// All elements of a mechanism.
#[derive(Clone, Debug, Default)]
pub(crate) struct Elements {
    pub joints: Vec<ElementJoint>,
    pub motors: Vec<Motor>,
}

/// A position this close to its limit is on it (rad or m, times the size of the limit where that is larger than one).
pub(crate) const AT_LIMIT: f64 = 1e-14;

impl Elements {
    /// Those of a mechanism, in the order of its bodies. Several limits of one joint are their intersection, several frictions their sum.
    pub fn new(mechanism: &Mechanism) -> Self {
        let nonsmooth = &mechanism.nonsmooth;
        let mut joints: Vec<ElementJoint> = Vec::new();
        let coordinates = nonsmooth.limits.iter().map(|limit| limit.coordinate);
        let mut coordinates: Vec<Coordinate> =
            coordinates.chain(nonsmooth.friction.iter().map(|friction| friction.coordinate)).collect();
        coordinates.sort_by_key(|coordinate| coordinate.freedom);
        coordinates.dedup();
        for coordinate in coordinates {
            let mut joint = ElementJoint {
                coordinate,
                lower: f64::NEG_INFINITY,
                upper: f64::INFINITY,
                restitution: 0.0,
                friction: 0.0,
            };
            for limit in nonsmooth.limits.iter().filter(|limit| limit.coordinate == coordinate) {
                joint.lower = joint.lower.max(limit.lower);
                joint.upper = joint.upper.min(limit.upper);
                joint.restitution = limit.restitution;
            }
            let friction = nonsmooth.friction.iter().filter(|friction| friction.coordinate == coordinate);
            joint.friction = friction.map(|friction| friction.effort).sum();
            joints.push(joint);
        }
        Elements { joints, motors: nonsmooth.motors.clone() }
    }
}

impl ElementJoint {
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

    /// What counts as being on a bound (rad or m).
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

    /// The efforts that can hold it at rest, on this limit or on none: λ from … to [N m or N].
    pub fn holding(&self, on: Option<Side>) -> (f64, f64) {
        match on {
            _ if self.is_locked() => (f64::NEG_INFINITY, f64::INFINITY),
            Some(Side::Lower) => (-self.friction, f64::INFINITY),
            Some(Side::Upper) => (f64::NEG_INFINITY, self.friction),
            None => (-self.friction, self.friction),
        }
    }

    /// Whether its bounds leave no room.
    pub fn is_locked(&self) -> bool {
        self.lower >= self.upper
    }
}

/// The direction into the allowed range: 1 from the lower bound, −1 from the upper.
pub(crate) fn inward(side: Side) -> f64 {
    match side {
        Side::Lower => 1.0,
        Side::Upper => -1.0,
    }
}
