//! The rules that simplify the model of a run, and the names by which `--keep` disables them.
//!
//! A run without a rule is the full model, against which the rule is tested. The rules of `model::ReductionRule`, by which links are no bodies of
//! their own, cannot be disabled: a joint without free motion is not a joint of a mechanism.

use std::str::FromStr;

/// A rule that can be switched off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// A round shape that all but turns about its axis, the axis of its joint, turns about it exactly.
    Wheels,
    /// Unconnected parts of the mechanism are simulated apart.
    Islands,
    /// An island at rest in equilibrium is not simulated.
    Sleep,
    /// A joint whose limits, with those of the joints that follow it, leave one position is simulated as a fixed joint.
    Locked,
    /// Steps are made on the spanning tree with the least work, whichever joints the file closes loops with.
    Tree,
    /// Mechanisms that move in a plane are simulated with three coordinates a body.
    Planar,
    /// A body that never turns has no rotation.
    Translation,
    /// A body whose mass is at a point has no rotational inertia.
    Points,
    /// A body with the same inertia about all axes has one moment of inertia.
    Spheres,
    /// A body on a hinge that the world holds has one equation.
    Pivots,
    /// A body that floats freely has only the equations of its rotation.
    Tumblers,
    /// Steps go over many impacts at once where single ones cost more than their instants are worth.
    Crowds,
}

/// There is no such rule.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no rule {0:?} that can be switched off; there are {list}", list = Rule::ALL.map(Rule::name).join(", "))]
pub struct UnknownRule(pub String);

impl Rule {
    /// All of them, in the order in which they are tried.
    pub const ALL: [Rule; 12] = [
        Rule::Wheels,
        Rule::Islands,
        Rule::Sleep,
        Rule::Locked,
        Rule::Tree,
        Rule::Planar,
        Rule::Translation,
        Rule::Points,
        Rule::Spheres,
        Rule::Pivots,
        Rule::Tumblers,
        Rule::Crowds,
    ];

    /// The name, for the command line.
    pub fn name(self) -> &'static str {
        match self {
            Rule::Wheels => "wheels",
            Rule::Islands => "islands",
            Rule::Sleep => "sleep",
            Rule::Locked => "locked",
            Rule::Tree => "tree",
            Rule::Planar => "planar",
            Rule::Translation => "translation",
            Rule::Points => "points",
            Rule::Spheres => "spheres",
            Rule::Pivots => "pivots",
            Rule::Tumblers => "tumblers",
            Rule::Crowds => "crowds",
        }
    }

    /// When it applies, for people.
    pub fn condition(self) -> &'static str {
        match self {
            Rule::Wheels => "shape of revolution on a hinge, its axis within 1e-3 rad of the hinge's",
            Rule::Islands => "no joint, loop, mimic relation or spring connects the parts",
            Rule::Sleep => "starts at rest, and all accelerations are zero",
            Rule::Locked => "limits of the joint and of those that follow it leave one position",
            Rule::Tree => "loops, and cutting them at other joints is less work",
            Rule::Planar => "all hinges about one direction, all slides across it, loops too",
            Rule::Translation => "in space, only slides between body and world",
            Rule::Points => "in space, no inertia about the center of mass",
            Rule::Spheres => "in space, under gravity alone, the same inertia about all axes",
            Rule::Pivots => "in space, under gravity alone, on a hinge that the world holds",
            Rule::Tumblers => "in space, under gravity alone, a body that floats and carries no other body",
            Rule::Crowds => "shapes may touch, and their events follow each other faster than steps",
        }
    }

    /// The saved work, for people.
    pub fn saving(self) -> &'static str {
        match self {
            Rule::Wheels => "turned onto the axis: no wobble",
            Rule::Islands => "each with its own steps, on several cores, small ones together",
            Rule::Sleep => "not simulated",
            Rule::Locked => "simulated as fixed",
            Rule::Tree => "fewer equations over each body",
            Rule::Planar => "three coordinates each instead of six",
            Rule::Translation => "three equations each instead of six",
            Rule::Points => "no angular momentum",
            Rule::Spheres => "one moment of inertia instead of six",
            Rule::Pivots => "one equation instead of six",
            Rule::Tumblers => "a parabola, and three equations instead of six",
            Rule::Crowds => "steps of first order over all events within them",
        }
    }
}

impl FromStr for Rule {
    type Err = UnknownRule;

    fn from_str(name: &str) -> Result<Self, UnknownRule> {
        Rule::ALL.into_iter().find(|rule| rule.name() == name).ok_or_else(|| UnknownRule(name.to_string()))
    }
}
