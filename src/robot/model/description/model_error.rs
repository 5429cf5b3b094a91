//! Errors: a robot cannot be simulated, or not with the given options.

use crate::mechanism::description::mechanism::MechanismError;
use crate::model::description::coupling_error::CouplingError;
use crate::scene::{Element, listed};
use std::path::PathBuf;

/// Errors of the reduction and of initial conditions.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum ModelError {
    /// A floating base was asked for, but the robot is attached to the world.
    #[error("{}: the base cannot float: the root link of {robot:?} is the fixed world", file.display())]
    BaseIsWorld { file: PathBuf, robot: String },
    /// A body whose inertia no motion can have.
    #[error(
        "{}:{line}: link {link:?}: {} has the principal moments of inertia {:e}, {:e}, {:e} kg m² (mass {mass} kg); \
         they must not be negative", file.display(), with_fused(fused), moments[0], moments[1], moments[2]
    )]
    NegativeInertia { file: PathBuf, line: usize, link: String, fused: Vec<String>, mass: f64, moments: [f64; 3] },
    /// Numbers so large that their sums or products are infinite.
    #[error("{}:{line}: link {link:?}: the numbers up to here are so large that its place or mass is infinite", file.display())]
    Overflow { file: PathBuf, line: usize, link: String },
    /// A joint that can move without moving any mass.
    #[error(
        "{}:{line}: {element}: can move without moving any mass or inertia, so its motion is not determined; give \
         link {child:?} a mass and an inertia", file.display()
    )]
    NoInertia { file: PathBuf, line: usize, element: Element, child: String },
    /// The bodies do not form a mechanism.
    #[error(transparent)]
    Mechanism(#[from] MechanismError),
    /// A loop, spring, load or mimic relation that cannot be.
    #[error(transparent)]
    Coupling(#[from] CouplingError),
    /// The start that a file gives is wrong.
    #[error("{}:{line}: {problem}", file.display())]
    InFile { file: PathBuf, line: usize, problem: Box<ModelError> },
    /// No such joint.
    #[error("there is no joint {joint:?}; the joints that move are {}", listed(known))]
    UnknownJoint { joint: String, known: Vec<String> },
    /// The joint does not move.
    #[error("joint {joint:?} does not move ({reason}); the joints that move are {}", listed(known))]
    JointDoesNotMove { joint: String, reason: String, known: Vec<String> },
    /// Not as many numbers as the joint has coordinates.
    #[error("the {what} of {kind} joint {joint:?} needs {} ({wanted}), not {given}", numbers(wanted))]
    WrongCount { what: &'static str, joint: String, kind: &'static str, wanted: &'static str, given: usize },
    /// Infinite or not a number.
    #[error("the {what} of joint {joint:?} is not finite")]
    NotFinite { what: &'static str, joint: String },
    /// A quaternion without a direction.
    #[error("the position of joint {joint:?} is no rotation: its quaternion w, x, y, z has no length")]
    NoRotation { joint: String },
    /// A start of a joint that is moved in time.
    #[error("joint {0:?} starts where its [[motion]] puts it; leave out the position and the velocity that are given")]
    Moved(String),
    /// An angle whose digits do not say where the joint is.
    #[error(
        "the position of joint {joint:?} is {angle:e} rad; above {largest:e} rad, double precision does not resolve the angle within a \
         turn; subtract whole turns"
    )]
    TurnedTooOften { joint: String, angle: f64, largest: f64 },
    /// A link whose distance has no finite square.
    #[error("link {link:?} is {distance:e} m away, so far that squares of distances to it are infinite")]
    TooFarAway { link: String, distance: f64 },
    /// A link whose kinetic energy is infinite.
    #[error(
        "joint {joint:?} starts so fast that the energy of link {link:?} is infinite: it moves at {speed:e} m/s and turns at {spin:e} \
         rad/s"
    )]
    TooFast { joint: String, link: String, speed: f64, spin: f64 },
    /// The sum of all energies is infinite though the energies of the bodies are not.
    #[error("the energy of gravity, springs and loads is infinite where the run starts")]
    InfiniteEnergy,
    /// A spring that pushes apart two points that coincide.
    #[error(
        "spring {spring:?}: its ends coincide where the run starts though its rest length is {rest_length} m, so its force has no \
         direction; start it elsewhere, or give it no rest length"
    )]
    UndirectedSpring { spring: String, rest_length: f64 },
    /// An ellipsoid and a shape with which its contact is not simulated.
    #[error(
        "{a:?} and {b:?} may touch, but contact of an ellipsoid with a {other} is not simulated, only with half spaces; leave the pair out: \
         [[contact.pair]] with a = {a:?}, b = {b:?}, ignore = true"
    )]
    EllipsoidTouches { a: String, b: String, other: &'static str },
    /// An obstacle that reports could not tell from a link.
    #[error("obstacle {0:?} has the name of a link; give it another")]
    ObstacleNamedAsLink(String),
    /// A base velocity for a base that does not float.
    #[error("a base velocity needs a floating base (--base floating)")]
    BaseDoesNotFloat,
    /// The base pose or velocity is infinite or not a number.
    #[error("the {0} is not finite")]
    OptionNotFinite(&'static str),
}

fn with_fused(fused: &[String]) -> String {
    match fused {
        [] => "the link".to_string(),
        fused => format!("together with the links fixed to it ({}) it", crate::scene::quoted(fused)),
    }
}

fn numbers(wanted: &str) -> String {
    match wanted.split(',').count() {
        1 => "one number".to_string(),
        count => format!("{count} numbers"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hundreds_of_joints_do_not_make_an_error_of_a_page() {
        let known = |count: usize| (1..=count).map(|joint| format!("joint{joint}")).collect();
        let said = |count| ModelError::UnknownJoint { joint: "hip".into(), known: known(count) }.to_string();
        assert!(said(12).ends_with(r#""joint11", "joint12""#), "{}", said(12));
        assert!(said(100).ends_with(r#""joint9", "joint10" and 90 more, which `catena model` lists"#), "{}", said(100));
    }
}
